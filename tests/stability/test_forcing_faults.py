# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 9: forcing with faults in it.

What must hold: each fault is refused in one sentence that names file, variable and, where it has
one, time or place; nothing of it reaches the elements.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.forcings import analytic, forcing
from floeflow.scene.blocks import Scene

ALL = ("wind", "ocean_drag", "coriolis", "tilt", "thermodynamics", "snow", "shortwave")
DOMAIN = {"x_min": -1.6e6, "x_max": -1.2e6, "y_min": 0.8e6, "y_max": 1.2e6, "spacing": 1e5}


@pytest.fixture(scope="module")
def scene() -> Scene:
    values = {"name": "t", "domain": DOMAIN, "effects": ALL, "time": {"windows": 1}}
    return Scene.model_validate(values)


@pytest.fixture
def good(scene: Scene) -> xr.Dataset:
    return analytic.make_analytic(scene, 1).load()


def refusal(scene: Scene, data: xr.Dataset, path: Path, name: str) -> str:
    data.to_netcdf(path)
    with pytest.raises(FloeError) as caught:
        forcing.make_forcing(scene, path, 1)
    said = str(caught.value)
    assert said.startswith(str(path)) and f"'{name}'" in said and "\n" not in said, said
    return said


def fields(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data.data_vars if "time" in data[name].dims]


def test_the_good_file_is_taken(scene: Scene, good: xr.Dataset, tmp_path: Path):
    good.to_netcdf(tmp_path / "f.nc")
    made = forcing.make_forcing(scene, tmp_path / "f.nc", 1)
    assert len(fields(good)) >= 11
    assert all(np.isfinite(made[name].values).all() for name in made)


FAULTS = {
    "a NaN": np.nan,
    "infinity": np.inf,
    "minus infinity": -np.inf,
    "an hour of 1e6": 1e6,
    "a fill value of old": 9.96921e36,
    "a fill value of -999": -999.0,
    "minus a million": -1e6,
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_bad_value_anywhere_is_named(
    scene: Scene, good: xr.Dataset, tmp_path: Path, fault: str, record
):
    for name in fields(good):
        data = good.copy(deep=True)
        data[name] = data[name].astype(float)
        data[name].values[2] = FAULTS[fault]
        said = refusal(scene, data, tmp_path / f"{name}.nc", name)
        assert "1981" in said or "reach" in said, said
    record(variables=len(fields(good)))


WRONG_UNITS: dict[str, tuple[str, Callable[[xr.DataArray], xr.DataArray]]] = {
    "degrees Celsius called kelvin": ("air_temperature", lambda v: v - 273.15),
    "kelvin called degrees Celsius": ("air_temperature", lambda v: v.assign_attrs(units="degC")),
    "hectopascal called pascal": ("air_pressure_at_mean_sea_level", lambda v: v / 100),
    "pascal called hectopascal": (
        "air_pressure_at_mean_sea_level",
        lambda v: v.assign_attrs(units="hPa"),
    ),
    "millimetres a day called kg m-2 s-1": ("snowfall_flux", lambda v: v * 86400 * 500),
    "g/kg called kg/kg": ("specific_humidity", lambda v: v * 1e3 + 1.0),
    "joules called watts": (
        "surface_downwelling_longwave_flux_in_air",
        lambda v: v * 3600,
    ),
    "no unit at all": ("air_temperature", lambda v: v.assign_attrs(units="")),
    "bananas": ("eastward_wind", lambda v: v.assign_attrs(units="banana s-1")),
}


def named(data: xr.Dataset, standard_name: str) -> str:
    for name in data.data_vars:
        if data[name].attrs.get("standard_name") == standard_name:
            return str(name)
    raise AssertionError(f"the analytic forcing has no {standard_name}: {list(data.data_vars)}")


@pytest.mark.parametrize("fault", WRONG_UNITS)
def test_wrong_units_are_named(scene: Scene, good: xr.Dataset, tmp_path: Path, fault: str):
    standard, change = WRONG_UNITS[fault]
    name = named(good, standard)
    kept = dict(good[name].attrs)
    changed = change(good[name])
    good[name] = changed.assign_attrs({**kept, **changed.attrs})
    said = refusal(scene, good, tmp_path / "f.nc", name)
    assert "unit" in said or "outside" in said or "reach" in said, said


def test_a_time_axis_that_runs_backwards_is_named(scene: Scene, good: xr.Dataset, tmp_path: Path):
    data = good.isel(time=slice(None, None, -1))
    assert "ascend" in refusal(scene, data, tmp_path / "f.nc", "time")


def test_a_time_that_stands_twice_is_named(scene: Scene, good: xr.Dataset, tmp_path: Path):
    data = good.isel(time=[0, 1, 1, 2, 3, 4])
    assert "ascend" in refusal(scene, data, tmp_path / "f.nc", "time")


def test_forcing_that_ends_too_soon_is_named(scene: Scene, good: xr.Dataset, tmp_path: Path):
    assert "covers" in refusal(scene, good.isel(time=slice(0, 3)), tmp_path / "f.nc", "time")


def test_a_gap_in_time_is_named(scene: Scene, good: xr.Dataset, tmp_path: Path):
    # Six-hourly but for a hole: 12 h, then 24 h.
    said = refusal(scene, good.isel(time=[0, 1, 2, 4]), tmp_path / "f.nc", "time")
    assert "gap" in said, said
