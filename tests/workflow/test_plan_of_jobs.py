# SPDX-License-Identifier: GPL-2.0-or-later
"""What Snakemake plans, without running it: variants share work, thousands of jobs stay flat."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Callable
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
import yaml

from support.runner import PROJECT, STREAMS, Done, Place

pytestmark = pytest.mark.workflow

SCENES, WINDOWS = 11, 140


def test_a_variant_makes_only_what_its_changes_touch(smoke: Done):
    wanted = {
        # The base run, which all others are compared with.
        "base": {"variant"},
        # What only the windows read is one job beside it.
        "step_share-0": {"variant"},
        "window-0": {"variant"},
        # Another packing has what is made from it, and no mask.
        "element_size-0": {"packing", "bonds", "initial", "variant"},
    }
    scenes = {f"smoke+accuracy-{name}": rules for name, rules in wanted.items()}
    targets = [f"results/{scene}/record.json" for scene in scenes]
    assert smoke.place.pending(smoke.scene, *targets) == scenes


def test_a_variant_that_no_study_has_is_refused(smoke: Done):
    done = smoke.place.run(smoke.scene, "-n", "results/smoke+accuracy-nothing/record.json")
    assert done.returncode == 1
    said = "floeflow: scene 'smoke' has no variant 'nothing' in a study 'accuracy'"
    assert said in done.stdout and "Traceback" not in done.stdout


def graph(dot: str) -> dict[str, set[str]]:
    """Jobs that each job waits for, of what ``--dag`` printed."""
    waits: dict[str, set[str]] = {name: set() for name in re.findall(r"^\s*(\d+)\[", dot, re.M)}
    for before, after in re.findall(r"^\s*(\d+) -> (\d+)", dot, re.M):
        waits[after].add(before)
    return waits


def depth(waits: dict[str, set[str]]) -> int:
    """Number of jobs of the longest chain."""
    deep: dict[str, int] = {}
    for job in TopologicalSorter(waits).static_order():
        deep[job] = 1 + max((deep[before] for before in waits[job]), default=0)
    return max(deep.values())


def test_three_thousand_jobs_are_planned_in_short_chains(place: Place):
    (place.folder / "config").unlink()
    shipped = place.folder / "config/scenes"
    shipped.mkdir(parents=True)
    keys = yaml.safe_load((PROJECT / "config/scenes/smoke.yaml").read_text())
    keys |= {"time": {**keys["time"], "windows": WINDOWS}, "workflow": {"windows_per_job": 1}}
    names = [f"member{number}" for number in range(SCENES)]
    for name in names:
        (shipped / f"{name}.yaml").write_text(yaml.safe_dump({**keys, "name": name}))
    reports = [f"results/{name}/report.html" for name in names]
    done = place.run(shipped / f"{names[0]}.yaml", "--dag", *reports)
    assert done.returncode == 0, done.stdout[-2000:]
    waits = graph(done.stdout)
    assert len(waits) >= 3000
    assert depth(waits) <= 150
    # Looking writes nothing.
    assert not (place.folder / "results").exists()


def test_lint_finds_what_is_meant_alone(place: Place):
    """One environment, of setup/requirements.lock or Apptainer.def, serves all rules."""
    done = place.run(place.scene(), "--lint")
    titles = {title.strip(":") for title in re.findall(r"^ {4}\* (.+)$", done.stdout, re.M)}
    assert titles == {"Specify a conda environment or container for each rule."}, done.stdout
    assert not (place.folder / "results").exists()


def test_snakemakes_own_report_has_categories_labels_and_captions(
    smoke: Done, copy: Callable[[], Place]
):
    """The report and its figures, each with the scene's name, in one file that needs no network."""
    place = copy()
    before = {path: path.stat().st_mtime_ns for path in place.results().rglob("*.nc")}
    done = place.run(place.scene(), "--report=all.html")
    assert done.returncode == 0, done.stdout[-3000:]
    page = (place.folder / "all.html").read_text(encoding="utf-8")
    results, categories, said = (
        json.loads(re.search(rf"var {name} = ([{{\"].*);\n", page)[1])
        for name in ("results", "categories", "workflow_desc")
    )
    assert set(categories) == {"Report", "Figures"} and "Sea ice as discrete elements" in said
    report = results["results/smoke/report.html"]
    assert report["labels"] == {"scene": "smoke"} and "time slider" in report["caption"]
    figures = [each for path, each in results.items() if "/figures/" in path]
    assert len(figures) > 10
    assert {each["labels"]["scene"] for each in figures} == {"smoke"}
    assert "elements_thickness_end" in {each["labels"]["figure"] for each in figures}
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_auto_is_decided_once_and_written_for_the_jobs(place: Place):
    target = "results/smoke/effects.json"
    scene = place.scene(effects="auto", mask={"land": "mask"})
    done = place.run(scene, target, ranks=1)
    assert done.returncode == 0, done.stdout
    resolved = place.results() / "scene.yaml"
    keys = yaml.safe_load(resolved.read_text())
    said = json.loads((place.folder / target).read_text())
    assert said["chosen_by"] == "auto" and said["effects"] == keys["effects"]
    assert "wind" in keys["effects"] and "walls" not in keys["effects"]
    # Resolved anew, to the same: nothing is written and nothing is done.
    before = resolved.stat().st_mtime_ns
    assert "Nothing to be done" in place.run(scene, target, ranks=1).stdout
    assert resolved.stat().st_mtime_ns == before
    # Named, the same effects are chosen by the scene.
    named = place.scene(effects=keys["effects"], mask={"land": "mask"})
    done = place.run(named, target, ranks=1)
    assert done.returncode == 0, done.stdout
    assert json.loads((place.folder / target).read_text())["chosen_by"] == "scene"


