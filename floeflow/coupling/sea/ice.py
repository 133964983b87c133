# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice that comes and goes: what it holds, and states with more or fewer elements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.column.params import Settings
from floeflow.column.schemes import scheme_of
from floeflow.coupling.sea.columns import Columns
from floeflow.coupling.sea.water import ICE_SALINITY, OCEAN, Water, gain_heat, gain_salt
from floeflow.dynamics.remesh.tables import (
    corner_rows,
    element_values,
    kept_pairs,
    put_together,
    with_pairs,
    with_walls,
)
from floeflow.scene.effects import SEA_VARIABLES
from floeflow.state.elements import pair_arrays

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Terms = dict[str, float]


def held_by(columns: Columns, settings: Settings) -> dict[str, Array]:
    """Amounts of the ice and snow of columns, per m2, (n,) each.

    ``energy`` (J/m2, against the water that it melts to), ``water`` and ``salt`` (kg/m2),
    ``ice_area`` (1), ``ice_volume``, with snow ``snow_volume`` and with ponds ``pond`` (m).

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state's schema.
    settings : Settings
        Scheme and processes.

    Returns
    -------
    dict of ndarray
        (n,) each, by name.
    """
    count = len(columns["ice_fraction"])
    alone = {name: value for name, value in columns.items() if name not in SEA_VARIABLES}
    without = replace(
        settings, processes=tuple(p for p in settings.processes if p != "mixed_layer")
    )
    held = dict(scheme_of(settings).stored(alone, without))
    held["ice_area"] = columns["ice_fraction"].sum(axis=1)
    held["ice_volume"] = columns["ice_volume"].sum(axis=1)
    if "snow_volume" in columns:
        held["snow_volume"] = columns["snow_volume"].sum(axis=1)
    fixed = 1e-3 * ICE_SALINITY * OCEAN.ice_density * held["ice_volume"]
    held.setdefault("salt", fixed)
    return {name: np.broadcast_to(value, count) for name, value in held.items()}


@dataclass(frozen=True)
class Returned:
    """Ice that melted into the sea as a whole, by places.

    Parameters
    ----------
    x, y : ndarray
        Places (m), (n,).
    volume, cover : ndarray
        Of the ice (m3, m2), (n,).
    fresh : ndarray
        Whether it had frozen in open water in the same window, (n,).
    """

    x: Array
    y: Array
    volume: Array
    cover: Array
    fresh: NDArray[np.bool_]


def returned_ice(
    places: tuple[Array, Array], columns: Columns, area: Array, fresh: bool
) -> Returned:
    """What `dissolve` melts, by places.

    Parameters
    ----------
    places : tuple of ndarray
        x and y (m), (n,).
    columns : dict of ndarray
        Columns of the ice.
    area : ndarray
        For which they stand (m2), (n,).
    fresh : bool
        It had frozen in open water in the same window.

    Returns
    -------
    Returned
        Volume (m3) and area (m2) of ice at each place, (k,).
    """
    volume, cover = (area * columns[f"ice_{each}"].sum(axis=1) for each in ("volume", "fraction"))
    return Returned(*places, volume, cover, np.full(len(area), fresh))


def join_returned(parts: Sequence[Returned]) -> Returned:
    """All of them behind each other.

    Parameters
    ----------
    parts : sequence of Returned
        Of several elements or ranks.

    Returns
    -------
    Returned
        In the order of the parts.
    """
    names = [field.name for field in fields(Returned)]
    return Returned(*(np.concatenate([getattr(each, name) for each in parts]) for name in names))


