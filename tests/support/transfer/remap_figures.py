# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the transfer from elements to fresh elements; drawn by `make verification`."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from floeflow.dynamics.remesh.overlap import carried_polygons
from floeflow.dynamics.remesh.remap import outlines
from floeflow.state.cells import rings_of
from floeflow.state.schema import MOBILE
from support.transfer.sheets import Sheet, ratios
from support.transfer.squeeze import Squeeze

LINES = {"remap": "-", "merge": "--", "": ":"}


def _draw(
    axes: plt.Axes, state: xr.Dataset, values: np.ndarray, limits: tuple[float, float]
) -> None:
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    start, corner = outlines(state, mobile)
    place = np.stack([state["x"].values, state["y"].values], axis=1)[mobile]
    polygons = carried_polygons(
        start, corner, place, state["theta"].values[mobile], state["area"].values[mobile]
    )
    first, ring = rings_of(polygons)
    colours = plt.get_cmap("viridis")((values - limits[0]) / (limits[1] - limits[0]))
    for k, colour in enumerate(colours):
        axes.add_patch(Polygon(ring[first[k] : first[k + 1]] / 1e3, facecolor=colour, lw=0))
    axes.set_aspect("equal")
    axes.set_xlim(-450, 450)
    axes.set_ylim(-450, 450)
    axes.set_xlabel("x (km)")


def steps(sheet: Sheet, after: Mapping[str, xr.Dataset]) -> Figure:
    """Thickness of the thinnest category, a step at the start, before and after the remaps."""
    panels = {"start": sheet.state, **after}
    figure, axes = plt.subplots(
        1, len(panels), figsize=(10.5, 4.0), layout="constrained", sharey=True
    )
    for ax, (name, state) in zip(axes, panels.items(), strict=True):
        _draw(ax, state, ratios(state)["thickness"][:, 0], (0.9, 2.1))
        ax.set_title(name, fontsize="medium")
    axes[0].set_ylabel("y (km)")
    scale = plt.cm.ScalarMappable(plt.Normalize(0.9, 2.1), "viridis")
    figure.colorbar(scale, ax=list(axes), label="ice thickness (m)", shrink=0.8)
    return figure


def squeezed(runs: Mapping[str, Squeeze]) -> Figure:
    """Step size and cost of the squeezed pack over time, with remapping, merging and neither."""
    figure, axes = plt.subplots(1, 3, figsize=(10.5, 3.6), layout="constrained")
    for name, run in runs.items():
        window = np.arange(1, len(run.step) + 1)
        label = name or "no remeshing"
        look = {"linestyle": LINES[name], "marker": ".", "label": label}
        axes[0].plot(window, run.step, **look)
        axes[1].plot(window, run.elements, **look)
        axes[2].plot(window, run.width, **look)
    texts = ("time step (s)", "elements", "width over that at the start")
    for ax, text in zip(axes, texts, strict=True):
        ax.set_xlabel("window")
        ax.set_ylabel(text)
        ax.set_ylim(bottom=0)
        ax.grid(alpha=0.3)
    axes[0].legend(fontsize="small")
    return figure


def cost(runs: Mapping[str, Squeeze]) -> Figure:
    """Element-steps of each window: what the dynamics cost, whatever the machine."""
    figure, axes = plt.subplots(figsize=(5.6, 3.6), layout="constrained")
    for name, run in runs.items():
        window = np.arange(1, len(run.steps) + 1)
        work = np.array(run.steps) * np.array(run.elements) / 1e6
        axes.plot(window, work, linestyle=LINES[name], marker=".", label=name or "no remeshing")
    axes.set_xlabel("window")
    axes.set_ylabel("million element-steps per window")
    axes.set_ylim(bottom=0)
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
    return figure
