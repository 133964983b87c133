# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables and sentences of the ensemble study."""

from __future__ import annotations

from collections.abc import Sequence

from floeflow.analysis.studies.ensemble_plan import NUDGE
from floeflow.analysis.studies.ensemble_table import (
    STATISTICS,
    Ensemble,
    Row,
    Wish,
    is_beaten,
    wishes,
)
from floeflow.analysis.studies.equivalence import Interval
from floeflow.report.study_page import Table, measured

SHARES = (0.01, 0.05, 0.2)
LEAD = (
    "Each setting was made finer and coarser, alone, and ran with several members, whose wind "
    "stress differs by 0.1 % from one to the next. Compared are statistics of the members with "
    "those of the scene as it is. Intervals hold with 95 % confidence, for all statistics of a "
    "setting together. Cost is CPU time of the windows over that of a window of the scene that "
    "ran just before."
)


def per_cent(found: Interval) -> str:
    """A relative value and half its interval in per cent.

    Parameters
    ----------
    found : Interval
        Relative value, 0.05 for 5 %.
    """
    return measured(100.0 * found.mean, 100.0 * found.half)


def ratio(found: Interval) -> str:
    """A ratio with half its interval.

    Parameters
    ----------
    found : Interval
        Of two costs (1).
    """
    return measured(found.mean, max(found.half, 1e-3))


def sentences(study: Ensemble) -> list[str]:
    """What the study says first.

    Parameters
    ----------
    study : Ensemble
        What was measured.
    """
    said = [
        f"A run of the scene takes {study.seconds.mean:.3g} ± {study.seconds.half:.1g} s of CPU "
        f"time in its windows ({study.members} members).",
        f"The scene's own members, run again with other stresses, are shown to be the same to "
        f"{100 * study.floor:.2g} %: no setting can be shown to be better than that here.",
        _parting(study),
    ]
    return [*said, *(_wish(wish, study.members) for wish in wishes(study, SHARES))]


def _wish(wish: Wish, members: int) -> str:
    share = f"{100 * wish.share:.3g} %"
    if wish.row is not None:
        return (
            f"Cheapest setting shown to keep all statistics to {share}: {wish.row.label}, at "
            f"{ratio(wish.row.cost)} of the cost."
        )
    if wish.members > members:
        return (
            f"No cheaper setting is shown to keep all statistics to {share}; to show as much of "
            f"the scene itself takes some {wish.members} members."
        )
    return f"No cheaper setting is shown to keep all statistics to {share}."


def _parting(study: Ensemble) -> str:
    apart, drift = study.parting["apart"], study.parting["drift"][-1]
    days = study.parting["time"][-1] / 86400.0
    parts = ", ".join(
        f"{_length(gaps[-1])} (stress changed by {float(nudge):g})" for nudge, gaps in apart.items()
    )
    return (
        f"After {days:.3g} days single elements, which drifted by {drift / 1000:.3g} km, are apart "
        f"by {parts}; members of the ensemble differ by {NUDGE:g}."
    )


def _length(metres: float) -> str:
    return f"{metres / 1000:.2g} km" if metres >= 100.0 else f"{metres:.2g} m"


def setting_table(study: Ensemble) -> Table:
    """Settings by cost: largest change, and what is shown for 1, 5 and 20 %.

    Parameters
    ----------
    study : Ensemble
        What was measured.
    """
    rows: list[Sequence[object]] = []
    for row in study.rows:
        if row.fault:
            shown: list[object] = [f"failed: {row.fault}", "", *[""] * len(SHARES)]
        elif row.changes:
            shown = [
                per_cent(row.changes[row.largest]),
                row.largest,
                *(row.verdict(share) for share in SHARES),
            ]
        else:
            shown = ["–", "", *["not known"] * len(SHARES)]
        rows.append([_name(row, study), row.members, ratio(row.cost), *shown])
    shown_to = tuple(f"to {100 * share:.3g} %" for share in SHARES)
    head = ("setting", "members", "cost (of the scene's)", "largest change (%)", "of", *shown_to)
    note = (
        "'within': all statistics are shown to change by less. 'beyond': one is shown to change by "
        "more. 'not known': the interval allows both. In brackets: a coarser setting that costs "
        "more than another which is shown to change less."
    )
    return Table("Settings", head, rows, note)


def _name(row: Row, study: Ensemble) -> str:
    return f"({row.label})" if is_beaten(row, study.rows) else row.label


def change_table(study: Ensemble) -> Table:
    """Changes of all statistics.

    Parameters
    ----------
    study : Ensemble
        What was measured.
    """
    names = [name for name in STATISTICS if any(name in row.changes for row in study.rows)]
    rows = [
        [row.label, *(per_cent(row.changes[n]) if n in row.changes else "–" for n in names)]
        for row in study.rows
    ]
    note = (
        "Boxes are 150 km wide, in small domains a sixth of the shorter side. Relative to: "
        + "; ".join(f"{name}: {STATISTICS[name]}" for name in names)
        + "."
    )
    return Table("Change of each statistic (%)", ("setting", *names), rows, note)
