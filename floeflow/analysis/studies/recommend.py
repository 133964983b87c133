# SPDX-License-Identifier: GPL-2.0-or-later
"""The cheapest setting of all knobs that keeps an error, from a study's points.

Errors of knobs add up as squares, their factors of work multiply: that is how single knobs predict
runs that turn several. The runs that vary all knobs together show how well it holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from floeflow.analysis.studies.accuracy_table import Point
from floeflow.analysis.studies.measures import KEPT


@dataclass(frozen=True)
class Setting:
    """A level for each knob, with predicted error (largest of the kept norms) and work."""

    levels: Mapping[str, float]
    error: float
    work: float


def quieted(points: Sequence[Point], noise: float) -> list[Point]:
    """Runs whose work differs from the default's by no more than the clock does, as cheap as it.

    The scene's own level comes first in a series: others must be better to be chosen.

    Parameters
    ----------
    points : sequence of Point
        Runs.
    noise : float
        Relative difference of the work of one and the same run.

    Returns
    -------
    list of Point
        Those of the scene's own level first.
    """
    even = [replace(p, work=1.0) if abs(p.work - 1.0) <= noise else p for p in points]
    return sorted(even, key=lambda p: p.level != 1.0)


def worst(point: Point, norms: Sequence[str] = KEPT) -> float:
    """Largest relative error of a run over the norms that a recommendation keeps.

    Parameters
    ----------
    point : Point
        Run.
    norms : sequence of str, optional
        Those that count.

    Returns
    -------
    float
        1.
    """
    return max((point.errors.get(name, 0.0) for name in norms), default=0.0)


def settings(points: Sequence[Point], knobs: Sequence[str]) -> list[Setting]:
    """Combinations of the knobs' stable levels that no other beats in work and every kept norm.

    Knob by knob, so that what is beaten already need not be combined with what comes.

    Parameters
    ----------
    points : sequence of Point
        Runs.
    knobs : sequence of str
        Numerical settings by name.

    Returns
    -------
    list of Setting
        With relative work and error.
    """
    levels: list[dict[str, float]] = [{}]
    # Squares of the errors and, last, the work; both grow with those of every further knob.
    rank = np.array([[0.0] * len(KEPT) + [1.0]])
    for knob in knobs:
        series = [p for p in points if p.knob == knob and p.stable]
        if not series:
            continue
        own = np.array([[p.errors.get(norm, 0.0) ** 2 for norm in KEPT] for p in series])
        squares = (rank[:, None, :-1] + own).reshape(-1, len(KEPT))
        work = (rank[:, None, -1] * np.array([p.work for p in series])).reshape(-1, 1)
        rank = np.hstack([squares, work])
        levels = [{**before, knob: p.level} for before in levels for p in series]
        best = _unbeaten(rank)
        rank, levels = rank[best], [levels[k] for k in best]
    worst = np.sqrt(rank[:, :-1].max(axis=1))
    return [Setting(*row) for row in zip(levels, worst.tolist(), rank[:, -1].tolist(), strict=True)]


def _unbeaten(rank: NDArray[np.float64]) -> list[int]:
    """Rows that no other row beats, or equals and comes before, in all columns."""
    kept: list[int] = []
    for k in np.lexsort(rank.T):
        if not (rank[kept] <= rank[k]).all(axis=1).any():
            kept.append(int(k))
    return kept


def recommend(points: Sequence[Point], knobs: Sequence[str], error: float) -> Setting | None:
    """Cheapest setting with at most this error; None where there is none.

    Parameters
    ----------
    points : sequence of Point
        Runs.
    knobs : sequence of str
        Numerical settings by name.
    error : float
        Relative error, 0.05 for 5 %.

    Returns
    -------
    Setting or None
        None where there is none.
    """
    good = [s for s in settings(points, knobs) if s.error <= error]
    return min(good, key=lambda s: (s.work, s.error)) if good else None


def most_accurate(points: Sequence[Point], knobs: Sequence[str], work: float) -> Setting | None:
    """Most accurate setting of at most this work; None where there is none.

    Parameters
    ----------
    points : sequence of Point
        Runs.
    knobs : sequence of str
        Numerical settings by name.
    work : float
        Relative to the scene's own.

    Returns
    -------
    Setting or None
        None where there is none.
    """
    good = [s for s in settings(points, knobs) if s.work <= work]
    return min(good, key=lambda s: (s.error, s.work)) if good else None
