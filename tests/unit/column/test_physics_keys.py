# SPDX-License-Identifier: GPL-2.0-or-later
"""Every key of a scene's block `physics` acts in the schemes that it names, and in no other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from floeflow.column.initial_columns import first_columns
from floeflow.column.layered_run import layered_physics
from floeflow.column.params import Settings, broadband, zero_layer_params
from floeflow.column.schemes import advance_columns
from floeflow.column.thermodynamics import surface
from floeflow.core.constants import ZERO_CELSIUS
from floeflow.scene.effects import column_variables
from floeflow.scene.load import build_scene
from floeflow.scene.physics import ColumnPhysics, unread_keys

WEATHER = {
    "wind_u": 6.0,
    "wind_v": 0.0,
    "air_temperature": 273.0,
    "specific_humidity": 3.3e-3,
    "air_pressure": 1.01e5,
    "longwave_down": 300.0,
    "shortwave_down": 200.0,
    "snowfall": 1e-6,
    "ocean_heat_flux": 2.0,
    "friction_velocity": 0.01,
    "sun_height": 0.45,
}
PROCESSES = ("snow", "shortwave", "lateral_melt", "frazil", "mixed_layer")
ZERO = Settings(scheme="zero_layer", processes=PROCESSES)
BL99 = replace(ZERO, scheme="bl99", new_ice_thickness=0.05)
MUSHY = replace(BL99, scheme="mushy", processes=(*PROCESSES, "ponds"), light="delta_eddington")
COLUMNS = {"zero_layer": ZERO, "bl99": BL99, "mushy": MUSHY}

# Another value of each key, and the columns above that it changes.
BROADBAND = {"zero_layer", "bl99"}
LIGHT = {"mushy"}
CHANGED: dict[str, tuple[object, set[str]]] = {
    "air_density": (1.4, set(COLUMNS)),
    "emissivity": (0.9, set(COLUMNS)),
    "snow_conductivity": (0.4, set(COLUMNS)),
    "ice_conductivity": (2.3, {"zero_layer", "mushy"}),
    "conductivity": ("maykut_untersteiner", {"bl99"}),
    "albedo_ice_visible": (0.6, BROADBAND),
    "albedo_ice_infrared": (0.3, BROADBAND),
    "albedo_ice_warming": (0.2, BROADBAND),
    "albedo_snow_visible": (0.9, BROADBAND),
    "albedo_snow_infrared": (0.6, BROADBAND),
    "albedo_snow_visible_warming": (0.2, BROADBAND),
    "albedo_snow_infrared_warming": (0.25, BROADBAND),
    "albedo_thickness": (1.0, BROADBAND),
    "albedo_ocean": (0.1, set(COLUMNS)),
    "snow_patchiness": (0.1, BROADBAND),
    "snow_grain_tuning": (0.0, LIGHT),
    "ice_scatter_tuning": (1.0, LIGHT),
    "pond_scatter_tuning": (1.0, LIGHT),
    "pond_aspect": (0.4, {"mushy"}),
    "bulk_transfer": (2.0e-3, {"zero_layer"}),
    "ice_roughness": (1e-3, {"bl99", "mushy"}),
    "ocean_transfer": (0.003, set(COLUMNS)),
    "floe_diameter": (100.0, set(COLUMNS)),
}


def after_days(settings: Settings) -> tuple[float, ...]:
    """What two elements hold after six days at the edge of melt: bare thin ice, snow on thick."""
    area, depth = np.array([0.9, 0.8]), np.array([0.2, 2.0])
    every = first_columns(area, area * depth, np.array([0.0, 0.05]), 271.5, settings)
    every["sea_temperature"] = every["sea_temperature"] + 0.2
    if settings.has("ponds"):
        every["pond_area"] = np.full_like(every["pond_area"], 0.2)
        every["pond_depth"] = np.full_like(every["pond_depth"], 0.15)
    effects = ("thermodynamics", *settings.processes)
    columns = {name: every[name] for name in column_variables(effects, settings.scheme)}
    sample = {name: np.full(2, value) for name, value in WEATHER.items()}
    after, _ = advance_columns(columns, lambda _: sample, (0.0, 6 * 86400.0), settings)
    kept = ("ice_volume", "snow_volume", "sea_temperature", "ice_fraction")
    return tuple(np.concatenate([after[name].ravel() for name in kept]))


@pytest.fixture(scope="module")
def defaults() -> dict[str, tuple[float, ...]]:
    """Columns of all schemes with the constants as they stand."""
    return {name: after_days(settings) for name, settings in COLUMNS.items()}


def test_no_key_is_left_out() -> None:
    assert set(CHANGED) == set(ColumnPhysics.model_fields)


@pytest.mark.parametrize("key", CHANGED)
def test_a_key_acts_where_it_says(key: str, defaults: dict[str, tuple[float, ...]]) -> None:
    value, schemes = CHANGED[key]
    tuned = ColumnPhysics(**{key: value})
    for name, settings in COLUMNS.items():
        changed = after_days(replace(settings, physics=tuned)) != defaults[name]
        assert changed == (name in schemes), name


# Bonds that freeze read the conductivity whatever the column is.
@pytest.mark.parametrize("key", sorted(set(CHANGED) - {"ice_conductivity"}))
def test_a_key_that_is_not_read_is_told(key: str) -> None:
    value, schemes = CHANGED[key]
    tuned = ColumnPhysics(**{key: value})
    for name, settings in COLUMNS.items():
        unread = unread_keys(tuned, settings.scheme, settings.light, settings.has("ponds"))
        assert unread == ([] if name in schemes else [key]), name


# Zero-layer constants under another name or unit than those of layered ice.
SAME = {
    "latent_fusion": lambda p: p.fusion,
    "latent_vapour": lambda p: p.vapour,
    "freezing_temperature": lambda p: ZERO_CELSIUS - p.melting_slope * ZERO.ocean_salinity,
    "latent_sublimation": lambda p: p.fusion + p.vapour,
    "ice_energy": lambda p: p.ice_density * p.fusion,
    "snow_energy": lambda p: p.snow_density * p.fusion,
    "melting_temperature": lambda p: ZERO_CELSIUS,
    "albedo_ice_cold": lambda p: broadband(p.albedo_ice_visible, p.albedo_ice_infrared),
    "albedo_snow_cold": lambda p: broadband(p.albedo_snow_visible, p.albedo_snow_infrared),
    "albedo_ice_melting": lambda p: (
        broadband(p.albedo_ice_visible, p.albedo_ice_infrared) - p.albedo_ice_warming
    ),
    "albedo_snow_melting": lambda p: (
        broadband(p.albedo_snow_visible, p.albedo_snow_infrared)
        - broadband(p.albedo_snow_visible_warming, p.albedo_snow_infrared_warming)
    ),
}
# What settings hand to either scheme, and what no layered scheme has as a constant.
OF_SETTINGS = {"new_ice_thickness", "ocean_salinity", "mixed_layer_depth"}


def test_zero_layer_ice_has_no_constant_of_its_own() -> None:
    """All its constants are those of layered ice under the same keys, also under changed ones."""
    changed = ColumnPhysics(**{key: value for key, (value, _) in CHANGED.items()})
    for physics in (ColumnPhysics(), changed):
        layered = layered_physics(replace(BL99, physics=physics))
        zero = zero_layer_params(replace(ZERO, physics=physics))
        names = {name for name in dir(zero) if isinstance(getattr(zero, name), float)}
        assert {"ice_density", "snow_density", "albedo_ramp"} < names - SAME.keys()
        for name in names - OF_SETTINGS:
            same = SAME[name](layered) if name in SAME else getattr(layered, name)
            assert getattr(zero, name) == same, name
        for key in set(ColumnPhysics.model_fields) & set(layered._fields):
            assert getattr(zero.keys, key) == getattr(layered, key), key
        assert layered.fresh_conductivity == zero.keys.ice_conductivity
    assert layered.stefan_boltzmann == surface.STEFAN_BOLTZMANN
    assert layered.heat_air == surface.HEAT_AIR


def test_a_scene_sets_them() -> None:
    scene = build_scene({"name": "bright", "physics": {"albedo_ice_visible": 0.8}})
    assert scene.physics.albedo_ice_visible == 0.8
