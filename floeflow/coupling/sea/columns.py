# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns of elements and of open water on one sea: what they read, and what they give back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floeflow.column.initial_columns import first_columns
from floeflow.column.params import Settings
from floeflow.column.physics import KELVIN
from floeflow.coupling.sea.shares import Shares
from floeflow.coupling.sea.water import (
    ICE_SALINITY,
    OCEAN,
    Water,
    freezing_points,
    gain_heat,
    gain_salt,
    split,
)
from floeflow.scene.effects import SEA_VARIABLES

Array = NDArray[np.float64]
Columns = dict[str, Array]
Index = NDArray[np.int64]

# Cells with less open water than this share of their sea count as closed.
LEAST_OPEN = 1e-6


@dataclass(frozen=True)
class Afloat:
    """Columns on the sea: those of n elements, then those of the open water of some cells.

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state's schema, with temperature and lack of heat of their sea.
    salinity : ndarray
        Of their sea (1e-3), (n + cells,).
    area : ndarray
        m2, (n + cells,).
    x, y : ndarray
        m, (n + cells,).
    cells : ndarray
        Flat index of each open cell, (cells,).
    """

    columns: Columns
    salinity: Array
    area: Array
    x: Array
    y: Array
    cells: Index


def open_columns(count: int, settings: Settings) -> Columns:
    """Columns without ice.

    Parameters
    ----------
    count : int
        Number of columns.
    settings : Settings
        Scheme, processes and categories.

    Returns
    -------
    dict of ndarray
        By the names of the state's schema, (count, ...).
    """
    none = np.zeros(count)
    return first_columns(none, none, none, 273.0, settings)


def float_columns(
    water: Water, shares: Shares, elements: Columns, places: tuple[Array, Array, Array],
    nodes: tuple[Array, Array],
) -> Afloat:  # fmt: skip
    """Columns of the elements and of the open water between and outside of them.

    Parameters
    ----------
    water : Water
        The sea.
    shares : Shares
        Of the elements.
    elements : dict of ndarray
        Columns of the elements, without their sea.
    places : tuple of ndarray
        x, y (m) and area (m2) of the elements.
    nodes : tuple of ndarray
        x, y of the grid's cells (m), (cells,) each.

    Returns
    -------
    Afloat
        Columns, salinity (1e-3), area (m2) and places (m), those of the elements first; rows of the
        cells whose open water follows.
    """
    settings = water.settings
    left = shares.open_area
    cells = np.flatnonzero(left > LEAST_OPEN * np.maximum(shares.sea, 1.0))
    empty = open_columns(len(cells), settings)
    columns = {name: np.concatenate([v, empty[name]]) for name, v in elements.items()}
    salinity = np.concatenate([shares.read(water.salinity), water.salinity[cells]])
    warmth = np.concatenate([shares.read_stock(water.warmth), water.warmth[cells]])
    sea = split(warmth, freezing_points(salinity, settings), water.capacity)
    columns |= dict(zip(SEA_VARIABLES, sea, strict=True))
    x, y, area = (np.concatenate([own, of]) for own, of in zip(
        places, (nodes[0][cells], nodes[1][cells], left[cells]), strict=True
    ))  # fmt: skip
    return Afloat(columns, salinity, area, x, y, cells)


def give_back(
    water: Water, shares: Shares, afloat: Afloat, after: Columns, terms: Columns
) -> tuple[Water, dict[str, float]]:
    """The sea after its columns were advanced, and the terms of its budgets.

    Water that freezes is replaced by as much of the layer's own salinity from below, so that the
    layer keeps its depth; water that melts pushes as much down.

    Parameters
    ----------
    water, shares, afloat
        As the columns began.
    after : dict of ndarray
        Columns at the end.
    terms : dict of ndarray
        Their terms, per m2: ``water_ocean`` and ``salt_ocean`` (kg/m2) are read.

    Returns
    -------
    water : Water
        Heat (J/m2) and salinity (1e-3) of the layer, (cells,).
    terms : dict of float
        Energy (J) and salt (kg) by name; they add up to the change of the sea's.
    """
    capacity, n = water.capacity, len(afloat.area) - len(afloat.cells)

    def heat(columns: Columns) -> Array:
        warmth, lack = (columns[name] for name in SEA_VARIABLES)
        return np.asarray(capacity * (warmth - KELVIN) - lack)

    def to_cells(amount: Array) -> Array:
        cells = shares.give(amount[:n]) if n else np.zeros(water.area.size)
        cells[afloat.cells] += amount[n:]
        return cells

    gained = to_cells(afloat.area * (heat(after) - heat(afloat.columns)))
    taken = to_cells(afloat.area * terms["water_ocean"])
    salt = to_cells(afloat.area * salt_of_ice(terms, water.settings))
    replaced = taken * water.salinity * 1e-3
    water = gain_salt(gain_heat(water, gained), replaced - salt)
    return water, {
        "sea_heat_columns": float(gained.sum()),
        "sea_salt_ice": -float(salt.sum()),
        "sea_salt_deep": float(replaced.sum()),
    }


def salt_of_ice(terms: Columns, settings: Settings) -> Array:
    """Salt that the ice took from the sea (kg/m2), (n,).

    Of ice that keeps no salt of its own as much as `ICE_SALINITY` says.

    Parameters
    ----------
    terms : dict of ndarray
        Terms of the columns' budgets, (n,).
    settings : Settings
        Not read where the terms hold ``salt_ocean``.

    Returns
    -------
    ndarray
        Negative where the ice gave salt back.
    """
    if "salt_ocean" in terms:
        return terms["salt_ocean"]
    grown = sum(value for name, value in terms.items() if name.startswith("growth_"))
    density = OCEAN.ice_density
    return np.asarray(1e-3 * ICE_SALINITY * density * grown + np.zeros_like(terms["water_ocean"]))
