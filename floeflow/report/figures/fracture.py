# SPDX-License-Identifier: GPL-2.0-or-later
"""Fracture: stresses of bonds beside their envelope, directions of cracks and linear features."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from floeflow.report.figures.style import (
    BLUE,
    FAINT,
    INK,
    SPEED,
    VERMILION,
    look,
    new_figure,
    style_axes,
)

Array = NDArray[np.float64]
Made = tuple[str, str, Figure]
# Fewer cracks or features have no direction.
FEW = 20


def fracture_figures(data: xr.Dataset) -> Iterator[Made]:
    """Draw what ``analyses.nc`` holds of fracture.

    Parameters
    ----------
    data : xarray.Dataset
        As from `floeflow.diagnostics.analyses`.

    Yields
    ------
    tuple of str, str and Figure
        Name, caption, figure.
    """
    if "bond_stress_count" in data:
        yield _stresses(data)
    if _many(data, "crack_size"):
        yield _cracks(data)
    if _many(data, "feature_length"):
        yield _features(data)


def _many(data: xr.Dataset, name: str) -> bool:
    return name in data and data[name].size >= FEW


def envelope(tensile_share: float, friction_angle: float) -> tuple[Array, Array]:
    """The line at which bonds fail, both stresses over the compressive strength.

    Parameters
    ----------
    tensile_share : float
        Tensile over compressive strength.
    friction_angle : float
        rad.

    Returns
    -------
    tuple of ndarray
        Normal stress, above 0 in tension, and shear stress, from the tip to crushing.
    """
    slope = np.tan(friction_angle)
    normal = np.array([tensile_share, -1.0, -1.0])
    return normal, np.array([0.0, (tensile_share + 1.0) * slope, 0.0])


def _stresses(data: xr.Dataset) -> Made:
    counts = data["bond_stress_count"].values
    said = data["bond_stress_count"].attrs
    tensile, angle = float(said["tensile_share"]), float(said["friction_angle_degrees"])
    normal, shear = data["normal"].values, data["shear"].values
    edge = envelope(tensile, np.radians(angle))
    with look():
        figure = new_figure(6.0, 3.6)
        axes = figure.add_subplot()
        mesh = axes.pcolormesh(
            normal,
            shear,
            np.where(counts > 0, counts, np.nan).T,
            cmap=SPEED.cmap,
            norm=LogNorm(0.5, max(float(counts.max()), 2.0)),
            shading="nearest",
            rasterized=True,
        )
        figure.colorbar(mesh, ax=axes, label="Bonds", pad=0.01)
        axes.plot(*edge, "-", color=INK, linewidth=1.2, label="where bonds fail")
        axes.axvline(0.0, color=FAINT, linewidth=0.8)
        style_axes(
            axes, "Normal stress over compressive strength (1)", "Shear stress over the same (1)"
        )
        axes.set_xlim(-1.06, max(1.3 * tensile, 0.1))
        axes.set_ylim(0.0, 1.05 * float(edge[1].max()))
        axes.legend(loc="upper right", fontsize=8.5)
    pulled = float(counts[normal > 0].sum() / counts.sum())
    caption = (
        f"Stress of the {counts.sum():,.0f} bonds that hold at the end, each where it is nearest "
        "to failing, over its compressive strength (tension to the right), and the Mohr-Coulomb "
        f"envelope with a tensile strength of {tensile:.2g} of it and {angle:.0f}° of internal "
        f"friction. {100 * pulled:.0f} % of the bonds are pulled (analyses.nc: bond_stress_count)."
    )
    return "bonds_stress", caption, figure


def _rose(axes: Axes, data: xr.Dataset, name: str, colour: str, label: str) -> None:
    """A distribution of directions as a line through both ends of each direction."""
    length = data[name].values
    angle = data["angle"].values
    share = length / max(float(length.sum()), 1e-9) / (angle[1] - angle[0])
    around = np.concatenate([angle, angle + np.pi, angle[:1]])
    axes.plot(around, np.concatenate([share, share, share[:1]]), "-", color=colour, label=label)


def _dress(axes: Axes) -> None:
    axes.set_ylim(0.0)
    axes.tick_params(labelsize=8)
    axes.set_yticklabels([])


def _cracks(data: xr.Dataset) -> Made:
    sizes = np.sort(data["crack_size"].values)[::-1] / 1e3
    rank = np.arange(1, sizes.size + 1)
    total = float(sizes.sum())
    # Where much broke, lines meet everywhere.
    network = ", a network through the pack" if sizes[0] > 0.5 * total else ""
    with look():
        figure = new_figure(6.0, 3.6)
        rose = figure.add_subplot(1, 2, 1, projection="polar")
        _rose(rose, data, "line_angle_length", FAINT, "all bonds")
        _rose(rose, data, "crack_angle_length", VERMILION, "broken")
        _dress(rose)
        rose.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, fontsize=8.5)
        axes = figure.add_subplot(1, 2, 2)
        axes.loglog(sizes, rank, ".", color=VERMILION, markersize=4)
        style_axes(axes, "Length of the crack (km)", "Cracks at least as long")
    caption = (
        f"Left: directions of the lines that broke in the run, beside those of all bonds of the "
        "start (share of the length by direction on the map). Right: how many cracks are at least "
        f"as long; broken lines that meet in an element are one crack. {sizes.size:,} cracks of "
        f"{total:,.0f} km in all, the longest {sizes[0]:,.0f} km{network}. "
        "(analyses.nc: crack_angle_length, crack_size)."
    )
    return "bonds_cracks", caption, figure


def _features(data: xr.Dataset) -> Made:
    length = np.sort(data["feature_length"].values)[::-1] / 1e3
    density, share = data["feature_density"].values, data["localised_share"].values
    with look():
        figure = new_figure(6.0, 3.6)
        rose = figure.add_subplot(1, 2, 1, projection="polar")
        _rose(rose, data, "feature_angle_length", BLUE, "")
        _dress(rose)
        axes = figure.add_subplot(1, 2, 2)
        axes.loglog(length, np.arange(1, length.size + 1), ".", color=BLUE, markersize=4)
        style_axes(axes, "Length of the feature (km)", "Features at least as long")
    caption = (
        f"Linear features of deformation: half of all deformation lies in "
        f"{100 * float(np.nanmean(share)):.0f} % of the ice. Neighbours that deform faster than "
        "twice the mean make a feature where they are at least five spacings long and three times "
        f"as long as wide: {length.size:,} in {density.size} "
        f"intervals, median length {float(np.median(length)):,.0f} km, "
        f"{1e7 * float(np.mean(density)):.2g} km for each 10,000 km². Left: their directions on "
        "the map. Satellites' features are found by other rules (Hutter et al. 2019). "
        "(analyses.nc: localised_share, feature_length, feature_angle_length)."
    )
    return "motion_features", caption, figure
