# SPDX-License-Identifier: GPL-2.0-or-later
"""Public functions of the library say what each parameter is, with shape and unit.

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
