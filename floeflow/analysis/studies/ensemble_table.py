# SPDX-License-Identifier: GPL-2.0-or-later
"""What an ensemble study found: cost and change of statistics of each setting, with intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floeflow.analysis.estimate.influence import ICE_FLOOR
from floeflow.analysis.studies.ensemble_plan import AGAIN
from floeflow.analysis.studies.equivalence import (
    WITHIN,
    Interval,
    difference,
    pool,
    together,
    verdict,
)
from floeflow.analysis.studies.variants import BASE

Array = NDArray[np.float64]
Record = Mapping[str, Any]

# What all intervals of a setting hold together; each has its part of the rest (Bonferroni).
CONFIDENCE = 0.95
# Differences below this are round-off, and no interval is narrower.
ROUND_OFF = 1.0e-9

# Statistics by name, and to what their differences are relative.
STATISTICS: Mapping[str, str] = {
    "drift_speed": "drift in boxes, its size: share of the mean of the scene's members",
    "drift_direction": "drift in boxes, its direction: radians (1 % is 0.6 degrees)",
    "drift_pattern": "drift in boxes, what size and direction leave: share of its rms",
    "deformation": "mean deformation rate of boxes: share of it",
    "strong_deformation": "its 90th percentile: share of it",
    "volume": "ice volume: share of its change in the run, 1 % of it at least",
    "area": "ice area: share of its change in the run, 1 % of it at least",
    "ridged": "area used up by ridging: share of it",
    "broken": "bonds broken: share of it",
    "bonded": "length that bonds hold: share of it",
    "patchiness": "its spread over boxes: share of it",
}


@dataclass(frozen=True)
class Row:
    """A setting.

    Parameters
    ----------
    name, group, label : str
        Variant, what is varied, and how tables call it.
    members : int
        How many ran through.
    fault : str
        Sentence of one that did not; empty where all ran.
    cost : Interval
        CPU time relative to the scene's.
    changes : mapping
        By statistic, relative; empty where fewer than two members ran.
    """

    name: str
    group: str
    label: str
    members: int
    fault: str
    cost: Interval
    changes: Mapping[str, Interval]

    @property
    def largest(self) -> str:
        """Statistic whose interval allows the largest change."""
        return max(self.changes, key=self._bound) if self.changes else ""

    @property
    def bound(self) -> float:
        """Largest change that the intervals allow."""
        return self.changes[self.largest].bound if self.changes else math.inf

    @property
    def change(self) -> float:
        """Largest change as estimated."""
        return max((abs(found.mean) for found in self.changes.values()), default=math.inf)

    def verdict(self, share: float) -> str:
        """What is shown of all statistics for a share.

        Parameters
        ----------
        share : float
            Change that is allowed, 0.05 for 5 %.

        Returns
        -------
        str
            within, beyond or not known.
        """
        return together([verdict(found, share) for found in self.changes.values()])

    def _bound(self, name: str) -> float:
        return self.changes[name].bound


@dataclass(frozen=True)
class Ensemble:
    """The study.

    Parameters
    ----------
    rows : sequence of Row
        The scene again first, then its settings.
    members : int
        Of the scene.
    seconds : Interval
        CPU seconds of one run of the scene.
    means : mapping
        Of the scene's members, by statistic as recorded.
    parting : mapping
        How fast runs part, of the base record.
    """

    rows: Sequence[Row]
    members: int
    seconds: Interval
    means: Mapping[str, float]
    parting: Mapping[str, Any]

    @property
    def floor(self) -> float:
        """Change that the scene's own members, taken again, are not shown to keep below."""
        return next(row.bound for row in self.rows if row.name == AGAIN)


def ensemble_table(records: Sequence[Record]) -> Ensemble:
    """Compare every setting with the scene.

    Parameters
    ----------
    records : sequence of mapping
        Of all runs of the study.
    """
    by_name = {str(record["variant"]): record for record in records}
    base = by_name[BASE]
    values = {name: member_values(record, base) for name, record in by_name.items()}
    known = [name for name in STATISTICS if len(values[BASE].get(name, ())) > 1]
    confidence = 1.0 - (1.0 - CONFIDENCE) / max(len(known), 1)
    spreads = {name: pool([own[name] for own in values.values() if name in own]) for name in known}
    costs = {name: log_costs(record) for name, record in by_name.items()}
    clock = pool(list(costs.values()))
    rows = []
    for name, record in by_name.items():
        if name == BASE:
            continue
        own = values[name]
        changes = {
            key: _no_narrower(difference(own[key], values[BASE][key], spreads[key], confidence))
            for key in known
            if len(own.get(key, ())) > 1
        }
        faults = [member["fault"] for member in record["members"] if member["fault"]]
        found = (
            difference(costs[name], costs[BASE], clock, CONFIDENCE) if len(costs[name]) else None
        )
        cost = Interval(*map(_exp, (found.mean, found.low, found.high))) if found else NOT_KNOWN
        rows.append(
            Row(
                name,
                str(record["group"]),
                str(record["label"]),
                len(record["members"]) - len(faults),
                faults[0] if faults else "",
                cost,
                {} if faults else changes,
            )
        )
    rows.sort(key=lambda row: row.name != AGAIN)
    seconds = np.array([member["cpu_seconds"] for member in base["members"]])
    means = {
        key: float(np.mean([member["statistics"][key] for member in base["members"]]))
        for key in base["members"][0]["statistics"]
    }
    one = difference(seconds, np.zeros(1), pool([seconds]), CONFIDENCE)
    return Ensemble(rows, len(base["members"]), one, means, base["parting"])


