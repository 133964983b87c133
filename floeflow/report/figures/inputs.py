# SPDX-License-Identifier: GPL-2.0-or-later
"""Small maps of what a scene reads: ice, and the forcing at its start."""

from __future__ import annotations

import math

import cmocean
import xarray as xr
from matplotlib.colors import Colormap
from matplotlib.figure import Figure

from floeflow.report.figures.frame import Frame, draw_land
from floeflow.report.figures.style import new_figure

COLUMNS, SIDE = 3, 3.2
MAPS: dict[str, tuple[str, Colormap]] = {
    "siconc": ("Ice concentration (1)", cmocean.cm.ice),
    "sithick": ("Ice thickness (m)", cmocean.cm.dense),
    "wind": ("Wind (m/s)", cmocean.cm.speed),
    "ocean": ("Current (m/s)", cmocean.cm.speed),
    "air_temperature": ("Air temperature (K)", cmocean.cm.thermal),
    "specific_humidity": ("Specific humidity (kg/kg)", cmocean.cm.rain),
    "air_pressure": ("Air pressure (Pa)", cmocean.cm.deep),
    "shortwave_down": ("Short wave (W/m2)", cmocean.cm.solar),
    "longwave_down": ("Long wave (W/m2)", cmocean.cm.thermal),
    "snowfall": ("Snowfall (kg/m2/s)", cmocean.cm.rain),
    "ocean_heat_flux": ("Ocean heat flux (W/m2)", cmocean.cm.amp),
}


def input_maps(frame: Frame, mask: xr.Dataset, forcing: xr.Dataset) -> Figure:
    """Maps of the mask and of the first fields of the forcing; vectors as speed and arrows.

    Parameters
    ----------
    frame : Frame
        Of the scene.
    mask : xarray.Dataset
        As `floeflow.masks.mask.make_mask` returns it.
    forcing : xarray.Dataset
        As `floeflow.forcings.forcing.make_forcing` returns it.

    Returns
    -------
    Figure
        Of Matplotlib, to be closed by the caller.
    """
    shown = {name: mask[name].where(mask["land"] == 0) for name in ("siconc", "sithick")}
    for name in MAPS:
        if name in forcing:
            shown[name] = forcing[name].isel(time=0)
        elif f"{name}_u" in forcing:
            u, v = (forcing[f"{name}_{axis}"].isel(time=0) for axis in "uv")
            shown[name] = (u**2 + v**2) ** 0.5
    rows = math.ceil(len(shown) / COLUMNS)
    left, right, bottom, top = frame.extent
    height = SIDE * (top - bottom) / (right - left) + 0.5
    figure = new_figure(COLUMNS * (SIDE + 0.8), rows * height)
    grid = figure.subplots(rows, COLUMNS, squeeze=False)
    for axes, name in zip(grid.flat, shown, strict=False):
        title, colours = MAPS[name]
        x, y = shown[name]["x"].values / 1e3, shown[name]["y"].values / 1e3
        picture = axes.pcolormesh(x, y, shown[name].values, cmap=colours, shading="nearest")
        if name == "siconc":
            picture.set_clim(0.0, 1.0)
        figure.colorbar(picture, ax=axes, shrink=0.8)
        draw_land(axes, frame.land)
        if f"{name}_u" in forcing:
            every = max(1, x.size // 12)
            cut = (slice(every // 2, None, every),) * 2
            arrows = [forcing[f"{name}_{axis}"].isel(time=0).values[cut] for axis in "uv"]
            axes.quiver(x[cut[1]], y[cut[0]], *arrows, width=0.004)
        axes.set(title=title, aspect="equal", xlim=(left, right), ylim=(bottom, top))
        axes.set_xticks([])
        axes.set_yticks([])
    for axes in grid.flat[len(shown) :]:
        axes.axis("off")
    return figure
