# SPDX-License-Identifier: GPL-2.0-or-later
"""The scripts of rules as modules, for tests that call what they hold."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

PROJECT = Path(__file__).resolve().parents[2]


def load_script(name: str) -> ModuleType:
    """Module of a rule's script, such as ``postprocess/report``; its rule is not run."""
    spec = importlib.util.spec_from_file_location(name.replace("/", "_"), PROJECT / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
