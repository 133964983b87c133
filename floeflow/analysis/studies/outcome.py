# SPDX-License-Identifier: GPL-2.0-or-later
"""How a run of a study ended and what it cost, from the records that its stages left."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

# Rules whose CPU seconds the records of the windows tell in parts.
WINDOW_RULES = ("windows", "variant")


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
        CPU seconds by part: dynamics, column and forcing within the windows, ``window`` for what
        else their job takes, other stages by name.
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


def read_outcome(
    name: str, fault: str, costs: Iterable[Path], stages: Path, job: float | None = None
) -> Outcome:
    """What a run's stages and windows cost.

    Parameters
    ----------
    name : str
        The run's scene.
    fault : str
        The sentence with which it failed, or nothing.
    costs : iterable of Path
        Records of its windows.
    stages : Path
        Folder with the CPU seconds of its other stages.
    job : float, optional
        CPU seconds of the job that ran all windows; None where none did.
    """
    stage = {rule: cpu for rule, cpu in stage_cpu(stages).items() if rule not in WINDOW_RULES}
    outcome = Outcome(name, fault)
    for path in sorted(costs):
        if path.is_file():
            _add_windows(outcome, json.loads(path.read_text()))
    if job is not None:
        outcome.cpu["window"] = max(0.0, job - outcome.cpu_seconds)
    outcome.cpu |= stage
    return outcome


def stage_cpu(folder: Path) -> dict[str, float]:
    """CPU seconds of the stages of a run by rule, summed over the jobs of a rule.

    Parameters
    ----------
    folder : Path
        ``results/<scene>/cpu``, where the jobs left them.
    """
    cpu: dict[str, float] = {}
    for path in sorted(folder.glob("*.json")):
        record = json.loads(path.read_text())
        cpu[record["rule"]] = cpu.get(record["rule"], 0.0) + float(record["cpu_seconds"])
    return cpu


def _add_windows(outcome: Outcome, records: Iterable[Mapping[str, Any]]) -> None:
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
