# SPDX-License-Identifier: GPL-2.0-or-later
"""The sides of the scene's rectangle: ice that leaves is exported, and ice may flow in.

An element is exported at the end of the window in which its centre has left the rectangle. What it
held is counted by the side over which it went furthest, and its area is open water again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.column.initial_columns import first_columns
from floeflow.column.settings import column_settings, first_ice
from floeflow.coupling.sea.birth import FILL, place_discs
from floeflow.coupling.sea.ice import Terms, held_by, with_elements
from floeflow.coupling.sea.places import SeaPlaces
from floeflow.dynamics.remesh.tables import element_values
from floeflow.scene import Scene
from floeflow.scene.blocks import Domain
from floeflow.scene.effects import SEA_VARIABLES
from floeflow.state.elements import Arrays
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Radius of an element that flows in as a share of a typical one's: gaps of a packing are smaller.
LEAST_INFLOW = 0.8
SIDES = ("left", "right", "bottom", "top")


def beyond(domain: Domain, x: Array, y: Array) -> Array:
    """How far places lie outside of each side (m, below 0 inside), in the order of `SIDES`.

    Parameters
    ----------
    domain : Domain
        Rectangle of the scene (m).
    x : ndarray
        Places (m), (n,).
    y : ndarray
        Places (m), (n,).

    Returns
    -------
    ndarray
        m, (4, n).
    """
    return np.stack([domain.x_min - x, x - domain.x_max, domain.y_min - y, y - domain.y_max])


def export_ice(scene: Scene, state: xr.Dataset) -> tuple[xr.Dataset, Terms]:
    """Take the elements that have left the rectangle out of a state.

    Parameters
    ----------
    scene : Scene
        Its domain and effects are read.
    state : xarray.Dataset
        State at a window's end.

    Returns
    -------
    tuple of xarray.Dataset and dict
        The state, and for each side ``export_elements_<side>``, ``export_ice_area_<side>`` (m2),
        ``export_ice_volume_<side>`` and, with snow, ``export_snow_volume_<side>`` (m3), with
        thermodynamics ``export_energy_<side>`` (J), ``export_water_<side>`` and
        ``export_salt_<side>`` (kg).
    """
    out = beyond(scene.domain, state["x"].values, state["y"].values)
    gone = np.flatnonzero((state["type"].values == MOBILE) & (out.max(axis=0) > 0.0))
    side = out[:, gone].argmax(axis=0)
    held = amounts_of(scene, element_values(state, gone))
    terms = {}
    for number, name in enumerate(SIDES):
        terms[f"export_elements_{name}"] = float((side == number).sum())
        for quantity, values in held.items():
            terms[f"export_{quantity}_{name}"] = float(values[side == number].sum())
    if not len(gone):
        return state, terms
    keep = np.setdiff1d(np.arange(state.sizes["element"]), gone)
    none = {name: np.empty(0) for name in ("x", "y", "area")}
    return with_elements(state, keep, none), terms


def amounts_of(scene: Scene, elements: Arrays) -> dict[str, Array]:
    """What elements hold, (n,) each: areas (m2), volumes (m3), energy (J), water and salt (kg).

    Parameters
    ----------
    scene : Scene
        Effects and settings of the columns.
    elements : Arrays
        Variables of n elements, by name.

    Returns
    -------
    dict of ndarray
        By the names of `held_by`; without thermodynamics area and volume alone.
    """
    area = elements["area"]
    if "thermodynamics" in scene.effects:
        held = held_by(elements, column_settings(scene))
        named = {name: value for name, value in held.items() if name != "pond"}
        return {name: area * value for name, value in named.items()}
    names = ("ice_area", "ice_fraction"), ("ice_volume", "ice_volume")
    return {name: area * elements[variable].sum(axis=1) for name, variable in names}


def inflow_ice(scene: Scene, state: xr.Dataset, places: SeaPlaces) -> tuple[xr.Dataset, Terms]:
    """Fill open water along the sides that the scene names with ice as it was there at the start.

    Beside such a side the ice goes on beyond the rectangle: wherever an element fits between those
    that are there and the rim's ice of the mask, it has come in.

    Parameters
    ----------
    scene : Scene
        Its domain and ``rims.inflow`` are read.
    state : xarray.Dataset
        State at a window's end.
    places : SeaPlaces
        With the ice of the mask.

    Returns
    -------
    tuple of xarray.Dataset and dict
        The state, and for each of these sides what `export_ice` counts, as ``inflow_...``.
    """
    typical = float(state.attrs["typical_area"])
    deep = 2.0 * np.sqrt(typical / np.pi)
    terms: Terms = {}
    for side in scene.rims.inflow:
        inside = -beyond(scene.domain, places.x, places.y)[SIDES.index(side)]
        spots = np.flatnonzero((inside < deep) & (places.concentration > 0.0))
        made = _elements(scene, state, places, spots, typical)
        held = amounts_of(scene, made)
        terms[f"inflow_elements_{side}"] = float(len(made["x"]))
        for quantity, values in held.items():
            terms[f"inflow_{quantity}_{side}"] = float(values.sum())
        if len(made["x"]):
            state = with_elements(state, np.arange(state.sizes["element"]), made)
    return state, terms


def _elements(
    scene: Scene, state: xr.Dataset, places: SeaPlaces, spots: Index, typical: float
) -> Arrays:
    """Element variables of new elements at some of these spots, with the mask's ice."""
    cells = np.unique(places.cell[spots])
    some = replace(
        places,
        **{
            name: getattr(places, name)[spots]
            for name in ("x", "y", "cell", "shore", "concentration", "thickness")
        },
    )
    asked = np.full(len(cells), 1 + int(places.area.max() // typical))
    discs = np.stack([state[name].values for name in ("x", "y", "radius")], axis=1)
    x, y, radius, _ = place_discs(
        some, discs, cells, asked, np.full(len(cells), typical), LEAST_INFLOW
    )
    at = np.zeros(0, dtype=np.int64)
    if len(x):
        at = cKDTree(np.stack([some.x, some.y], axis=1)).query(np.stack([x, y], axis=1))[1]
    fraction = some.concentration[at]
    volume = fraction * some.thickness[at]
    made: Arrays = {"ice_fraction": fraction[:, None], "ice_volume": volume[:, None]}
    if "thermodynamics" in scene.effects:
        snow = np.full(len(at), scene.mask.snow_thickness)
        surface, settings = scene.column.initial_surface, column_settings(scene)
        every = first_columns(fraction, volume, snow, surface, settings, first_ice(scene))
        made = {n: v for n, v in every.items() if n in state and n not in SEA_VARIABLES}
    made |= {"x": x, "y": y, "radius": radius, "area": np.pi * radius**2 / FILL}
    return made | {"type": np.full(len(at), MOBILE)}
