# SPDX-License-Identifier: GPL-2.0-or-later
"""State 0: the packing and its bonds, at rest."""

import numpy as np
import xarray as xr

from floeflow.column.initial_columns import SNOW_LAYERS, first_columns
from floeflow.column.settings import column_settings, first_ice
from floeflow.core.grids import scene_grid
from floeflow.core.period import ATTRIBUTE
from floeflow.coupling.initial_walls import wall_variables
from floeflow.coupling.origin import provenance
from floeflow.coupling.sea.initial_sea import first_sea
from floeflow.coupling.sea.places import sea_places
from floeflow.scene.blocks import Scene
from floeflow.state import SCHEMA_VERSION
from floeflow.state.attributes import SCHEME_ATTRIBUTE
from floeflow.state.schema import MOBILE, VARIABLES, expected_variables


def make_state(
    scene: Scene,
    packing: xr.Dataset,
    bonds: xr.Dataset | None,
    mask: xr.Dataset | None = None,
) -> xr.Dataset:
    """State at the start.

    Parameters
    ----------
    scene : Scene
        Its effects say which variables there are.
    packing : xarray.Dataset
        Output of the packing stage.
    bonds : xarray.Dataset or None
        Output of the bonds stage, with the effect bonds.
    mask : xarray.Dataset or None
        Output of the mask stage, with the effect mixed_layer.

    Returns
    -------
    xarray.Dataset
        As in ``floeflow.state.schema``: no velocities, no contacts. With thermodynamics, snow of
        the scene's thickness on the ice; the surface of zero-layer ice at the ocean's freezing
        point, layers of the temperatures of steady conduction.
    """
    made = _columns(scene, packing) if "thermodynamics" in scene.effects else {}
    # Outlines in the body frames; elements are not turned yet.
    corners = np.diff(packing["cell_start"].values)
    made |= {"cell_corners": corners}
    for axis in ("x", "y"):
        made[f"corner_{axis}"] = packing[f"cell_{axis}"].values - np.repeat(
            packing[axis].values, corners
        )
    walled = {"walls", "coast"} & set(scene.effects)
    made |= wall_variables(scene, packing) if walled else {}
    sizes = {"element": packing.sizes["element"], "category": packing.sizes["category"]}
    sizes |= {"bond": 0 if bonds is None else bonds.sizes["bond"], "contact": 0}
    sizes |= {"ice_layer": scene.column.layers, "snow_layer": SNOW_LAYERS}
    sizes["wall_contact"] = len(made.get("wall_contact_id", ()))
    data: dict[str, tuple[tuple[str, ...], np.ndarray]] = {}
    if "mixed_layer" in scene.effects:
        assert mask is not None
        grid = scene_grid(scene.domain)
        places = sea_places(mask, grid.x, grid.y)
        data |= first_sea(places, mask, column_settings(scene))
    for name in expected_variables(scene.effects, scene.column.scheme):
        rule = VARIABLES[name]
        if name in data:
            continue
        if name in made:
            values = made[name]
        elif name in packing:
            values = packing[name].values
        elif bonds is not None and name in bonds:
            values = bonds[name].values
        else:
            values = np.zeros([sizes[dim] for dim in rule.dims], dtype=rule.dtype)
        data[name] = (rule.dims, values)
    attrs = {
        "schema_version": SCHEMA_VERSION,
        "scene": scene.name,
        "effects": " ".join(scene.effects),
        "window": 0,
        "time": 0.0,
        "start": scene.time.start.isoformat(),
        "seed": scene.seed,
        "crs": scene.domain.crs,
        "ocean_area": float(packing.attrs["ocean_area"]),
        "unclaimed_water": float(packing.attrs["unclaimed_water"]),
        "provenance": provenance(scene),
    }
    if scene.period is not None:
        attrs[ATTRIBUTE] = list(scene.period)
    if "thermodynamics" in scene.effects:
        attrs[SCHEME_ATTRIBUTE] = scene.column.scheme
    if {"mixed_layer", "rims"} & set(scene.effects):
        attrs["typical_area"] = _typical_area(scene, packing)
    return xr.Dataset(data, attrs=attrs)


def _typical_area(scene: Scene, packing: xr.Dataset) -> float:
    """Effective area (m2) of an element of the scene: the mean, or what it is where all freezes."""
    area = packing["area"].values[packing["type"].values == MOBILE]
    ocean = float(packing.attrs["ocean_area"])
    return float(area.mean()) if len(area) else ocean / scene.packing.elements


def _columns(scene: Scene, packing: xr.Dataset) -> dict[str, np.ndarray]:
    """Columns of the packing's ice, in the categories and layers that the scene asks for."""
    fraction, volume = (packing[name].values.sum(axis=1) for name in ("ice_fraction", "ice_volume"))
    snow = np.full(len(fraction), scene.mask.snow_thickness)
    surface = scene.column.initial_surface
    settings = column_settings(scene)
    return first_columns(fraction, volume, snow, surface, settings, first_ice(scene))
