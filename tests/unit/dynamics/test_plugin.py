# SPDX-License-Identifier: GPL-2.0-or-later
"""A plugin that is missing or older than the code: one sentence that says what to do."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.plugin import load_plugin


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
