# SPDX-License-Identifier: GPL-2.0-or-later
"""Error and cost of all runs of an accuracy study, orders of convergence, Pareto fronts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from floeflow.analysis.studies.accuracy_plan import KEPT, TOGETHER
from floeflow.analysis.studies.compare import RunEnds, read_ends, work
from floeflow.analysis.studies.measures import NORMS
from floeflow.analysis.studies.norms import errors, on_grid, relative
from floeflow.analysis.studies.numerical_settings import Setting, numerical_settings
from floeflow.analysis.studies.orders import with_tail
from floeflow.analysis.studies.variants import BASE
from floeflow.scene import Scene

Record = Mapping[str, Any]
REFERENCE = "all-finest"


@dataclass(frozen=True)
class Point:
    """A run in one setting's series.

    Parameters
    ----------
    run : str
        Its variant.
    setting : str
        What was varied; ``together`` for the runs that vary all, ``repeat`` for nudged ones.
    level : float
        Of the setting; NaN for several.
    work, cpu, element_steps : float
        Relative to the scene's default run: CPU time of element model and column, all CPU time,
        element-steps.
    stable : bool
        Whether it ran to its end with finite results.
    errors : mapping
        Relative error by norm that the setting alone makes; empty where unstable.
    totals : mapping
        Relative error by norm of all settings: against the finest run of all. With another packing
        the setting's own error and the default's total one, added as squares.
    """

    run: str
    setting: str
    level: float
    work: float
    cpu: float
    element_steps: float
    stable: bool
    errors: Mapping[str, float]
    totals: Mapping[str, float]


@dataclass(frozen=True)
class Convergence:
    """What a setting's series says in one norm."""

    setting: str
    norm: str
    expected: float | None
    observed: float
    converges: bool


@dataclass(frozen=True)
class Accuracy:
    """The study: all points, orders, chaos (error of a nudge by norm) and noise of the clock."""

    points: Sequence[Point]
    orders: Sequence[Convergence]
    chaos: Mapping[str, float]
    noise: float
    seconds: float


class Runs:
    """Results of the study's runs, read once each."""

    def __init__(self, scene: Scene, records: Mapping[str, Record], mask: xr.Dataset) -> None:
        self.scene, self.records, self.mask = scene, records, mask
        self._read: dict[str, tuple[RunEnds, tuple[xr.Dataset, xr.Dataset]]] = {}

    def ends(self, run: str) -> tuple[RunEnds, tuple[xr.Dataset, xr.Dataset]]:
        """States of a run and its fields on the base scene's grid, brought there in its own way.

        Parameters
        ----------
        run : str
            Name of the run.
        """
        if run not in self._read:
            ends = read_ends(*map(Path, self.records[run]["ends"]))
            self._read[run] = ends, on_grid(self._gridded(run), ends, self.mask)
        return self._read[run]

    def _gridded(self, run: str) -> Scene:
        way = self.records[run]["changes"].get("grid.transfer", self.scene.grid.transfer)
        grid = self.scene.grid.model_copy(update={"transfer": way})
        return self.scene.model_copy(update={"grid": grid})

    def errors(self, reference: str, run: str) -> dict[str, float]:
        """Relative errors of a run against another.

        Parameters
        ----------
        reference : str
            Names of runs.
        run : str
            Names of runs.

        Returns
        -------
        dict of float
            1, by norm.
        """
        (one, first), (two, second) = self.ends(reference), self.ends(run)
        return relative(*errors(one, two, (first, second)))

    def stable(self, run: str) -> bool:
        """Whether a run ended well.

        Parameters
        ----------
        run : str
            Name of the run.
        """
        return run in self.records and not self.records[run]["fault"]


def analyse(scene: Scene, records: Sequence[Record], mask: xr.Dataset) -> Accuracy:
    """Compare all runs of a study.

    Parameters
    ----------
    scene : Scene
        The scene of the study.
    records : sequence of mapping
        Of all runs.
    mask : xarray.Dataset
        The scene's mask.
    """
    by_name = {str(record["variant"]): record for record in records}
    runs = Runs(scene, by_name, mask)
    repeats = [name for name, record in by_name.items() if record["group"] == "repeat"]
    alike = [BASE, *repeats]
    usual = {
        "work": median(work(by_name[name]) for name in alike),
        "cpu": median(by_name[name]["cpu_seconds"] for name in alike),
        "element_steps": float(by_name[BASE]["element_steps"]),
    }
    points: list[Point] = []
    orders: list[Convergence] = []
    reference = REFERENCE if runs.stable(REFERENCE) else BASE
    for setting in numerical_settings(scene):
        found, said = _series(setting, runs, usual)
        points += [replace(p, totals=_totals(p, runs, reference)) for p in found]
        orders += said
    for name, record in by_name.items():
        if name == BASE or record["group"] == TOGETHER:
            lies = runs.errors(reference, name) if runs.stable(name) else {}
            points.append(_point(record, TOGETHER, np.nan, usual, lies, lies))
    chaos = [runs.errors(BASE, name) for name in repeats if runs.stable(name)]
    times = [work(by_name[name]) for name in alike]
    return Accuracy(
        points,
        orders,
        {name: max((c.get(name, 0.0) for c in chaos), default=0.0) for name in NORMS},
        (max(times) - min(times)) / usual["work"],
        usual["work"],
    )


