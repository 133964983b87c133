# SPDX-License-Identifier: GPL-2.0-or-later
"""What discs of a packing keep clear of: the coast's lines, and the walls that a scene names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floeflow.core.grids import Grid
from floeflow.core.near_lines import NearLines, near_lines
from floeflow.packings.coastline import coastline
from floeflow.state.bonds import Arrays
from floeflow.state.walls import join, rings

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Shore:
    """Lines with two sides, and endless planes with ice on one.

    Parameters
    ----------
    lines : NearLines
        Of the coast and of walls.
    planes : dict of ndarray
        Faces as in `floeflow.state.walls`.
    """

    lines: NearLines
    planes: Arrays

    def clearance(self, places: Array) -> Array:
        """Distance (m) of places (n, 2), below 0 behind a plane, infinite out of reach.

        Parameters
        ----------
        places : ndarray
            m.

        Returns
        -------
        ndarray
            m, (n,).
        """
        return self._nearest(places)[0]

    def pushes(self, places: Array, target: Array, share: float) -> tuple[Array, float]:
        """Moves (m), (n, 2), by a share of what discs reach over a line; the most of that (m).

        Parameters
        ----------
        places, target : ndarray
            Centres (n, 2) and radii (n,) of discs, m.
        share : float
            Of the overlap.

        Returns
        -------
        moves : ndarray
            m, (n, 2).
        deepest : float
            m, 0 where no disc reaches over a line.
        """
        away, foot = self.lines.nearest(places)
        lack = np.where(np.isfinite(away), np.maximum(target - away, 0.0), 0.0)
        moved = lack > 0
        moves = np.zeros(places.shape)
        outward = places[moved] - foot[moved]
        moves[moved] = (share * lack[moved] / np.maximum(away[moved], 1e-9))[:, None] * outward
        deepest = float(lack.max(initial=0.0))
        for k in range(len(self.planes["ax"])):
            normal, height = self._plane(places, k)
            lack = np.maximum(target - height, 0.0)
            moves += share * lack[:, None] * normal
            deepest = max(deepest, float(lack.max(initial=0.0)))
        return moves, deepest

    def before(self, places: Array, least: Array) -> Array:
        """Places that lie a little behind a plane, or nearer than `least` (m), moved before it.

        Parameters
        ----------
        places : ndarray
            m, (n, 2).
        least : ndarray
            m, (n,).

        Returns
        -------
        ndarray
            m, (n, 2).
        """
        places = places.copy()
        for k in range(len(self.planes["ax"])):
            normal, height = self._plane(places, k)
            lack = np.where(height > -least, np.maximum(least - height, 0.0), 0.0)
            places += lack[:, None] * normal
        return places

    def _plane(self, places: Array, row: int) -> tuple[Array, Array]:
        """Normal of a plane, and heights of places above it (m), (n,)."""
        face = {name: values[row] for name, values in self.planes.items()}
        along = np.array([face["bx"] - face["ax"], face["by"] - face["ay"]])
        along /= np.hypot(*along)
        normal = np.array([-along[1], along[0]])
        return normal, (places - [face["ax"], face["ay"]]) @ normal

    def _nearest(self, places: Array) -> tuple[Array, Array]:
        away, foot = self.lines.nearest(places)
        for k in range(len(self.planes["ax"])):
            _, height = self._plane(places, k)
            away = np.minimum(away, height)
        return away, foot


def shore_of(grid: Grid, land: Flags, walls: Arrays | None, reach: float) -> Shore:
    """Coast of a mask and walls of a scene.

    Parameters
    ----------
    grid, land
        Mask grid and its cells of land, (ny, nx).
    walls : dict of ndarray, optional
        Faces as in `floeflow.state.walls`, where they are at the start.
    reach : float
        The largest radius (m) that will be asked for.

    Returns
    -------
    Shore
        Lines that are found by place within the reach, and planes.
    """
    faces = join([rings(*coastline(grid, land)), *([] if walls is None else [walls])])
    endless = faces["plane"] != 0
    ends = np.stack([np.column_stack([faces[f"{e}x"], faces[f"{e}y"]]) for e in "ab"], axis=1)
    planes = {name: values[endless] for name, values in faces.items()}
    return Shore(near_lines(ends[~endless], reach), planes)