NOT_KNOWN = Interval(math.nan, math.nan, math.nan)


def _exp(value: float) -> float:
    return math.exp(value) if value < 700.0 else math.inf


def _no_narrower(found: Interval) -> Interval:
    low, high = min(found.low, found.mean - ROUND_OFF), max(found.high, found.mean + ROUND_OFF)
    return Interval(found.mean, low, high)


def log_costs(record: Record) -> Array:
    """Logarithm of each member's CPU time over that of the clock beside it, (n,).

    Parameters
    ----------
    record : Record
        Of a setting's members.
    """
    ran = [member for member in record["members"] if not member["fault"]]
    return np.array([math.log(member["cpu_seconds"] / member["clock_seconds"]) for member in ran])


def member_values(record: Record, base: Record) -> dict[str, Array]:
    """Statistics of a setting's members, in the units in which they are compared.

    Parameters
    ----------
    record, base : mapping
        Of the setting and of the scene.

    Returns
    -------
    dict of ndarray
        By name of `STATISTICS`, (n,).
    """
    ran = [member for member in record["members"] if not member["fault"]]
    if not ran:
        return {}
    found: dict[str, Array] = {}
    for name in STATISTICS:
        if all(name in member["statistics"] for member in (*ran, *base["members"])):
            scale = _scale(name, base)
            if scale > 0.0:
                values = [member["statistics"][name] for member in ran]
                found[name] = np.array(values) / scale
    return found | _drift_values(ran, base, record is base)


def _scale(name: str, base: Record) -> float:
    mean = float(np.mean([member["statistics"][name] for member in base["members"]]))
    if name not in ("volume", "area"):
        return abs(mean)
    start = float(base["members"][0]["start"][name])
    return max(abs(mean - start), ICE_FLOOR * start)


def _drift_values(ran: Sequence[Record], base: Record, same: bool) -> dict[str, Array]:
    """Drift of members against the mean of the scene's: size, direction and what these leave.

    The coefficient of complex regression on that mean, and the rms of what it leaves over the rms
    of the mean. A member of the scene is compared with the mean of the others.
    """
    fields = [_complex(member) for member in base["members"]]
    sizes, turns, rests = [], [], []
    for number, member in enumerate(ran):
        others = [field for k, field in enumerate(fields) if not (same and k == number)]
        own = fields[number] if same else _complex(member)
        mean = np.mean(others, axis=0)
        both = np.isfinite(own) & np.isfinite(mean)
        if not both.any():
            return {}
        one, truth = own[both], mean[both]
        size = float((np.abs(truth) ** 2).sum())
        if size == 0.0:
            return {}
        factor = complex((np.conj(truth) * one).sum() / size)
        sizes.append(abs(factor))
        turns.append(math.atan2(factor.imag, factor.real))
        rests.append(float(np.sqrt((np.abs(one - factor * truth) ** 2).sum() / size)))
    return {
        "drift_speed": np.array(sizes),
        "drift_direction": np.array(turns),
        "drift_pattern": np.array(rests),
    }


def _complex(member: Record) -> NDArray[np.complex128]:
    """Velocities of boxes as complex numbers, NaN where none is known, (ny, nx)."""
    u, v = np.array(member["drift"], dtype=float)
    return np.asarray(u + 1j * v)


@dataclass(frozen=True)
class Wish:
    """The cheapest setting that is shown to keep all statistics to a share; None for none.

    ``members`` is how many members of every setting would be needed to show it of the scene itself,
    where those that ran cannot.
    """

    share: float
    row: Row | None
    members: int


def wishes(study: Ensemble, shares: Sequence[float]) -> list[Wish]:
    """What can be said for each wanted share.

    The scene as it is keeps its own statistics: nothing need be cheaper.

    Parameters
    ----------
    study : Ensemble
        What was measured.
    shares : sequence of float
        Relative changes that would be accepted, such as 0.05.

    Returns
    -------
    list of Wish
        One for each share.
    """
    found = []
    for share in shares:
        good = [
            row
            for row in study.rows
            if row.name != AGAIN and row.cost.high < 1.0 and row.verdict(share) == WITHIN
        ]
        row = min(good, key=lambda each: each.cost.mean) if good else None
        floor = study.floor
        enough = floor <= share
        count = study.members if enough else math.ceil(study.members * (floor / share) ** 2)
        found.append(Wish(share, row, count))
    return found


def is_beaten(row: Row, rows: Sequence[Row]) -> bool:
    """Whether a setting cheaper than the scene's is dearer than one that is shown to change less.

    What a dearer setting changes is no loss: it is what the scene's own still lacks.

    Parameters
    ----------
    row : Row
        Setting.
    rows : sequence of Row
        All settings.

    Returns
    -------
    bool
        False for the scene's own setting.
    """
    others = [other for other in rows if other is not row and other.name != AGAIN]
    coarser = row.name != AGAIN and row.cost.mean < 1.0
    return coarser and any(
        other.cost.mean < row.cost.mean and other.bound <= row.bound for other in others
    )