def _totals(point: Point, runs: Runs, reference: str) -> dict[str, float]:
    """Errors of a setting's run against the finest of all."""
    if not point.stable:
        return {}
    if point.setting not in KEPT or point.level == 1.0:
        return runs.errors(reference, point.run)
    default = runs.errors(reference, BASE)
    return {n: float(np.hypot(e, default.get(n, 0.0))) for n, e in point.errors.items()}


def run_of(setting: Setting, place: int) -> str:
    """Variant of a setting's level.

    Parameters
    ----------
    setting : Setting
        Numerical setting.
    place : int
        Of the level in its levels.

    Returns
    -------
    str
        Name of the run.
    """
    return BASE if setting.levels[place] == 1.0 else f"{setting.name}-{place}"


def _series(
    setting: Setting, runs: Runs, usual: Mapping[str, float]
) -> tuple[list[Point], list[Convergence]]:
    """Points of one setting, from fine to coarse, and its orders in all norms."""
    names = [run_of(setting, place) for place in range(len(setting.levels))]
    levels = dict(zip(names, setting.levels, strict=True))
    well = [name for name in names if runs.stable(name)]
    against = {name: runs.errors(well[0], name) for name in well}
    steps = [runs.errors(b, a) for a, b in zip(well, well[1:], strict=False)]
    total: dict[str, dict[str, float]] = {name: {} for name in names}
    orders = []
    for norm in NORMS:
        if not all(norm in found for found in against.values()):
            continue
        series = [against[name][norm] for name in well]
        order, converges = math.nan, False
        if not setting.ways:  # nothing lies beyond the best way
            series, order, converges = with_tail(
                [levels[name] for name in well], series, [step[norm] for step in steps]
            )
        orders.append(Convergence(setting.name, norm, setting.order, order, converges))
        for name, error in zip(well, series, strict=True):
            total[name][norm] = error
    points = [
        _point(runs.records[name], setting.name, levels[name], usual, total[name])
        for name in names
        if name in runs.records
    ]
    return points, orders


def _point(
    record: Record,
    setting: str,
    level: float,
    usual: Mapping[str, float],
    lies: Mapping[str, float],
    totals: Mapping[str, float] = MappingProxyType({}),
) -> Point:
    return Point(
        str(record["variant"]),
        setting,
        level,
        work(record) / usual["work"],
        record["cpu_seconds"] / usual["cpu"],
        record["element_steps"] / usual["element_steps"] if usual["element_steps"] else 1.0,
        not record["fault"],
        lies,
        totals,
    )


def pareto(points: Sequence[Point], norm: str) -> list[Point]:
    """Runs that no other beats in both work and total error, cheapest first.

    The reference itself is none of them.

    Parameters
    ----------
    points : sequence of Point
        Runs.
    norm : str
        Of the error.

    Returns
    -------
    list of Point
        Ascending in work.
    """
    front: list[Point] = []
    good = [p for p in points if p.stable and norm in p.totals and p.run != REFERENCE]
    for point in sorted(good, key=lambda p: (p.work, p.totals[norm])):
        if not front or point.totals[norm] < front[-1].totals[norm]:
            front.append(point)
    return front


def as_dataset(study: Accuracy, scene: Scene) -> xr.Dataset:
    """All runs of a study on ``run`` and ``norm``, for ``accuracy.nc``.

    Parameters
    ----------
    study : Accuracy
        What was measured.
    scene : Scene
        Its keys.

    Returns
    -------
    xarray.Dataset
        With units and descriptions.
    """
    points = study.points
    names = list(NORMS)
    table = [[p.errors.get(name, np.nan) for name in names] for p in points]
    totals = [[p.totals.get(name, np.nan) for name in names] for p in points]
    text = {name: np.array([getattr(p, name) for p in points]) for name in ("run", "setting")}
    numbers = {
        name: ("point", np.array([getattr(p, name) for p in points], dtype=float), {"units": "1"})
        for name in ("level", "work", "cpu", "element_steps")
    }
    data = xr.Dataset(
        {
            **{name: ("point", values) for name, values in text.items()},
            **numbers,
            "stable": ("point", np.array([p.stable for p in points], dtype=np.int8)),
            "error": (("point", "norm"), np.array(table), {"units": "1"}),
            "total_error": (("point", "norm"), np.array(totals), {"units": "1"}),
            "chaos": ("norm", np.array([study.chaos[name] for name in names]), {"units": "1"}),
            "norm": ("norm", np.array(names)),
        }
    )
    data.attrs = {
        "scene": scene.name,
        "default_work_seconds": study.seconds,
        "work": "CPU time of element model and column relative to the scene's default run",
        "error": "relative to what happens in the run; see docs/accuracy.md",
        "noise": study.noise,
    }
    return data
