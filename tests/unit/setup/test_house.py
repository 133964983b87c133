# SPDX-License-Identifier: GPL-2.0-or-later
"""The house: layers of the library, scripts of rules, and the library as a wheel by itself."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml

from unit.analysis.test_single_column import HOURS, era5

STAGES = ("preprocess", "simulate", "postprocess", "studies")


def imported(path: Path) -> Iterator[str]:
    """Modules that a file imports, inside of functions too."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "." * node.level + (node.module or "")


def scripts(project: Path) -> list[Path]:
    return [path for stage in STAGES for path in sorted((project / stage).glob("*.py"))]


def test_scripts_import_only_the_library(project: Path):
    known = {"floeflow", *sys.stdlib_module_names}
    found = scripts(project)
    assert len(found) > 10
    for path in found:
        strange = [name for name in imported(path) if name.partition(".")[0] not in known]
        assert not strange, (path.name, strange)


def test_each_script_has_a_rule_of_its_name(project: Path):
    text = "".join(path.read_text() for path in (project / "workflows/rules").glob("*.smk"))
    rules = re.findall(r"^rule (\w+):(.*?)(?=^rule |\Z)", text, re.M | re.S)
    called = {
        found[1]: name
        for name, body in rules
        if (found := re.search(r'"\.\./\.\./(\w+/\w+)\.py"', body))
    }
    assert called == {
        path.relative_to(project).with_suffix("").as_posix(): path.stem for path in scripts(project)
    }


def test_the_library_knows_no_workflow(project: Path):
    forbidden = {"snakemake", "tests", "support", "benchmarks", *STAGES}
    for path in sorted((project / "floeflow").rglob("*.py")):
        up = [name for name in imported(path) if name.partition(".")[0] in forbidden]
        assert not up, (path.relative_to(project).as_posix(), up)


def test_the_start_of_a_workflow_reads_no_library_of_readers():
    """It stands before every run, dry or not, and imports what is large only where it needs it."""
    code = "import sys, floeflow.workflow.scenes as _; print(*sys.modules)"
    loaded = run([sys.executable, "-c", code], Path.cwd()).split()
    assert "yaml" in loaded
    assert not {"xarray", "pandas", "netCDF4", "scipy", "numba", "meshio", "matplotlib"} & {*loaded}


