# SPDX-License-Identifier: GPL-2.0-or-later
"""Work-precision figure of an accuracy study: error over work in one norm."""

from __future__ import annotations

import math
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from floeflow.analysis.studies.accuracy_plan import TOGETHER
from floeflow.analysis.studies.accuracy_table import REFERENCE, Accuracy, Point, pareto
from floeflow.analysis.studies.measures import NORMS
from floeflow.report.figures.style import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    ORANGE,
    SKY,
    VERMILION,
    look,
    new_figure,
)

# Colour, mark and dash differ together, so that print and colour-blind eyes tell settings apart.
STYLES = (
    (BLUE, "o", "-"),
    (VERMILION, "s", "--"),
    (GREEN, "^", "-."),
    (ORANGE, "v", ":"),
    (SKY, "D", (0, (5, 1))),
    (INK, "P", (0, (1, 1))),
    ("#cc79a7", "X", (0, (3, 1, 1, 1))),
    ("#8a6d3b", "<", (0, (8, 2))),
    ("#4b0082", ">", (0, (2, 2))),
    (FAINT, "h", "-"),
    ("#7fb800", "p", "--"),
    ("#a2142f", "d", "-."),
    ("#006d77", "1", ":"),
    ("#b56576", "H", (0, (5, 1))),
    ("#3d405b", "8", (0, (1, 1))),
)
# How the scene's own setting is marked.
RING: dict[str, Any] = {"markersize": 9, "markeredgecolor": INK, "markeredgewidth": 1.2}
# Runs that vary all settings are no series.
ALL = (INK, "*", "none")
# Errors below this are round-off.
LEAST = 1.0e-7


def is_felt(study: Accuracy, norm: str) -> bool:
    """Whether any run has an error in a norm: without thermodynamics no volume changes.

    Parameters
    ----------
    study : Accuracy
        What was measured.
    norm : str
        Of the error.

    Returns
    -------
    bool
        False where all errors are round-off.
    """
    errors = [e.get(norm, 0.0) for p in study.points for e in (p.errors, p.totals)]
    return max(errors, default=0.0) >= LEAST


def accuracy_figure(study: Accuracy, norm: str) -> Figure:
    """Relative error over work, both logarithmic, one line for each setting.

    Lines show the error that a setting alone makes, the marks of "all settings" and the thick grey
    line, the Pareto front of all runs, that of all settings. Ringed marks are the default, crosses
    at the top runs that failed; below the hatched line is what chaos alone makes. Not drawn are the
    reference and what has no error: settings that the norm does not feel, runs equal to their
    limit.

    Parameters
    ----------
    study : Accuracy
        What was measured.
    norm : str
        Of the error.

    Returns
    -------
    Figure
        For page and docs.
    """
    with look():
        figure = new_figure(7.6, 4.6)
        axes = figure.add_subplot()
        names = [
            name for name in dict.fromkeys(p.setting for p in study.points) if name != TOGETHER
        ]
        for name, style in [*zip(names, cycle(STYLES), strict=False), (TOGETHER, ALL)]:
            _setting(axes, [p for p in study.points if p.setting == name], norm, name, style)
        ring = {"markerfacecolor": "none", **RING}
        axes.plot([], [], "o", linestyle="none", label="default (ringed)", **ring)
        front = [p for p in pareto(study.points, norm) if p.totals[norm] >= LEAST]
        axes.plot(
            [p.work for p in front],
            [p.totals[norm] for p in front],
            color=FAINT,
            linewidth=5,
            alpha=0.35,
            zorder=0,
            marker=".",
            label="Pareto front",
        )
        failed = [p.work for p in study.points if not p.stable]
        if failed:
            axes.plot(
                failed,
                np.full(len(failed), 0.97),
                "x",
                color=INK,
                transform=axes.get_xaxis_transform(),
                label="unstable",
            )
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
        chaos = study.chaos.get(norm, 0.0)
        if chaos > LEAST:
            axes.axhspan(
                axes.get_ylim()[0], chaos, facecolor="none", edgecolor=FAINT, hatch="//", alpha=0.4
            )
            axes.axhline(chaos, color=FAINT, linewidth=0.8)
        axes.set_xlabel("CPU time of element model and column, relative to the default run (1)")
        axes.set_ylabel("Error relative to what happens in the run (1)")
        axes.set_title(NORMS[norm].label)
        axes.grid(color=FAINT, alpha=0.25, linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8)
    return figure


def _setting(
    axes: Axes, points: list[Point], norm: str, name: str, style: tuple[str, str, object]
) -> None:
    good = [
        p for p in points if p.stable and p.errors.get(norm, 0.0) >= LEAST and p.run != REFERENCE
    ]
    if not good:
        return
    colour, mark, dash = style
    x, y = [p.work for p in good], [p.errors[norm] for p in good]
    label, size = ("all settings", 9) if name == TOGETHER else (name.replace("_", " "), 5)
    axes.plot(x, y, marker=mark, color=colour, label=label, linestyle=dash, markersize=size)
    for point in good:
        if point.level == 1.0 or (math.isnan(point.level) and point.run == "base"):
            axes.plot(point.work, point.errors[norm], mark, color=colour, linestyle="none", **RING)
