# SPDX-License-Identifier: GPL-2.0-or-later
"""Forcing on the scene grid: turned by the right angle, in SI, in time, nothing missing used."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr

from floeflow.core import grids
from floeflow.core.errors import FloeError
from floeflow.forcings import analytic, forcing, moisture
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import EFFECTS, forcing_variables

POLE = {"x_min": -5e5, "x_max": 5e5, "y_min": -5e5, "y_max": 5e5, "spacing": 1e5}
AWAY = {"x_min": -2e6, "x_max": -1e6, "y_min": 4e5, "y_max": 1.2e6, "spacing": 1e5}
HOURS = np.arange(0.0, 49.0, 6.0)
UNITS = "hours since 1981-12-31 00:00:00"


def scene_of(domain: dict[str, Any] = POLE, **changes: Any) -> Scene:
    values = {"name": "t", "domain": domain, "effects": ("wind",), "time": {"windows": 2}}
    return Scene.model_validate(values | changes)


def places(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    grid = grids.scene_grid(scene.domain)
    return grids.to_lonlat(grids.scene_crs(scene.domain), *grid.mesh())


def file_with(**fields: tuple[np.ndarray | float, dict[str, str]]) -> xr.Dataset:
    """A file of given fields on a 2 degree grid, every 6 hours for two days."""
    lat, lon = np.arange(50.0, 90.0, 2.0), np.arange(0.0, 360.0, 2.0)
    data = xr.Dataset(
        coords={
            "time": ("time", HOURS, {"units": UNITS}),
            "lat": ("lat", lat, {"units": "degrees_north"}),
            "lon": ("lon", lon, {"units": "degrees_east"}),
        }
    )
    for name, (values, attrs) in fields.items():
        full = np.broadcast_to(np.asarray(values, dtype=float), (9, lat.size, lon.size))
        data[name] = (("time", "lat", "lon"), full.copy(), attrs)
    return data


def wind(u: np.ndarray | float, v: np.ndarray | float, units: str = "m s-1") -> xr.Dataset:
    return file_with(
        u10=(u, {"standard_name": "eastward_wind", "units": units}),
        v10=(v, {"standard_name": "northward_wind", "units": units}),
    )


def test_a_straight_wind_over_the_pole_stays_straight(tmp_path: Path) -> None:
    """10 m/s along the Greenwich meridian over the pole: along +y on the map of EPSG:6931."""
    lon = np.radians(np.arange(0.0, 360.0, 2.0))
    wind(10 * np.sin(-lon) * -1, 10 * np.cos(lon)).to_netcdf(tmp_path / "w.nc")
    made = forcing.make_forcing(scene_of(), tmp_path / "w.nc", 1)
    speed = np.hypot(made["wind_u"], made["wind_v"]).values
    assert speed == pytest.approx(np.full(speed.shape, 10.0), rel=1e-3)
    assert made["wind_v"].values == pytest.approx(speed, rel=1e-3)


def test_bilinear_interpolation_of_a_known_field(tmp_path: Path) -> None:
    scene = scene_of(AWAY, effects=("thermodynamics", "snow", "shortwave"))
    lon, lat = places(scene)
    data = analytic.make_analytic(scene, 1)
    mesh_lon, mesh_lat = np.meshgrid(data["lon"], data["lat"])
    # Bilinear in longitude and latitude, so the interpolation is exact.
    data["t2m"].values[:] = 200.0 + 0.5 * mesh_lat + 0.1 * (mesh_lon % 360 - 200) * 0.5
    data.to_netcdf(tmp_path / "f.nc")
    made = forcing.make_forcing(scene, tmp_path / "f.nc", 1)
    expected = 200.0 + 0.5 * lat + 0.1 * (lon % 360 - 200) * 0.5
    np.testing.assert_allclose(made["air_temperature"][0], expected, atol=1e-4)


@pytest.mark.parametrize("domain", [POLE, AWAY])
def test_analytic_forcing_comes_through(tmp_path: Path, domain: dict[str, Any]) -> None:
    """What was written as east and north on a globe comes back as the scene's own formula."""
    cyclone = {"x": -1.5e6, "y": 8e5, "radius": 9e5, "u": 4.0, "v": -2.0}
    scene = scene_of(
        domain,
        effects=tuple(EFFECTS),
        forcing={"cyclone": cyclone, "gyre": {"x": 1e5, "y": 2e5, "radius": 8e5}},
    )
    analytic.write_cf(analytic.make_analytic(scene, 2), tmp_path / "a.nc")
    made = forcing.make_forcing(scene, tmp_path / "a.nc", 2)
    assert list(made["time"].values) == [86400.0 + 21600.0 * k for k in range(5)]
    assert set(made.data_vars) == set(forcing_variables(scene.effects))
    x, y = np.meshgrid(made["x"], made["y"])
    for k, time in enumerate(made["time"].values):
        u, v = analytic.cyclone_wind(scene.forcing.cyclone, x, y, time, northern=True)
        error = np.hypot(made["wind_u"][k] - u, made["wind_v"][k] - v).values
        # The kink at the radius of the largest wind is rounded off.
        assert error.max() < 0.5 and np.median(error) < 0.02
        u, v = analytic.gyre_current(scene.forcing.gyre, x, y)
        error = np.hypot(made["ocean_u"][k] - u, made["ocean_v"][k] - v).values
        assert error.max() < 5e-4
    assert float(made["air_temperature"][0, 0, 0]) == pytest.approx(248.15, abs=1e-4)


