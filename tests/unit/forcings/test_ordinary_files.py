# SPDX-License-Identifier: GPL-2.0-or-later
"""Ordinary files of atmospheres: read to the right number, or refused in one sentence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.forcings.forcing import make_forcing
from floeflow.forcings.inputs import check_forcing_file
from floeflow.scene.blocks import Scene

DOMAIN = {"x_min": -2e6, "x_max": -1e6, "y_min": 4e5, "y_max": 1.2e6, "spacing": 2e5}
UNITS = "hours since 1981-12-31 00:00:00"
EAST = {"standard_name": "eastward_wind", "units": "m s-1"}
NORTH = {"standard_name": "northward_wind", "units": "m s-1"}
WEATHER: dict[str, tuple[Any, dict[str, str]]] = {
    "U10M": (3.0, {"units": "m s-1"}),  # names of MERRA-2
    "V10M": (4.0, {"units": "m s-1"}),
    "T2M": (250.0, {"units": "K"}),
    "QV2M": (5e-4, {"units": "kg kg-1"}),
    "SLP": (101000.0, {"units": "Pa"}),
    "LWGAB": (200.0, {"units": "W m-2"}),
    "PRECSNO": (1e-5, {"units": "kg m-2 s-1"}),
}
COLUMN = ("thermodynamics", "snow")


def scene_of(*paths: Path, effects: tuple[str, ...] = ("wind",), **changes: Any) -> Scene:
    given = {"source": "file", "files": tuple(map(str, paths))} | changes.pop("forcing", {})
    keys = {"name": "t", "domain": DOMAIN, "effects": effects, "time": {"windows": 1}}
    return Scene.model_validate(keys | {"forcing": given} | changes)


def write(
    path: Path, fields: dict[str, tuple[Any, dict[str, str]]], hours: Any = (0, 12, 24)
) -> Path:
    lat, lon = np.arange(50.0, 91.0, 5.0), np.arange(0.0, 360.0, 5.0)
    coords = {
        "time": ("time", np.asarray(hours, float), {"units": UNITS}),
        "lat": ("lat", lat, {"units": "degrees_north"}),
        "lon": ("lon", lon, {"units": "degrees_east"}),
    }
    shape = len(hours), lat.size, lon.size
    data = {
        name: (tuple(coords), np.broadcast_to(values, shape).copy(), attrs)
        for name, (values, attrs) in fields.items()
    }
    xr.Dataset(data, coords).to_netcdf(path)
    return path


def read(scene: Scene, *paths: Path, window: int = 1) -> xr.Dataset:
    check_forcing_file(scene)
    return make_forcing(scene, paths, window)


def test_merra_by_its_names(tmp_path: Path) -> None:
    path = write(tmp_path / "m.nc", WEATHER)
    made = read(scene_of(path, effects=(*COLUMN, "wind")), path)
    right = {"air_temperature": 250.0, "specific_humidity": 5e-4, "snowfall": 1e-5}
    for name, value in right.items():
        np.testing.assert_allclose(made[name], value, rtol=1e-6)


@pytest.mark.parametrize(
    ("standard", "units", "value"),
    [
        ("precipitation_flux", "mm/day", 8.64),
        ("precipitation_flux", "kg m-2 s-1", 1e-4),
        ("lwe_precipitation_rate", "mm h-1", 0.36),
        ("lwe_snowfall_rate", "m s-1", 1e-7),
    ],
)
def test_rates_of_snow(tmp_path: Path, standard: str, units: str, value: float) -> None:
    fields = {k: v for k, v in WEATHER.items() if k != "PRECSNO"}
    path = write(
        tmp_path / "p.nc", fields | {"p": (value, {"standard_name": standard, "units": units})}
    )
    made = read(scene_of(path, effects=COLUMN), path)
    np.testing.assert_allclose(made["snowfall"], 1e-4, rtol=1e-6)


@pytest.mark.parametrize("word", ["maximum", "minimum"])
def test_a_days_extreme_is_no_value(tmp_path: Path, word: str) -> None:
    attrs = EAST | {"cell_methods": f"time: {word}"}
    path = write(tmp_path / "x.nc", {"u": (3.0, attrs), "v": (4.0, NORTH)})
    with pytest.raises(FloeError, match=f"'u' is a {word} by its cell_methods"):
        read(scene_of(path), path)


def test_parts_in_other_units_are_refused_and_other_spellings_are_not(tmp_path: Path) -> None:
    first = write(tmp_path / "1.nc", {"u": (3.0, EAST), "v": (4.0, NORTH)})
    for units in ("m s**-1", "knots"):
        attrs = [item | {"units": units} for item in (EAST, NORTH)]
        fields = {"u": (3.0, attrs[0]), "v": (4.0, attrs[1])}
        second = write(tmp_path / "2.nc", fields, (36, 48))
        scene = scene_of(first, second, time={"windows": 2})
        if units == "knots":
            with pytest.raises(FloeError, match="2.nc: 'u' has units 'knots', but 'm s-1' in"):
                read(scene, first, second, window=2)
            continue
        made = read(scene, first, second, window=2)
        np.testing.assert_allclose(np.hypot(made["wind_u"], made["wind_v"]), 5.0, rtol=3e-3)


def test_a_rotated_pole_with_the_units_of_true_longitudes(tmp_path: Path) -> None:
    pole = {
        "grid_mapping_name": "rotated_latitude_longitude",
        "grid_north_pole_latitude": 6.55,
        "grid_north_pole_longitude": 0.0,
    }
    turn = pyproj.Transformer.from_crs(pyproj.CRS.from_cf(pole), "EPSG:4326", always_xy=True)
    axis = np.arange(-45.0, 46.0, 3.0)
    x, y = np.meshgrid(axis, axis)
    lon, lat = turn.transform(x, y)
    near, above = turn.transform(x + 1e-3, y)
    step = np.radians((near - lon + 180.0) % 360.0 - 180.0) * np.cos(np.radians(lat))
    angle = np.arctan2(np.radians(above - lat), step)
    parts = 3.0 * np.cos(angle) + 4.0 * np.sin(angle), 4.0 * np.cos(angle) - 3.0 * np.sin(angle)
    dims = ("time", "rlat", "rlon")
    data = xr.Dataset(
        {
            name: (
                dims,
                np.broadcast_to(part, (3, *x.shape)).copy(),
                {"standard_name": f"grid_{word}_wind", "units": "m s-1", "grid_mapping": "pole"},
            )
            for name, part, word in zip("uv", parts, ("eastward", "northward"), strict=True)
        },
        {
            "time": ("time", [0.0, 12.0, 24.0], {"units": UNITS}),
            "rlat": ("rlat", axis, {"standard_name": "grid_latitude", "units": "degrees_north"}),
            "rlon": ("rlon", axis, {"standard_name": "grid_longitude", "units": "degrees_east"}),
            "lon": (dims[1:], lon, {"units": "degrees_east"}),
            "lat": (dims[1:], lat, {"units": "degrees_north"}),
        },
    )
    data["pole"] = ((), 0, pole)
    data.to_netcdf(tmp_path / "rotated.nc")
    right = write(tmp_path / "right.nc", {"u": (3.0, EAST), "v": (4.0, NORTH)})
    found = [read(scene_of(p), p).isel(time=0) for p in (tmp_path / "rotated.nc", right)]
    for name in ("wind_u", "wind_v"):
        np.testing.assert_allclose(found[0][name], found[1][name], atol=0.06)


def test_times_that_are_not_told(tmp_path: Path) -> None:
    path = write(tmp_path / "t.nc", {"u": (3.0, EAST), "v": (4.0, NORTH)})
    data = xr.open_dataset(path, decode_times=False).load()
    data.close()
    for units, said in (("month", "has units 'month'"), ("", "has no units")):
        data["time"].attrs = {"units": units} if units else {}
        data.to_netcdf(tmp_path / f"other{units}.nc")
        other = tmp_path / f"other{units}.nc"
        with pytest.raises(FloeError, match=f"'time' of variable 'u' {said}"):
            read(scene_of(other), other)


@pytest.mark.parametrize("accumulation", ["", "hour", "step", "day"])
@pytest.mark.parametrize("bounds", [False, True])
def test_monthly_sums_need_bounds(tmp_path: Path, accumulation: str, bounds: bool) -> None:
    """ERA5's monthly sums are those of a day, others of the month: no key tells them apart."""
    hours = np.array([-30.0, 0.0, 31.0, 59.0]) * 24.0
    path = write(tmp_path / "s.nc", WEATHER | {"strd": (5e8, {"units": "J m-2"})}, hours)
    with xr.open_dataset(path, decode_times=False) as data:
        data = data.drop_vars("LWGAB").load()
    if bounds:
        data["time"].attrs["bounds"] = "bnds"
        ends = np.stack([hours, np.append(hours[1:], 90.0 * 24.0)], axis=1)
        data["bnds"] = (("time", "nv"), ends)
    data.to_netcdf(tmp_path / "sums.nc")
    keys = {"accumulation": accumulation}
    scene = scene_of(tmp_path / "sums.nc", effects=COLUMN, forcing=keys)
    if bounds:
        made = read(scene, tmp_path / "sums.nc")
        # 31 days of January after 30 of December, whose middles lie half a day apart from theirs.
        rate = float(made["longwave_down"][0].mean())
        assert 5e8 / (31 * 86400.0) < rate < 5e8 / (30 * 86400.0)
        return
    with pytest.raises(FloeError, match="'strd' .* records are further apart than a day: over wh"):
        read(scene, tmp_path / "sums.nc")