@pytest.mark.parametrize("stray", [None, "    from floeflow.report import report"])
def test_an_import_that_points_up_is_a_finding_of_lint(
    project: Path, tmp_path: Path, stray: str | None
):
    """The contract holds, and an upward import in a function's body breaks it."""
    shutil.copytree(
        project / "floeflow", tmp_path / "floeflow", ignore=shutil.ignore_patterns("__pycache__")
    )
    shutil.copy(project / "pyproject.toml", tmp_path)
    if stray:
        with (tmp_path / "floeflow/core/errors.py").open("a") as file:
            file.write(f"\n\ndef later() -> None:\n{stray}\n")
    lint = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [str(lint), "--no-cache"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == (1 if stray else 0), done.stdout
    assert ("floeflow.core.errors -> floeflow.report.report" in done.stdout) == bool(stray)


def test_lint_runs_the_contract(project: Path):
    text = (project / "setup/lint.sh").read_text()
    assert re.search(r"^check_imports\(\).*lint-imports", text, re.M)
    assert re.search(r"^all=\(.*\bimports\b.*\)$", text, re.M)


PATH = re.compile(
    r"`((?:floeflow|liggghts_models|workflows|tests|setup|benchmarks|config)/[\w./-]+)`"
)


def test_documents_name_files_that_are_there(project: Path):
    pages = [project / "README.md", *(project / "docs").rglob("*.md")]
    named = {(page.name, path) for page in pages for path in PATH.findall(page.read_text())}
    assert len(named) > 50
    made = {"build", "results"}
    lost = [
        (page, path)
        for page, path in sorted(named)
        if not (project / path).exists() and path.split("/")[0] not in made
    ]
    # A user writes these in the tutorials and recipes.
    own = {f"config/scenes/{name}.yaml" for name in ("first", "mine", "own_data", "storm")}
    own.add("liggghts_models/laws/swell.h")
    assert [entry for entry in lost if entry[1] not in own] == []


@pytest.fixture(scope="module")
def wheel(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """``bin`` of an environment that has only the wheel, beside the packages that it needs."""
    place = tmp_path_factory.mktemp("wheel")
    source = place / "source"
    source.mkdir()
    # A copy, so that nothing that an earlier build left in the checkout gets in.
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(project / "floeflow", source / "floeflow", ignore=ignore)
    shutil.copytree(project / "setup", source / "setup", ignore=ignore)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(project / name, source)
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    build = [*pip, "wheel", ".", "--no-deps", "--no-build-isolation", "--wheel-dir", str(place)]
    run(build, source)
    venv = place / "venv"
    run([sys.executable, "-m", "venv", "--without-pip", str(venv)], place)
    (made,) = place.glob("floeflow-*.whl")
    python = venv / "bin/python"
    install = [*pip, "--python", str(python), "install", "--no-deps", "--no-index", str(made)]
    run(install, place)
    site = Path(run([str(python), "-c", "import site; print(site.getsitepackages()[0])"], place))
    # Lines of such a file are not read for a further .pth: the checkout stays unknown.
    (site / "needs.pth").write_text(sysconfig.get_path("purelib") + "\n")
    where = run([str(python), "-c", "import floeflow; print(floeflow.__file__)"], place)
    assert Path(where).is_relative_to(venv)
    return venv / "bin"


def run(command: list[str], folder: Path) -> str:
    """Run a command that must succeed; what it said."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.strip()


@pytest.fixture
def scene(project: Path, tmp_path: Path) -> Path:
    """A scene outside of the checkout, with its mask."""
    keys = yaml.safe_load((project / "config/scenes/smoke.yaml").read_text())
    shutil.copy(project / "data/oisst_arctic_1981-12-31.nc", tmp_path / "ice.nc")
    keys["mask"]["file"] = "ice.nc"
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(keys))
    return tmp_path / "mine.yaml"


def test_the_wheel_has_what_its_modules_read(wheel: Path, project: Path):
    site = next((wheel.parent / "lib").glob("python*/site-packages/floeflow"))
    tracked = {
        path.relative_to(project / "floeflow")
        for path in (project / "floeflow").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    there = {path.relative_to(site) for path in site.rglob("*") if path.is_file()}
    assert tracked <= there


def test_the_wheel_estimates_plans_and_checks(wheel: Path, scene: Path):
    floeflow = str(wheel / "floeflow")
    assert "scene 'mine' with wind" in run([floeflow, "check", "mine.yaml"], scene.parent)
    assert "ocean_drag" in run([floeflow, "effects", "mine.yaml"], scene.parent)
    said = run([floeflow, "plan", "mine.yaml", "--budget", "1h"], scene.parent)
    assert "as it stands: about" in said


# Layered ice compiles its kernel anew, which takes most of a minute: the sources lie elsewhere.
@pytest.mark.parametrize("scheme", ["zero_layer", pytest.param("bl99", marks=pytest.mark.slow)])
def test_the_wheel_runs_a_column(wheel: Path, tmp_path: Path, scheme: str):
    era5(HOURS[:49]).to_netcdf(tmp_path / "era5.nc")
    column = [str(wheel / "floeflow"), "column", "era5.nc", "--output", "column.nc"]
    run([*column, "--scheme", scheme], tmp_path)
    with xr.open_dataset(tmp_path / "column.nc") as data:
        assert data.sizes["time"] == 3 and (np.diff(data["ice_volume"].values) > 0).all()


def test_the_wheel_says_what_needs_a_checkout(wheel: Path, scene: Path):
    done = subprocess.run(
        [str(wheel / "floeflow"), "run", "mine.yaml"],
        cwd=scene.parent,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert "'floeflow run' needs a checkout of the project" in done.stderr
