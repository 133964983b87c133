# SPDX-License-Identifier: GPL-2.0-or-later
"""Breaks of bonds: when they come, how they cluster, and how many neighbours break at once."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from floeflow.diagnostics.break_events import SOON
from floeflow.report.figures.series import time_axis
from floeflow.report.figures.style import (
    BLUE,
    FAINT,
    INK,
    VERMILION,
    look,
    new_figure,
    style_axes,
)

# Fewer breaks have no statistics.
FEW = 100


def break_figures(data: xr.Dataset, start: datetime) -> Iterator[tuple[str, str, Figure]]:
    """Draw what ``analyses.nc`` holds of the breaks.

    Parameters
    ----------
    data : xarray.Dataset
        As from `floeflow.diagnostics.analyses`.
    start : datetime
        Of the scene.

    Yields
    ------
    tuple of str, str and Figure
        Name, caption, figure.
    """
    if "break_fano" not in data or int(data["break_count"].sum()) < FEW:
        return
    counts = data["break_count"].values
    with_events = "break_event_elements" in data
    with look():
        figure = new_figure(6.0, 5.2)
        rows = figure.subplot_mosaic([["when", "when"], ["time", "space" if with_events else "."]])
        _when(rows["when"], data, start)
        _in_time(rows["time"], data)
        if with_events:
            _in_space(rows["space"], data)
    unit, word = time_axis(float(data["break_step"].values[0]))
    step = float(data["break_step"].values[0]) / unit
    caption = (
        f"{counts.sum():,} bonds broke, half of them in "
        f"{100.0 * float(data['break_busy_share']):.0f} % of the time. Top: breaks in intervals of "
        f"{step:.3g} {word} between samples. Below left: variance of the counts over their mean "
        "(Fano factor), and the same of neighbouring intervals alone (Allan factor), by the length "
        "of the intervals; independent breaks at a steady rate have 1 (band: two standard errors). "
        "Both rise with cascades; the Fano factor rises with any change of the wind as well, and "
        f"neither tells the cause. {100.0 * float(data['break_soon_share']):.0f} % of the breaks "
        f"come in the first {100.0 * SOON:.3g} % of a window: a larger share than that follows the "
        "windows, between which bonds freeze, and not the wind."
    )
    if with_events:
        caption += _said_of_space(data)
    caption += " (analyses.nc: break_count, break_fano, break_allan"
    caption += ", break_event_elements, break_neighbour_ratio)." if with_events else ")."
    yield "bonds_events", caption, figure


def _said_of_space(data: xr.Dataset) -> str:
    elements = data["break_event_elements"].values
    ratio, mean, drawn = (
        float(np.nanmedian(data[f"break_{name}"].values))
        for name in ("neighbour_ratio", "mean_event", "random_event")
    )
    return (
        " Below right: events, which are neighbours that lost bonds in the same window: "
        f"{elements.size:,}, the largest of {elements.max():,} elements. In the median window "
        f"neighbours both break {ratio:.2g} times as often as by chance, and a broken element's "
        f"event has {mean:.3g} elements, {drawn:.3g} where as many are drawn at random. A window "
        "takes separate events together, bonds that froze in it hide others, and elements beside "
        "those that left are not counted."
    )


def _when(axes: Axes, data: xr.Dataset, start: datetime) -> None:
    seconds, counts = data["break_time"].values, data["break_count"].values
    unit, word = time_axis(float(seconds[-1]))
    axes.fill_between(seconds / unit, counts, step="pre", color=BLUE, linewidth=0, alpha=0.8)
    style_axes(axes, f"Time since {start:%Y-%m-%d %H:%M} ({word})", "Bonds that broke (1)")
    axes.set_ylim(0)


def _in_time(axes: Axes, data: xr.Dataset) -> None:
    steps, blocks = data["break_step"].values, data["break_blocks"].values
    unit, word = time_axis(float(steps[-1]))
    at, wide = steps / unit, 2.0 * np.sqrt(2.0 / (blocks - 1.0))
    low = np.maximum(1.0 - wide, 0.05)
    axes.fill_between(at, low, 1.0 + wide, color=FAINT, alpha=0.25, linewidth=0)
    for name, colour, mark in (("fano", INK, "o-"), ("allan", VERMILION, "s--")):
        values = data[f"break_{name}"].values
        shown = np.where(values > 0.0, values, np.nan)
        axes.loglog(at, shown, mark, color=colour, markersize=4, label=name.title())
    style_axes(axes, f"Length of the intervals ({word})", "Factor (1)")
    axes.legend(fontsize=8.5)


def _in_space(axes: Axes, data: xr.Dataset) -> None:
    sizes = np.sort(data["break_event_elements"].values)[::-1]
    rank = np.arange(1, sizes.size + 1)
    axes.loglog(sizes, rank, ".", color=BLUE, markersize=4)
    style_axes(axes, "Elements of the event", "Events at least as large")
