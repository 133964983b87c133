# SPDX-License-Identifier: GPL-2.0-or-later
"""Dense packs by the element model: radii grow while damped contacts part the discs.

Growth goes in rounds (after Lubachevsky and Stillinger 1990, doi 10.1007/BF01025983, but without
heat): in each the discs start at rest, a little larger than before, and run until their overlaps
have pushed them apart. The last rounds keep the radii, until no overlap exceeds the tolerance.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from floeflow.core.constants import ICE_DENSITY
from floeflow.core.grids import Grid
from floeflow.core.near import deepest_overlap
from floeflow.core.period import Period, sides, wrapped
from floeflow.dynamics.engine.engine import Engine
from floeflow.dynamics.engine.params import FIXED, EngineParams
from floeflow.dynamics.step.critical import critical_step
from floeflow.packings.dense import Compactor
from floeflow.state.bonds import Arrays
from floeflow.state.walls import distances, join, plane

Array = NDArray[np.float64]

log = logging.getLogger(__name__)

# Growth of the radii in a round, steps of a round, most rounds at full radii.
GROWTH, STEPS, MOST_ROUNDS = 0.02, 150, 60
# Of the critical time step.
STEP_SHARE = 0.5
# Contacts nearly without rebound, no friction: a dense pack, not a loose one.
DAMPING = 0.7
# Planes that are no further apart stand at one place, m.
ROUND_OFF = 1.0e-3
# The modulus and thickness set only the scale of time.
MODULUS, THICKNESS = 1.0e8, 1.0


@dataclass(frozen=True)
class Compacted:
    """Discs after compaction.

    Parameters
    ----------
    places : ndarray
        Centres of the mobile discs (m), (n, 2).
    overlap : float
        Largest overlap, as a share of the sum of the two radii.
    rounds : int
        Rounds that it took.
    """

    places: Array
    overlap: float
    rounds: int


@dataclass(frozen=True)
class Box:
    """What holds the discs.

    Parameters
    ----------
    fixed, fixed_radius : ndarray
        Discs that stand (m), (k, 2) and (k,).
    walls : dict of ndarray, optional
        Faces as from `floeflow.state.walls`.
    period : tuple of float, optional
        Bounds (m) of a rectangle that repeats itself (`floeflow.core.period`).
    """

    fixed: Array
    fixed_radius: Array
    walls: Arrays | None = None
    period: Period | None = None


def compact(places: Array, radius: Array, box: Box, tolerance: float, folder: Path) -> Compacted:
    """Part discs until none overlaps another by more than a tolerance, or it cannot be.

    Parameters
    ----------
    places, radius : ndarray
        Centres and wanted radii of the mobile discs (m), (n, 2) and (n,).
    box : Box
        What holds them.
    tolerance : float
        Largest overlap that may be left, as a share of the sum of two radii.
    folder : Path
        For LIGGGHTS' log.

    Returns
    -------
    Compacted
        Where they are. Jammed discs keep overlaps above the tolerance, which is said.
    """
    radius = np.asarray(radius, float)
    places = wrapped(np.asarray(places, float), box.period)
    share = 1.0
    while share > 0.3 and _overlap(places, share * radius, box) > 0.25 * GROWTH:
        share -= GROWTH
    rounds = full = 0
    overlap = _overlap(places, radius, box)
    while overlap > tolerance and full < MOST_ROUNDS:
        share = min(1.0, share + GROWTH)
        places = _round(places, share * radius, box, folder)
        rounds, full = rounds + 1, full + (share == 1.0)
        overlap = _overlap(places, radius, box)
    log.info("compacted in %d rounds; largest overlap %.2e of the radii's sum", rounds, overlap)
    return Compacted(places, overlap, rounds)


def _round(places: Array, radius: Array, box: Box, folder: Path) -> Array:
    elements = _elements(places, radius, box)
    params = EngineParams(
        time_step=1.0,
        friction=False,
        contact_modulus=MODULUS,
        contact_damping=DAMPING,
        period=box.period,
    )
    critical, _ = critical_step(elements, None, params)
    params = replace(params, time_step=STEP_SHARE * critical)
    with Engine(MPI.COMM_SELF, params, folder / "compaction.log", box.walls) as engine:
        engine.load(elements)
        engine.run(STEPS)
        moved = engine.elements()
    mobile = moved["type"] != FIXED
    return wrapped(np.stack([moved["x"][mobile], moved["y"][mobile]], axis=1), box.period)


def _elements(places: Array, radius: Array, box: Box) -> Arrays:
    everywhere = np.concatenate([places, box.fixed])
    wide = np.concatenate([radius, box.fixed_radius])
    count = len(wide)
    area = np.pi * wide**2
    fixed = np.arange(count) >= len(places)
    zero = {name: np.zeros(count) for name in ("theta", "u", "v", "omega")}
    return {
        "id": np.arange(1, count + 1),
        "type": np.where(fixed, FIXED, 1).astype(np.int8),
        "x": everywhere[:, 0].copy(),
        "y": everywhere[:, 1].copy(),
        **zero,
        "radius": wide,
        "mass": ICE_DENSITY * THICKNESS * area,
        "thickness": np.full(count, THICKNESS),
        "ice_area": area,
    }


def _overlap(places: Array, radius: Array, box: Box) -> float:
    everywhere = np.concatenate([places, box.fixed])
    wide = np.concatenate([radius, box.fixed_radius])
    return deepest_overlap(everywhere, wide, len(places), box.period)


def _held(side: Arrays, walls: Arrays) -> bool:
    """Whether a plane of the walls stands at a side of the rectangle, or parallel before it."""
    along = [walls[f"b{axis}"] - walls[f"a{axis}"] for axis in "xy"]
    own = [side[f"b{axis}"] - side[f"a{axis}"] for axis in "xy"]
    parallel = along[0] * own[0] + along[1] * own[1] > (1.0 - 1e-12) * np.hypot(*along)
    before = distances(side, walls["ax"], walls["ay"]) > -ROUND_OFF
    return bool(((walls["plane"] != 0) & parallel & before).any())


def compactor(
    grid: Grid, folder: Path, walls: Arrays | None = None, period: Period | None = None
) -> Compactor:
    """Compaction by the element model within the rectangle of a grid, and walls that stand in it.

    Walls are taken where they are at time 0, at rest. Sides beyond which the ice repeats itself
    hold nothing.

    Parameters
    ----------
    grid : Grid
        Its outer edges (m) are the sides of the rectangle.
    folder : Path
        For the logs of LIGGGHTS.
    walls : Arrays, optional
        Faces and their velocities as in `floeflow.state.walls`.
    period : Period, optional
        Along which axes the domain repeats itself.

    Returns
    -------
    Compactor
        Function that presses discs together until they rest.
    """
    (west, east), (south, north) = grid.x_edges[[0, -1]], grid.y_edges[[0, -1]]
    low, high = (float(west), float(south)), (float(east), float(north))
    ends = [True, True] if period is None else [not np.isfinite(side) for side in sides(period)]
    planes = (
        (low, (1.0, 0.0), ends[0]),
        (low, (0.0, 1.0), ends[1]),
        (high, (-1.0, 0.0), ends[0]),
        (high, (0.0, -1.0), ends[1]),
    )
    rim = [plane(*corner, normal) for corner, normal, there in planes if there]
    if walls is not None:
        # Two planes at one place would push twice.
        rim = [side for side in rim if not _held(side, walls)]
        rim.append(walls | {name: np.zeros(len(walls[name])) for name in ("u", "v")})
    held = join(rim) if rim else None

    def run(
        places: Array, radius: Array, fixed: Array, fixed_radius: Array, overlap: float
    ) -> Array:
        box = Box(fixed, fixed_radius, held, period)
        return compact(places, radius, box, overlap, folder).places

    return run
