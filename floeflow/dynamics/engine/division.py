# SPDX-License-Identifier: GPL-2.0-or-later
"""How the box is divided among the ranks: by cuts that give each about as much work.

LIGGGHTS divides a box into equal parts; of a pack that fills half of it, half of the ranks then
have nothing to do. Here the ranks form a grid, cut into columns and rows where the elements are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floeflow.state.bonds import Arrays
from floeflow.state.schema import MOBILE

# Work with a fixed element, which meets no other fixed one, and with a ghost: beside a mobile one.
FIXED_WORK, GHOST_WORK = 0.2, 0.5
# Cells along each side of the box, with which work is added up.
CELLS = 512

Edges = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Division:
    """A grid of ranks.

    Parameters
    ----------
    x, y : tuple of float
        Where columns and rows begin and end, as shares of the box: 0 first, 1 last.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]

    @property
    def command(self) -> str:
        """LIGGGHTS' command for a grid of so many ranks."""
        return f"processors {len(self.x) - 1} {len(self.y) - 1} 1"


def choose_division(elements: Arrays, ranks: int, box: Edges, halo: float) -> Division | None:
    """The division that gives the busiest rank the least work.

    Parameters
    ----------
    elements : dict of ndarray
        As `Engine.load` takes them.
    ranks : int
        How many.
    box : tuple
        Lowest and highest x, lowest and highest y (m).
    halo : float
        Width of the rim in which a rank knows the elements of others, m.

    Returns
    -------
    Division or None
        None for one rank, and where every grid has parts narrower than the rim: then LIGGGHTS
        divides the box.
    """
    places = [np.asarray(elements[axis], float) for axis in ("x", "y")]
    work = np.where(elements["type"] == MOBILE, 1.0, FIXED_WORK)
    table = work_table(places, work, box)
    found: list[tuple[float, Division]] = []
    for columns in range(1, ranks + 1):
        if ranks == 1 or ranks % columns:
            continue
        shape = columns, ranks // columns
        for even in (True, False):
            cuts = [
                np.linspace(*edges, parts + 1) if even else level_cuts(place, work, edges, parts)
                for place, edges, parts in zip(places, box, shape, strict=True)
            ]
            if min(np.diff(each).min() for each in cuts) < halo:
                continue
            most = busiest(table, box, cuts, halo)
            x, y = (
                tuple(((each - low) / (high - low)).tolist())
                for each, (low, high) in zip(cuts, box, strict=True)
            )
            found.append((most, Division((0.0, *x[1:-1], 1.0), (0.0, *y[1:-1], 1.0))))
    return min(found, key=lambda each: each[0])[1] if found else None


def level_cuts(
    place: np.ndarray, work: np.ndarray, edges: tuple[float, float], parts: int
) -> np.ndarray:
    """Cuts along an axis with the same work between any two of them, edges first and last.

    Parameters
    ----------
    place : ndarray
        Places along the axis (m), (n,).
    work : ndarray
        Work of each element, in any unit, (n,).
    edges : tuple of float
        First and last cut (m).
    parts : int
        Number of parts.

    Returns
    -------
    ndarray
        m, ascending, (parts + 1,).
    """
    order = np.argsort(place, kind="stable")
    done = np.cumsum(work[order])
    last = np.searchsorted(done, done[-1] * np.arange(1, parts) / parts)
    # Between two elements, so that none lies on a cut.
    sorted_places = place[order]
    cuts = 0.5 * (sorted_places[last] + sorted_places[np.minimum(last + 1, len(place) - 1)])
    return np.array([edges[0], *cuts, edges[1]])


def busiest(table: np.ndarray, box: Edges, cuts: list[np.ndarray], halo: float) -> float:
    """Work of the busiest rank: its elements, and a share for those of others in its rim.

    Parameters
    ----------
    table : ndarray
        From `work_table`.
    box, halo
        As for `choose_division`.
    cuts : list of ndarray
        Along x and y (m).

    Returns
    -------
    float
        Work in the unit of the table; a rank with nothing has 0.
    """

    def within(rim: float) -> np.ndarray:
        (left, right), (low, high) = (
            cells_between(each, edges, rim) for each, edges in zip(cuts, box, strict=True)
        )
        upper, lower = (table[np.ix_(right, y)] - table[np.ix_(left, y)] for y in (high, low))
        return np.asarray(upper - lower)

    own = within(0.0)
    return float((own + GHOST_WORK * (within(halo) - own)).max())


def cells_between(
    cuts: np.ndarray, edges: tuple[float, float], rim: float
) -> tuple[np.ndarray, np.ndarray]:
    """First cell of each part along an axis, its rim included, and the one behind its last.

    Parameters
    ----------
    cuts : ndarray
        From `level_cuts` (m), (parts + 1,).
    edges : tuple of float
        Ends of the axis (m).
    rim : float
        By how much each part is widened (m).

    Returns
    -------
    tuple of ndarray
        Numbers of cells, (parts,) each.
    """
    low, high = edges
    ends = np.array([cuts[:-1] - rim, cuts[1:] + rim])
    first, last = np.rint((ends - low) / (high - low) * CELLS).clip(0, CELLS).astype(int)
    return first, last


def work_table(places: list[np.ndarray], work: np.ndarray, box: Edges) -> np.ndarray:
    """Work to the lower left of each corner of a grid of `CELLS` by `CELLS` cells over the box.

    Parameters
    ----------
    places : list of ndarray
        Coordinates x and y (m), (n,) each.
    work : ndarray
        Work of each element, in any unit, (n,).
    box : Edges
        Ends of the two axes (m).

    Returns
    -------
    ndarray
        Cumulative in both directions, (CELLS + 1, CELLS + 1).
    """
    x, y = places
    cells, _, _ = np.histogram2d(x, y, CELLS, range=[list(edges) for edges in box], weights=work)
    table = np.zeros((CELLS + 1, CELLS + 1))
    table[1:, 1:] = cells.cumsum(axis=0).cumsum(axis=1)
    return table
