# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables that the engine takes, checked before LIGGGHTS sees them."""

from __future__ import annotations

import numpy as np

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.params import FIXED, EngineParams, Forcing
from floeflow.state.bonds import BOND_COLUMNS, RIDGE_COLUMNS, Arrays, element_rows, pair_keys

_POSITIVE = ("radius", "mass")
_NUMBERS = ("x", "y", "theta", "u", "v", "omega", "radius", "mass", "thickness", "ice_area")


def check_elements(elements: Arrays) -> None:
    """Refuse elements that are not finite, not positive where they must be, or not in order.

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.

    Raises
    ------
    FloeError
        Names the first element at fault and its value.
    """
    ids = np.asarray(elements["id"])
    if len(ids) == 0:
        raise FloeError("There are no elements.")
    if ids[0] < 1 or ids[-1] > np.iinfo(np.int32).max or (np.diff(ids) <= 0).any():
        raise FloeError("Element ids must be ascending, from 1, and fit in 32 bits.")
    if not np.isin(elements["type"], (1, FIXED)).all():
        raise FloeError("Element types must be 1 (mobile) or 2 (fixed).")
    for name in _NUMBERS:
        values = np.asarray(elements[name], dtype=float)
        if len(values) != len(ids):
            raise FloeError(f"There are {len(ids)} elements but {len(values)} values of {name}.")
        if name in _POSITIVE:
            bad, rule = ~(values > 0) | ~np.isfinite(values), "above 0"
        elif name in ("thickness", "ice_area"):
            bad, rule = ~(values >= 0) | ~np.isfinite(values), "at least 0"
        else:
            bad, rule = ~np.isfinite(values), "finite"
        _refuse(ids, name, values, bad, rule)
    if "cover" in elements:
        cover = np.asarray(elements["cover"], dtype=float)
        _refuse(ids, "cover", cover, ~((cover >= 0) & (cover <= 1)), "from 0 to 1")


def _refuse(ids: np.ndarray, name: str, values: np.ndarray, bad: np.ndarray, rule: str) -> None:
    """Refuse the first of the elements whose values are bad."""
    if bad.any():
        k = int(np.flatnonzero(bad)[0])
        raise FloeError(f"{name} of element {ids[k]} must be {rule}, not {values[k]}.")


def _check_pairs(elements: Arrays, table: Arrays, names: tuple[str, ...], kind: str) -> None:
    lo, hi = np.asarray(table["id_lo"]), np.asarray(table["id_hi"])
    if len(lo) == 0:
        return
    rows = element_rows(elements["id"], lo), element_rows(elements["id"], hi)
    if not (lo < hi).all():
        raise FloeError(f"Each {kind} must name the lower id first.")
    if len(np.unique(pair_keys(table))) != len(lo):
        raise FloeError(f"A pair of elements appears twice in the {kind} table.")
    both = (elements["type"][rows[0]] == FIXED) & (elements["type"][rows[1]] == FIXED)
    if both.any():
        k = int(np.flatnonzero(both)[0])
        raise FloeError(f"The {kind} {lo[k]}-{hi[k]} joins two fixed elements.")
    for name in names:
        bad = ~np.isfinite(table[name])
        if bad.any():
            k = int(np.flatnonzero(bad)[0])
            raise FloeError(f"{name} of the {kind} {lo[k]}-{hi[k]} is not finite.")


def check_bonds(elements: Arrays, bonds: Arrays) -> None:
    """Refuse a bond table that no ice could have.

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.

    Raises
    ------
    FloeError
        For a value or pair that cannot be; names the bond.
    """
    _check_pairs(elements, bonds, BOND_COLUMNS, "bond")
    for name, good in (
        ("span", bonds["span"] > 0),
        ("thickness", bonds["thickness"] > 0),
        ("crack_a", bonds["crack_a"] >= 0),
        ("crack_b", bonds["crack_b"] >= 0),
        ("crack_a + crack_b", bonds["crack_a"] + bonds["crack_b"] < 1),
    ):
        if not good.all():
            k = int(np.flatnonzero(~good)[0])
            raise FloeError(
                f"{name} of the bond {bonds['id_lo'][k]}-{bonds['id_hi'][k]} is out of range."
            )


def check_contacts(
    elements: Arrays, bonds: Arrays, contacts: Arrays, columns: tuple[str, ...]
) -> None:
    """Refuse a contact table with impossible values or with bonded pairs in it.

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    contacts : Arrays
        Contact table of k contacts.
    columns : tuple of str
        Columns that the table must have.

    Raises
    ------
    FloeError
        For a value or pair that cannot be; names the contact.
    """
    _check_pairs(elements, contacts, columns, "contact")
    # With ridging a contact may reach across a gap: its rest overlap is below 0 then.
    kept = RIDGE_COLUMNS if "ridge_closing" in columns else ("rest_overlap",)
    for name in kept:
        if (contacts[name] < 0).any():
            raise FloeError(f"A contact's {name} must not be negative.")
    both = np.flatnonzero(np.isin(pair_keys(contacts), pair_keys(bonds)))
    if both.size:
        lo, hi = (contacts[name][both[0]] for name in ("id_lo", "id_hi"))
        raise FloeError(f"Elements {lo} and {hi} are bonded and in contact at once.")


def check_time(params: EngineParams, forcing: Forcing | None, begin: float, steps: int) -> None:
    """Refuse steps from a time (s) on that the forcing, where one is needed, does not cover.

    Parameters
    ----------
    params : EngineParams
        Parameters of the engine.
    forcing : Forcing or None
        None where the effects need none.
    begin : float
        s.
    steps : int
        Number of time steps.

    Raises
    ------
    FloeError
        For forcing that is missing, or too short.
    """
    needed = params.external
    if not needed:
        return
    if forcing is None:
        raise FloeError(f"The scene's effects need forcing ({', '.join(needed)}).")
    first, last = float(forcing.time[0]), float(forcing.time[-1])
    end = begin + steps * params.time_step
    slack = 0.5 * params.time_step
    if first < last and (begin < first - slack or end > last + slack):
        raise FloeError(
            f"The forcing covers {first:g} s to {last:g} s, not {begin:g} s to {end:g} s."
        )
