# SPDX-License-Identifier: GPL-2.0-or-later
"""The commands and lists around the set-up: lint, CI, help of make, lock, packages."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from packaging.version import Version

from support.beside import taken

ROOT = Path(__file__).parents[3]


def test_lint_finds_a_type_error_in_every_package(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "setup", tmp_path / "setup")
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    packages = ("floeflow", "floeflow/column")
    for package in packages:
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").touch()
        (tmp_path / package / "planted.py").write_text("HEIGHT: int = 'tall'\n")
    user = "from floeflow.column.planted import HEIGHT\n\nNAME: str = HEIGHT\n"
    (tmp_path / "floeflow/user.py").write_text(user)
    run = subprocess.run(
        ["bash", tmp_path / "setup/lint.sh", "types"], capture_output=True, text=True
    )
    assert run.returncode == 1
    for package in packages:
        assert f"\n{package}/planted.py:1: error" in "\n" + run.stdout
    assert "floeflow/user.py:3: error" in run.stdout
    for file in [tmp_path / package / "planted.py" for package in packages]:
        file.write_text("HEIGHT: int = 1\n")
    (tmp_path / "floeflow/user.py").unlink()
    clean = subprocess.run(
        ["bash", tmp_path / "setup/lint.sh", "types"], capture_output=True, text=True
    )
    assert clean.returncode == 0, clean.stdout + clean.stderr


def test_lint_of_the_workflow_tolerates_one_finding() -> None:
    spec = importlib.util.spec_from_file_location("lint_workflow", ROOT / "setup/lint_workflow.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    tolerated = (
        "Lints for rule mask (line 3, Snakefile):\n"
        f"    * {module.TOLERATED}:\n      This way, the used software is documented.\n"
    )
    assert module.intolerable(tolerated) == []
    other = tolerated + "    * No log directive defined:\n      Without a log directive ...\n"
    assert module.intolerable(other) == ["rule mask (line 3, Snakefile): No log directive defined"]


TARGETS = ("test", "test-cluster", "test-browser")


@pytest.mark.parametrize("failing", [*TARGETS, "none"])
def test_ci_runs_its_targets_in_order_and_passes_an_exit_code_on(
    tmp_path: Path, failing: str
) -> None:
    make, called = tmp_path / "bin/make", tmp_path / "called"
    make.parent.mkdir()
    make.write_text(f'#!/bin/sh\necho "$PWD: make $*" >>"{called}"\ntest "$*" != {failing}\n')
    make.chmod(0o755)
    run = subprocess.run(
        ["bash", ROOT / ".ci/run"],
        cwd=tmp_path,
        env=os.environ | {"PATH": f"{make.parent}:{os.environ['PATH']}"},
    )
    assert run.returncode == (failing != "none")
    ran = TARGETS[: TARGETS.index(failing) + 1] if failing in TARGETS else TARGETS
    assert called.read_text().splitlines() == [f"{ROOT}: make {target}" for target in ran]


FAKES = {
    "dpkg-query": "exit 1",
    "id": "echo 0",
    "apt-get": 'echo "apt-get $*" >>"$CALLED"; echo "E: no route to the mirror" >&2; exit 100',
}


@pytest.mark.parametrize("pip", ["works", "fails"])
@pytest.mark.parametrize("forbidden", ["", "1"])
def test_a_slurm_that_cannot_be_installed_is_told_and_no_failure(
    tmp_path: Path, pip: str, forbidden: str
) -> None:
    """No network to the packages, or no right to install: its tests then say why they skip."""
    (tmp_path / "setup").mkdir()
    for name in ("cluster.sh", "common.sh"):
        shutil.copy(ROOT / "setup" / name, tmp_path / "setup")
    programs = {tmp_path / "bin" / name: body for name, body in FAKES.items()}
    programs[tmp_path / ".venv/bin/python"] = f"test {pip} = works"
    for path, body in programs.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"#!/bin/sh\n{body}\n")
        path.chmod(0o755)
    called = tmp_path / "called"
    more = {"PATH": f"{tmp_path}/bin:{os.environ['PATH']}", "NO_APT": forbidden, "CALLED": called}
    run = subprocess.run(
        ["bash", tmp_path / "setup/cluster.sh", "--slurm"],
        env=os.environ | more,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    said = "cannot install slurmctld" if forbidden else "'apt-get install slurmctld"
    last = run.stderr.splitlines()[-1]
    assert said in last and last.endswith("cluster tests will skip.")
    assert called.exists() == (not forbidden)
    assert ("pip's words are above" in run.stderr) == (pip == "fails")


PYTEST = """#!/bin/sh
echo "SKIPPED [3] tests/conftest.py:40: no reference data at /nowhere (FLOEFLOW_SHARED ...)"
echo "SKIPPED [9] tests/unit/x.py:1: valgrind is not installed"
case "$*" in *pytest-{failing}*) exit 1 ;; esac
"""


@pytest.mark.parametrize("failing", ["1", "2", "none"])
def test_both_processes_of_the_tests_count(tmp_path: Path, failing: str) -> None:
    """A failure in either is one of the whole, and what lacked reference data is told last."""
    python = tmp_path / ".venv/bin/python"
    python.parent.mkdir(parents=True)
    python.write_text(PYTEST.format(failing=failing))
    python.chmod(0o755)
    (tmp_path / "setup").mkdir()
    script = shutil.copy(ROOT / "setup/test.sh", tmp_path / "setup")
    run = subprocess.run(["bash", script], capture_output=True, text=True)
    assert run.returncode == (failing != "none")
    last = run.stdout.splitlines()[-1]
    assert last.startswith("FloeFlow: 6 tests were skipped because reference data are absent")


def test_modules_are_shared_out_once(tmp_path: Path) -> None:
    """Two processes that run tests side by side: none is left out, none runs twice."""
    paths = [ROOT / f"tests/{name}/test_{name}.py" for name in "abc" for _ in range(2)]
    items = [SimpleNamespace(path=path, number=number) for number, path in enumerate(paths)]
    first, second = taken(tmp_path, items), taken(tmp_path, items)
    ran = [next(first), next(second), next(first), *second, *first]
    assert [item.number for item in ran] == [0, 2, 1, 3, 4, 5]


def test_every_target_of_make_has_its_line_of_help() -> None:
    run = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True)
    phony = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert phony
    assert [line.split()[1] for line in run.stdout.splitlines()] == phony[1].split()


LOCKS = ("requirements.lock", "requirements-cluster.lock", "requirements-docs.lock")


def pinned() -> dict[str, str]:
    """Return the entries of the locks, each with its hashes, by normalised name."""
    entries: dict[str, str] = {}
    for line in "".join((ROOT / "setup" / lock).read_text() for lock in LOCKS).splitlines():
        if match := re.match(r"([a-z0-9-]+)==", line):
            name = match[1]
            entries[name] = line
        elif line.startswith("    --hash"):
            entries[name] += line
    return entries


def direct() -> list[str]:
    """Return the names in the lists of direct dependencies, normalised, without their bounds."""
    files = (
        "requirements.in",
        "requirements-workflow.in",
        "requirements-formats.in",
        "requirements-movies.in",
        "requirements-dev.in",
        "requirements-cluster.in",
        "requirements-docs.in",
    )
    lines = [line for file in files for line in (ROOT / "setup" / file).read_text().splitlines()]
    names = (line.partition(">=")[0] for line in lines if line and not line.startswith("#"))
    return [name.lower() for name in names]


def test_lock_pins_every_dependency_with_hashes_and_names_no_index() -> None:
    entries = pinned()
    assert set(direct()) <= set(entries)
    assert all("--hash=sha256:" in entry for entry in entries.values())
    text = "".join((ROOT / "setup" / lock).read_text() for lock in LOCKS)
    assert "://" not in text
    assert not re.search(r"^\s*-(?!-hash)", text, re.MULTILINE)


def test_oldest_versions_are_told_and_lie_below_the_lock() -> None:
    lines = (ROOT / "setup/requirements.in").read_text().splitlines()
    bounds = dict(line.split(">=") for line in lines if ">=" in line)
    assert {"numpy", "scipy", "numba", "xarray"} <= set(bounds)
    text = " ".join((ROOT / "docs/dependencies.md").read_text().lower().split())
    told = text.partition("## oldest versions")[2].partition("## the lock")[0]
    locked = pinned()
    for name, version in bounds.items():
        assert f"{name.lower()} {version}" in told, name
        (pin,) = re.findall(r"==([\w.]+)", locked[name.lower()])
        assert Version(version) < Version(pin), name


def test_every_dependency_has_its_reason_and_licence() -> None:
    text = (ROOT / "docs/dependencies.md").read_text()
    rows = re.findall(r"^\| `([^`]+)` \| ([^|]{10,}) \| ([^|]{3,}) \|$", text, re.MULTILINE)
    assert sorted(name.lower() for name, _, _ in rows if "apt:" not in name) == sorted(direct())


def test_the_site_lists_every_page_and_no_other() -> None:
    nav = (ROOT / "mkdocs.yml").read_text().partition("\nnav:\n")[2]
    listed = re.findall(r"[\w/-]+\.md", nav)
    pages = [str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.md")]
    assert sorted(listed) == sorted([*pages, "config.md"])