def test_the_workflow_runs_as_a_module_of_another(place: Place):
    scene = place.scene(mask={"land": "mask"})
    (place.folder / "Snakefile").write_text(
        f"""
module ice:
    snakefile: "{PROJECT}/Snakefile"
    config: config

use rule * from ice as ice_*

rule mine:
    default_target: True
    input: "results/smoke/preprocess/mask.nc"
    output: "mine.txt"
    shell: "wc -c {{input}} > {{output}}"
"""
    )
    command = place.command(scene, 1, "mine.txt")
    command[command.index("--snakefile") + 1] = str(place.folder / "Snakefile")
    # Its rules have other names here.
    at = command.index("--set-threads")
    del command[at : at + 2]
    done = subprocess.run(command, check=False, cwd=place.folder.parent, **STREAMS)
    assert done.returncode == 0, done.stdout
    assert int((place.folder / "mine.txt").read_text().split()[0]) > 1000


def test_the_scene_of_the_workflow_catalog_is_planned(place: Place):
    command = place.command(Path("unused"), 2, "-n")
    at = command.index("--config")
    command[at : at + 2] = ["--configfile", str(PROJECT / ".test/config/config.yaml")]
    done = subprocess.run(command, check=False, **STREAMS)
    assert done.returncode == 0 and "results/smoke/report.html" in done.stdout, done.stdout
    usage = yaml.safe_load((PROJECT / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert usage["mandatory-flags"]["flags"].startswith("--config scene=config/scenes/smoke.yaml")


def test_a_plugin_may_be_named(place: Place, monkeypatch: pytest.MonkeyPatch):
    scene, target = place.scene(), "results/smoke/state/0003.nc"
    other = place.folder / "mine.so"
    other.symlink_to(PROJECT / "build/liggghts_models/libfloe.so")
    monkeypatch.setenv("FLOEFLOW_PLUGIN", str(other))
    done = place.run(scene, "--filegraph", target)
    assert done.returncode == 0 and str(other) in done.stdout, done.stdout
    monkeypatch.setenv("FLOEFLOW_PLUGIN", "/nowhere/libfloe.so")
    done = place.run(scene, "-n", target)
    assert done.returncode == 1
    assert "floeflow: FLOEFLOW_PLUGIN=/nowhere/libfloe.so: there is no such file" in done.stdout