def test_windows_meet(tmp_path: Path) -> None:
    scene = scene_of(AWAY)
    for window in (1, 2):
        analytic.write_cf(analytic.make_analytic(scene, window), tmp_path / f"{window}.nc")
    first, second = (forcing.make_forcing(scene, tmp_path / f"{w}.nc", w) for w in (1, 2))
    assert first["time"].values[-1] == second["time"].values[0]
    np.testing.assert_array_equal(first["wind_u"][-1], second["wind_u"][0])


def test_time_is_cut_with_its_ends_interpolated(tmp_path: Path) -> None:
    ramp = (HOURS / 10.0)[:, None, None]
    wind(ramp, 0.0).to_netcdf(tmp_path / "w.nc")
    scene = scene_of(time={"windows": 2, "window": 32400.0})
    made = forcing.make_forcing(scene, tmp_path / "w.nc", 2)
    assert list(made["time"].values / 3600.0) == [9.0, 12.0, 18.0]
    speed = np.hypot(made["wind_u"], made["wind_v"]).values
    far = speed[:, 0, 0]
    assert far == pytest.approx([0.9, 1.2, 1.8], rel=1e-2)


@pytest.mark.parametrize("calendar", ["standard", "noleap", "360_day", "proleptic_gregorian"])
def test_calendars(tmp_path: Path, calendar: str) -> None:
    data = wind(3.0, 0.0)
    unit = "days since 1981-12-01"
    start = netCDF4.date2num(
        netCDF4.num2date([30.0], unit, calendar, only_use_cftime_datetimes=True), unit, calendar
    )
    data = data.assign_coords(time=("time", start + HOURS / 24.0))
    data["time"].attrs = {"units": unit, "calendar": calendar}
    data.to_netcdf(tmp_path / "w.nc")
    day = 31 if calendar != "360_day" else 1
    month = 12 if calendar != "360_day" else 1
    year = 1981 if calendar != "360_day" else 1982
    scene = scene_of(time={"start": f"{year}-{month:02d}-{day:02d}T00:00:00", "windows": 2})
    made = forcing.make_forcing(scene, tmp_path / "w.nc", 1)
    assert list(made["time"].values) == [0.0, 21600.0, 43200.0, 64800.0, 86400.0]


@pytest.mark.parametrize(
    ("name", "standard", "units", "value", "expected"),
    [
        ("air_temperature", "air_temperature", "degC", -20.0, 253.15),
        ("air_pressure", "surface_air_pressure", "hPa", 1010.0, 101000.0),
        ("specific_humidity", "specific_humidity", "g kg-1", 0.5, 5e-4),
        ("snowfall", "snowfall_flux", "mm day-1", 8.64, 1e-4),
        ("longwave_down", "surface_downwelling_longwave_flux_in_air", "W m**-2", 200.0, 200.0),
    ],
)
def test_units_become_si(
    tmp_path: Path, name: str, standard: str, units: str, value: float, expected: float
) -> None:
    scene = scene_of(AWAY, effects=("thermodynamics", "snow", "shortwave"))
    data = analytic.make_analytic(scene, 1)
    old = next(n for n in data if data[n].attrs["standard_name"].startswith(standard[:8]))
    if name == "air_pressure":
        old = "msl"
    if name == "longwave_down":
        old = "rlds"
    data = data.drop_vars(old)
    shape = (data.sizes["time"], data.sizes["lat"], data.sizes["lon"])
    attrs = {"standard_name": standard, "units": units}
    data["mine"] = (("time", "lat", "lon"), np.full(shape, value), attrs)
    data.to_netcdf(tmp_path / "f.nc")
    made = forcing.make_forcing(scene, tmp_path / "f.nc", 1)
    assert made[name].values == pytest.approx(np.full(made[name].shape, expected), rel=1e-6)


