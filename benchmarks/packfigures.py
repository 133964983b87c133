# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of the pack: maps of some days, and bonds in time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cmocean
import matplotlib.pyplot as plt
import numpy as np
import shapely
import xarray as xr
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap, Normalize
from numpy.typing import NDArray
from PIL import Image

from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]

# What is mapped: title, colours, ends of the scale.
PANELS = (
    ("thickness of the ice (m)", cmocean.cm.dense, (0.0, 5.0)),
    ("outline held by whole bonds (1)", cmocean.cm.matter, (0.0, 1.0)),
    ("ridged share of the volume (1)", cmocean.cm.amp, (0.0, 0.6)),
    ("open water in elements (1)", cmocean.cm.tempo, (0.0, 0.3)),
)


def draw_days(
    states: Mapping[float, xr.Dataset],
    outlined: Mapping[float, NDArray[np.object_]],
    mask: xr.Dataset,
    path: Path,
) -> None:
    """Map thickness, whole bonds, ridged share and open water of some days.

    Parameters
    ----------
    states : mapping
        Elements by day.
    outlined : mapping
        Outlines of the mobile ones, shapely.Polygon, in their order.
    mask : xarray.Dataset
        With ``land``.
    path : Path
        PNG to write.
    """
    x, y = mask["x"].values / 1e3, mask["y"].values / 1e3
    land = np.ma.masked_equal(mask["land"].values, 0)
    figure, axes = plt.subplots(
        *(len(states), len(PANELS)),
        figsize=(12.0, 3.1 * len(states)),
        layout="constrained",
        squeeze=False,
    )
    half = 0.5 * (x[1] - x[0])
    sides = (x[0] - half, x[-1] + half, y[0] - half, y[-1] + half)
    for number, (day, state) in enumerate(sorted(states.items())):
        drawn = values(state, outlined[day])
        rings = [np.asarray(each.exterior.coords) / 1e3 for each in outlined[day]]
        panels = zip(axes[number], PANELS, drawn, strict=True)
        for k, (axis, (title, colours, limits), shade) in enumerate(panels):
            axis.set_facecolor("#eef3f7")
            axis.imshow(land, extent=sides, origin="lower", cmap=ListedColormap(["0.72"]))
            icy = np.flatnonzero(np.isfinite(shade))
            patches = PolyCollection(
                [rings[i] for i in icy], array=shade[icy], cmap=colours, norm=Normalize(*limits)
            )
            patches.set(edgecolor="face", linewidth=0.2)
            axis.add_collection(patches, autolim=False)
            axis.set(xlim=sides[:2], ylim=sides[2:], xticks=[], yticks=[], aspect="equal")
            if number == 0:
                axis.set_title(title, fontsize=10)
            if number == len(states) - 1:
                figure.colorbar(patches, ax=axes[:, k], location="bottom", shrink=0.7, pad=0.01)
        axes[number, 0].set_ylabel(f"day {day:g}")
    save(figure, path)


def values(state: xr.Dataset, outlined: NDArray[np.object_]) -> tuple[Array, Array, Array, Array]:
    """What the panels show of the mobile elements; NaN where an element has no ice."""
    mobile = state["type"].values == MOBILE
    share = state["ice_fraction"].values[mobile].sum(axis=1)
    by_category = state["ice_volume"].values[mobile]
    volume = by_category.sum(axis=1)
    icy = share > 0.0
    level = state["level_volume"].values[mobile] if "level_volume" in state else 1.0
    ridged = (by_category * (1.0 - level)).sum(axis=1)
    held = state["bonded_length"].values[mobile] / shapely.length(outlined)

    def over(amount: Array, whole: Array) -> Array:
        return np.divide(amount, whole, out=np.full_like(amount, np.nan), where=icy)

    return (
        over(volume, share),
        np.where(icy, np.minimum(held, 1.0), np.nan),
        over(ridged, volume),
        1.0 - share,
    )


def draw_bonds(told: Mapping[str, Any], path: Path) -> None:
    """Whole bonds in time, over what breaks and freezes in each window and the drift."""
    day, windows = np.array(told["day"]), told["windows"]
    middle = 0.5 * (day[:-1] + day[1:])
    figure, axes = plt.subplots(3, 1, figsize=(9.0, 6.0), sharex=True, layout="constrained")
    share = np.array(told["bonded"]) / np.array(told["perimeter"])
    axes[0].plot(day, share, color="#0072b2")
    axes[0].set(ylabel="whole bonds,\nshare of the outlines", ylim=(0.0, None))
    axes[1].plot(middle, windows["broken"] / np.diff(day), color="#d55e00", label="break")
    axes[1].plot(
        middle, windows["frozen"] / np.diff(day), color="#009e73", ls="--", label="freeze together"
    )
    axes[1].set(ylabel="bonds a day", ylim=(0.0, None))
    axes[1].legend(frameon=False)
    axes[2].plot(middle, 100.0 * np.array(windows["speed"]), color="#1d2733")
    axes[2].set(ylabel="mean drift (cm/s)", ylim=(0.0, None), xlabel="days since the start")
    save(figure, path)


def save(figure: plt.Figure, path: Path) -> None:
    """Write a figure as PNG of few colours, which is small, and close it."""
    figure.savefig(path, dpi=80)
    plt.close(figure)
    with Image.open(path) as picture:
        small = picture.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    small.save(path, optimize=True)
