# SPDX-License-Identifier: GPL-2.0-or-later
"""Command blocks of README and docs: run as they are typed, in a folder like a checkout.

A block is fenced as ``console``. A comment in the line before it may say ``slow``, or ``not run:``
with the reason. Targets of make are asked for with ``make -n``: CI and `make test-fresh` run them.
Blocks of YAML are scenes that are accepted here. Blocks of Python are run by the tests that
`PYTHON` names.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml

from floeflow.scene.load import build_scene

PROJECT = Path(__file__).resolve().parents[3]
PAGES = [
    *(PROJECT / name for name in ("README.md", "CONTRIBUTING.md", "config/README.md")),
    *sorted((PROJECT / "docs").rglob("*.md")),
]
BLOCK = re.compile(r"(?:^<!-- (?P<tag>[^\n]*?) -->\n)?^```console\n(?P<text>.*?)^```", re.M | re.S)
# What is written by runs, or is a test's own.
OWN = {"results", "config", ".git", ".snakemake"}


@dataclass(frozen=True)
class Block:
    """A command block: its page, its place on it, its commands and its tag."""

    page: str
    number: int
    commands: tuple[str, ...]
    tag: str


def commands_of(text: str) -> tuple[str, ...]:
    """Commands of a block: lines after a prompt, with their continuation, without comments."""
    joined = re.sub(r"\\\n\s*", "", text)
    lines = re.findall(r"^\$ (.*)$", joined, re.M)
    return tuple(re.sub(r"\s{2,}# .*", "", line).strip() for line in lines)


def blocks() -> list[Block]:
    found = []
    for page in PAGES:
        name = page.relative_to(PROJECT).as_posix()
        for number, match in enumerate(BLOCK.finditer(page.read_text())):
            found.append(Block(name, number, commands_of(match["text"]), match["tag"] or ""))
    return found


ALL = blocks()
RUN = [
    pytest.param(block, id=f"{block.page}:{block.number}", marks=marks)
    for block in ALL
    if not block.tag.startswith("not run")
    for marks in ([pytest.mark.slow] if block.tag == "slow" else [],)
]


def test_blocks_have_commands_and_tags_have_reasons():
    assert len(ALL) > 15
    for block in ALL:
        assert block.commands, (block.page, block.number)
        known = block.tag in ("", "slow") or re.fullmatch(r"not run: .{15,}", block.tag)
        assert known, (block.page, block.tag)


def test_commands_are_written_with_their_path():
    """Nothing of .venv/bin is on a PATH: no line and no sentence has a bare command of it."""
    bare = re.compile(r"(?:^(?:\$ | {4})|(?<!`)`)(?:floeflow|snakemake|python|pytest) ", re.M)
    lost = {
        page.relative_to(PROJECT).as_posix(): bare.findall(page.read_text())
        for page in PAGES
        if bare.search(page.read_text())
    }
    assert lost == {}


def test_commands_stand_in_blocks_that_are_looked_at():
    """Not indented alone, nor in a fence of no kind: such a block would be run by nothing."""
    words = (
        r"\$ |\.venv/|make |cd |pip |apt-get |cmake |mpirun |git |floeflow |snakemake |python3? "
    )
    loose = re.compile(rf"(?<=\n\n) {{4}}(?:{words}).*")
    fenced = re.compile(rf"^```\n(?:{words}).*", re.M)
    lost = {}
    for page in PAGES:
        text = re.sub(r"^```\w.*?^```$", "", page.read_text(), flags=re.M | re.S)
        plain = re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)
        if found := loose.findall(plain) + fenced.findall(text):
            lost[page.relative_to(PROJECT).as_posix()] = found
    assert lost == {}


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A folder like a checkout after `make setup`, with the README's scene, and its own results."""
    for entry in PROJECT.iterdir():
        if entry.name not in OWN:
            (tmp_path / entry.name).symlink_to(entry)
    shutil.copytree(PROJECT / "config", tmp_path / "config")
    (tmp_path / "results").mkdir()
    scene = re.search(r"^```yaml\n(.*?)^```", (PROJECT / "README.md").read_text(), re.M | re.S)
    assert scene is not None
    (tmp_path / "config/scenes/mine.yaml").write_text(scene[1])
    return tmp_path


def without_running(command: str) -> str:
    """A command of make that only says what it would do."""
    return re.sub(r"^make\b", "make -n", command)


@pytest.mark.parametrize("block", RUN)
def test_a_command_block_runs_as_typed(block: Block, checkout: Path):
    for command in block.commands:
        if command.startswith(".venv/bin/floeflow report"):
            continue  # it needs a run; tests/unit/report/test_run_so_far.py has one
        done = subprocess.run(
            ["bash", "-euc", without_running(command)],
            cwd=checkout,
            env={**os.environ, "PYTHONPATH": ""},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, (command, done.stdout[-2000:], done.stderr[-2000:])


# Tests that run the Python of a page.
PYTHON = {
    "docs/contributing/column_process.md": "tests/unit/setup/test_recipes.py",
    "docs/contributing/diagnostic.md": "tests/unit/setup/test_recipes.py",
    "docs/contributing/effect.md": "tests/unit/setup/test_recipes.py",
    "docs/contributing/figure.md": "tests/unit/setup/test_recipes.py",
    "docs/contributing/reader.md": "tests/unit/setup/test_recipes.py",
    "docs/export.md": "tests/unit/diagnostics/test_trajectory.py",
    "docs/how-to/coupling.md": "tests/unit/coupling/test_fluxes.py",
    "docs/how-to/read_results.md": "tests/unit/diagnostics/test_reading_page.py",
    **{
        f"docs/tutorials/{page}.md": "tests/workflow/test_tutorials.py"
        for page in ("deformation", "first_scene", "liggghts", "own_data")
    },
    "docs/tutorial_column.md": "tests/unit/analysis/test_single_column.py",
}


def test_python_of_the_documents_is_run_by_a_test():
    found = {
        page.relative_to(PROJECT).as_posix()
        for page in PAGES
        if re.search(r"^```python\n", page.read_text(), re.M)
    }
    assert found == set(PYTHON)
    for page, test in PYTHON.items():
        assert Path(page).stem in (PROJECT / test).read_text(), (page, test)


YAML = [
    pytest.param(text, id=f"{page.relative_to(PROJECT)}:{number}")
    for page in PAGES
    for number, text in enumerate(re.findall(r"^```yaml\n(.*?)^```", page.read_text(), re.M | re.S))
]


@pytest.mark.parametrize("text", YAML)
def test_a_scene_of_the_documents_is_accepted(text: str):
    keys = yaml.safe_load(text)
    if keys.get("effects") == "auto":
        del keys["effects"]
    build_scene({"name": "mine", **keys})
