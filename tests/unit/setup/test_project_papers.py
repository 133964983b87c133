# SPDX-License-Identifier: GPL-2.0-or-later
"""Version, changes, citation, public names and bibliography agree with the code."""

from __future__ import annotations

import importlib
import importlib.metadata
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

import floeflow
from floeflow.state import SCHEMA_VERSION
from support.listing import listed

NAME = r"(?:De |van |von )?[A-Z][\wà-öø-ÿ'’\-]+"
CITATION = re.compile(
    rf"((?:{NAME})(?:(?:,| and| &|, and) (?:{NAME}))*(?: et al\.?)?(?:'s)?),? ?"
    r"\(?((?:18|19|20)\d\d)(?=[a-z]?[,;.)\s:](?![0-9]))"
)
# What looks like an author and is none.
NO_AUTHOR = set(
    "January February March April May June July August September October November December "
    "Jan Feb Mar Apr Jun Jul Aug Sep Oct Nov Dec Index LAWS".split()
)
# Names that code, which is ASCII, writes without their accents.
PLAIN = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ó": "O"})
LINE_STARTS = re.compile(r"\s*\n\s*(?:#|//|\*)?\s*")


def cited(text: str) -> Iterator[tuple[list[str], str]]:
    """Authors and years that a text cites."""
    for match in CITATION.finditer(LINE_STARTS.sub(" ", text)):
        names = re.split(r",? and |, | & ", re.sub(r"'s\b| et al\.?", "", match[1]))
        names = [name for name in names if name and not re.fullmatch(r"J[A-Z]+\d+", name)]
        if names and not NO_AUTHOR & set(names) and "_" not in match[1]:
            yield names, match[2]


def unlisted(text: str, entries: list[str]) -> list[str]:
    """Citations of a text that no entry of a bibliography has."""
    entries = [f"{entry} {entry.translate(PLAIN)}" for entry in entries]
    return [
        f"{' & '.join(names)} {year}"
        for names, year in cited(text)
        if not any(year in entry and all(name in entry for name in names) for entry in entries)
    ]


def bibliography(project: Path) -> list[str]:
    lines = (project / "docs/bibliography.md").read_text().splitlines()
    return [line for line in lines if line.startswith("- ")]


def test_every_citation_is_in_the_bibliography(project: Path):
    entries = bibliography(project)
    named = listed(project, "*.py", "*.md", "*.h", "*.cpp", "*.yaml")
    files = [project / name for name in named]
    # This test makes up a source of its own.
    files = [file for file in files if file.name not in ("bibliography.md", Path(__file__).name)]
    found = {
        file.relative_to(project).as_posix(): lost
        for file in files
        if (lost := unlisted(file.read_text(), entries))
    }
    assert found == {}


def test_a_citation_that_is_missing_is_found(project: Path):
    text = "conducts as ice does (Nobody and Untersteiner\n    # 1971), see Semtner (1976)"
    assert unlisted(text, bibliography(project)) == ["Nobody & Untersteiner 1971"]


def test_the_bibliography_is_in_order_and_has_no_entry_twice(project: Path):
    keys = [entry.translate(PLAIN).lower() for entry in bibliography(project)]
    assert len(keys) > 100 and len(set(keys)) == len(keys)
    firsts = [key[2] for key in keys]
    assert firsts == sorted(firsts)


def test_version_changes_and_citation_agree(project: Path):
    version = floeflow.__version__
    assert importlib.metadata.version("floeflow") == version
    released = re.findall(
        r"^## (\d+\.\d+\.\d+) \((\d{4}-\d\d-\d\d)\)$", (project / "CHANGELOG.md").read_text(), re.M
    )
    assert released[0][0] == version
    citation = yaml.safe_load((project / "CITATION.cff").read_text())
    assert (citation["version"], citation["date-released"]) == released[0]
    assert citation["license"] == "GPL-2.0-or-later"


def test_the_version_stands_in_one_place(project: Path):
    assert not re.search(r"^version = \"", (project / "pyproject.toml").read_text(), re.M)


def test_public_names_are_there(project: Path):
    text = (project / "docs/api.md").read_text()
    table = text.split("## Public")[1].split("## Deprecation")[0]
    modules = re.findall(r"`(floeflow\.[\w.]+)`((?:, `\w+`)*)", table)
    assert len(modules) > 5
    for first, others in modules:
        module, _, name = first.rpartition(".")
        for wanted in (name, *re.findall(r"`(\w+)`", others)):
            assert hasattr(importlib.import_module(module), wanted), (module, wanted)


def test_the_table_of_state_versions_ends_with_the_present_one(project: Path):
    text = (project / "docs/api.md").read_text().split("## Versions of the state")[1]
    assert [int(n) for n in re.findall(r"^\| (\d+) \|", text, re.M)] == list(
        range(1, SCHEMA_VERSION + 1)
    )


def test_the_automatic_build_calls_the_script_that_anyone_may_call(project: Path):
    workflow = yaml.safe_load((project / ".github/workflows/ci.yml").read_text())
    steps = workflow["jobs"]["test"]["steps"]
    assert steps[-1]["run"] == ".ci/run" and (project / ".ci/run").stat().st_mode & 0o100


def tag(folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([folder / "setup/tag.sh"], cwd=folder, capture_output=True, text=True)


@pytest.fixture
def release(project: Path, tmp_path: Path) -> Path:
    """A small repository with what a release needs."""
    for name in ("setup/tag.sh", "setup/common.sh", "floeflow/__init__.py", "CITATION.cff"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes((project / name).read_bytes())
    (tmp_path / "setup/tag.sh").chmod(0o755)
    date = yaml.safe_load((project / "CITATION.cff").read_text())["date-released"]
    (tmp_path / "CHANGELOG.md").write_text(f"# Changes\n\n## {floeflow.__version__} ({date})\n")
    for words in ("init -q", "config user.name A", "config user.email a@b", "add .", "commit -qmx"):
        subprocess.run(["git", *words.split()], cwd=tmp_path, check=True)
    return tmp_path


def test_a_release_is_tagged_once(release: Path):
    done = tag(release)
    assert done.returncode == 0, done.stderr
    tags = subprocess.run(["git", "tag"], cwd=release, capture_output=True, text=True).stdout
    assert tags == f"v{floeflow.__version__}\n"
    assert "is there" in tag(release).stderr


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("CHANGELOG.md", "## ", "## Unreleased\n\n## ", "CHANGELOG.md is 'Unreleased'"),
        ("CITATION.cff", "date-released", "date", "CITATION.cff does not name"),
        ("CITATION.cff", "message", " message", "something is not committed"),
    ],
)
def test_what_does_not_agree_is_not_tagged(release: Path, file: str, old: str, new: str, said: str):
    path = release / file
    path.write_text(path.read_text().replace(old, new, 1))
    done = tag(release)
    assert done.returncode == 1 and said in done.stderr
