# SPDX-License-Identifier: GPL-2.0-or-later
"""From the state to the arrays of the discrete element model, and back.

The model knows discs with a mass, a thickness and an ice-covered area; the state knows columns.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from floeflow.core.constants import ICE_DENSITY, SNOW_DENSITY
from floeflow.state.schema import COAST, VARIABLES

Arrays = dict[str, np.ndarray]

# Discs cannot come nearer than half of their distance in a window: emptier elements count as half
# covered, so that they resist then.
LEAST_COVER = 0.5
# What the model moves; everything else of an element is the column's.
MOVED = ("x", "y", "theta", "u", "v", "omega")


def element_arrays(state: xr.Dataset, minimum_thickness: float) -> Arrays:
    """Arrays of the discs that stand for a state's elements.

    Parameters
    ----------
    state : xarray.Dataset
        The state.
    minimum_thickness : float
        Elements with less ice than this (m over their whole area) get the mass and thickness of
        this much, and the drag of the part that is made up, so that ice that melts out keeps a
        mass and goes with wind and water.

    Returns
    -------
    dict of ndarray, shape (n,)
        id, type, x, y, theta, u, v, omega, radius, mass (kg), thickness (m, `bearing_thickness`),
        ice_area (m2, on which wind and water act), cover (share of the area under ice, at least
        `LEAST_COVER`: what is open closes without force).
    """
    arrays = {name: state[name].values.copy() for name in ("id", "type", *MOVED, "radius")}
    area = state["area"].values
    fraction = state["ice_fraction"].values.sum(axis=1)
    volume = state["ice_volume"].values.sum(axis=1)
    load = ICE_DENSITY * np.maximum(volume, minimum_thickness)
    if "snow_volume" in state:
        load = load + SNOW_DENSITY * state["snow_volume"].values.sum(axis=1)
    arrays["mass"] = area * load
    arrays["thickness"] = np.maximum(joint_thickness(state), minimum_thickness)
    made_up = np.maximum(1.0 - volume / minimum_thickness, 0.0)
    arrays["ice_area"] = area * np.maximum(fraction, made_up)
    arrays["cover"] = np.clip(fraction, LEAST_COVER, 1.0)
    # Coast stands for no ocean, but a contact needs a mass on both sides.
    coast = arrays["type"] == COAST
    disc = np.pi * arrays["radius"][coast] ** 2
    arrays["mass"][coast] = ICE_DENSITY * arrays["thickness"][coast] * disc
    arrays["ice_area"][coast] = 0.0
    arrays["cover"][coast] = 1.0
    return arrays


def bearing_thickness(state: xr.Dataset) -> np.ndarray:
    """Thickness that bears load, m, shape (n,): ice volume per effective area.

    Ice that covers a share of its element bears over that share of a bond or contact. Mass and
    stiffness then shrink together, so thin or open ice asks for no shorter step.

    Parameters
    ----------
    state : xarray.Dataset
        The state.

    Returns
    -------
    ndarray
        m, (n,).
    """
    return np.asarray(state["ice_volume"].values.sum(axis=1))


def joint_thickness(state: xr.Dataset) -> np.ndarray:
    """Thickness with which an element takes part in bonds and contacts, m, shape (n,).

    That which bears load; the coast is as thick as the thickest ice, so that the ice's own
    thickness sets what joins them.

    Parameters
    ----------
    state : xarray.Dataset
        The state.

    Returns
    -------
    ndarray
        m, (n,).
    """
    thickness = bearing_thickness(state)
    coast = state["type"].values == COAST
    thickness[coast] = thickness[~coast].max(initial=0.0)
    return thickness


def pair_arrays(state: xr.Dataset, kind: str) -> Arrays:
    """Table of a state (bond, contact, wall_face, wall_contact), names without that prefix.

    Parameters
    ----------
    state : xarray.Dataset
        With that table.
    kind : str
        bond, contact, wall_face or wall_contact.

    Returns
    -------
    Arrays
        Copies.
    """
    names = [name for name in VARIABLES if name.startswith(f"{kind}_") and name in state]
    return {name.removeprefix(f"{kind}_"): state[name].values.copy() for name in names}


def moved_state(
    state: xr.Dataset,
    elements: Arrays,
    bonds: Arrays | None,
    contacts: Arrays,
    wall_contacts: Arrays | None = None,
) -> xr.Dataset:
    """State with the motion, bonds and contacts that the model left.

    Parameters
    ----------
    state : xarray.Dataset
        State before the motion.
    elements, bonds, contacts, wall_contacts : dict of ndarray
        What the model holds now; sorted by id, by (id_lo, id_hi) and by (id, face).

    Returns
    -------
    xarray.Dataset
        Places, velocities and orientations from `elements`, and the tables that are given; all else
        as in `state`.
    """
    kinds = {"bond": bonds, "contact": contacts, "wall_contact": wall_contacts}
    pairs = tuple(f"{kind}_" for kind in kinds)
    keep = [name for name in state.variables if not str(name).startswith(pairs)]
    moved = {name: ("element", elements[name]) for name in MOVED}
    tables = {kind: table for kind, table in kinds.items() if table}
    return with_tables(state[keep].assign(moved), tables)


def with_tables(state: xr.Dataset, tables: Mapping[str, Arrays]) -> xr.Dataset:
    """State with tables by kind; all at once, since each change of a dataset costs milliseconds.

    Parameters
    ----------
    state : xarray.Dataset
        A state.
    tables : mapping of Arrays
        Names without the kind's prefix: bond, contact, wall_contact, wall_face.

    Returns
    -------
    xarray.Dataset
        Variables ``<kind>_<name>`` over the dimension ``<kind>``, in the schema's types.
    """
    found = {}
    for kind, table in tables.items():
        for name, values in table.items():
            full = f"{kind}_{name}"
            found[full] = (kind, values.astype(VARIABLES[full].dtype, copy=False))
    return state.assign(found)


def carry_drift(
    before: xr.Dataset, after: xr.Dataset, way: tuple[np.ndarray, np.ndarray] | None = None
) -> xr.Dataset:
    """State after a motion, in whose net displacement that motion is counted.

    Fresh elements begin where their cells are, and in a rectangle that repeats itself elements
    that leave come in again: positions alone do not tell how far ice went.

    Parameters
    ----------
    before, after : xarray.Dataset
        State before and after the motion.
    way : tuple of ndarray, optional
        How far each element went in x and y (m), (n,); absent: as its places tell.

    Returns
    -------
    xarray.Dataset
        With drift_x and drift_y (m) over the elements; `after` itself where `before` counts none.
    """
    if "drift_x" not in before:
        return after
    if way is None:
        way = after["x"].values - before["x"].values, after["y"].values - before["y"].values
    gone = {
        f"drift_{a}": ("element", before[f"drift_{a}"].values + each)
        for a, each in zip("xy", way, strict=True)
    }
    return after.assign(gone)


def thin_bonds(state: xr.Dataset) -> xr.Dataset:
    """Let bonds be no thicker than the ice beside them: melt weakens, growth does not heal.

    The series thickness of a pair is that of the thinner element. Where its ice has melted out
    nothing is left of a bond.

    Parameters
    ----------
    state : xarray.Dataset
        The state.

    Returns
    -------
    xarray.Dataset
        Without bonds between elements whose ice has gone; the state itself where it has no bonds.
    """
    if "bond_thickness" not in state:
        return state
    thickness = joint_thickness(state)
    ids = state["id"].values
    lo = thickness[np.searchsorted(ids, state["bond_id_lo"].values)]
    hi = thickness[np.searchsorted(ids, state["bond_id_hi"].values)]
    now = np.minimum(state["bond_thickness"].values, np.minimum(lo, hi))
    return state.assign(bond_thickness=("bond", now)).isel(bond=np.flatnonzero(now > 0))