def test_knots(tmp_path: Path) -> None:
    wind(0.0, 36.0, "knots").to_netcdf(tmp_path / "w.nc")
    made = forcing.make_forcing(scene_of(AWAY), tmp_path / "w.nc", 1)
    speed = np.hypot(made["wind_u"], made["wind_v"]).values
    assert speed.max() == pytest.approx(18.52, rel=1e-3)


def test_humidity_from_dew_point(tmp_path: Path) -> None:
    scene = scene_of(AWAY, effects=("thermodynamics", "snow", "shortwave"))
    data = analytic.make_analytic(scene, 1).drop_vars("huss")
    shape = (data.sizes["time"], data.sizes["lat"], data.sizes["lon"])
    data["d2m"] = (("time", "lat", "lon"), np.full(shape, 250.0), {"units": "K"})
    data.to_netcdf(tmp_path / "f.nc")
    made = forcing.make_forcing(scene, tmp_path / "f.nc", 1)
    expected = forcing.dew_point_humidity(np.array(250.0), np.array(101000.0))
    assert made["specific_humidity"].values == pytest.approx(float(expected), rel=1e-6)


def test_coriolis_is_that_of_the_latitude(tmp_path: Path) -> None:
    wind(1.0, 0.0).to_netcdf(tmp_path / "w.nc")
    scene = scene_of(AWAY, effects=("wind", "coriolis"))
    made = forcing.make_forcing(scene, tmp_path / "w.nc", 1)
    _, lat = places(scene)
    np.testing.assert_allclose(made["coriolis"], 1.458423e-4 * np.sin(np.radians(lat)), rtol=1e-12)
    assert made["coriolis"].dims == ("y", "x")


def hole(data: xr.Dataset) -> None:
    data["u10"].values[2, 12, 90] = np.nan


def endless(data: xr.Dataset) -> None:
    data["u10"].values[2, 12, 90] = np.inf


def too_fast(data: xr.Dataset) -> None:
    data["u10"].values[0] = 500.0


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (hole, r"'u10' is missing or not finite at 1981-12-31 12:00:00 near 7\d\.\d N, 1\d\d\.\d"),
        (endless, "'u10' is missing or not finite at 1981-12-31 12:00:00"),
        (too_fast, "'u10' and 'v10' reach 500.001 m/s, above 150: check their units"),
        (lambda d: d.isel(lat=slice(0, 8)), r"'u10' does not cover the scene, such as \d+\.\d N"),
        (lambda d: d.isel(lon=slice(0, 60)), "'u10' does not cover the scene, such as"),
        (lambda d: d.isel(time=slice(0, 3)), "'time' covers .* but the scene needs"),
        (lambda d: d.isel(lat=[0, 0]), "coordinate 'lat' has under two different values"),
    ],
)
def test_bad_values_are_refused(
    tmp_path: Path, change: Callable[[xr.Dataset], xr.Dataset | None], sentence: str
) -> None:
    data = wind(2.0, 1.0)
    changed = change(data)
    (data if changed is None else changed).to_netcdf(tmp_path / "w.nc")
    domain = {"x_min": -1e6, "x_max": 1e6, "y_min": 1.2e6, "y_max": 2.2e6, "spacing": 1e5}
    with pytest.raises(FloeError, match=sentence) as caught:
        forcing.make_forcing(scene_of(domain), tmp_path / "w.nc", 1)
    assert str(caught.value).startswith(str(tmp_path / "w.nc"))


COLUMN = ("thermodynamics", "snow", "shortwave")


