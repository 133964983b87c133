# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the hard cases: the stability map, and energy that no term accounts for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

MARKS = "osD^v"
# Share of the energy that the budget may miss at the default step.
LIMIT = 0.02


def stability_map(
    found: Mapping[tuple[str, float], Sequence[float]], dampings: Sequence[float], default: float
) -> Figure:
    """Largest stable step over the critical one, by damping; a line a pack and stiffness."""
    figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
    names = list(dict.fromkeys(name for name, _ in found))
    stiff = sorted({young for _, young in found})
    for (name, young), shares in found.items():
        axes.plot(
            range(len(dampings)),
            shares,
            marker=MARKS[names.index(name)],
            color=f"C{names.index(name)}",
            linestyle="-" if young == stiff[-1] else ":",
            label=f"{name}, E = {young:.0e} Pa",
        )
    axes.axhline(1.0, color="black", linewidth=1.0)
    axes.axhline(default, color="black", linewidth=1.0, linestyle="--")
    axes.annotate("critical step", (0.02, 1.01), xycoords=("axes fraction", "data"))
    axes.annotate("default step", (0.02, default + 0.01), xycoords=("axes fraction", "data"))
    axes.set_xticks(range(len(dampings)), [f"{damping:g}" for damping in dampings])
    axes.set_xlabel("damping of bonds / critical damping")
    axes.set_ylabel("largest stable step / critical step")
    axes.set_ylim(0.0, 1.2)
    axes.legend(fontsize=7, ncols=2)
    return figure


def residual_figure(residuals: Mapping[str, float]) -> Figure:
    """Energy not accounted for in each test that has a budget, on a logarithmic axis."""
    figure, axes = plt.subplots(figsize=(7.5, 1.2 + 0.24 * len(residuals)), layout="constrained")
    names = list(residuals)[::-1]
    axes.plot([max(residuals[n], 1e-17) for n in names], names, "ko", markersize=5)
    axes.axvline(LIMIT, color="black", linewidth=1.0, linestyle="--")
    axes.annotate(" limit", (LIMIT, 0.0), xycoords=("data", "axes fraction"), va="bottom")
    axes.set_xscale("log")
    axes.set_xlabel("energy not accounted for / energy there or moved")
    axes.tick_params(axis="y", labelsize=7)
    axes.grid(axis="x", alpha=0.3)
    return figure
