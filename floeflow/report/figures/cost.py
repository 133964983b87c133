# SPDX-License-Identifier: GPL-2.0-or-later
"""Cost of the run: wall seconds by stage as bars."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from floeflow.report.figures.style import BLUE, FAINT, SKY, look, new_figure


def cost_figure(stages: Sequence[tuple[str, float, bool]]) -> Figure:
    """Draw the wall time of stages.

    Parameters
    ----------
    stages : sequence of tuple
        Name, wall seconds, and whether it is a part of the windows (drawn lighter and hatched).

    Returns
    -------
    Figure
        Of Matplotlib, to be closed by the caller.
    """
    with look():
        figure = new_figure(6.0, 1.0 + 0.26 * max(1, len(stages)))
        axes = figure.add_subplot()
        places = np.arange(len(stages))[::-1]
        longest = max((seconds for _, seconds, _ in stages), default=0.0) or 1.0
        for (_, seconds, inner), place in zip(stages, places, strict=True):
            axes.barh(
                place,
                seconds,
                height=0.66,
                color=SKY if inner else BLUE,
                edgecolor="white",
                hatch="////" if inner else "",
                linewidth=0,
            )
            axes.text(seconds + 0.01 * longest, place, f"{seconds:.3g} s", va="center", fontsize=8)
        axes.set_yticks(places, [name for name, _, _ in stages])
        axes.set_xlim(0, 1.15 * longest)
        axes.set_xlabel("Wall time (s)")
        axes.grid(axis="x", color=FAINT, alpha=0.25, linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right", "left"]].set_visible(False)
        axes.tick_params(axis="y", length=0)
        if not stages:
            axes.text(0.5, 0.5, "nothing was timed", transform=axes.transAxes, ha="center")
    return figure
