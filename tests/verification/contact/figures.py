# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the verification cases; drawn by `make verification`."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

Curves = dict[str, tuple[np.ndarray, np.ndarray]]


def curves(lines: Curves, points: Curves, x: str, y: str, scale: str = "linear") -> Figure:
    """Lines for theory and this model, points for other programs; named in the legend."""
    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    for name, (a, b) in lines.items():
        axes.plot(a, b, label=name)
    for name, (a, b) in points.items():
        axes.plot(a, b, ".", markersize=4, label=name)
    if scale == "log":
        axes.set_xscale("log")
        axes.set_yscale("log")
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
    return figure
