# SPDX-License-Identifier: GPL-2.0-or-later
"""Forcing that looks fine and would be read wrong: levels, hemispheres, means, forecasts, times.

The files are built after the specifications of the products that they stand for.
"""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from floeflow.core import grids, vectors
from floeflow.core.errors import FloeError
from floeflow.core.sun import day_of_year, sun_height
from floeflow.forcings import forcing
from floeflow.forcings.inputs import check_forcing_file
from floeflow.scene.blocks import Scene

AWAY = {"x_min": -2e6, "x_max": -1e6, "y_min": 4e5, "y_max": 1.2e6, "spacing": 2e5}
SOUTH = {"crs": "EPSG:6932", "x_min": -2e6, "x_max": -1e6, "y_min": 4e5, "y_max": 1.2e6,
         "spacing": 2e5}  # fmt: skip
UNITS = "hours since 1981-12-31 00:00:00"
WEATHER = ("thermodynamics", "snow", "shortwave")


def scene_of(path: Path, domain: dict[str, Any] = AWAY, **changes: Any) -> Scene:
    values: dict[str, Any] = {
        "name": "t",
        "domain": domain,
        "effects": ("wind",),
        "time": {"windows": 1},
        "forcing": {"source": "file", "file": str(path)},
    }
    return Scene.model_validate(values | changes)


def gridded(
    fields: dict[str, tuple[Any, dict[str, Any]]],
    hours: np.ndarray,
    extra: dict[str, tuple[np.ndarray, dict[str, Any]]] | None = None,
    sign: float = 1.0,
) -> xr.Dataset:
    """Fields on a 5 degree grid; values broadcast from (time, [extra,] 1, 1)."""
    lat, lon = sign * np.arange(50.0, 91.0, 5.0), np.arange(0.0, 360.0, 5.0)
    coords: dict[str, Any] = {"time": ("time", hours, {"units": UNITS})}
    sizes = [hours.size]
    for name, (values, attrs) in (extra or {}).items():
        coords[name] = (name, values, attrs)
        sizes.append(values.size)
    coords["lat"] = ("lat", lat, {"units": "degrees_north"})
    coords["lon"] = ("lon", lon, {"units": "degrees_east"})
    data = {
        name: (tuple(coords), np.broadcast_to(values, (*sizes, 9, 72)).copy(), attrs)
        for name, (values, attrs) in fields.items()
    }
    return xr.Dataset(data, coords)


def wind_attrs(units: str = "m s-1") -> list[dict[str, str]]:
    names = ("eastward_wind", "northward_wind")
    return [{"standard_name": name, "units": units} for name in names]


DAY = np.array([0.0, 12.0, 24.0])


@pytest.mark.parametrize(
    ("axis", "attrs", "values"),
    [
        ("level", {"units": "hPa"}, [1000.0, 500.0, 10.0]),
        ("level", {"units": "millibars"}, [10.0, 500.0, 1000.0]),
        ("lev", {"standard_name": "atmosphere_sigma_coordinate", "units": "1"}, [0.995, 0.5, 0.01]),
        ("hybrid", {"positive": "down", "units": "1"}, [137.0, 60.0, 1.0]),
        ("lev", {"positive": "up", "units": "1"}, [1.0, 60.0, 137.0]),
        ("height", {"units": "m"}, [10.0, 5000.0, 30000.0]),
    ],
)
def test_wind_is_that_of_the_lowest_level(
    tmp_path: Path, axis: str, attrs: dict[str, str], values: list[float]
) -> None:
    surface = 2 if values == [10.0, 500.0, 1000.0] else 0
    speed = np.full(3, 60.0)
    speed[surface] = 10.0
    east, north = wind_attrs()
    fields = {"u": (speed[None, :, None, None], east), "v": (0.0, north)}
    path = tmp_path / "w.nc"
    gridded(fields, DAY, {axis: (np.array(values), attrs)}).to_netcdf(path)
    check_forcing_file(scene_of(path))
    made = forcing.make_forcing(scene_of(path), path, 1)
    np.testing.assert_allclose(np.hypot(made["wind_u"], made["wind_v"]), 10.0, rtol=3e-3)
    assert f"{axis} = {values[surface]:g}" in made.attrs["sources"]


def test_levels_that_do_not_say_where_the_ground_is(tmp_path: Path) -> None:
    east, north = wind_attrs()
    fields = {"u": (1.0, east), "v": (0.0, north)}
    path = tmp_path / "w.nc"
    gridded(fields, DAY, {"lev": (np.array([1.0, 2.0]), {"units": "1"})}).to_netcdf(path)
    for read in (check_forcing_file, lambda scene: forcing.make_forcing(scene, path, 1)):
        with pytest.raises(FloeError, match="'u': its vertical axis 'lev' does not say"):
            read(scene_of(path))


