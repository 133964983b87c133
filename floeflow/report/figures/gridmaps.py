# SPDX-License-Identifier: GPL-2.0-or-later
"""Maps of the gridded fields, with the land of the mask over them."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from floeflow.report.figures.frame import Frame, prepare_axes
from floeflow.report.figures.maps import WIDTH, add_colour_bar, draw_arrows, say_no_ice
from floeflow.report.figures.style import (
    CONCENTRATION,
    SNOW,
    SPEED,
    THICKNESS,
    VOLUME,
    Quantity,
    look,
    new_figure,
)

FIELDS: dict[str, Quantity] = {
    "siconc": CONCENTRATION,
    "sithick": THICKNESS,
    "sivol": VOLUME,
    "sisnthick": SNOW,
    "drift": SPEED,
}


def field_values(grid: xr.Dataset, name: str) -> np.ndarray | None:
    """A field with NaN where there is no ice, (y, x); None where the grid does not hold it."""
    if name == "drift":
        if "siu" not in grid or "siv" not in grid:
            return None
        values = np.hypot(grid["siu"].values, grid["siv"].values)
    elif name in grid:
        values = np.array(grid[name].values, dtype=float)
    else:
        return None
    values[~(grid["siconc"].values > 0)] = np.nan
    return np.asarray(values)


def grid_map(
    frame: Frame, grid: xr.Dataset, name: str, limits: tuple[float, float], title: str
) -> Figure | None:
    """Map a gridded field; drift speed with arrows.

    Parameters
    ----------
    frame : Frame
        Land, projection, extent.
    grid : xarray.Dataset
        CF grid with x, y (m) and fields (y, x).
    name : str
        A name in ``FIELDS``.
    limits : tuple of float
        Ends of the colour scale.
    title : str
        Title.

    Returns
    -------
    Figure or None
        None where the grid does not hold the field.
    """
    values = field_values(grid, name)
    if values is None:
        return None
    quantity = FIELDS[name]
    x, y = grid["x"].values / 1e3, grid["y"].values / 1e3
    with look():
        figure = new_figure(*frame.size(WIDTH))
        axes = figure.add_subplot()
        prepare_axes(axes, frame, title, quantity.water)
        axes.pcolormesh(
            x,
            y,
            np.ma.masked_invalid(values),
            shading="nearest",
            cmap=quantity.cmap,
            vmin=limits[0],
            vmax=limits[1],
            zorder=0.5,
        )
        beyond = bool(np.nanmax(values, initial=limits[1]) > limits[1])
        add_colour_bar(figure, axes, quantity, limits, beyond)
        ice = np.isfinite(values)
        if not ice.any():
            say_no_ice(axes)
        elif name == "drift":
            gx, gy = np.meshgrid(x, y)
            u, v = grid["siu"].values[ice], grid["siv"].values[ice]
            draw_arrows(axes, frame, gx[ice], gy[ice], u, v, "m/s")
    return figure
