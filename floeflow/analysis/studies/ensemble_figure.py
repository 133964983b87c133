# SPDX-License-Identifier: GPL-2.0-or-later
"""Figure of an ensemble study: change of the statistics over cost, with intervals."""

from __future__ import annotations

import math
from itertools import cycle
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from floeflow.analysis.studies.accuracy_figure import RING, STYLES
from floeflow.analysis.studies.accuracy_plan import TOGETHER
from floeflow.analysis.studies.ensemble_plan import AGAIN
from floeflow.analysis.studies.ensemble_table import Ensemble, Row, is_beaten
from floeflow.report.figures.style import FAINT, INK, look, new_figure

CAPTION = (
    "How much settings change the statistics of the scene, over what they cost. Marks stand at the "
    "largest change of any statistic, vertical lines reach up to the largest that the intervals "
    "allow, horizontal lines are the intervals of the cost. The ring is the scene run again: what "
    "lies in the hatched area cannot be told from chance with so many members. To the left is "
    "what coarser settings lose, to the right what the scene's own setting still lacks. Grey: a "
    "coarser setting that costs more than another which is shown to change less."
)
NAMES = {AGAIN: "the scene again", TOGETHER: "all settings"}
# How the scene run again is marked.
HOLLOW: dict[str, Any] = {**RING, "markerfacecolor": "none"}


def ensemble_figure(study: Ensemble) -> Figure:
    """Largest change over cost, both logarithmic.

    Parameters
    ----------
    study : Ensemble
        What was measured.
    """
    rows = [row for row in study.rows if row.changes and math.isfinite(row.cost.mean)]
    groups = [g for g in dict.fromkeys(row.group for row in rows) if g not in (AGAIN, TOGETHER)]
    with look():
        figure = new_figure(8.2, 5.0)
        axes = figure.add_subplot()
        # Grey is for what another setting beats.
        strong = [style for style in STYLES if style[0] != FAINT]
        styles = dict(zip(groups, cycle(strong), strict=False))
        styles |= {TOGETHER: (INK, "*", "-"), AGAIN: (INK, "o", "-")}
        for group in (AGAIN, *groups, TOGETHER):
            colour, mark, _ = styles[group]
            label = NAMES.get(group, group.replace("_", " "))
            ring = HOLLOW if group == AGAIN else {"markersize": 6}
            axes.plot([], [], mark, color=colour, label=label, **ring)
        for row in rows:
            colour, mark, _ = styles[row.group]
            grey = is_beaten(row, study.rows)
            least = max(row.change, 1e-4)
            axes.errorbar(
                row.cost.mean,
                least,
                xerr=[[row.cost.mean - row.cost.low], [row.cost.high - row.cost.mean]],
                yerr=[[0.0], [max(row.bound - least, 0.0)]],
                fmt=mark,
                color=FAINT if grey else colour,
                alpha=0.6 if grey else 1.0,
                elinewidth=1.0,
                label="_",
                **(HOLLOW if row.name == AGAIN else {"markersize": 6}),
            )
            if not grey and row.name != AGAIN:
                axes.annotate(
                    _short(row),
                    (row.cost.mean, least),
                    xytext=(5, 4),
                    textcoords="offset points",
                    fontsize=7,
                    color=colour,
                )
        axes.set_xscale("log")
        axes.set_yscale("log")
        bottom = axes.get_ylim()[0]
        axes.axhspan(
            bottom, study.floor, facecolor="none", edgecolor=FAINT, hatch="//", alpha=0.3, zorder=0
        )
        axes.set_ylim(bottom=bottom)
        axes.axvline(1.0, color=FAINT, linewidth=0.8)
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.yaxis.set_major_formatter(lambda y, _: f"{100 * y:g} %")
        axes.set_xlabel("CPU time of the windows, relative to the scene's (1)")
        axes.set_ylabel("Largest relative change of a statistic")
        axes.grid(color=FAINT, alpha=0.25, linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8)
    return figure


def _short(row: Row) -> str:
    """What a setting is changed to."""
    return row.label.rpartition(": ")[2] if ": " in row.label else row.label.removeprefix("all ")
