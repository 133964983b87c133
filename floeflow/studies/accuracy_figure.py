# SPDX-License-Identifier: GPL-2.0-or-later
"""Work-precision figure of an accuracy study: error over work in one norm."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from floeflow.postprocess.figures.style import (
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
from floeflow.studies.accuracy_plan import TOGETHER
from floeflow.studies.accuracy_table import REFERENCE, Accuracy, Point, pareto
from floeflow.studies.measures import NORMS

# Colour, mark and dash differ together, so that print and colour-blind eyes tell knobs apart.
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
    ("#a2142f", "*", "-."),
    ("#006d77", "d", ":"),
    ("#b56576", "H", (0, (5, 1))),
    ("#3d405b", "8", (0, (1, 1))),
)
LEAST = 1.0e-7


def accuracy_figure(study: Accuracy, norm: str) -> Figure:
    """Relative error over work, both logarithmic, one line for each knob.

    Lines show the error that a knob alone makes, the marks of "all knobs" and the thick grey line,
    the Pareto front of all runs, that of all knobs. Stars are the default, crosses at the top runs
    that failed; below the hatched line is what chaos alone makes. Not drawn are the reference and
    knobs that the norm does not feel.
    """
    with look():
        figure = new_figure(7.6, 4.6)
        axes = figure.add_subplot()
        names = list(dict.fromkeys(p.knob for p in study.points))
        for name, style in zip(names, STYLES, strict=False):
            _knob(axes, [p for p in study.points if p.knob == name], norm, name, style)
        front = pareto(study.points, norm)
        axes.plot(
            [p.work for p in front],
            [max(p.totals[norm], LEAST) for p in front],
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


def _knob(
    axes: Axes, points: list[Point], norm: str, name: str, style: tuple[str, str, object]
) -> None:
    good = [p for p in points if p.stable and norm in p.errors and p.run != REFERENCE]
    if max((p.errors[norm] for p in good), default=0.0) < LEAST:
        return
    colour, mark, dash = style
    x, y = [p.work for p in good], [max(p.errors[norm], LEAST) for p in good]
    if name == TOGETHER:
        axes.plot(x, y, mark, color=colour, label="all knobs", linestyle="none", markersize=8)
    else:
        label = name.replace("_", " ")
        axes.plot(x, y, marker=mark, color=colour, label=label, linestyle=dash, markersize=5)
    for point in good:
        if point.level == 1.0 or (math.isnan(point.level) and point.run == "base"):
            axes.plot(
                point.work,
                max(point.errors[norm], LEAST),
                marker="*",
                color=colour,
                markersize=13,
                markeredgecolor="white",
                linestyle="none",
            )
