# SPDX-License-Identifier: GPL-2.0-or-later
"""Grids with two-dimensional latitudes: tripolar folds, left-out blocks, staggered components."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.core import grids, vectors
from floeflow.core.errors import FloeError
from floeflow.forcings import forcing
from floeflow.forcings.inputs import check_forcing_file
from floeflow.masks import mask
from floeflow.masks.mask_file import check_mask_file
from floeflow.scene.blocks import Scene

POLE = {"x_min": -1e6, "x_max": 1e6, "y_min": -1e6, "y_max": 1e6, "spacing": 1e5}
CRS = pyproj.CRS("EPSG:6931")


def mask_scene(path: Path, **changes: Any) -> Scene:
    block = {"file": str(path), "land": "none", "minimum_concentration": 0.0, "refine": 1}
    return Scene.model_validate({"name": "t", "domain": POLE, "mask": block | changes})


def bipolar(rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """The upper part of a tripolar grid: longitudes and latitudes of its cells, (rows, columns).

    Ellipses and hyperbolas with foci at two poles on land, x = +-F on the map; the last row folds
    onto itself along the line between them, so that cell i of it lies beside cell columns - 1 - i.
    """
    focus = 2.2e6
    v = np.linspace(1.35, 0.0, rows, endpoint=False) + 0.5 * (0.0 - 1.35) / rows
    u = 2 * np.pi * (np.arange(columns) + 0.5) / columns
    x = focus * np.cosh(v)[:, None] * np.cos(u)
    y = focus * np.sinh(v)[:, None] * np.sin(u)
    return grids.to_lonlat(CRS, x, y)


def smooth(lon: np.ndarray, lat: np.ndarray) -> np.ndarray:
    x, y = grids.from_lonlat(CRS, lon, lat)
    return 0.5 + 0.2 * np.sin(x / 1.5e6) - 0.15 * np.sin(y / 2e6)


def places(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    return grids.to_lonlat(CRS, *grids.mask_grid(scene.domain, scene.mask.refine).mesh())


def cice(lon: np.ndarray, lat: np.ndarray, values: np.ndarray) -> xr.Dataset:
    """History of CICE: TLON and TLAT, dimensions ni and nj without coordinates."""
    attrs = {"long_name": "ice area  (aggregate)", "units": "1", "coordinates": "TLON TLAT time"}
    data = xr.Dataset({"aice": (("time", "nj", "ni"), values[None], attrs)})
    data["TLON"] = (("nj", "ni"), lon % 360, {"units": "degrees_east"})
    data["TLAT"] = (("nj", "ni"), lat.copy(), {"units": "degrees_north"})
    data["ULON"], data["ULAT"] = data["TLON"] + 0.3, data["TLAT"] + 0.1
    for name in ("ULON", "ULAT"):
        data[name].attrs = data["T" + name[1:]].attrs
    data["time"] = ("time", [0.0], {"units": "days since 1981-12-31"})
    return data


@pytest.mark.parametrize("size", [(30, 90), (90, 360)])
def test_a_tripolar_grid_has_no_seam_and_no_fold(tmp_path: Path, size: tuple[int, int]) -> None:
    """Coarser than the mask it is interpolated, finer it is meant; the pole lies on the fold."""
    lon, lat = bipolar(*size)
    cice(lon, lat, smooth(lon, lat)).to_netcdf(tmp_path / "ice.nc")
    scene = mask_scene(tmp_path / "ice.nc", concentration="aice")
    check_mask_file(scene)
    made = mask.make_mask(scene, None)
    np.testing.assert_allclose(made["siconc"], smooth(*places(scene)), atol=2e-3)
    assert "covers" not in made.attrs["notes"]


@pytest.mark.parametrize("gone", ["missing", "zero", "fill"])
def test_left_out_blocks_are_no_places(tmp_path: Path, gone: str) -> None:
    """Blocks of land that CICE and NEMO leave out have no longitudes and latitudes."""
    lon, lat = bipolar(90, 360)
    data = cice(lon, lat, smooth(lon, lat))
    block = np.zeros(lon.shape, bool)
    block[60:80, 60:120] = True
    value = {"missing": np.nan, "zero": 0.0, "fill": 9.969209968386869e36}[gone]
    for name in ("TLON", "TLAT"):
        data[name].values[block] = value
        data[name].encoding["_FillValue"] = None
    data["aice"].values[0][block] = np.nan
    data.to_netcdf(tmp_path / "ice.nc")
    scene = mask_scene(tmp_path / "ice.nc", concentration="aice", fill_reach=0.0)
    made = mask.make_mask(scene, None)
    x, y = np.meshgrid(made["x"], made["y"])
    px, py = grids.from_lonlat(CRS, lon[block], lat[block])
    nearest = np.array(
        [np.hypot(px - a, py - b).min() for a, b in zip(x.flat, y.flat, strict=True)]
    )
    inside = (nearest < 3e4).reshape(x.shape)
    away = (nearest > 2.5e5).reshape(x.shape)
    right = smooth(*places(scene))
    np.testing.assert_allclose(made["siconc"].values[away], right[away], atol=2e-3)
    deep = inside & (made["siconc"].values == 0.0)
    assert deep.sum() > 0.5 * inside.sum()


def test_nemo_names(tmp_path: Path) -> None:
    lon, lat = bipolar(30, 90)
    attrs = {"standard_name": "sea_ice_area_fraction", "units": "1"}
    data = xr.Dataset(
        {
            "siconc": (("y", "x"), smooth(lon, lat), attrs | {"coordinates": "nav_lat nav_lon"}),
            "nav_lon": (("y", "x"), lon, {"units": "degrees_east"}),
            "nav_lat": (("y", "x"), lat, {"units": "degrees_north"}),
        }
    )
    data.to_netcdf(tmp_path / "ice.nc")
    scene = mask_scene(tmp_path / "ice.nc")
    made = mask.make_mask(scene, None)
    np.testing.assert_allclose(made["siconc"], smooth(*places(scene)), atol=2e-3)


def forcing_scene(*paths: Path) -> Scene:
    block = {"source": "file", "files": tuple(map(str, paths))}
    return Scene.model_validate(
        {"name": "t", "domain": POLE, "effects": ("ocean_drag",), "forcing": block,
         "time": {"windows": 1}}
    )  # fmt: skip


def shifted(lon: np.ndarray, lat: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Places half a cell on along the columns (axis 1) or the rows (axis 0)."""
    x, y = grids.from_lonlat(CRS, lon, lat)
    if axis == 1:
        x, y = (0.5 * (part + np.roll(part, -1, axis=1)) for part in (x, y))
    else:
        x, y = (part + 0.5 * np.gradient(part, axis=0) for part in (x, y))
    return grids.to_lonlat(CRS, x, y)


