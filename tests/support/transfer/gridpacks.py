# SPDX-License-Identifier: GPL-2.0-or-later
"""Elements displaced from a lattice in the unit square, and the errors of fields on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from floeflow.transfer import ROOM, Field, Grid, build_remapper, conservative_transfer, open_room

DISPLACEMENT = 0.25
FIELDS = (Field("area", "extensive", ROOM), Field("f", "intensive", "area"))


def unit_grid(cells: int) -> Grid:
    """Grid of square cells over the unit square."""
    centres = (np.arange(cells) + 0.5) / cells
    return Grid(centres, centres)


def displaced(cells: int, seed: int, displacement: float) -> tuple[np.ndarray, np.ndarray]:
    """Four elements to a cell, each moved by up to a share of their spacing, x and y."""
    n = 2 * cells
    rng = np.random.default_rng([seed, cells])
    x, y = np.meshgrid(*2 * [(np.arange(n) + 0.5) / n])
    move = rng.uniform(-displacement, displacement, (2, n, n)) / n
    return (x + move[0]).ravel(), (y + move[1]).ravel()


def waves(k: int, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """sin(k pi x) sin(k pi y)."""
    return np.asarray(np.sin(k * np.pi * x) * np.sin(k * np.pi * y))


@dataclass(frozen=True)
class Errors:
    """Errors at the interior nodes: (cells, seeds) each."""

    cells: list[int]
    mean_square: np.ndarray
    largest: np.ndarray

    def halvings(self) -> np.ndarray:
        """Slope of the L2 error (rms over the seeds) at each halving of the spacing."""
        whole = np.sqrt((self.mean_square**2).mean(axis=1))
        return np.asarray(np.log2(whole[:-1] / whole[1:]))

    def slopes(self, name: str, first: int = 0) -> np.ndarray:
        """Fitted slope of an error for each seed, from a number of cells on."""
        keep = [i for i, cells in enumerate(self.cells) if cells >= first]
        rows = np.log2(getattr(self, name)[keep])
        return np.asarray(-np.polyfit(np.log2([self.cells[i] for i in keep]), rows, 1)[0])


def convergence(
    cells: list[int], seeds: int, cover: float, displacement: float = DISPLACEMENT
) -> dict[tuple[int, str], Errors]:
    """Errors of both waves, as averaged and after the conservative correction.

    The elements have equal areas, which together are `cover` of the square.
    """
    found: dict[tuple[int, str], list[tuple[float, float]]] = {}
    for size in cells:
        grid = unit_grid(size)
        room, (node_x, node_y) = open_room(grid), np.meshgrid(grid.x, grid.y)
        for seed in range(seeds):
            x, y = displaced(size, seed, displacement)
            area = np.full(x.size, cover / x.size)
            remapper = build_remapper(x, y, {"area": area}, room)
            for k in (1, 2):
                own, exact = waves(k, x, y), waves(k, node_x, node_y)
                carried = conservative_transfer(FIELDS, {"area": area, "f": own}, remapper)
                assert not carried.infeasible or cover == 1.0
                for name, values in (
                    ("averaged", remapper.weights["area"].apply(own)),
                    ("corrected", carried.values["f"]),
                ):
                    error = (values - exact)[1:-1, 1:-1]
                    pair = float(np.sqrt((error**2).mean())), float(np.abs(error).max())
                    found.setdefault((k, name), []).append(pair)
    shape = len(cells), seeds, 2
    return {
        key: Errors(cells, *np.moveaxis(np.reshape(pairs, shape), 2, 0))
        for key, pairs in found.items()
    }


def convergence_figure(errors: dict[tuple[int, str], Errors]) -> Figure:
    """L2 and largest error against the number of cells, all seeds, with a line of second order."""
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    both = figure.subplots(1, 2, sharey=True)
    names = {1: "sin πx sin πy", 2: "sin 2πx sin 2πy"}
    looks = {1: ("o", "#0072b2"), 2: ("s", "#d55e00")}
    for axes, kind, title in zip(
        both, ("mean_square", "largest"), ("L2 error", "largest error"), strict=True
    ):
        for (k, name), error in errors.items():
            (marker, colour), hollow = looks[k], name == "averaged"
            values = getattr(error, kind)
            cells = np.repeat(error.cells, values.shape[1])
            axes.loglog(
                *(cells, values.ravel()),
                marker=marker,
                color=colour,
                fillstyle="none" if hollow else "full",
                linestyle="",
                markersize=7 if hollow else 3,
                label=f"{names[k]}, {name}",
            )
        cells = np.array(next(iter(errors.values())).cells, float)
        axes.loglog(cells, 2.0 / cells**2, color="black", linewidth=1, label="second order")
        axes.set_title(title)
        axes.set_xlabel("cells along a side")
        axes.set_xticks(cells)
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.minorticks_off()
        axes.grid(alpha=0.3)
    both[0].set_ylabel("error (the field's largest value is 1)")
    both[0].legend(fontsize="small")
    return figure
