# SPDX-License-Identifier: GPL-2.0-or-later
"""Which elements cannot go on by themselves: used up, run over, torn from bonds, or pushed ashore.

Ridging makes elements smaller without end, and drives them into each other. What is left of one
that is nearly used up, or whose centre lies deep inside of its neighbour or behind a coast, is ice
of its neighbour: the two become one (`merge`). So nothing that ridging does ever ends a run. What
is used up far from all others is left to the sea (`used_up_alone`).
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.dynamics.engine.params import EngineParams
from floeflow.dynamics.engine.setup import pair_reach
from floeflow.dynamics.remesh.merge import into_roots
from floeflow.scene import Scene
from floeflow.state.bonds import element_rows
from floeflow.state.elements import pair_arrays
from floeflow.state.schema import MOBILE
from floeflow.state.walls import enclosed

Index = NDArray[np.int64]
Array = NDArray[np.float64]

# An element of less than this share of the mean area of those around it is used up, so that fine
# parts of a packing stay; those around are so many.
USED_UP = 0.2
AROUND = 12
# An element of less than this share without a neighbour that could take it is the sea's.
ALONE = 0.05
# One whose centre is nearer to a larger one's than this share of the larger radius is run over.
RUN_OVER = 0.5
# How far a neighbour may be to take a used-up element or one ashore, as a share of the sum of the
# mean radii.
FARTHEST = 2.0
# A bond that survives at more than this many times the sum of the radii has too small elements.
LONGEST_BOND = 3.0


def absorbed(state: xr.Dataset, params: EngineParams, on_land: Index | None = None) -> Index:
    """Row that each element becomes part of; its own where it stays, (n,).

    Parameters
    ----------
    state : xarray.Dataset
        A state at a window's end.
    params : EngineParams
        Laws: they say how far bonds reach.
    on_land : ndarray, optional
        Rows of elements whose centres lie behind a coast, from `ashore`.
    """
    area = state["area"].values
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    into = np.arange(len(area))
    if len(mobile) < 2:
        return into
    places = np.column_stack([state["x"].values, state["y"].values])
    radius = state["radius"].values
    for small, large in (
        _torn(state, params),
        _run_over(places, radius, area, mobile),
        _used_up(places, radius, area, mobile),
        _pushed_ashore(places, radius, area, mobile, on_land),
    ):
        into[small] = large
    return into_roots(into)


def ashore(scene: Scene, state: xr.Dataset) -> Index:
    """Rows of the mobile elements whose centre lies on land, (k,).

    Parameters
    ----------
    scene : Scene
        Whether there is a coast, and which walls there are beside it.
    state : xarray.Dataset
        Elements and faces.
    """
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    if "coast" not in scene.effects:
        return mobile[:0]
    coast = len(scene.walls.names) if "walls" in scene.effects else 0
    faces = pair_arrays(state, "wall_face")
    inside = enclosed(faces, coast, state["x"].values[mobile], state["y"].values[mobile])
    return np.asarray(mobile[inside])


def used_up_alone(state: xr.Dataset) -> Index:
    """Rows of used-up elements that have no neighbour within reach, (k,).

    Parameters
    ----------
    state : xarray.Dataset
        A state at a window's end.
    """
    area = state["area"].values
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    if len(mobile) < 2:
        return mobile[:0]
    small = mobile[area[mobile] < ALONE * area[mobile].mean()]
    places = np.column_stack([state["x"].values, state["y"].values])
    taken, _ = _used_up(places, state["radius"].values, area, mobile)
    return np.setdiff1d(small, taken)


def _larger(area: Array, one: Index, two: Index) -> tuple[Index, Index]:
    """The smaller and the larger of pairs; of equal ones the later row is the smaller."""
    first = (area[one] > area[two]) | ((area[one] == area[two]) & (one < two))
    return np.where(first, two, one), np.where(first, one, two)


def _run_over(places: Array, radius: Array, area: Array, mobile: Index) -> tuple[Index, Index]:
    most = RUN_OVER * float(radius[mobile].max())
    pairs = mobile[cKDTree(places[mobile]).query_pairs(most, output_type="ndarray").reshape(-1, 2)]
    apart = np.hypot(*(places[pairs[:, 1]] - places[pairs[:, 0]]).T)
    deep = apart < RUN_OVER * np.maximum(radius[pairs[:, 0]], radius[pairs[:, 1]])
    # Of several the nearest comes last, and stays.
    order = np.argsort(-apart[deep], kind="stable")
    return _larger(area, *pairs[deep][order].T)


def _used_up(places: Array, radius: Array, area: Array, mobile: Index) -> tuple[Index, Index]:
    small = area[mobile] < USED_UP * _usual(places[mobile], area[mobile])
    return _into_nearest(places, radius, area, (mobile[small], mobile[~small]))


def _usual(places: Array, area: Array) -> Array:
    """Mean area of the elements around each one (m2), not above that of all, (n,)."""
    everywhere = np.full(len(area), area.mean())
    if len(area) <= AROUND:
        return everywhere
    near = cKDTree(places).query(places, k=AROUND + 1)[1][:, 1:]
    return np.minimum(area[near].mean(axis=1), everywhere)


def _pushed_ashore(
    places: Array, radius: Array, area: Array, mobile: Index, on_land: Index | None
) -> tuple[Index, Index]:
    on_land = mobile[:0] if on_land is None else on_land
    return _into_nearest(places, radius, area, (on_land, np.setdiff1d(mobile, on_land)))


def _into_nearest(
    places: Array, radius: Array, area: Array, rows: tuple[Index, Index]
) -> tuple[Index, Index]:
    """Those of the first rows that have one of the second in reach, and the nearest of these."""
    some, rest = rows
    if not (len(some) and len(rest)):
        return some[:0], some[:0]
    most = FARTHEST * 2.0 * float(np.sqrt(area[np.concatenate(rows)].mean() / np.pi))
    near = cKDTree(places[rest]).query_ball_point(places[some], most, return_sorted=True)
    takes, by = [], []
    for row, around in zip(some.tolist(), near, strict=True):
        others = rest[np.asarray(around, dtype=np.int64)]
        if len(others):
            gap = np.hypot(*(places[others] - places[row]).T) - radius[others]
            takes.append(row)
            by.append(int(others[np.argmin(gap)]))
    return np.array(takes, dtype=np.int64), np.array(by, dtype=np.int64)


def _torn(state: xr.Dataset, params: EngineParams) -> tuple[Index, Index]:
    none = np.zeros(0, dtype=np.int64)
    if "bond_id_lo" not in state or not state.sizes["bond"]:
        return none, none
    bonds = pair_arrays(state, "bond")
    elements = {name: state[name].values for name in ("id", "type", "radius")}
    far = pair_reach(elements, bonds, params) > LONGEST_BOND
    lo, hi = (element_rows(elements["id"], bonds[f"id_{end}"][far]) for end in ("lo", "hi"))
    both = (elements["type"][lo] == MOBILE) & (elements["type"][hi] == MOBILE)
    return _larger(state["area"].values, lo[both], hi[both])
