# SPDX-License-Identifier: GPL-2.0-or-later
"""Lines along which discs may freeze together: sides of their power diagram, cut to the discs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floeflow.core.grids import Grid
from floeflow.packings.tessellation import Diagram, power_diagram

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Lines shorter than this share of the smaller disc are corners.
SHORTEST = 1.0e-6


def diagram_around(places: Array, radius: Array) -> Diagram:
    """Power diagram of discs (m), (n, 2) and (n,), in the square around them.

    Parameters
    ----------
    places : ndarray
        Centres (m), (n, 2).
    radius : ndarray
        m, (n,).

    Returns
    -------
    Diagram
        Cells of the discs.
    """
    low, high = places - radius[:, None], places + radius[:, None]
    side = float((places.max(axis=0) - places.min(axis=0)).max() + 2.0 * radius.max())
    left, bottom = (float(edge) for edge in low.min(axis=0))
    side = max(side, float((high.max(axis=0) - low.min(axis=0)).max()))
    x, y = (np.array([edge + 0.5 * side]) for edge in (left, bottom))
    return power_diagram(places, radius, Grid(x, y, side, left, bottom))


def disc_lines(
    diagram: Diagram, places: Array, radius: Array, chosen: Flags
) -> tuple[Index, Index, Array]:
    """Sides between chosen pairs of discs, no wider than the smaller disc about the centres' line.

    Where discs stand apart the diagram alone would draw them far out.

    Parameters
    ----------
    diagram : Diagram
        Of these discs.
    places, radius : ndarray
        Centres and radii (m), (n, 2) and (n,).
    chosen : ndarray
        Which sides of the diagram, (m,).

    Returns
    -------
    lo, hi : ndarray
        Rows of the discs, (k,).
    ends : ndarray
        End points as in `Diagram` (m), (k, 2, 2).
    """
    lo, hi, ends = diagram.lo[chosen], diagram.hi[chosen], diagram.ends[chosen]
    apart = places[hi] - places[lo]
    span = np.hypot(*apart.T)
    # The radical axis crosses the line of centres where both discs have the same power.
    arm = 0.5 * (span + (radius[lo] ** 2 - radius[hi] ** 2) / span)
    along = apart / span[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    middle = places[lo] + arm[:, None] * along
    half = np.minimum(radius[lo], radius[hi])[:, None]
    reach = np.clip(((ends - middle[:, None]) * across[:, None]).sum(axis=2), -half, half)
    lines = middle[:, None] + reach[:, :, None] * across[:, None]
    keep = np.abs(reach[:, 1] - reach[:, 0]) > SHORTEST * half[:, 0]
    return lo[keep], hi[keep], lines[keep]
