# SPDX-License-Identifier: GPL-2.0-or-later
"""The cheapest setting of all knobs that keeps an error, from a study's points.

Errors of knobs add up as squares, their factors of work multiply: that is how single knobs predict
runs that turn several. The runs that vary all knobs together show how well it holds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from floeflow.studies.accuracy_table import Point
from floeflow.studies.measures import KEPT


@dataclass(frozen=True)
class Setting:
    """A level for each knob, with predicted error (largest of the kept norms) and work."""

    levels: Mapping[str, float]
    error: float
    work: float


def worst(point: Point, norms: Sequence[str] = KEPT) -> float:
    """Largest relative error of a run over the norms that a recommendation keeps."""
    return max((point.errors.get(name, 0.0) for name in norms), default=0.0)


def settings(points: Sequence[Point], knobs: Sequence[str]) -> list[Setting]:
    """All combinations of the knobs' stable levels."""
    series = [[p for p in points if p.knob == knob and p.stable] for knob in knobs]
    series = [found for found in series if found]
    found = []
    for choice in product(*series):
        error = max(math.sqrt(sum(p.errors.get(norm, 0.0) ** 2 for p in choice)) for norm in KEPT)
        levels = {p.knob: p.level for p in choice}
        found.append(Setting(levels, error, math.prod(p.work for p in choice)))
    return found


def recommend(points: Sequence[Point], knobs: Sequence[str], error: float) -> Setting | None:
    """Cheapest setting with at most this error; None where there is none."""
    good = [s for s in settings(points, knobs) if s.error <= error]
    return min(good, key=lambda s: (s.work, s.error)) if good else None


def most_accurate(points: Sequence[Point], knobs: Sequence[str], work: float) -> Setting | None:
    """Most accurate setting of at most this work; None where there is none."""
    good = [s for s in settings(points, knobs) if s.work <= work]
    return min(good, key=lambda s: (s.error, s.work)) if good else None