def current(lon: np.ndarray, lat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A gyre around the pole on the map, m/s."""
    x, y = grids.from_lonlat(CRS, lon, lat)
    return -2e-7 * y, 2e-7 * x


def along_grid(lon: np.ndarray, lat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The gyre along a grid's own axes, by steps on the map, not by the library's angle."""
    x, y = grids.from_lonlat(CRS, lon, lat)
    step_x, step_y = (np.roll(part, -1, axis=1) - np.roll(part, 1, axis=1) for part in (x, y))
    size = np.hypot(step_x, step_y)
    u, v = current(lon, lat)
    return (u * step_x + v * step_y) / size, (v * step_x - u * step_y) / size


@pytest.mark.parametrize("form", ["one file, A-grid", "two files, C-grid"])
def test_currents_along_a_tripolar_grid(tmp_path: Path, form: str) -> None:
    """NEMO: components along the grid, on a C-grid in a file of their own each."""
    lon, lat = bipolar(60, 180)
    attrs = {"units": "m/s"}
    paths = []
    for name, axis, part in (("vozocrtx", 1, 0), ("vomecrty", 0, 1)):
        at = shifted(lon, lat, axis) if "C-grid" in form else (lon, lat)
        values = along_grid(*at)[part]
        data = xr.Dataset({name: (("y", "x"), values, attrs)})
        data["nav_lon"] = (("y", "x"), at[0], {"units": "degrees_east"})
        data["nav_lat"] = (("y", "x"), at[1], {"units": "degrees_north"})
        paths.append(tmp_path / f"{name}.nc")
        data.to_netcdf(paths[-1])
    if "one file" in form:
        with xr.open_dataset(paths[0]) as one, xr.open_dataset(paths[1]) as other:
            one.merge(other, compat="override").to_netcdf(tmp_path / "both.nc")
        paths = [tmp_path / "both.nc"]
    scene = forcing_scene(*paths)
    check_forcing_file(scene)
    made = forcing.make_forcing(scene, paths, 1)
    x, y = np.meshgrid(made["x"], made["y"])
    error = np.hypot(made["ocean_u"][0] + 2e-7 * y, made["ocean_v"][0] - 2e-7 * x).values
    speed = 2e-7 * np.hypot(x, y)
    # The fold and the two poles on land bend the grid's lines within a cell.
    assert np.median(error / speed) < 0.01 and error.max() < 0.02


def test_the_angle_of_a_rotated_grid() -> None:
    """What CICE calls ANGLE: a grid turned by 30 degrees from east."""
    plane = pyproj.CRS("+proj=stere +lat_0=80 +lon_0=10 +R=6371000")
    line = 1e4 * np.arange(-10.0, 11.0)
    i, j = np.meshgrid(line, line)
    turn = np.radians(30.0)
    x, y = i * np.cos(turn) - j * np.sin(turn), i * np.sin(turn) + j * np.cos(turn)
    lon, lat = grids.to_lonlat(plane, x, y)
    angle = vectors.first_axis_angle(lon, lat)
    assert np.degrees(angle[10, 10]) == pytest.approx(30.0, abs=0.01)
    east = vectors.north_angle(plane, lon, lat) - np.pi / 2
    np.testing.assert_allclose(angle + east, turn, atol=1e-3)


def test_without_places_a_curvilinear_grid_is_refused(tmp_path: Path) -> None:
    lon, lat = bipolar(30, 90)
    data = cice(lon, lat, smooth(lon, lat)).drop_vars(["TLON", "ULON"])
    data.to_netcdf(tmp_path / "ice.nc")
    with pytest.raises(FloeError, match="does not have two-dimensional longitudes and latitudes"):
        check_mask_file(mask_scene(tmp_path / "ice.nc", concentration="aice"))
