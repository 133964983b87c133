# SPDX-License-Identifier: GPL-2.0-or-later
"""Public functions of the library say what each parameter and result is, with shape and unit.

Ruff asks for a docstring of all that is public, and that sections, where there are any, name each
parameter and error. This asks for the sections themselves, and for the help of each option of the
commands, whose docstrings are what ``--help`` prints.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer.main

from floeflow.cli import app

# Its docstrings are what ``--help`` prints, and its parameters are asked for below.
COMMANDS = "floeflow/cli.py"
# Packages whose public functions with parameters say what they return, with shape and unit. They
# grow by what is done.
COMPLETE = (
    *("column", "core", "coupling", "dynamics", "forcings", "masks", "packings", "scene", "state"),
    *("diagnostics", "report", "transfer", "workflow"),
)
# Modules of these in which some do not yet.
INCOMPLETE = {
    "floeflow/coupling/coupled_windows.py",
    "floeflow/coupling/sea/birth.py",
    "floeflow/dynamics/remesh/absorb.py",
    "floeflow/dynamics/remesh/remesh.py",
}


def public(body: list[ast.stmt]) -> Iterator[ast.FunctionDef]:
    """Public functions of a module, and methods of its public classes, but no properties."""
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public(node.body)
        elif isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            yield node


def without_sections(source: str) -> list[str]:
    """Public functions with parameters whose docstring has no list of them."""
    found = []
    for node in public(ast.parse(source).body):
        given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        names = [each.arg for each in given if each.arg not in ("self", "cls")]
        text = ast.get_docstring(node) or ""
        if names and "Parameters\n----------\n" not in text:
            found.append(node.name)
    return found


def test_public_functions_list_their_parameters(project: Path):
    lost = {}
    for path in sorted((project / "floeflow").rglob("*.py")):
        name = path.relative_to(project).as_posix()
        if name != COMMANDS and (found := without_sections(path.read_text())):
            lost[name] = found
    assert lost == {}


def without_returns(source: str) -> list[str]:
    """Public functions with parameters that return or yield something and do not say what."""
    found = []
    for node in public(ast.parse(source).body):
        given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        names = [each.arg for each in given if each.arg not in ("self", "cls")]
        kind = ast.unparse(node.returns) if node.returns else "None"
        text = ast.get_docstring(node) or ""
        said = re.search(r"^(Returns\n-------|Yields\n------)\n\S", text, re.M)
        is_property = any("property" in ast.unparse(each) for each in node.decorator_list)
        if (
            names
            and kind not in ("None", "NoReturn", "Iterator[None]")
            and not said
            and not is_property
        ):
            found.append(node.name)
    return found


def test_functions_of_complete_packages_say_what_they_return(project: Path):
    lost = {}
    for package in COMPLETE:
        for path in sorted((project / "floeflow" / package).rglob("*.py")):
            if found := without_returns(path.read_text()):
                lost[path.relative_to(project).as_posix()] = found
    assert {name: found for name, found in lost.items() if name not in INCOMPLETE} == {}
    # What has been completed is taken from the list.
    assert set(lost) >= INCOMPLETE


def test_a_function_that_does_not_say_what_it_returns_is_found():
    told = '    """Sum.\n\n    Returns\n    -------\n    float\n        m.\n    """\n'
    assert without_returns(f"def add(a, b) -> float:\n{told}") == []
    bare = told.replace("    float\n        m.\n", "")
    assert without_returns(f"def add(a, b) -> float:\n{bare}") == ["add"]
    assert without_returns('def add(a, b) -> float:\n    """Sum of two lengths (m)."""\n') == [
        "add"
    ]
    assert without_returns('def add(a, b) -> None:\n    """Add."""\n') == []
    assert without_returns('def length() -> float:\n    """A length (m)."""\n') == []


def test_a_function_without_sections_is_found():
    listed = '    """Sum.\n\n    Parameters\n    ----------\n    a, b : float\n    """\n'
    assert without_sections(f"def add(a, b):\n{listed}") == []
    assert without_sections('def add(a, b):\n    """Sum of two lengths (m)."""\n') == ["add"]
    assert without_sections('class A:\n    def add(self, a):\n        """Sum."""\n') == ["add"]
    assert without_sections('def _add(a, b):\n    """Sum."""\n') == []
    assert without_sections('def length():\n    """A length (m)."""\n') == []


def test_no_module_is_left_out_of_the_check_of_types(project: Path):
    """Compiled functions have types too: mypy asks for them everywhere (`make lint`)."""
    left_out = re.compile(r"# mypy: |\[no-untyped-def\]|\bno_type_check\b")
    paths = sorted((project / "floeflow").rglob("*.py"))
    assert [path for path in paths if left_out.search(path.read_text())] == []
    settings = tomllib.loads((project / "pyproject.toml").read_text())["tool"]["mypy"]
    assert settings["disallow_untyped_defs"]
    assert not any("disallow_untyped_defs" in each for each in settings["overrides"])


COMMANDS_OF_APP = typer.main.get_group(app).commands


@pytest.mark.parametrize("name", sorted(COMMANDS_OF_APP))
def test_each_option_of_a_command_has_help(name: str):
    command = COMMANDS_OF_APP[name]
    assert command.help
    lost = [each.name for each in command.params if not getattr(each, "help", None)]
    assert lost == []
