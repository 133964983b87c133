# SPDX-License-Identifier: GPL-2.0-or-later
"""Refreezing at a window's end: elements that stay in touch in the cold freeze together.

New bonds begin thin and thicken as ice grows in a crack (Stefan's law), and so do old bonds that
are thinner than the ice beside them; cracked parts of bonds that hold freeze again. Ice that forms
in between is free of stress, so a bond keeps its force while its strength grows. Pure functions on
the state.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from floeflow.core.constants import EDGE_SHARE
from floeflow.dynamics.bonds.glue_line import displaced, healed, loaded_less_than, thickened
from floeflow.dynamics.engine.params import EngineParams
from floeflow.state.bonds import Arrays, element_rows, new_bonds
from floeflow.state.elements import joint_thickness, pair_arrays, with_tables
from floeflow.state.schema import MOBILE

# A bond that would have to bear more than this share of its strength does not form or heal yet.
MOST_LOAD = 0.5


@dataclass(frozen=True)
class Cold:
    """When and how fast cracks freeze.

    Parameters
    ----------
    touch_time : float
        Time in touch and in the cold after which a pair freezes together, s.
    temperature : float
        Air colder than this freezes, K.
    thickness : float
        Of a new bond, m.
    freezing_point : float
        Of the sea, K.
    growth : float
        Stefan's 2 k / (rho L), by which the squared thickness grows per degree and second,
        m2/(K s).
    to_coast : bool
        Whether ice freezes to coast elements too.
    """

    touch_time: float
    temperature: float
    thickness: float
    freezing_point: float
    growth: float
    to_coast: bool = False


Air = Callable[[np.ndarray, np.ndarray], np.ndarray]


def refreeze(
    state: xr.Dataset,
    touched: Arrays,
    air: Air,
    cold: Cold,
    params: EngineParams,
    window: float,
) -> tuple[xr.Dataset, int]:
    """Let bonds thicken, count the time in touch and freeze pairs together.

    Parameters
    ----------
    state : xarray.Dataset
        State at the window's end; its contacts have no touch time yet.
    touched : dict of ndarray
        Contact table at the window's start, with touch_time (s).
    air : callable
        Air temperature (K) over the window at places x, y (m).
    cold : Cold
        When and how fast.
    params : EngineParams
        Stiffness of bonds and contacts.
    window : float
        Length of the window, s.

    Returns
    -------
    tuple of xarray.Dataset and int
        State with bonds and contacts as they are now, and the number of new bonds.
    """
    elements = {name: state[name].values for name in ("id", "type", "x", "y", "theta", "radius")}
    elements["thickness"] = joint_thickness(state)
    weather = elements, air, cold, window
    bonds = heal(thicken(pair_arrays(state, "bond"), *weather), *weather, params)
    contacts = pair_arrays(state, "contact")
    contacts["touch_time"] = touch_times(contacts, touched, elements, air, cold, window)
    made, frozen = freeze(contacts, elements, cold, params)
    bonds = {name: np.concatenate([bonds[name], made[name]]) for name in bonds}
    order = np.lexsort((bonds["id_hi"], bonds["id_lo"]))
    tables = {
        "bond": {name: values[order] for name, values in bonds.items()},
        "contact": {name: values[~frozen] for name, values in contacts.items()},
    }
    keep = [name for name in state.variables if not str(name).startswith(("bond_", "contact_"))]
    return with_tables(state[keep], tables), int(frozen.sum())


def thicken(bonds: Arrays, elements: Arrays, air: Air, cold: Cold, window: float) -> Arrays:
    """Bonds after a window of growth: no thicker than the ice beside them, force as before.

    Parameters
    ----------
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    elements : Arrays
        Table of n elements, sorted by id.
    air : Air
        Temperatures of the air.
    cold : Cold
        When and how ice freezes.
    window : float
        Length of the window (s).

    Returns
    -------
    Arrays
        A new table.
    """
    lo, hi = _rows(bonds, elements)
    grown = np.sqrt(bonds["thickness"] ** 2 + _growth(bonds, elements, air, cold, window))
    beside = np.minimum(elements["thickness"][lo], elements["thickness"][hi])
    thickness = np.maximum(bonds["thickness"], np.minimum(grown, beside))
    return thickened(bonds, elements, thickness)


def heal(
    bonds: Arrays, elements: Arrays, air: Air, cold: Cold, window: float, params: EngineParams
) -> Arrays:
    """Bonds after their cracks have frozen for a window: shorter cracks, force as before.

    Ice in a crack is as thick as the bond after h^2 / growth; until then a third of it is missing
    on average. Cracks close by 1/e in a third of that time: in sum as much is missing. The
    longer line bears an eccentric load: where that is too much, the cracks stay.

    Parameters
    ----------
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    elements : Arrays
        Table of n elements, sorted by id.
    air : Air
        Temperatures of the air.
    cold : Cold
        When and how ice freezes.
    window : float
        Length of the window (s).
    params : EngineParams
        Parameters of the engine.

    Returns
    -------
    Arrays
        A new table.
    """
    grown = _growth(bonds, elements, air, cold, window) / bonds["thickness"] ** 2
    longer = healed(bonds, elements, np.exp(-3.0 * grown))
    good = loaded_less_than(MOST_LOAD, longer, elements, params)
    return {name: np.where(good, longer[name], bonds[name]) for name in bonds}


def _growth(bonds: Arrays, elements: Arrays, air: Air, cold: Cold, window: float) -> np.ndarray:
    """By how much the squared thickness of ice in a crack of each bond grows in a window, m2."""
    between = _air_between(elements, *_rows(bonds, elements), air)
    return np.asarray(cold.growth * np.maximum(cold.freezing_point - between, 0.0) * window)


def touch_times(
    contacts: Arrays, touched: Arrays, elements: Arrays, air: Air, cold: Cold, window: float
) -> np.ndarray:
    """Time (s) for which each pair has been in touch and in the cold, by the windows' ends.

    A pair counts a window if it is in touch at both of its ends; warm air sets it back to 0.

    Parameters
    ----------
    contacts : Arrays
        Contact table of k contacts.
    touched : Arrays
        Pairs that were in touch before, with their ``touch_time`` (s).
    elements : Arrays
        Table of n elements, sorted by id.
    air : Air
        Temperatures of the air.
    cold : Cold
        When and how ice freezes.
    window : float
        Length of the window (s).

    Returns
    -------
    ndarray
        (k,); 0 for pairs that are not in touch, or not in the cold.
    """
    lo, hi = _rows(contacts, elements)
    known = dict(
        zip(
            zip(touched["id_lo"].tolist(), touched["id_hi"].tolist(), strict=True),
            touched["touch_time"].tolist(),
            strict=True,
        )
    )
    pairs = zip(contacts["id_lo"].tolist(), contacts["id_hi"].tolist(), strict=True)
    since = np.array([known.get(pair, -window) for pair in pairs], dtype=float) + window
    freezing = _air_between(elements, lo, hi, air) < cold.temperature
    return np.where(freezing & (_elastic_overlap(contacts, elements) > 0), since, 0.0)


def freeze(
    contacts: Arrays, elements: Arrays, cold: Cold, params: EngineParams
) -> tuple[Arrays, np.ndarray]:
    """Bonds of the pairs that freeze together now, and which contacts they were.

    The glue line lies across the line of centres where the contact's levers meet, as long as the
    contact. It takes over the contact's force, or less where it would hold more elastic energy
    than the contact did.

    Parameters
    ----------
    contacts : Arrays
        Contacts that have been in touch long enough, k of them.
    elements : Arrays
        Table of n elements, sorted by id.
    cold : Cold
        When and how ice freezes.
    params : EngineParams
        Parameters of the engine.

    Returns
    -------
    tuple of Arrays and ndarray
        Bond table of the new bonds, and which contacts they were (k,), bool.
    """
    lo, hi = _rows(contacts, elements)
    dx, dy = elements["x"][hi] - elements["x"][lo], elements["y"][hi] - elements["y"][lo]
    span = np.hypot(dx, dy)
    radii = elements["radius"][lo], elements["radius"][hi]
    length = contacts.get("ridge_length", 2.0 * EDGE_SHARE * np.minimum(*radii))
    beside = elements["thickness"][lo], elements["thickness"][hi]
    thickness = np.minimum(cold.thickness, np.minimum(*beside))
    elastic = np.maximum(_elastic_overlap(contacts, elements), 0.0)
    total = np.maximum(beside[0] + beside[1], np.finfo(float).tiny)
    spring = params.contact_modulus * beside[0] * beside[1] / total
    stiffness = params.young_modulus * thickness * length / span
    push = elastic * np.minimum(spring, np.sqrt(spring * stiffness))
    bearable = MOST_LOAD * params.bond_strength(thickness) * thickness * length
    mobile = [elements["type"][row] == MOBILE for row in (lo, hi)]
    joined = (mobile[0] | mobile[1]) if cold.to_coast else (mobile[0] & mobile[1])
    frozen = (contacts["touch_time"] >= cold.touch_time) & joined
    frozen &= (contacts["touch_time"] > 0) & (thickness > 0) & (push <= bearable)

    def at(values: np.ndarray) -> np.ndarray:
        return np.asarray(values)[frozen]

    nx, ny = at(dx) / at(span), at(dy) / at(span)
    arm, half = at(span * radii[0] / (radii[0] + radii[1])), 0.5 * at(length)
    cx, cy = elements["x"][lo[frozen]] + arm * nx, elements["y"][lo[frozen]] + arm * ny
    made = new_bonds(
        elements,
        *(at(contacts["id_lo"]), at(contacts["id_hi"])),
        *(cx + half * ny, cy - half * nx, cx - half * ny, cy + half * nx),
        at(thickness),
    )
    squeeze = -at(push) / np.where(at(push) > 0, at(stiffness), 1.0) * (nx + 1j * ny)
    return displaced(made, elements, squeeze, squeeze), frozen


def _rows(pairs: Arrays, elements: Arrays) -> tuple[np.ndarray, np.ndarray]:
    ids = elements["id"]
    return element_rows(ids, pairs["id_lo"]), element_rows(ids, pairs["id_hi"])


def _elastic_overlap(contacts: Arrays, elements: Arrays) -> np.ndarray:
    lo, hi = _rows(contacts, elements)
    distance = np.hypot(
        elements["x"][hi] - elements["x"][lo], elements["y"][hi] - elements["y"][lo]
    )
    overlap = elements["radius"][lo] + elements["radius"][hi] - distance
    return np.asarray(overlap - contacts["rest_overlap"])


def _air_between(elements: Arrays, lo: np.ndarray, hi: np.ndarray, air: Air) -> np.ndarray:
    if len(lo) == 0:
        return np.zeros(0)
    middle = (0.5 * (elements[axis][lo] + elements[axis][hi]) for axis in ("x", "y"))
    return np.asarray(air(*middle))
