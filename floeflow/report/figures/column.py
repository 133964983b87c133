# SPDX-License-Identifier: GPL-2.0-or-later
"""The year of one column: a section of temperatures by depth, thicknesses, and what drives them."""

from __future__ import annotations

from datetime import datetime
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter
from matplotlib.figure import Figure
from numpy.typing import NDArray

from floeflow.core.constants import ZERO_CELSIUS
from floeflow.report.figures.style import BLUE, FAINT, INK, VERMILION, look, new_figure

Times = NDArray[np.datetime64]

COLDEST = -25.0  # degC, low end of the section's scale where nothing is colder


def column_figure(data: xr.Dataset, start: datetime, title: str) -> Figure:
    """Draw a column's record.

    Parameters
    ----------
    data : xarray.Dataset
        From `floeflow.analysis.single_column.year.run_column`.
    start : datetime
        To which its seconds refer.
    title : str
        Above the figure.

    Returns
    -------
    Figure
        Section of snow and ice, thicknesses (m), temperatures (degC), over time.
    """
    seconds = data["time"].values
    epoch = np.datetime64(start.replace(tzinfo=None), "s")
    when = epoch + np.round(seconds).astype("timedelta64[s]")
    with look():
        figure = new_figure(8.0, 8.4)
        axes = figure.subplots(3, 1, sharex=True, height_ratios=(3, 2, 2))
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
        _section(figure, axes[0], when, data)
        _thicknesses(axes[1], when, data)
        _temperatures(axes[2], when, data)
        locator = AutoDateLocator()
        axes[2].xaxis.set_major_locator(locator)
        axes[2].xaxis.set_major_formatter(ConciseDateFormatter(locator))
        axes[2].set_xlim(when[0], when[-1])
        for each in axes:
            each.grid(color=FAINT, alpha=0.25, linewidth=0.5)
    return figure


def _section(figure: Figure, axes: Axes, when: Times, data: xr.Dataset) -> None:
    """Temperatures in the ice below, and in the snow above, the ice's surface at zero."""
    ice = np.nan_to_num(data["ice_thickness"].values)
    snow = np.nan_to_num(data["snow_thickness"].values)
    warm = data["ice_temperature"].values - ZERO_CELSIUS
    layers = warm.shape[1]
    low = min(COLDEST, float(np.nanmin(warm, initial=0.0)))
    scale: dict[str, Any] = {"cmap": "inferno", "vmin": low, "vmax": 0.0, "shading": "gouraud"}
    # Every layer is drawn from its upper to its lower face, so that the bottom is where it is.
    faces = -ice[:, None] * np.linspace(0.0, 1.0, layers + 1)
    inner = 0.5 * (warm[:, 1:] + warm[:, :-1])
    top = np.fmin(data["surface_temperature"].values - ZERO_CELSIUS, 0.0)
    if "snow_temperature" in data:
        top = np.where(snow > 0.01, 1.5 * warm[:, 0] - 0.5 * warm[:, 1], top)
    bottom = data["sea_temperature"].values - ZERO_CELSIUS
    at_faces = np.column_stack([np.fmin(top, 0.0), inner, np.fmin(bottom, warm[:, -1] + 2.0)])
    x = np.broadcast_to(when[:, None], faces.shape)
    filled = np.ma.masked_invalid(at_faces)
    mesh = axes.pcolormesh(x, faces, filled, **scale)
    if snow.any():
        axes.fill_between(when, 0.0, snow, facecolor="white", edgecolor=INK, linewidth=0.6)
        axes.fill_between(when, 0.0, snow, facecolor="none", edgecolor=FAINT, hatch="....", lw=0)
    axes.plot(when, -ice, color=INK, linewidth=1.0)
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.set_ylim(-1.08 * max(float(ice.max()), 0.1), 1.4 * max(float(snow.max()), 0.05))
    axes.set_ylabel("Height above the ice's surface (m)")
    axes.set_title("Temperature in the ice; snow dotted above it")
    figure.colorbar(mesh, ax=axes, label="Temperature (°C)", extend="min", pad=0.01)


def _thicknesses(axes: Axes, when: Times, data: xr.Dataset) -> None:
    axes.plot(when, data["ice_volume"], color=BLUE, label="ice (m)")
    axes.plot(when, data["snow_volume"], color=VERMILION, linestyle="--", label="snow (m)")
    axes.plot(when, data["ice_fraction"], color=FAINT, linestyle=":", label="share under ice (1)")
    axes.set_ylabel("Per area (m), share (1)")
    axes.set_ylim(bottom=0.0)
    _legend(axes)
    axes.set_title("Ice and snow per area")


def _legend(axes: Axes) -> None:
    """Above the axes, where no line can be."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3, borderaxespad=0.0)


def _temperatures(axes: Axes, when: Times, data: xr.Dataset) -> None:
    drawn = (
        ("air_temperature", "air", FAINT, "-"),
        ("surface_temperature", "surface", VERMILION, "-"),
        ("sea_temperature", "sea", BLUE, "--"),
    )
    for name, label, colour, dash in drawn:
        width = 0.8 if name == "air_temperature" else 1.3
        values = data[name].values - ZERO_CELSIUS
        axes.plot(when, values, color=colour, linestyle=dash, linewidth=width, label=label)
    axes.set_ylabel("Temperature (°C)")
    axes.set_title("Air, surface and mixed layer")
    _legend(axes)
