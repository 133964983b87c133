# SPDX-License-Identifier: GPL-2.0-or-later
"""Whole files as products deliver them, built after their manuals: masks and forcing of each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.forcings import files, forcing
from floeflow.forcings.inputs import check_forcing_file
from floeflow.masks import mask
from floeflow.masks.mask_file import check_mask_file
from floeflow.scene.blocks import Scene

POLE = {"x_min": -8e5, "x_max": 8e5, "y_min": -8e5, "y_max": 8e5, "spacing": 1e5}

AWAY = {"x_min": -2e6, "x_max": -1e6, "y_min": 4e5, "y_max": 1.2e6, "spacing": 2e5}


def made_mask(path: Path, start: str, **block: Any) -> xr.Dataset:
    values = {"file": str(path), "land": "mask", "minimum_concentration": 0.0, "refine": 1}
    scene = Scene.model_validate(
        {"name": "t", "domain": POLE, "mask": values | block, "time": {"start": start}}
    )
    check_mask_file(scene)
    return mask.make_mask(scene, None)


def axis(count: int, cell: float) -> np.ndarray:
    return cell * (np.arange(count) + 0.5 - count / 2)


def test_osi_saf(tmp_path: Path) -> None:
    """OSI-450: packed per cent, x and y in km beside +units=km, status flags of bits."""
    cells = 80
    ice = np.full((1, cells, cells), 8000, np.int32)
    status = np.zeros((1, cells, cells), np.int16)
    status[0, :, :20], ice[0, :, :20] = 1, -32767
    status[0, :10, 20:] = 8 + 4  # land spill-over and weather filter: no land
    x = axis(cells, 25.0)
    data = xr.Dataset(
        {
            "ice_conc": (
                ("time", "yc", "xc"),
                ice,
                {"standard_name": "sea_ice_area_fraction", "units": "%",
                 "grid_mapping": "Lambert_Azimuthal_Grid", "scale_factor": 0.01, "add_offset": 0.0,
                 "_FillValue": np.int32(-32767), "valid_min": np.int32(0),
                 "valid_max": np.int32(10000), "ancillary_variables": "status_flag"},
            ),
            "status_flag": (
                ("time", "yc", "xc"),
                status,
                {"standard_name": "sea_ice_area_fraction status_flag",
                 "flag_masks": np.array([1, 2, 4, 8], np.int16),
                 "flag_meanings": "land lake open_water_filter land_spill_over"},
            ),
            "Lambert_Azimuthal_Grid": (
                (),
                0,
                {"grid_mapping_name": "lambert_azimuthal_equal_area",
                 "proj4_string": "+proj=laea +lon_0=0 +datum=WGS84 +ellps=WGS84 +lat_0=90.0 "
                                 "+units=km"},
            ),
        },
        {
            "time": ("time", [1426.5], {"units": "days since 1978-02-04 00:00:00"}),
            "xc": ("xc", x, {"standard_name": "projection_x_coordinate", "units": "km"}),
            "yc": ("yc", x[::-1], {"standard_name": "projection_y_coordinate", "units": "km"}),
        },
    )  # fmt: skip
    data.to_netcdf(tmp_path / "ice.nc")
    made = made_mask(tmp_path / "ice.nc", "1981-12-31T12:00:00", fill_reach=0.0)
    land = made["land"].values.astype(bool)
    assert land[:, made["x"].values < -5e5].all() and not land[:, made["x"].values > -5e5].any()
    np.testing.assert_allclose(made["siconc"].values[~land], 0.8, rtol=1e-9)
    assert "0.0 days" in made.attrs["notes"]


def test_amsr2(tmp_path: Path) -> None:
    """Bremen's ASI: bare 6.25 km raster of per cent, projection not told, 120 land."""
    cells = 320
    z = np.where(np.indices((cells, cells)).sum(axis=0) % 2, 100, 0).astype(np.uint8)
    z[:, :100] = 120
    x = axis(cells, 6250.0)
    data = xr.Dataset(
        {"z": (("y", "x"), z, {"units": "percent"})},
        {"x": ("x", x, {"units": "m"}), "y": ("y", x, {"units": "m"})},
    )
    data.to_netcdf(tmp_path / "asi.nc")
    made = made_mask(tmp_path / "asi.nc", "2020-01-15", concentration="z", crs="EPSG:3411")
    # The map of EPSG:3411 is turned by 45 degrees against that of the scene.
    assert 0.1 < made["land"].values.mean() < 0.4
    sea = made["siconc"].values[made["land"].values == 0]
    assert np.median(sea) == pytest.approx(0.5, abs=0.01)
    assert "of no known time" in made.attrs["notes"]