def era5_like(hours: np.ndarray, sums: dict[str, np.ndarray]) -> xr.Dataset:
    """A file with the names and units of ERA5; sums (J/m2 or m) of (hours,), the same all over."""
    lat, lon = np.arange(90.0, 59.0, -2.0), np.arange(0.0, 360.0, 2.0)
    shape = (hours.size, lat.size, lon.size)
    steady = {
        "u10": (3.0, "m s**-1"),
        "v10": (4.0, "m s**-1"),
        "t2m": (250.0, "K"),
        "d2m": (248.0, "K"),
        "msl": (101000.0, "Pa"),
    }
    data = {n: (np.full(shape, value), units) for n, (value, units) in steady.items()}
    units = {"ssrd": "J m**-2", "strd": "J m**-2", "sf": "m of water equivalent", "tp": "m"}
    data |= {n: (np.broadcast_to(v[:, None, None], shape), units[n]) for n, v in sums.items()}
    coords = {
        "valid_time": ("valid_time", hours, {"units": "hours since 1981-12-31"}),
        "latitude": ("latitude", lat, {"units": "degrees_north"}),
        "longitude": ("longitude", lon, {"units": "degrees_east"}),
    }
    dims = ("valid_time", "latitude", "longitude")
    return xr.Dataset({n: (dims, v, {"units": u}) for n, (v, u) in data.items()}, coords)


def test_hourly_sums_become_rates_of_their_hours(tmp_path: Path) -> None:
    hours = np.arange(0.0, 26.0)
    # Each hour's mean is 10 W/m2 more than that of the hour before; snow of 1 mm an hour.
    sun = 3600.0 * 10.0 * hours
    sums = {"ssrd": sun, "strd": np.full(26, 7.2e5), "sf": np.full(26, 1e-3)}
    era5_like(hours, sums).to_netcdf(tmp_path / "era5.nc")
    scene = scene_of(AWAY, effects=COLUMN, time={"windows": 1, "window": 86400.0})
    made = forcing.make_forcing(scene, tmp_path / "era5.nc", 1)
    np.testing.assert_allclose(made["longwave_down"], 200.0, rtol=1e-12)
    np.testing.assert_allclose(made["snowfall"], 1.0 / 3600.0, rtol=1e-12)
    light = made["shortwave_down"].isel(x=0, y=0)
    # The hour that ends at 6:00 has its mean at 5:30; linear in between.
    half = light.sel(time=5.5 * 3600.0).item()
    assert half == pytest.approx(60.0, rel=1e-12)
    assert np.trapezoid(light, made["time"]) == pytest.approx(
        3600.0 * 10.0 * 24 * 25 / 2, rel=1e-12
    )
    # No ocean in ERA5: the scene's constant.
    np.testing.assert_array_equal(made["ocean_heat_flux"], scene.forcing.weather.ocean_heat_flux)


@pytest.mark.parametrize("how", ["hour", "step", "day"])
def test_sums_of_any_interval_become_the_same_rates(tmp_path: Path, how: str) -> None:
    hours = np.arange(-24.0, 49.0, 3.0)
    rate = 150.0
    length = {
        "hour": np.ones(hours.size),
        "step": np.full(hours.size, 3.0),
        "day": np.where(hours % 24 == 0, 24.0, hours % 24),
    }[how]
    sums = {name: 3600.0 * length * rate for name in ("ssrd", "strd")}
    sums["tp"] = 3600.0 * length * 1e-7
    era5_like(hours, sums).to_netcdf(tmp_path / "era5.nc")
    changes = {"forcing": {"source": "file", "file": "x", "accumulation": how}}
    scene = scene_of(AWAY, effects=COLUMN, time={"windows": 2, "window": 86400.0}, **changes)
    for window in (1, 2):
        made = forcing.make_forcing(scene, tmp_path / "era5.nc", window)
        for name in ("shortwave_down", "longwave_down"):
            np.testing.assert_allclose(made[name], rate, rtol=1e-12)
        # Precipitation in air of 250 K is snow.
        np.testing.assert_allclose(made["snowfall"], 1e-4, rtol=1e-12)


def test_sums_that_could_be_anything_are_refused(tmp_path: Path) -> None:
    hours = np.arange(0.0, 49.0, 3.0)
    sums = {name: np.full(hours.size, 7e5) for name in ("ssrd", "strd", "sf")}
    era5_like(hours, sums).to_netcdf(tmp_path / "era5.nc")
    scene = scene_of(AWAY, effects=COLUMN)
    with pytest.raises(FloeError, match="'strd' is a sum .* not hourly: say in forcing.accumul"):
        forcing.make_forcing(scene, tmp_path / "era5.nc", 1)
    # Sums since midnight taken for those of an hour are more than any sky can give.
    hours = np.arange(0.0, 26.0)
    sums = {name: 7e5 * hours for name in ("ssrd", "strd", "sf")}
    era5_like(hours, sums).to_netcdf(tmp_path / "land.nc")
    with pytest.raises(FloeError, match="'strd' reaches from .* outside 0 to 1000 W m-2"):
        forcing.make_forcing(scene, tmp_path / "land.nc", 1)


