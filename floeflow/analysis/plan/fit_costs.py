# SPDX-License-Identifier: GPL-2.0-or-later
"""Fit the cost model to the runs of studies."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from scipy.optimize import nnls

from floeflow.analysis.estimate.conditions import Conditions, conditions
from floeflow.analysis.estimate.cost import IN_WINDOWS, bonded, coast_measure, column_parts
from floeflow.analysis.plan.propose import adjusted
from floeflow.analysis.studies.outcome import read_outcome, stage_cpu
from floeflow.analysis.studies.variants import BASE, run_name
from floeflow.core.constants import ICE_DENSITY
from floeflow.core.errors import FloeError
from floeflow.core.records import WINDOW_CPU
from floeflow.diagnostics.collect import read_grid
from floeflow.scene import Scene
from floeflow.scene.effects import EFFECTS, plugin_switches
from floeflow.scene.load import read_resolved

# Stages after the windows that every whole run has.
AFTER = ("estimate", "diagnostics", "report")


@dataclass(frozen=True)
class Run:
    """A finished run: its scene, conditions and record.

    ``launched``: whether its CPU seconds hold the start of the program that ran its windows.
    """

    scene: Scene
    conditions: Conditions
    record: Mapping[str, Any]
    launched: bool = True

    @property
    def cpu(self) -> Mapping[str, float]:
        """CPU seconds by part."""
        cpu: Mapping[str, float] = self.record["cpu"]
        return cpu


def read_runs(folders: Iterable[Path]) -> list[Run]:
    """Finished runs of studies.

    Parameters
    ----------
    folders : iterable of Path
        ``results/<scene>/<study>``.

    Raises
    ------
    FloeError
        Where a folder holds no study.
    """
    found = []
    for folder in folders:
        base = base_scene(folder)
        if not base.is_file():
            raise FloeError(f"{folder}: there is no study here")
        c = conditions(read_resolved(base))
        runs = run_name(folder.parent.name, folder.name, "*")
        for path in sorted(folder.parent.parent.glob(f"{runs}/record.json")):
            record = json.loads(path.read_text())
            scene = read_resolved(path.with_name("scene.yaml"))
            if "members" in record:
                found += [
                    Run(scene, adjusted(c, scene), with_rest(member), launched=False)
                    for member in record["members"]
                    if not member["fault"]
                ]
            elif not record["fault"]:
                found.append(Run(scene, adjusted(c, scene), record))
    return found


def with_rest(record: Mapping[str, Any]) -> dict[str, Any]:
    """A record with what its windows took beside dynamics, column and forcing, as ``window``.

    Parameters
    ----------
    record : mapping
        Seconds of a run's parts.
    """
    cpu = dict(record["cpu"])
    cpu["window"] = max(0.0, record["cpu_seconds"] - sum(cpu.values()))
    return {**record, "cpu": cpu}


def read_whole_runs(folders: Iterable[Path]) -> list[Run]:
    """Windows of whole runs on one rank, whose CPU time is known.

    Parameters
    ----------
    folders : iterable of Path
        ``results/<scene>`` of whole runs.
    """
    found = []
    for folder in folders:
        costs = sorted((folder / "cost").glob("*.json"))
        records = [record for path in costs for record in json.loads(path.read_text())]
        alone = all(record["ranks"] == 1 for record in records)
        if alone and any(WINDOW_CPU in record for record in records):
            scene = read_resolved(folder / "scene.yaml")
            outcome = asdict(read_outcome(scene.name, "", costs, folder / "no stages"))
            outcome["cpu_seconds"] = sum(record.get(WINDOW_CPU, 0.0) for record in records)
            found.append(Run(scene, conditions(scene), with_rest(outcome), launched=False))
    return found


def base_scene(folder: Path) -> Path:
    """Resolved scene of the base run of a study ``results/<scene>/<study>``.

    Parameters
    ----------
    folder : Path
        ``results/<scene>/<study>``.
    """
    name = run_name(folder.parent.name, folder.name, BASE)
    return folder.parent.parent / name / "scene.yaml"


def fit_costs(runs: Sequence[Run], old: Mapping[str, float]) -> dict[str, float]:
    """Coefficients of `floeflow.analysis.estimate.cost`; those no run tells stay.

    Parameters
    ----------
    runs : sequence of Run
        Measured runs.
    old : mapping of float
        Coefficients so far.

    Returns
    -------
    dict of float
        By name.
    """
    return {
        **old,
        **_fit_dynamics(runs),
        **_fit_column(runs),
        **_fit_jobs(runs),
        **_fit_steps(runs),
        **_fit_coast(runs),
    }


def fit_whole_runs(folders: Iterable[Path], job: float) -> dict[str, float]:
    """Coefficients of stages that studies leave out: report, grid, tendencies and land.

    Parameters
    ----------
    folders : iterable of Path
        ``results/<scene>`` of whole runs, with their logs.
    job : float
        Seconds of a job that does next to nothing.
    """
    names = ("report", "land", "grid_per_cell", "tendencies_per_cell")
    found: dict[str, list[float]] = {name: [] for name in names}
    for folder in folders:
        cpu = stage_cpu(folder / "cpu")
        found["report"].append(sum(cpu.get(name, 0.0) for name in AFTER))
        if "land" in cpu:
            found["land"].append(cpu["land"])
        if (folder / "grid.nc").is_file() and "fields" in cpu:
            sizes = read_grid(folder / "grid.nc").sizes
            cells = sizes["x"] * sizes["y"]
            chunks = len(list((folder / "fields").glob("*.nc")))
            work = max(0.0, cpu["fields"] - chunks * job) / sizes["time"]
            found["grid_per_cell"].append(work / cells)
            if "tendencies" in cpu:
                work = max(0.0, cpu["tendencies"] - job) / (sizes["time"] - 1)
                found["tendencies_per_cell"].append(work / cells)
    return {name: median(values) for name, values in found.items() if values}


def _solve(rows: list[list[float]], values: list[float], runs: Sequence[Run]) -> np.ndarray:
    """Non-negative least squares of relative errors; every base scene counts as much as another.

    Parameters
    ----------
    rows : list of list of float
        Sizes of each run, (n, k).
    values : list of float
        What they took, (n,).
    runs : sequence of Run
        Of the rows: a study of a scene has many.
    """
    scenes = [run.scene.name.partition("+")[0] for run in runs]
    many = Counter(scenes)
    weight = np.array([1.0 / math.sqrt(many[name]) for name in scenes])
    matrix = np.array(rows) * (weight / np.array(values))[:, None]
    # Columns of one size, so that small coefficients are found as well as large ones.
    size = np.linalg.norm(matrix, axis=0)
    size[size == 0] = 1.0
    return np.asarray(nnls(matrix / size, weight)[0] / size)


def _fit_dynamics(runs: Sequence[Run]) -> dict[str, float]:
    names = [name for name in EFFECTS if plugin_switches((name,))]
    rows, values, used = [], [], []
    for run in runs:
        steps, work = float(run.record["steps"]), float(run.record["element_steps"])
        if run.cpu.get("dynamics", 0.0) > 0 and work:
            effects = set(run.scene.effects)
            if not bonded(run.conditions, effects):
                effects.discard("bonds")
            rows.append([steps, work, *(work * (name in effects) for name in names)])
            values.append(run.cpu["dynamics"])
            used.append(run)
    found = _solve(rows, values, used)
    keys = ["step", "dynamics", *(f"dynamics_{name}" for name in names)]
    return dict(zip(keys, map(float, found), strict=True))


def _column_steps(scene: Scene) -> int:
    return math.ceil(scene.time.window / scene.column.step * (1 - 1e-12)) * scene.time.windows


def _fit_column(runs: Sequence[Run]) -> dict[str, float]:
    some = [run for run in runs if run.cpu.get("column", 0.0) > 0]
    parts = [column_parts(run.scene, run.scene.effects) for run in some]
    names = sorted({name for part in parts for name in part})
    rows = []
    for run, part in zip(some, parts, strict=True):
        work = float(run.record["elements"]) * _column_steps(run.scene)
        often = [work * part.get(name, 0.0) for name in names]
        rows.append([float(run.scene.time.windows), work, *often])
    if not rows:
        return {}
    found = _solve(rows, [run.cpu["column"] for run in some], some)
    keys = ["column_start", "column", *(f"column_{name}" for name in names)]
    return dict(zip(keys, map(float, found), strict=True))


def _fit_jobs(runs: Sequence[Run]) -> dict[str, float]:
    """Constants and slopes of the stages that make one job each."""
    found: dict[str, float] = {}
    starts = [run.cpu["initial"] for run in runs if "initial" in run.cpu]
    if not starts:
        raise FloeError("no run of a study made its own state 0: what a job takes is not known")
    found["job"] = median(starts)
    lands = [run.cpu["land"] for run in runs if run.cpu.get("land")]
    if lands:
        found["land"] = median(lands)
    slopes = {
        "packing_per_element": [
            (run.cpu["packing"] - found["job"]) / run.record["elements"]
            for run in runs
            if "packing" in run.cpu
        ],
        "forcing_per_cell": [
            run.cpu["forcing"] / (run.scene.time.windows * _cells(run.scene))
            for run in runs
            if "forcing" in run.cpu
        ],
    }
    for name, values in slopes.items():
        if values:
            found[name] = max(0.0, median(values))
    rows, values, used = [], [], []
    for run in runs:
        if "window" in run.cpu:
            windows = float(run.scene.time.windows)
            each = windows * run.record["elements"]
            own = [each * (name in run.scene.effects) for name in IN_WINDOWS]
            rows.append([float(run.launched), windows, each, *own])
            values.append(max(run.cpu["window"], 1e-3))
            used.append(run)
    if not rows:
        return found
    keys = ["launch", "window", "window_per_element", *(f"window_{n}" for n in IN_WINDOWS)]
    told = [any(column) for column in zip(*rows, strict=True)]
    solved = zip(keys, _solve(rows, values, used), told, strict=True)
    return {**found, **{name: float(value) for name, value, there in solved if there}}


def _cells(scene: Scene) -> float:
    d = scene.domain
    return (d.x_max - d.x_min) * (d.y_max - d.y_min) / d.spacing**2


def _fit_steps(runs: Sequence[Run]) -> dict[str, float]:
    """Critical step over element size and speed of sound: bare contacts, friction, bonds alone."""
    rows, values = [], []
    for run in runs:
        d, effects = run.scene.dynamics, run.scene.effects
        critical = float(run.record["time_step"]) / d.step_share
        contacts, bonds = d.contact_modulus / ICE_DENSITY, d.young_modulus / ICE_DENSITY
        held = bonded(run.conditions, effects)
        rows.append([contacts, contacts * ("friction" in effects), bonds * held])
        values.append((run.conditions.element_size / critical) ** 2)
    names = ("step_contacts", "step_friction", "step_bonds")
    found = _solve(rows, values, runs)
    # What costs no step in these runs is not known from them.
    return {n: float(1.0 / math.sqrt(f)) for n, f in zip(names, found, strict=True) if f > 1e-6}


def _fit_coast(runs: Sequence[Run]) -> dict[str, float]:
    ratios = [
        (run.record["elements"] / run.conditions.elements - 1.0) / coast_measure(run.conditions)
        for run in runs
        if "coast" in run.scene.effects and run.conditions.coast_share > 0.01
    ]
    return {"coast_elements": median(ratios)} if ratios else {}
