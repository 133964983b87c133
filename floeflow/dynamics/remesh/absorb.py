# SPDX-License-Identifier: GPL-2.0-or-later
"""Which elements cannot go on by themselves: used up by ridges, run over, or torn from their bonds.

Ridging makes elements smaller without end, and drives them into each other. What is left of one
that is nearly used up, or whose centre lies deep inside of its neighbour, is ice of that
neighbour: the two become one (`merge`). So nothing that ridging does ever ends a run.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.dynamics.engine.params import EngineParams
from floeflow.dynamics.engine.setup import pair_reach
from floeflow.dynamics.remesh.merge import into_roots
from floeflow.state.bonds import element_rows
from floeflow.state.elements import pair_arrays
from floeflow.state.schema import MOBILE

Index = NDArray[np.int64]
Array = NDArray[np.float64]

# An element of less than this share of the mean area is used up.
USED_UP = 0.2
# One whose centre is nearer to a larger one's than this share of the larger radius is run over.
RUN_OVER = 0.5
# How far a neighbour may be to take a used-up element, as a share of the sum of the mean radii.
FARTHEST = 2.0
# A bond that survives at more than this many times the sum of the radii has too small elements.
LONGEST_BOND = 3.0


def absorbed(state: xr.Dataset, params: EngineParams) -> Index:
    """Row that each element becomes part of; its own where it stays, (n,).

    Parameters
    ----------
    state : xarray.Dataset
        A state at a window's end.
    params : EngineParams
        Laws: they say how far bonds reach.
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
    ):
        into[small] = large
    return into_roots(into)


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
    small = mobile[area[mobile] < USED_UP * area[mobile].mean()]
    rest = mobile[area[mobile] >= USED_UP * area[mobile].mean()]
    most = FARTHEST * 2.0 * float(np.sqrt(area[mobile].mean() / np.pi))
    near = cKDTree(places[rest]).query_ball_point(places[small], most, return_sorted=True)
    takes, by = [], []
    for row, around in zip(small.tolist(), near, strict=True):
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