def test_a_single_level_high_in_the_air_is_no_surface(tmp_path: Path) -> None:
    east, north = wind_attrs()
    fields = {"u": (1.0, east), "v": (0.0, north)}
    data = gridded(fields, DAY)
    data = data.assign_coords(level=((), 500.0, {"units": "hPa"}))
    path = tmp_path / "w.nc"
    data.to_netcdf(path)
    with pytest.raises(FloeError, match="its lowest level is level = 500 hPa"):
        check_forcing_file(scene_of(path))


def test_daily_means_stand_in_the_middle_of_their_bounds(tmp_path: Path) -> None:
    """Stamped at the end of the day, with bounds: CF, and what NEMO and CMIP write."""
    hours = np.array([0.0, 24.0, 48.0])
    east, north = wind_attrs()
    ramp = np.array([0.0, 10.0, 20.0])[:, None, None]
    data = gridded({"u": (ramp, east), "v": (0.0, north)}, hours)
    data["time"].attrs["bounds"] = "time_bnds"
    data["time_bnds"] = (("time", "nv"), np.stack([hours - 24.0, hours], axis=1))
    path = tmp_path / "w.nc"
    data.to_netcdf(path)
    made = forcing.make_forcing(scene_of(path), path, 1)
    speed = np.hypot(made["wind_u"], made["wind_v"]).isel(x=0, y=0)
    at_noon = float(speed.sel(time=43200.0))
    assert at_noon == pytest.approx(10.0, rel=3e-3)
    assert float(speed.sel(time=0.0)) == pytest.approx(5.0, rel=1e-2)
    # Instants with bounds, as some write them too, keep their stamps.
    for name in "uv":
        data[name].attrs["cell_methods"] = "time: point"
    data.to_netcdf(tmp_path / "p.nc")
    made = forcing.make_forcing(scene_of(tmp_path / "p.nc"), tmp_path / "p.nc", 1)
    speed = np.hypot(made["wind_u"], made["wind_v"]).isel(x=0, y=0)
    assert float(speed.sel(time=86400.0)) == pytest.approx(10.0, rel=3e-3)


def weather_fields(light: Any, name: str) -> dict[str, tuple[Any, dict[str, Any]]]:
    return {
        "u10": (3.0, {"units": "m s**-1"}),
        "v10": (4.0, {"units": "m s**-1"}),
        "t2m": (250.0, {"units": "K"}),
        "d2m": (248.0, {"units": "K"}),
        "msl": (101000.0, {"units": "Pa"}),
        name: (light, {"units": "W m**-2"}),
        "avg_sdlwrf": (200.0, {"units": "W m**-2", "GRIB_stepType": "avg"}),
        "avg_tsrwe": (1e-6, {"units": "kg m**-2 s**-1"}),
    }


@pytest.mark.parametrize("name", ["avg_sdswrf", "msdwswrf"])
@pytest.mark.parametrize("step", [1.0, 3.0])
def test_mean_rates_of_era5_are_of_the_hour_before(tmp_path: Path, name: str, step: float) -> None:
    hours = np.arange(0.0, 49.0, step)
    # A rate that grows by 10 W/m2 an hour: the mean of the hour up to h is that of h - 1/2.
    light = (10.0 * (hours - 0.5) + 5.0)[:, None, None]
    fields = weather_fields(light, name)
    del fields["avg_sdlwrf"][1]["GRIB_stepType"]
    path = tmp_path / "era5.nc"
    gridded(fields, hours).to_netcdf(path)
    made = forcing.make_forcing(scene_of(path, effects=WEATHER), path, 1)
    at = made["time"].values[1:-1]
    np.testing.assert_allclose(
        made["shortwave_down"].isel(x=0, y=0)[1:-1], 10.0 * at / 3600.0 + 5.0, rtol=1e-9
    )


def test_a_forecast_is_of_its_valid_time(tmp_path: Path) -> None:
    """Cfgrib's layout: `time` is the forecast's start, `valid_time` what the field is of."""
    hours = np.arange(-12.0, 37.0, 12.0)
    east, north = wind_attrs()
    speed = (hours + 24.0)[:, None, None] / 4.0
    data = gridded({"u10": (speed, east), "v10": (0.0, north)}, hours)
    data["time"].attrs["standard_name"] = "forecast_reference_time"
    step = {"standard_name": "forecast_period", "units": "hours"}
    data["step"] = ((), 12.0, step)
    data.to_netcdf(tmp_path / "step.nc")
    data["valid_time"] = ("time", hours + 12.0, {"units": UNITS, "standard_name": "time"})
    data.to_netcdf(tmp_path / "valid.nc")
    for name in ("step.nc", "valid.nc"):
        path = tmp_path / name
        made = forcing.make_forcing(scene_of(path), path, 1)
        found = np.hypot(made["wind_u"], made["wind_v"]).isel(x=0, y=0)
        # Of the scene's start (0 h) is the forecast of 12 hours before.
        assert float(found.sel(time=0.0)) == pytest.approx(3.0, rel=3e-3)
        assert float(found.sel(time=86400.0)) == pytest.approx(9.0, rel=3e-3)