def test_topaz(tmp_path: Path) -> None:
    """TOPAZ: x and y in units of 100 km on a sphere, thickness of the ice, daily means."""
    cells = 90
    x = axis(cells, 0.25)
    crs = pyproj.CRS("+proj=stere +lat_0=90 +lon_0=-45 +lat_ts=90 +R=6378273")
    common = {"grid_mapping": "stereographic"}
    shape = (1, cells, cells)
    data = xr.Dataset(
        {
            "siconc": (("time", "y", "x"), np.full(shape, 0.5),
                       {"standard_name": "sea_ice_area_fraction", "units": "1", **common}),
            "sithick": (("time", "y", "x"), np.full(shape, 2.0),
                        {"standard_name": "sea_ice_thickness", "units": "m",
                         "cell_methods": "area: mean where sea_ice", **common}),
            "stereographic": ((), 0, crs.to_cf()),
            "time_bnds": (("time", "nv"), [[0.0, 24.0]]),
        },
        {
            "time": ("time", [12.0], {"units": "hour since 2016-02-01T00:00:00Z",
                                      "bounds": "time_bnds"}),
            "x": ("x", x, {"standard_name": "projection_x_coordinate", "units": "100  km"}),
            "y": ("y", x, {"standard_name": "projection_y_coordinate", "units": "100  km"}),
        },
    )  # fmt: skip
    data.to_netcdf(tmp_path / "topaz.nc")
    made = made_mask(tmp_path / "topaz.nc", "2016-02-01", thickness="sithick", land="none")
    np.testing.assert_allclose(made["siconc"], 0.5, rtol=1e-9)
    np.testing.assert_allclose(made["sithick"], 2.0, rtol=1e-9)
    assert "covers" not in made.attrs["notes"]


def test_jra55(tmp_path: Path) -> None:
    """JRA55-do: a variable a file, instants at the stamp, radiation as means by bounds."""
    lat = np.degrees(np.arcsin(np.polynomial.legendre.leggauss(64)[0]))
    lon = np.arange(0.0, 360.0, 2.8125)
    hours = np.arange(0.0, 49.0, 3.0)
    ramp = hours[:, None, None]
    point, mean = "area: mean time: point", "area: time: mean"
    fields = {
        "uas": (3.0, "eastward_wind", "m s-1", point),
        "vas": (4.0, "northward_wind", "m s-1", point),
        "tas": (240.0 + ramp, "air_temperature", "K", point),
        "huss": (5e-4, "specific_humidity", "1", point),
        "psl": (1.01e5, "air_pressure_at_sea_level", "Pa", point),
        "rsds": (10.0 * (ramp + 1.5), "surface_downwelling_shortwave_flux_in_air", "W m-2", mean),
        "rlds": (200.0, "surface_downwelling_longwave_flux_in_air", "W m-2", mean),
        "prsn": (1e-6, "snowfall_flux", "kg m-2 s-1", mean),
    }
    for name, (values, standard, unit, methods) in fields.items():
        shift = 1.5 if methods == mean else 0.0
        attrs = {"standard_name": standard, "units": unit, "cell_methods": methods}
        whole = np.broadcast_to(values, (hours.size, lat.size, lon.size))
        data = xr.Dataset(
            {name: (("time", "lat", "lon"), whole, attrs)},
            {
                "time": ("time", (hours + shift) / 24.0, {"units": "days since 1981-12-31"}),
                "lat": ("lat", lat, {"standard_name": "latitude", "units": "degrees_north"}),
                "lon": ("lon", lon, {"standard_name": "longitude", "units": "degrees_east"}),
            },
        )
        if methods == mean:
            data["time"].attrs["bounds"] = "time_bnds"
            ends = np.stack([hours, hours + 3.0], axis=1) / 24.0
            data["time_bnds"] = (("time", "bnds"), ends)
        else:
            data["height"] = ((), 10.0, {"standard_name": "height", "units": "m"})
            data[name].attrs["coordinates"] = "height"
        data.to_netcdf(tmp_path / f"{name}_input4MIPs_1982.nc")
    block = {"source": "file", "files": (str(tmp_path / "*_1982.nc"),),
             "fallback": {"ocean": "rest"}}  # fmt: skip
    effects = ("wind", "ocean_drag", "thermodynamics", "snow", "shortwave")
    scene = Scene.model_validate(
        {"name": "t", "domain": AWAY, "effects": effects, "forcing": block, "time": {"windows": 1}}
    )
    check_forcing_file(scene)
    made = forcing.make_forcing(scene, files.forcing_files(scene), 1)
    np.testing.assert_allclose(np.hypot(made["wind_u"], made["wind_v"]), 5.0, rtol=5e-3)
    hour = made["time"].values / 3600.0
    np.testing.assert_allclose(made["air_temperature"][:, 0, 0], 240.0 + hour, rtol=1e-9)
    light = made["shortwave_down"][:, 0, 0]
    inner = (hour >= 1.5) & (hour <= 24.0)
    np.testing.assert_allclose(light[inner], 10.0 * hour[inner], rtol=1e-9)
    assert "height = 10 m, about 10 m above the ground" in made.attrs["sources"]