def dissolve(water: Water, columns: Columns, area: Array, share: object) -> tuple[Water, Terms]:
    """Let ice and snow of columns melt into the sea, which gives the heat.

    Parameters
    ----------
    water : Water
        The sea.
    columns : dict of ndarray
        Columns of the ice.
    area : ndarray
        For which they stand (m2), (n,).
    share : sparse array
        Shares of the cells in their areas, (n, cells).

    Returns
    -------
    tuple of Water and dict
        The sea, and the terms of the budgets: what ice, snow, water, salt and ponds lose.
    """
    held = held_by(columns, water.settings)
    amount = {name: area * value for name, value in held.items()}

    def cells(values: Array) -> Array:
        return np.asarray(share.T @ values)  # type: ignore[attr-defined]

    pushed = cells(amount["water"]) * water.salinity * 1e-3
    after = gain_heat(water, cells(amount["energy"]))
    after = gain_salt(after, cells(amount["salt"]) - pushed)
    total = {name: float(value.sum()) for name, value in amount.items()}
    terms = {
        "growth_dissolved": -total["ice_volume"],
        "ice_area_dissolved": -total["ice_area"],
        "water_dissolved": -total["water"],
        "water_stored": -total["water"],
        "sea_heat_dissolved": total["energy"],
        "sea_salt_ice": total["salt"],
        "sea_salt_deep": -float(pushed.sum()),
    }
    if "snow_volume" in total:
        terms["snow_dissolved"] = -total["snow_volume"]
    if water.settings.scheme == "mushy":
        terms |= {"salt_dissolved": -total["salt"], "salt_stored": -total["salt"]}
    if "pond" in total:
        terms |= {"pond_dissolved": -total["pond"], "pond_stored": -total["pond"]}
    return after, terms


def add_terms(*parts: Mapping[str, float]) -> Terms:
    """Sums of terms by name."""
    total: Terms = {}
    for part in parts:
        for name, value in part.items():
            total[name] = total.get(name, 0.0) + value
    return total


def with_elements(state: xr.Dataset, keep: Index, new: Mapping[str, Array]) -> xr.Dataset:
    """State with some of its elements and new ones; their bonds and contacts go with them.

    Parameters
    ----------
    state : xarray.Dataset
        The state.
    keep : ndarray
        Rows that stay.
    new : mapping
        Element variables of the new ones, without ids (given after the highest); what they lack is
        zero. They stand apart from all others.

    Returns
    -------
    xarray.Dataset
        Those kept, then the new ones, sorted by id.
    """
    old = element_values(state, keep)
    count = len(new["x"])
    ids = int(state["id"].values.max(initial=0)) + 1 + np.arange(count)
    values = {**new, "id": ids}
    corners = None
    if "cell_corners" in old:
        rows = corner_rows(state["cell_corners"].values, keep)
        ring = np.stack([state[f"corner_{axis}"].values[rows] for axis in "xy"], axis=1)
        values["cell_corners"] = np.full(count, _SIDES)
        corners = np.concatenate([ring, _outlines(new["area"])])
    fresh = {
        name: values.get(name, np.zeros((count, *value.shape[1:]))) for name, value in old.items()
    }
    elements = {name: np.concatenate([old[name], fresh[name]]) for name in old}
    out = put_together(state, elements, corners)
    gone = float(state["area"].values.sum()) - float(elements["area"].sum())
    out.attrs["unclaimed_water"] = float(state.attrs["unclaimed_water"]) + gone
    tables = {
        kind: kept_pairs(pair_arrays(state, kind), old["id"], old["id"])
        for kind in ("bond", "contact")
        if f"{kind}_id_lo" in state
    }
    if "wall_contact_id" in state:
        held = np.flatnonzero(np.isin(state["wall_contact_id"].values, old["id"]))
        state = state.isel(wall_contact=held)
    return with_walls(with_pairs(out, tables), state, state["id"].values)


_SIDES = 12


def _outlines(area: Array) -> Array:
    """Corners of regular polygons of these areas around the origin (m), (n * sides, 2)."""
    angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    far = np.sqrt(2.0 * area / (_SIDES * np.sin(2.0 * np.pi / _SIDES)))
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.asarray((far[:, None, None] * ring).reshape(-1, 2))
