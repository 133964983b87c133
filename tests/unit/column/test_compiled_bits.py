# SPDX-License-Identifier: GPL-2.0-or-later
"""Results do not depend on whether Numba compiled a function or loaded it from its cache.

A compiled function holds copies of the functions that it calls, optimised together with it. In the
process that compiles, calls go to the first copies, which were optimised alone; in one that loads
the function from the cache they go to its own copies. Without fast-math both have the same bits;
with it sums are taken in another order.
"""

import os
import pkgutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

import floeflow.column

SCRIPTS = Path(__file__).parents[2] / "support/column"


def runs(script: str, cache: Path) -> list[list[str]]:
    """What a script prints with an empty and with a filled cache of Numba."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "NUMBA_NUM_THREADS": "1"}
    found = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, str(SCRIPTS / script)],
            env=environment, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        found.append(done.stdout.split())
    return found


def test_light_has_the_same_bits_compiled_and_loaded(tmp_path: Path) -> None:
    compiled, loaded = runs("light_bits.py", tmp_path)
    assert (compiled[0], loaded[0]) == ("0", "1")
    assert compiled[1] == loaded[1]


@pytest.mark.slow
def test_columns_have_the_same_bits_compiled_and_loaded(tmp_path: Path) -> None:
    compiled, loaded = runs("column_bits.py", tmp_path)
    assert (compiled[0], loaded[0]) == ("0", "1")
    assert compiled[1:] == loaded[1:] and len(compiled) == 5


def test_no_compiled_function_of_the_column_uses_fast_math() -> None:
    checked = 0
    for found in pkgutil.walk_packages(floeflow.column.__path__, "floeflow.column."):
        module = import_module(found.name)
        for name, value in vars(module).items():
            if isinstance(value, Dispatcher):
                checked += 1
                assert not value.targetoptions.get("fastmath"), f"{found.name}.{name}"
    assert checked > 50
