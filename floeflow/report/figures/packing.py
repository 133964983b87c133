# SPDX-License-Identifier: GPL-2.0-or-later
"""How good the packing is, element by element: sizes, neighbours, cells beside what was asked."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from floeflow.packings.quality import neighbour_counts
from floeflow.report.figures.style import BLUE, FAINT, INK, SKY, look, new_figure
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]

BINS = 30
# Sizes are drawn up to these shares of the elements, so that single ones do not squeeze the rest.
SHARES = (0.001, 0.999)


def packing_figures(packing: xr.Dataset) -> Iterator[tuple[str, str, Figure]]:
    """Draw how radii, cells, neighbours and sizes are distributed; nothing without elements.

    Parameters
    ----------
    packing : xarray.Dataset
        As `floeflow.packings.packing.make_packing` returns it.

    Yields
    ------
    name, caption : str
        Of the figure.
    figure : Figure
        Of Matplotlib, to be closed by the caller.
    """
    mobile = packing["type"].values == MOBILE
    if not mobile.any():
        return
    sides, touching = neighbour_counts(packing)
    asked = packing["size_ratio"].values[mobile] if "size_ratio" in packing else None
    with look():
        figure = new_figure(6.4, 4.6)
        panels = figure.subplots(2, 2).ravel()
        _sizes(panels[0], packing["radius"].values[mobile] / 1e3, "Radius of the disc (km)")
        cell = np.sqrt(packing["area"].values[mobile]) / 1e3
        _sizes(panels[1], cell, "Root of the cell's area (km)")
        _neighbours(panels[2], sides, touching)
        if asked is None:
            panels[3].axis("off")
        else:
            _sizes(panels[3], asked, "Cell size over the size function (1)")
            panels[3].axvline(1.0, color=INK, linewidth=0.9, linestyle="--")
        for axes in panels:
            axes.spines[["top", "right"]].set_visible(False)
            axes.grid(color=FAINT, alpha=0.25, linewidth=0.6)
            axes.set_axisbelow(True)
    caption = (
        f"The packing of {int(mobile.sum())} elements: radii of discs, sizes of cells, and with "
        f"how many others each shares a side of its cell (mean {sides.mean():.2f}) or is in touch "
        f"(mean {touching.mean():.2f})"
    )
    if asked is not None:
        caption += f"; cell sizes over those that were asked for (spread {asked.std():.2f})"
    yield "packing_quality", f"{caption}.", figure


def _sizes(axes: Axes, values: Array, label: str) -> None:
    low, high = np.quantile(values, SHARES)
    if not high > low:
        low, high = 0.9 * low, 1.1 * high
    axes.hist(np.clip(values, low, high), bins=BINS, range=(low, high), color=BLUE)
    axes.set_xlabel(label)
    axes.set_ylabel("Elements")


def _neighbours(axes: Axes, sides: NDArray[np.int64], touching: NDArray[np.int64]) -> None:
    most = int(max(sides.max(initial=0), touching.max(initial=0))) + 1
    place = np.arange(most)
    for shift, counts, colour, hatch, label in (
        (-0.2, sides, BLUE, "", "sides of the cell"),
        (0.2, touching, SKY, "///", "discs in touch"),
    ):
        height = np.bincount(counts, minlength=most)
        axes.bar(place + shift, height, 0.4, color=colour, hatch=hatch, edgecolor=INK,
                 linewidth=0.4, label=label)  # fmt: skip
    axes.set_xlabel("Neighbours of an element")
    axes.set_ylabel("Elements")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(fontsize=8)
