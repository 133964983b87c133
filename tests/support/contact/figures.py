# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the verification cases; drawn by `make verification`."""

from __future__ import annotations

from itertools import cycle

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

Curves = dict[str, tuple[np.ndarray, np.ndarray]]


def curves(lines: Curves, points: Curves, x: str, y: str, scale: str = "linear") -> Figure:
    """Lines for theory and this model, points for other programs; named in the legend."""
    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    for (name, (a, b)), style in zip(lines.items(), cycle(("-", "--", ":", "-."))):
        axes.plot(a, b, linestyle=style, label=name)
    # Rings first, so that what coincides is seen.
    for name, (a, b) in points.items():
        ring = len(points) > 1 and name == next(iter(points))
        look = {"marker": "o", "markersize": 7} if ring else {"marker": ".", "markersize": 4}
        axes.plot(a, b, linestyle="", fillstyle="none" if ring else "full", label=name, **look)
    if scale == "log":
        axes.set_xscale("log")
        axes.set_yscale("log")
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.legend(
        fontsize="small", loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False
    )
    axes.grid(alpha=0.3)
    return figure


def aggregates(elements: dict[str, np.ndarray], number: np.ndarray) -> Figure:
    """Discs in the colours of the aggregates that they belong to."""
    figure, axes = plt.subplots(figsize=(6.4, 6.4), layout="constrained")
    discs = [
        Circle((x / 1e3, y / 1e3), r / 1e3)
        for x, y, r in zip(elements["x"], elements["y"], elements["radius"], strict=True)
    ]
    colours = np.random.default_rng(1).uniform(0.1, 0.9, (number.max() + 1, 3))
    axes.add_collection(PatchCollection(discs, facecolor=colours[number]))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel("x (km)")
    axes.set_ylabel("y (km)")
    return figure


def vortex(demsi: np.ndarray, ours: np.ndarray) -> Figure:
    """Places of the ice in both models, side by side."""
    figure, both = plt.subplots(1, 2, figsize=(9.0, 4.2), layout="constrained", sharey=True)
    for axes, place, name in zip(both, (demsi, ours), ("DEMSI", "FloeFlow"), strict=True):
        axes.plot(*(place.T / 1e3), ".", markersize=1.5)
        axes.set_aspect("equal")
        axes.set_xlim(0, 500)
        axes.set_ylim(0, 500)
        axes.set_title(name)
        axes.set_xlabel("x (km)")
    both[0].set_ylabel("y (km)")
    return figure


def shaded(state: xr.Dataset, values: np.ndarray, label: str) -> Figure:
    """Discs, darker where a value (n,) is larger; fixed ones are hatched."""
    figure, axes = plt.subplots(figsize=(6.4, 5.2), layout="constrained")
    fixed = state["type"].values == 2
    x, y, r = (state[name].values / 1e3 for name in ("x", "y", "radius"))
    discs = [Circle(place, size) for *place, size in zip(x, y, r, strict=True)]
    ice = PatchCollection([d for d, f in zip(discs, fixed, strict=True) if not f], cmap="viridis_r")
    ice.set_array(values[~fixed])
    axes.add_collection(ice)
    land = [d for d, f in zip(discs, fixed, strict=True) if f]
    axes.add_collection(PatchCollection(land, facecolor="0.8", edgecolor="black", hatch="///"))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel("x (km)")
    axes.set_ylabel("y (km)")
    figure.colorbar(ice, ax=axes, label=label)
    return figure


def bonded(states: dict[str, xr.Dataset]) -> Figure:
    """Mobile and fixed elements, with the bonds that hold, one picture below the other."""
    figure, column = plt.subplots(
        len(states), 1, figsize=(6.4, 4.6), layout="constrained", sharex=True, sharey=True
    )
    for axes, (name, state) in zip(column, states.items(), strict=True):
        x, y, r = (state[key].values / 1e3 for key in ("x", "y", "radius"))
        colour = np.where(state["type"].values == 2, "0.35", "0.85")
        discs = [Circle(place, size) for *place, size in zip(x, y, r, strict=True)]
        axes.add_collection(PatchCollection(discs, facecolor=colour))
        lo, hi = (state[f"bond_id_{end}"].values - 1 for end in ("lo", "hi"))
        axes.plot([x[lo], x[hi]], [y[lo], y[hi]], "-", color="C0", linewidth=0.8)
        axes.set_aspect("equal")
        axes.set_title(name)
        axes.set_ylabel("y (km)")
    column[-1].set_xlabel("x (km)")
    return figure