def test_means_of_months_need_bounds_and_means_of_sums_are_refused(tmp_path: Path) -> None:
    hours = np.array([-30.0, 0.0, 31.0, 59.0]) * 24.0
    monthly = {"units": "W m-2", "GRIB_stepType": "avgua"}
    fields = {**WEATHER, "avg_sdlwrf": (200.0, monthly)}
    del fields["LWGAB"]
    path = write(tmp_path / "m.nc", fields, hours)
    with pytest.raises(FloeError, match="'avg_sdlwrf' is a mean over time whose records are furth"):
        read(scene_of(path, effects=COLUMN), path)
    fields = {**fields, "strd": (1.7e7, {"units": "J m-2", "GRIB_stepType": "avgad"})}
    del fields["avg_sdlwrf"]
    path = write(tmp_path / "s.nc", fields, hours)
    with pytest.raises(
        FloeError, match=r"'strd' is a mean of sums over time \(GRIB step type avga"
    ):
        read(scene_of(path, effects=COLUMN), path)


def test_the_first_of_unequal_sums_reaches_back_unknown(tmp_path: Path) -> None:
    """Sums of 6 h up to -12 h and of 3 h after it: that of the first record is not guessed."""
    hours = np.array([-12.0, -9.0, -3.0, 0.0, 3.0, 6.0, 12.0, 18.0, 24.0])
    values = 3600.0 * 200.0 * np.concatenate([[6.0], np.diff(hours)])
    sums = {"units": "J m-2"}
    fields = {**WEATHER, "strd": (values[:, None, None], sums)}
    del fields["LWGAB"]
    path = write(tmp_path / "s.nc", fields, hours)
    made = read(scene_of(path, effects=COLUMN, forcing={"accumulation": "step"}), path)
    np.testing.assert_allclose(made["longwave_down"], 200.0, rtol=1e-12)
    rest = {name: item for name, item in fields.items() if name != "strd"}
    parts = [
        write(tmp_path / "rest.nc", rest),
        write(tmp_path / "late.nc", {"strd": (values[4:, None, None], sums)}, hours[4:]),
    ]
    with pytest.raises(FloeError, match="the sums of 'strd' do not cover the scene"):
        read(scene_of(*parts, effects=COLUMN, forcing={"accumulation": "step"}), *parts)


