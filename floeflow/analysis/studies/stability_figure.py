# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the hard cases: the stability map, and energy that no term accounts for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

MARKS, LINES = "osD^vP", ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
# Share of the largest stable step that the default one should be.
AIM = 0.6
# Share of the energy that the budget may miss at the default step.
LIMIT = 0.02


def stability_map(
    panels: Sequence[Mapping[str, Any]], dampings: Sequence[float], default: float
) -> Figure:
    """Largest stable step over the critical one, by damping.

    Parameters
    ----------
    panels : sequence of mapping
        `title` and `lines`: name of the pack, modulus (Pa; two, a hundredfold apart) and a share
        for each damping.
    dampings : sequence of float
        Over critical damping.
    default : float
        Default step over the critical one.
    """
    figure, rows = plt.subplots(
        1, len(panels), figsize=(4.4 * len(panels), 5.2), layout="constrained", squeeze=False
    )
    names = list(dict.fromkeys(line[0] for panel in panels for line in panel["lines"]))
    handles: dict[str, Artist] = {}
    for axes, panel in zip(rows[0], panels, strict=True):
        _panel(axes, panel["lines"], names, default)
        axes.set_title(panel["title"])
        axes.set_xticks(range(len(dampings)), [f"{damping:g}" for damping in dampings])
        axes.set_xlabel("damping / critical damping")
        found, labels = axes.get_legend_handles_labels()
        handles |= dict(zip(labels, found, strict=True))
    rows[0][0].set_ylabel("largest stable step / critical step")
    figure.legend(
        *(handles.values(), handles.keys()),
        loc="outside lower center",
        ncols=3,
        fontsize=8,
        frameon=False,
        handlelength=3.2,
    )
    return figure


def _panel(
    axes: Axes, lines: Sequence[Sequence[Any]], names: Sequence[str], default: float
) -> None:
    """Lines of the stiffest packs; softer ones as open marks, which lie on them or do not."""
    stiffest = max(modulus for _, modulus, _ in lines)
    for name, modulus, shares in lines:
        k, stiff = names.index(name), modulus == stiffest
        axes.plot(
            range(len(shares)),
            shares,
            marker=MARKS[k],
            color=f"{0.15 * (k % 4):g}",
            linestyle=LINES[k] if stiff else "none",
            linewidth=1.2,
            markersize=5 if stiff else 9,
            markerfacecolor=None if stiff else "none",
            label=name if stiff else f"_{name}",
        )
    axes.plot(
        [], [], "ko", markersize=9, markerfacecolor="none", label="open: a hundredth as stiff"
    )
    axes.axhspan(1.0, default / AIM, color="0.88", zorder=0, label="default is 60 % of it or more")
    axes.axhline(1.0, color="black", linewidth=1.0, label="critical step")
    axes.axhline(default, color="black", linewidth=2.0, linestyle=(0, (2, 1)), label="default step")
    axes.set_ylim(0.0, 1.15 * max(max(shares) for _, _, shares in lines))


def residual_figure(residuals: Mapping[str, float]) -> Figure:
    """Energy not accounted for in each test that has a budget, on a logarithmic axis.

    Parameters
    ----------
    residuals : mapping of float
        Energy that is not accounted for, relative, by test.
    """
    figure, axes = plt.subplots(figsize=(8.5, 1.2 + 0.24 * len(residuals)), layout="constrained")
    names = list(residuals)[::-1]
    values = [max(residuals[n], 1e-17) for n in names]
    axes.plot(values, names, "ko", markersize=5)
    axes.axvline(LIMIT, color="black", linewidth=1.0, linestyle="--", label="limit")
    axes.set_xscale("log")
    axes.set_xlim(min([*values, LIMIT]) / 3.0, 3.0 * max([*values, LIMIT]))
    axes.set_xlabel("share of the energy that is missed")
    axes.tick_params(axis="y", labelsize=7)
    axes.grid(axis="x", alpha=0.3)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    return figure
