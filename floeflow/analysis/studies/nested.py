# SPDX-License-Identifier: GPL-2.0-or-later
"""Run a variant through the workflow, and read what it cost.

A variant is a job of the study's workflow that starts a workflow of its own on one core. The
outer one knows the study, the inner one the scene; both can be interrupted and go on. A run that
fails is a result of a study: its sentence is kept.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from floeflow.core.errors import FloeError
from floeflow.core.records import CPU_LINE
from floeflow.scene import Scene
from floeflow.scene.docs import PROJECT


@dataclass
class Outcome:
    """How a variant ended and what it cost.

    Parameters
    ----------
    name : str
        Its scene.
    fault : str
        The sentence with which it failed; empty where it did not.
    cpu : dict
        CPU seconds by part: dynamics and column within the windows, other stages by name.
    wall : dict
        Wall seconds of the parts of the windows.
    element_steps : float
        Elements times steps of the element model.
    steps : int
        Steps of the element model.
    time_step : float
        Of the element model, s.
    elements : int
        Elements, coast included.
    """

    name: str
    fault: str = ""
    cpu: dict[str, float] = field(default_factory=dict)
    wall: dict[str, float] = field(default_factory=dict)
    element_steps: float = 0.0
    steps: int = 0
    time_step: float = 0.0
    elements: int = 0

    @property
    def cpu_seconds(self) -> float:
        """CPU seconds of the whole run."""
        return sum(self.cpu.values())


def targets(scene: Scene) -> list[str]:
    """Files that a variant must make: its last state, and the output that its effects name."""
    folder = f"results/{scene.name}"
    last = f"{scene.time.windows:04d}"
    wanted = [f"{folder}/state/{last}.nc"]
    if "grid_output" in scene.effects:
        wanted += [f"{folder}/grid/{last}.nc"]
    if "trajectory_output" in scene.effects:
        wanted += [f"{folder}/trajectory/elements.lammpsdump"]
    return wanted


def run_scene(
    path: Path, scene: Scene, log: Path, ranks: int = 1, wanted: Sequence[str] = ()
) -> str:
    """Run a scene's workflow up to its targets, on one core where it has one rank.

    Returns
    -------
    str
        The sentence with which it failed; empty where it did not.

    Raises
    ------
    FloeError
        Where it was interrupted or Snakemake itself failed: that says nothing of the scene.
    """
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(PROJECT / "Snakefile")]
    command += ["--cores", str(ranks), "--rerun-incomplete", "--set-threads", f"window={ranks}"]
    command += ["--config", f"scene={path}", "--", *(wanted or targets(scene))]
    log.parent.mkdir(parents=True, exist_ok=True)
    with open(log, "w") as out:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=out, stderr=out)
    if not done.returncode:
        return ""
    said = [line for line in log.read_text().splitlines() if line.startswith("floeflow: ")]
    if done.returncode < 0 or not said:
        raise FloeError(f"the run of {path} broke off (code {done.returncode}); see {log}")
    return said[-1].removeprefix("floeflow: ")


def read_outcome(scene: Scene, fault: str, results: Path = Path("results")) -> Outcome:
    """What a variant's stages and windows cost, from their logs and cost files."""
    folder = results / scene.name
    outcome = Outcome(scene.name, fault)
    outcome.cpu = stage_cpu(folder / "log")
    for path in sorted((folder / "cost").glob("*.json")):
        _add_window(outcome, json.loads(path.read_text()))
    inside = sum(outcome.cpu.get(part, 0.0) for part in ("dynamics", "column"))
    if "window" in outcome.cpu:
        outcome.cpu["window"] = max(0.0, outcome.cpu["window"] - inside)
    return outcome


def stage_cpu(folder: Path) -> dict[str, float]:
    """CPU seconds of the stages of a run, from its folder of logs."""
    cpu: dict[str, float] = {}
    for log in sorted(folder.rglob("*.log")):
        found = re.findall(rf"{CPU_LINE}([0-9.]+) s$", log.read_text(errors="replace"), re.M)
        if found:
            stage = log.relative_to(folder).parts[0].removesuffix(".log")
            cpu[stage] = cpu.get(stage, 0.0) + float(found[-1])
    return cpu


def _add_window(outcome: Outcome, records: list[Mapping[str, Any]]) -> None:
    for record in records:
        name = str(record["name"])
        outcome.wall[name] = outcome.wall.get(name, 0.0) + sum(map(float, record["seconds"]))
        if "cpu_seconds" in record:
            outcome.cpu[name] = outcome.cpu.get(name, 0.0) + float(record["cpu_seconds"])
        if record["name"] == "dynamics":
            outcome.element_steps += float(record["n"]) * int(record["steps"])
            outcome.steps += int(record["steps"])
            outcome.time_step = float(record["time_step"])
            outcome.elements = int(record["n"])
