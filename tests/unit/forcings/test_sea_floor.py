# SPDX-License-Identifier: GPL-2.0-or-later
"""The depth of the sea: from a key, from files of depths and of heights; refused if impossible."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.forcings.files import users_files
from floeflow.forcings.fixed_fields import sea_floor_depth
from floeflow.forcings.inputs import check_forcing_file
from floeflow.scene.blocks import Scene
from floeflow.scene.hashes import stage_hash

DOMAIN = {"x_min": -2e6, "x_max": -1e6, "y_min": 4e5, "y_max": 1.2e6, "spacing": 1e5}


def a_scene(effects: tuple[str, ...] = ("wind", "grounding"), **grounding: Any) -> Scene:
    keys = {"name": "t", "domain": DOMAIN, "effects": effects, "grounding": grounding}
    return Scene.model_validate(keys)


def write(path: Path, values: Any, name: str, least: float = 60.0, **attrs: str) -> str:
    """A file of one field on a degree of latitude and two of longitude."""
    lat, lon = np.arange(least, 90.0), np.arange(0.0, 360.0, 2.0)
    full = np.broadcast_to(np.asarray(values, float), (lat.size, lon.size))
    data = xr.Dataset({name: (("lat", "lon"), full, {"units": "m"} | attrs)})
    data["lat"] = ("lat", lat, {"units": "degrees_north"})
    data["lon"] = ("lon", lon, {"units": "degrees_east"})
    data.to_netcdf(path)
    return str(path)


def test_a_key_gives_one_depth_everywhere() -> None:
    np.testing.assert_array_equal(sea_floor_depth(a_scene(depth=12.0)), np.full((8, 10), 12.0))


@pytest.mark.parametrize(
    ("sign", "name", "attrs", "asked"),
    [
        (1.0, "deptho", {"standard_name": "sea_floor_depth_below_geoid"}, ""),
        (1.0, "h", {}, ""),
        (1.0, "bottom", {}, "bottom"),
        (-1.0, "elevation", {}, ""),
        (-1.0, "topography", {"positive": "up"}, "topography"),
        (-1.0, "a", {"standard_name": "height_above_mean_sea_level"}, ""),
    ],
)
def test_depths_and_heights_of_files(
    tmp_path: Path, sign: float, name: str, attrs: dict[str, str], asked: str
) -> None:
    lat = np.arange(60.0, 90.0)[:, None]
    file = write(tmp_path / "d.nc", sign * 10.0 * (90.0 - lat), name, **attrs)
    found = sea_floor_depth(a_scene(file=file, variable=asked))
    assert found.shape == (8, 10)
    # About 111 km to a degree: depth grows by 10 m with each.
    x, y = np.meshgrid(np.arange(-1.95e6, -1e6, 1e5), np.arange(4.5e5, 1.2e6, 1e5))
    np.testing.assert_allclose(found, np.hypot(x, y) / 11.15e3, rtol=0.02)


def test_land_is_no_depth_and_missing_values_take_the_nearest(tmp_path: Path) -> None:
    lat, lon = np.arange(60.0, 90.0)[:, None], np.arange(0.0, 360.0, 2.0)
    height = np.where((lon > 280) & (lat < 80), 500.0, -30.0)
    found = sea_floor_depth(a_scene(file=write(tmp_path / "h.nc", height, "elevation")))
    assert found.min() >= 0.0 and found.max() == pytest.approx(30.0)
    gaps = np.where(lat < 75, np.nan, 40.0)
    found = sea_floor_depth(a_scene(file=write(tmp_path / "d.nc", gaps, "deptho")))
    np.testing.assert_allclose(found, 40.0)


@pytest.mark.parametrize(
    ("values", "name", "more", "sentence"),
    [
        (-30.0, "deptho", {}, "which is no depth of a sea floor: check its units, its sign"),
        (3.0e4, "deptho", {}, "reaches from 30000 to 30000 m"),
        (500.0, "elevation", {}, "which is no height of a sea floor"),
        (30.0, "deptho", {"least": 80.0}, "does not cover the scene"),
        (30.0, "depths", {}, "has no depth of the sea: no standard_name sea_floor_depth"),
        (30.0, "deptho", {"units": "K"}, "units"),
    ],
)
def test_what_cannot_be_is_refused(
    tmp_path: Path, values: float, name: str, more: dict[str, Any], sentence: str
) -> None:
    file = write(tmp_path / "d.nc", values, name, **more)
    with pytest.raises(FloeError, match=sentence):
        check_forcing_file(a_scene(file=file))


def test_a_file_or_variable_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(FloeError, match=r"none\.nc: there is no such file"):
        sea_floor_depth(a_scene(file=str(tmp_path / "none.nc")))
    file = write(tmp_path / "d.nc", 30.0, "deptho")
    with pytest.raises(FloeError, match="grounding.variable asks for variable 'depht'"):
        sea_floor_depth(a_scene(file=file, variable="depht"))


def test_a_scene_reads_the_file_only_with_the_effect() -> None:
    assert users_files(a_scene(file="d.nc")) == ("d.nc",)
    assert users_files(a_scene(("wind",), file="d.nc")) == ()
    for stage in ("forcing", "dynamics"):
        same = {stage_hash(a_scene(("wind",), depth=depth), stage) for depth in (1.0, 2.0)}
        other = {stage_hash(a_scene(depth=depth), stage) for depth in (1.0, 2.0)}
        assert len(same) == 1 and len(other) == 2
