# SPDX-License-Identifier: GPL-2.0-or-later
"""The cheapest combination of all settings that keeps an error, from a study's points.

Errors of settings add up as squares, their factors of work multiply: that is how single settings
predict runs that change several. The runs that vary all settings together show how well it holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from floeflow.analysis.studies.accuracy_table import Point
from floeflow.analysis.studies.measures import KEPT


@dataclass(frozen=True)
class Combination:
    """A level for each setting, with predicted error (largest of the kept norms) and work."""

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


def combinations(points: Sequence[Point], settings: Sequence[str]) -> list[Combination]:
    """Combinations of the settings' stable levels that no other beats in work and every kept norm.

    Setting by setting, so that what is beaten already need not be combined with what comes.

    Parameters
    ----------
    points : sequence of Point
        Runs.
    settings : sequence of str
        Numerical settings by name.

    Returns
    -------
    list of Combination
        With relative work and error.
    """
    levels: list[dict[str, float]] = [{}]
    # Squares of the errors and, last, the work; both grow with those of every further setting.
    rank = np.array([[0.0] * len(KEPT) + [1.0]])
    for setting in settings:
        series = [p for p in points if p.setting == setting and p.stable]
        if not series:
            continue
        own = np.array([[p.errors.get(norm, 0.0) ** 2 for norm in KEPT] for p in series])
        squares = (rank[:, None, :-1] + own).reshape(-1, len(KEPT))
        work = (rank[:, None, -1] * np.array([p.work for p in series])).reshape(-1, 1)
        rank = np.hstack([squares, work])
        levels = [{**before, setting: p.level} for before in levels for p in series]
        best = _unbeaten(rank)
        rank, levels = rank[best], [levels[k] for k in best]
    worst = np.sqrt(rank[:, :-1].max(axis=1))
    return [
        Combination(*row) for row in zip(levels, worst.tolist(), rank[:, -1].tolist(), strict=True)
    ]


def _unbeaten(rank: NDArray[np.float64]) -> list[int]:
    """Rows that no other row beats, or equals and comes before, in all columns."""
    kept: list[int] = []
    for k in np.lexsort(rank.T):
        if not (rank[kept] <= rank[k]).all(axis=1).any():
            kept.append(int(k))
    return kept


def recommend(points: Sequence[Point], settings: Sequence[str], error: float) -> Combination | None:
    """Cheapest combination with at most this error; None where there is none.

    Parameters
    ----------
    points : sequence of Point
        Runs.
    settings : sequence of str
        Numerical settings by name.
    error : float
        Relative error, 0.05 for 5 %.

    Returns
    -------
    Combination or None
        None where there is none.
    """
    good = [s for s in combinations(points, settings) if s.error <= error]
    return min(good, key=lambda s: (s.work, s.error)) if good else None


def most_accurate(
    points: Sequence[Point], settings: Sequence[str], work: float
) -> Combination | None:
    """Most accurate combination of at most this work; None where there is none.

    Parameters
    ----------
    points : sequence of Point
        Runs.
    settings : sequence of str
        Numerical settings by name.
    work : float
        Relative to the scene's own.

    Returns
    -------
    Combination or None
        None where there is none.
    """
    good = [s for s in combinations(points, settings) if s.work <= work]
    return min(good, key=lambda s: (s.error, s.work)) if good else None
