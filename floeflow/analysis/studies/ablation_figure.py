# SPDX-License-Identifier: GPL-2.0-or-later
"""Figure of an ablation study: influence and saving of each effect, measured beside estimated."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from floeflow.analysis.estimate.choose import NEEDED
from floeflow.analysis.studies.ablation_table import Ablation
from floeflow.report.figures.style import BLUE, FAINT, SKY, VERMILION, look, new_figure

# Influences below this share are drawn at it.
LEAST = 1.0e-6


def ablation_figure(study: Ablation) -> Figure:
    """Two panels over the effects, the most influential at the top.

    Left: influence (logarithmic), measured as filled and estimated as open marks, joined by a line;
    shaded is what chaos alone makes. Right: share of the work (CPU time of element model and
    column) saved by leaving the effect out.

    Parameters
    ----------
    study : Ablation
        What was measured.
    """
    rows = sorted(study.rows, key=lambda row: row.share if np.isfinite(row.share) else np.inf)
    places = np.arange(len(rows))
    with look():
        figure = new_figure(9.0, 1.3 + 0.3 * max(4, len(rows)))
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
        measured, guessed = (
            np.clip([getattr(row, name) for row in rows], LEAST, 1e3)
            for name in ("share", "estimated_share")
        )
        for place, one, two in zip(places, measured, guessed, strict=True):
            left.plot([one, two], [place, place], color=FAINT, linewidth=1, zorder=1)
        left.plot(measured, places, "o", color=BLUE, label="measured", zorder=3)
        left.plot(
            guessed,
            places,
            "D",
            markerfacecolor="white",
            color=VERMILION,
            label="estimated",
            zorder=2,
        )
        left.axvspan(LEAST / 2, max(study.floor, LEAST / 2), color=FAINT, alpha=0.18, linewidth=0)
        left.axvline(NEEDED, color=FAINT, linestyle="--", linewidth=1)
        left.set_xscale("log")
        left.set_xlabel("Influence: change relative to what happens in the run (1)")
        left.set_yticks(places, [row.name for row in rows])
        left.legend(loc="lower right")
        saved = [100 * np.nan_to_num(r.saving) for r in rows]
        right.barh(places, saved, 0.62, color=SKY, label="measured")
        right.plot(
            [100 * row.estimated_saving for row in rows],
            places,
            "D",
            markerfacecolor="white",
            color=VERMILION,
            label="estimated",
        )
        right.axvline(0, color=FAINT, linewidth=0.8)
        right.set_xlabel("Work saved without it (%)")
        right.legend(loc="lower right")
        for axes in (left, right):
            axes.grid(axis="x", color=FAINT, alpha=0.25, linewidth=0.6)
            axes.spines[["top", "right"]].set_visible(False)
            axes.set_axisbelow(True)
    return figure