@pytest.mark.parametrize(
    ("attrs", "said"),
    [
        ({}, "no bounds: taken as of its stamps"),
        ({"cell_methods": "time: mean"}, "no bounds: taken as of its stamps"),
        ({"cell_methods": "time: point"}, ""),
    ],
)
def test_what_is_taken_for_granted_of_daily_values_is_told(
    tmp_path: Path, attrs: dict[str, str], said: str
) -> None:
    fields = {"u": (3.0, {**EAST, **attrs}), "v": (4.0, {**NORTH, **attrs})}
    path = write(tmp_path / "d.nc", fields, (0, 24))
    told = read(scene_of(path), path).attrs["sources"]
    assert (said in told) if said else ("bounds" not in told)


def test_what_keeps_a_variable_from_being_a_map_is_named(tmp_path: Path) -> None:
    """Members of an ensemble; axes in metres of no known projection; a page in place of data."""
    path = write(tmp_path / "f.nc", {"u": (3.0, EAST), "v": (4.0, NORTH)})
    with xr.open_dataset(path, decode_times=False) as data:
        members = data.load().expand_dims(number=[0, 1])
    members.to_netcdf(tmp_path / "members.nc")
    plain = members.isel(number=0).rename(lat="y", lon="x").drop_vars(["x", "y", "number"])
    plain.to_netcdf(tmp_path / "plain.nc")
    (tmp_path / "page.nc").write_bytes(b"\n<!DOCTYPE html><html>Earthdata Login</html>")
    for name, sentence in (
        ("members.nc", "'u' has 2 values along 'number', which is no time, level, longitude or la"),
        ("plain.nc", "projected x and y: name their projection in mask.crs or forcing.crs"),
        ("page.nc", "is a page of HTML or XML and no data: did its download need a login?"),
    ):
        with pytest.raises(FloeError, match=sentence.replace("?", r"\?")):
            read(scene_of(tmp_path / name), tmp_path / name)
