# SPDX-License-Identifier: GPL-2.0-or-later
"""Fracture: how loaded bonds are, which way new cracks run, and how large they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.diagnostics.collect import intact
from floeflow.diagnostics.floe_sizes import fragments
from floeflow.dynamics.bonds.glue_line import line_stresses
from floeflow.dynamics.engine.params import EngineParams
from floeflow.state.bonds import lines_in_space
from floeflow.state.elements import pair_arrays

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def bond_stresses(state: xr.Dataset, params: EngineParams) -> tuple[Array, Array]:
    """Stress of the bonds that hold, over their compressive strength.

    Bonds across the sides of a rectangle that repeats itself are left out.

    Parameters
    ----------
    state : xarray.Dataset
        A state with bonds.
    params : EngineParams
        Of the scene.

    Returns
    -------
    tuple of ndarray
        Normal stress, above 0 in tension, at the end of the holding line that is nearer to
        failing, and the size of the shear stress (1), (bond,).
    """
    bonds = pair_arrays(state, "bond")
    elements = {name: state[name].values for name in ("id", "x", "y", "theta")}
    lo, hi = (np.searchsorted(elements["id"], bonds[f"id_{side}"]) for side in ("lo", "hi"))
    apart = np.hypot(*(elements[axis][hi] - elements[axis][lo] for axis in "xy"))
    held = (bonds["crack_a"] + bonds["crack_b"] < 1.0) & (apart < 2.0 * bonds["span"])
    bonds = {name: values[held] for name, values in bonds.items()}
    normal, shear = line_stresses(bonds, elements, params)
    strength = params.bond_strength(bonds["thickness"])
    normal, shear = normal / strength, shear / strength
    slope = np.tan(params.friction_angle)
    # How far each end is inside of the envelope: tension and shear, and crushing.
    room = np.minimum((params.tensile_share - normal) * slope - shear, 1.0 + normal)
    return np.where(room[0] <= room[1], normal[0], normal[1]), shear


@dataclass(frozen=True)
class Cracks:
    """Lines of bonds of the start that no longer hold at the end.

    Attributes
    ----------
    angle, length : ndarray
        Direction of each line at the end, from the x axis to the left (rad, 0 to pi), and its
        length (m), (line,).
    sizes : ndarray
        Lengths of cracks (m), the longest first: lines that meet in an element are one, (crack,).
    before : ndarray
        Lengths of all lines of the start by direction, as `by_angle` counts them (m).
    """

    angle: Array
    length: Array
    sizes: Array
    before: Array


# Directions are counted in so many bins.
ANGLES = 18


def by_angle(angle: Array, length: Array) -> Array:
    """Length by direction, (`ANGLES`,).

    Parameters
    ----------
    angle : ndarray
        rad, 0 to pi, (n,).
    length : ndarray
        m, (n,).

    Returns
    -------
    ndarray
        m.
    """
    bins = np.minimum((np.mod(angle, np.pi) / np.pi * ANGLES).astype(np.int64), ANGLES - 1)
    return np.bincount(bins, length, ANGLES).astype(np.float64)


def new_cracks(first: xr.Dataset, last: xr.Dataset) -> Cracks | None:
    """Cracks that opened between two states whose elements are the same.

    Parameters
    ----------
    first, last : xarray.Dataset
        States with bonds; elements that merged away are left out.

    Returns
    -------
    Cracks or None
        None where no bond broke, or where a remap made elements anew.
    """
    if "remap" in str(last.attrs["effects"]).split():
        return None
    ids = last["id"].values
    held = {tuple(pair) for pair in intact(last).tolist()}
    table = pair_arrays(first, "bond")
    pairs = np.stack([table["id_lo"], table["id_hi"]], axis=1)
    began = table["crack_a"] + table["crack_b"] < 1.0
    there = began & np.isin(pairs, ids).all(axis=1)
    gone = np.array([tuple(pair) not in held for pair in pairs.tolist()], dtype=bool) & there
    if not gone.any():
        return None
    start, _ = _directions({name: values[there] for name, values in table.items()}, first)
    table = {name: values[gone] for name, values in table.items()}
    angle, length = _directions(table, last)
    before = by_angle(start, pair_arrays(first, "bond")["length"][there])
    return Cracks(angle, length, _joined(pairs[gone], length), before)


def _directions(table: dict[str, Array], state: xr.Dataset) -> tuple[Array, Array]:
    """Direction (rad) and length (m) of lines, carried by their element of the lower id."""
    row = np.searchsorted(state["id"].values, table["id_lo"])
    x, y, theta = (state[name].values[row] for name in ("x", "y", "theta"))
    lines = lines_in_space(table, x, y, theta)
    dx, dy = (lines[:, 1] - lines[:, 0]).T
    return np.mod(np.arctan2(dy, dx), np.pi), np.hypot(dx, dy)


def _joined(pairs: Index, length: Array) -> Array:
    """Lengths of lines that share elements, added up, the longest first."""
    known = np.unique(pairs)
    label = fragments(known, pairs)[np.searchsorted(known, pairs[:, 0])]
    sums = np.bincount(label, length).astype(np.float64)
    return np.sort(sums[sums > 0.0])[::-1]
