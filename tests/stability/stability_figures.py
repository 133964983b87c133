# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the hard cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

MARKS = "osD^v"


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
    axes.set_ylim(0.0, None)
    axes.legend(fontsize=7, ncols=2)
    return figure