def test_starts_and_steps_of_forecasts_make_one_axis(tmp_path: Path) -> None:
    """ERA5's accumulations from the archive: starts at 6 and 18 h, steps of 1 to 12 h."""
    starts, steps = np.array([-6.0, 6.0, 18.0]), np.arange(1.0, 13.0)
    valid = starts[:, None] + steps[None]
    light = 3600.0 * 10.0 * (valid + 6.0)
    fields: dict[str, tuple[Any, dict[str, Any]]] = {
        name: (value, attrs)
        for name, (value, attrs) in weather_fields(0.0, "unused").items()
        if name not in ("unused", "avg_sdlwrf", "avg_tsrwe")
    }
    fields["ssrd"] = (light[:, :, None, None], {"units": "J m**-2"})
    fields["strd"] = (7.2e5, {"units": "J m**-2"})
    fields["sf"] = (1e-3, {"units": "m of water equivalent"})
    data = gridded(fields, starts, {"step": (steps, {"units": "hours"})})
    data["time"].attrs["standard_name"] = "forecast_reference_time"
    data["valid_time"] = (("time", "step"), valid, {"units": UNITS, "standard_name": "time"})
    path = tmp_path / "era5.nc"
    data.to_netcdf(path)
    made = forcing.make_forcing(scene_of(path, effects=WEATHER), path, 1)
    noon = made["shortwave_down"].isel(x=0, y=0).sel(time=11.5 * 3600.0)
    assert float(noon) == pytest.approx(10.0 * 18.0, rel=1e-9)


@pytest.mark.parametrize("form", ["scalar", "month"])
def test_a_field_of_another_year_is_no_steady_one(tmp_path: Path, form: str) -> None:
    east, north = wind_attrs()
    data = gridded({"u": (1.0, east), "v": (0.0, north)}, np.array([0.0]))
    data = data.isel(time=0) if form == "scalar" else data
    data["time"].attrs["units"] = "days since 1991-12-31"
    path = tmp_path / "w.nc"
    data.to_netcdf(path)
    said = "3652 days from the scene's start; forcing.days_off" if form == "scalar" else "covers"
    for read in (check_forcing_file, lambda scene: forcing.make_forcing(scene, path, 1)):
        with pytest.raises(FloeError, match=said):
            read(scene_of(path))
    if form == "scalar":
        allowed = {"source": "file", "file": str(path), "days_off": 4000.0}
        made = forcing.make_forcing(scene_of(path, forcing=allowed), path, 1)
        assert made.sizes["time"] == 2


@pytest.mark.parametrize(("domain", "sign"), [(AWAY, 1.0), (SOUTH, -1.0)])
def test_both_hemispheres(tmp_path: Path, domain: dict[str, Any], sign: float) -> None:
    """Coriolis, north on the map, the cyclone's sense and the sun, each in its hemisphere."""
    east, north = wind_attrs()
    data = gridded({"u": (0.0, east), "v": (8.0, north)}, DAY, sign=sign)
    path = tmp_path / "w.nc"
    data.to_netcdf(path)
    scene = scene_of(path, domain, effects=("wind", "coriolis"))
    made = forcing.make_forcing(scene, path, 1)
    assert (sign * made["coriolis"].values > 1.2e-4).all()
    # A wind to the north blows towards the pole in the north, and away from it in the south.
    x, y = np.meshgrid(made["x"], made["y"])
    outward = (made["wind_u"][0] * x + made["wind_v"][0] * y) / np.hypot(x, y)
    np.testing.assert_allclose(outward, -sign * 8.0, rtol=2e-2)
    crs = grids.scene_crs(scene.domain)
    lon, lat = grids.to_lonlat(crs, x, y)
    assert (np.sign(lat) == sign).all()
    turned = vectors.east_north_to_map(
        np.zeros(lat.shape), np.ones(lat.shape), vectors.north_angle(crs, lon, lat)
    )
    np.testing.assert_allclose((turned[0] * x + turned[1] * y) / np.hypot(x, y), -sign, atol=1e-6)
    winter = day_of_year(datetime(1981, 12, 21), 43200.0)
    assert (sign * sun_height(winter, sign * 80.0, 0.0) < 0).all()


def test_the_cyclone_turns_the_other_way_in_the_south(tmp_path: Path) -> None:
    east, north = wind_attrs()
    spins = []
    for domain, sign in ((AWAY, 1.0), (SOUTH, -1.0)):
        path = tmp_path / f"{sign}.nc"
        data = gridded({"u": (0.0, east), "v": (0.0, north)}, DAY, sign=sign)
        data[["time"]].to_netcdf(path)
        given = {"source": "file", "file": str(path), "fallback": {"wind": "cyclone"},
                 "cyclone": {"x": -1.5e6, "y": 8e5, "inflow_angle": 0.0}}  # fmt: skip
        made = forcing.make_forcing(scene_of(path, domain, forcing=given), path, 1)
        x, y = np.meshgrid(made["x"] + 1.5e6, made["y"] - 8e5)
        spins.append(float((x * made["wind_v"][0] - y * made["wind_u"][0]).sum()))
    assert spins[0] > 0 and spins[1] == pytest.approx(-spins[0], rel=1e-6)