def test_a_gap_in_time_is_named(tmp_path: Path) -> None:
    hours = np.delete(np.arange(0.0, 26.0), [7, 8])
    sums = {name: np.full(hours.size, 7e5) for name in ("ssrd", "strd", "sf")}
    era5_like(hours, sums).to_netcdf(tmp_path / "era5.nc")
    scene = scene_of(AWAY, effects=COLUMN)
    with pytest.raises(FloeError, match="has a gap from 1981-12-31 06:00:00 to 1981-12-31 09:00"):
        forcing.make_forcing(scene, tmp_path / "era5.nc", 1)


def test_rain_is_no_snow() -> None:
    air = np.array([250.0, 273.14, 273.16, 280.0])
    np.testing.assert_array_equal(moisture.snow_of_precipitation(np.ones(4), air), [1, 1, 0, 0])


def test_impossible_temperature_is_refused(tmp_path: Path) -> None:
    scene = scene_of(AWAY, effects=("thermodynamics", "snow", "shortwave"))
    data = analytic.make_analytic(scene, 1)
    data["t2m"].values[:] = -20.0
    data.to_netcdf(tmp_path / "f.nc")
    with pytest.raises(FloeError, match="'t2m' reaches from -20 to -20 K, outside 150 to 350 K"):
        forcing.make_forcing(scene, tmp_path / "f.nc", 1)


def ocean(values: np.ndarray) -> xr.Dataset:
    return file_with(
        uo=(values, {"standard_name": "eastward_sea_water_velocity", "units": "m s-1"}),
        vo=(0 * values, {"standard_name": "northward_sea_water_velocity", "units": "m s-1"}),
    )


def test_ocean_missing_on_land_takes_the_nearest_water(tmp_path: Path) -> None:
    values = np.full((20, 180), 0.2)
    values[10:14, 60:70] = np.nan
    ocean(values).to_netcdf(tmp_path / "o.nc")
    domain = {"x_min": 0.5e6, "x_max": 2.5e6, "y_min": 0.5e6, "y_max": 2.0e6, "spacing": 1e5}
    scene = scene_of(domain, effects=("ocean_drag",))
    made = forcing.make_forcing(scene, tmp_path / "o.nc", 1)
    speed = np.hypot(made["ocean_u"], made["ocean_v"]).values
    assert speed == pytest.approx(np.full(speed.shape, 0.2), rel=1e-2)


def test_ocean_missing_for_a_time_is_refused(tmp_path: Path) -> None:
    values = np.full((9, 20, 180), 0.2)
    values[1, 10:14, :] = np.nan
    ocean(values).to_netcdf(tmp_path / "o.nc")
    domain = {"x_min": 0.5e6, "x_max": 2.5e6, "y_min": 0.5e6, "y_max": 2.0e6, "spacing": 1e5}
    with pytest.raises(FloeError, match="'uo' is missing or not finite at 1981-12-31 06:00:00"):
        forcing.make_forcing(scene_of(domain, effects=("ocean_drag",)), tmp_path / "o.nc", 1)


def test_a_wind_of_gusts_keeps_its_velocity_or_its_stress(tmp_path: Path) -> None:
    """20 m/s in one row and calm in the next, on rows much finer than the scene's cells."""
    lat, lon = np.arange(70.0, 90.0, 0.1), np.arange(0.0, 360.0, 1.0)
    gusts = np.broadcast_to(np.where(np.arange(lat.size) % 2, 20.0, 0.0)[:, None], (200, 360))
    coords = {
        "lat": ("lat", lat, {"units": "degrees_north"}),
        "lon": ("lon", lon, {"units": "degrees_east"}),
    }
    parts = {"u10": ("eastward_wind", gusts), "v10": ("northward_wind", 0.0 * gusts)}
    xr.Dataset(
        {
            name: (("lat", "lon"), values, {"standard_name": standard, "units": "m s-1"})
            for name, (standard, values) in parts.items()
        },
        coords,
    ).to_netcdf(tmp_path / "w.nc")
    domain = AWAY | {"spacing": 2e5}
    for wind_mean, right in (("velocity", 10.0), ("stress", np.sqrt(200.0))):
        scene = scene_of(domain, forcing={"wind_mean": wind_mean})
        made = forcing.make_forcing(scene, tmp_path / "w.nc", 1)
        speed = np.hypot(made["wind_u"], made["wind_v"]).values
        assert speed == pytest.approx(np.full(speed.shape, right), rel=0.06)
