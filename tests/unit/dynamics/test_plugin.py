# SPDX-License-Identifier: GPL-2.0-or-later
"""A plugin that is missing or older than the code: one sentence that says what to do."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine import plugin as plugin_module
from floeflow.dynamics.engine.plugin import (
    _FUNCTIONS,
    INTERFACE,
    LAYOUT,
    _check_layout,
    load_plugin,
)

CAPI = Path(__file__).parents[3] / "liggghts_models/capi"


@pytest.fixture
def plugin(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """Where the plugin is looked for, during one test."""
    path = tmp_path / "libfloe.so"
    monkeypatch.setenv("FLOEFLOW_PLUGIN", str(path))
    load_plugin.cache_clear()
    yield path
    load_plugin.cache_clear()


@pytest.mark.usefixtures("plugin")
def test_a_missing_plugin_is_one_sentence() -> None:
    with pytest.raises(FloeError, match="libfloe.so: there is no such file; leave"):
        load_plugin()


def test_a_plugin_of_another_age_is_one_sentence(plugin: Path) -> None:
    # It has none of the functions: those of an older one would hide the true ones from then on.
    source = plugin.with_name("older.c")
    source.write_text("")
    subprocess.run(["cc", "-shared", "-o", str(plugin), str(source)], check=True)
    with pytest.raises(FloeError, match="libfloe.so does not .* no floe_error: `make setup`"):
        load_plugin()


@pytest.mark.parametrize("what", sorted(LAYOUT))
def test_a_reordered_column_is_refused(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    library = load_plugin()
    first, second, *rest = LAYOUT[what]
    monkeypatch.setitem(LAYOUT, what, (second, first, *rest))
    with pytest.raises(FloeError, match=f"columns of {what} are '{first} {second}.* and not"):
        _check_layout(library, Path("libfloe.so"))
    monkeypatch.setattr(plugin_module, "INTERFACE", INTERFACE + 1)
    with pytest.raises(FloeError, match=f"interface is number {INTERFACE} and not"):
        _check_layout(library, Path("libfloe.so"))


def test_no_exception_crosses_the_interface() -> None:
    # All functions of the interface go through `guarded` or `counted`, but for what cannot fail.
    header = (CAPI / "capi.h").read_text()
    names = set(re.findall(r"\b(floe_\w+)\(", re.sub("//.*", "", header)))
    bodies = {}
    for path in CAPI.glob("*.cpp"):
        _, _, text = path.read_text().partition('extern "C" {')
        bodies |= dict(
            re.findall(r"^[\w ]+[ *](floe_\w+)\([^{;]*\) \{(.*?)(?:^\}| \}$)", text, re.M | re.S)
        )
    assert set(bodies) == names and len(names) > 20
    open_to_faults = {
        name for name, body in bodies.items() if not re.search(r"floe::(guarded|counted)\(", body)
    }
    assert open_to_faults == {"floe_error", "floe_interface"}


def test_every_function_of_the_interface_is_loaded() -> None:
    header = re.sub("//.*", "", (CAPI / "capi.h").read_text())
    assert set(re.findall(r"\b(floe_\w+)\(", header)) == set(_FUNCTIONS)
    assert int(re.search(r"FLOE_INTERFACE (\d+)", header)[1]) == INTERFACE  # type: ignore[index]


def test_a_count_that_fails_is_a_sentence() -> None:
    with pytest.raises(FloeError, match="The LIGGGHTS plugin failed: no LIGGGHTS is open"):
        load_plugin().floe_count_elements(None)
