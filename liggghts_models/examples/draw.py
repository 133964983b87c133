# SPDX-License-Identifier: GPL-2.0-or-later
"""Draws what an example dumped, in the folder where it ran: python draw.py NAME [NAME ...].

Elements are coloured by the last column of the dump (damage, ridged area, speed); walls are lines.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

WALLS = {
    "ice_arch": ["strait.stl"],
    "cyclone": ["coast.stl"],
    "cylinder": ["cylinder.stl"],
}
COLOUR = {
    "compression": "ridged area (m²)",
    "shear": "velocity along the flow (m/s)",
    "collision": "damage",
    "ice_arch": "damage",
    "cyclone": "damage",
    "cylinder": "damage",
    "bonded_raft": "damage",
    "restart": "damage",
}
SERIES = {"brazilian": "load.brazilian", "cylinder": "load.cylinder"}


def last_frame(name: str) -> tuple[list[str], np.ndarray]:
    """Names and values of the columns in the last frame of a dump."""
    frame = Path(f"dump.{name}").read_text().split("ITEM: TIMESTEP")[-1]
    head, body = frame.split("ITEM: ATOMS ")[-1].split("\n", 1)
    return head.split(), np.array([[float(v) for v in line.split()] for line in body.splitlines()])


def wall_lines(file: str) -> list[np.ndarray]:
    """Lines of a wall in the plane of the ice."""
    numbers = re.findall(r"vertex (\S+) (\S+) \S+", (Path(__file__).parent / file).read_text())
    return list(np.array(numbers, float).reshape(-1, 3, 2))


def draw(name: str) -> None:
    """Write NAME.png."""
    columns, rows = last_frame(name)
    x, y, radius = (rows[:, columns.index(c)] for c in ("x", "y", "radius"))
    figure, axes = plt.subplots(figsize=(6, 5), layout="constrained")
    discs = EllipseCollection(
        2 * radius, 2 * radius, 0.0, units="xy", offsets=np.column_stack([x, y]),
        offset_transform=axes.transData, edgecolor="0.3", linewidth=0.3, facecolor="#a7c7e7",
    )  # fmt: skip
    if name in COLOUR:
        column = columns.index("vx") if name == "shear" else len(columns) - 1
        if name == "cyclone":
            column = columns.index("c_atom[1]")
        discs.set_array(rows[:, column])
        discs.set_facecolor(None)
        discs.set_cmap("RdBu_r" if name == "shear" else "viridis")
        figure.colorbar(discs, ax=axes, label=COLOUR[name])
    axes.add_collection(discs)
    for file in WALLS.get(name, []):
        axes.add_collection(LineCollection(wall_lines(file), color="k", linewidth=1.5))
    wide = radius.max()
    axes.set_xlim(x.min() - 2 * wide, x.max() + 2 * wide)
    axes.set_ylim(y.min() - 2 * wide, y.max() + 2 * wide)
    axes.set_aspect("equal")
    axes.locator_params(nbins=5)
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    save(figure, name)
    if name in SERIES:
        steps, load = np.loadtxt(SERIES[name], unpack=True)
        figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
        axes.plot(steps, load)
        axes.set_xlabel("step")
        axes.set_ylabel("load (N)")
        save(figure, f"{name}_load")


def draw_cantilever() -> None:
    """Deflection of the chain of discs beside that of its bonds, as in.cantilever has them."""
    columns, rows = last_frame("cantilever")
    x, y = (rows[:, columns.index(c)] for c in ("x", "y"))
    load, spacing, width, young, bonds = 100.0, 2.0, 1.6, 1e7, 10
    at = spacing * (np.arange(bonds) + 0.5)
    turn = load * (bonds * spacing - at) * 12 * spacing / (young * width**3)
    slide = load * spacing / (young / 2.6 * width)
    places = spacing * np.arange(bonds + 1)
    sag = [np.sum((turn * (p - at) + slide)[at < p]) for p in places]
    figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
    axes.plot(places, -1e3 * np.array(sag), color="0.4", label="chain of bonds, closed form")
    axes.plot(x, 1e3 * y, "o", label="discs")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("deflection (mm)")
    axes.legend()
    save(figure, "cantilever")


def save(figure: Figure, name: str) -> None:
    """Write a picture beside the dumps."""
    figure.savefig(f"{name}.png", dpi=90, metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    for word in sys.argv[1:]:
        draw_cantilever() if word == "cantilever" else draw(word)
