# SPDX-License-Identifier: GPL-2.0-or-later
"""Mask files are checked before any job: each fault is one sentence that names the file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.masks import mask_file
from floeflow.scene import load_scene
from floeflow.scene.blocks import Scene

SMALL = {"x_min": -2e5, "x_max": 2e5, "y_min": -8e5, "y_max": -4e5, "spacing": 1e5}


def ice_file() -> xr.Dataset:
    lat, lon = np.arange(60.5, 90), np.arange(0.0, 360.0, 5.0)
    return xr.Dataset(
        {
            "ice": (("time", "lat", "lon"), np.full((1, 30, 72), 0.5), {"units": "1"}),
            "sst": (("time", "lat", "lon"), np.full((1, 30, 72), 271.0), {"units": "K"}),
        },
        coords={
            "time": ("time", [0.0], {"units": "days since 1981-12-31"}),
            "lat": ("lat", lat, {"units": "degrees_north"}),
            "lon": ("lon", lon, {"units": "degrees_east"}),
        },
    )


def mask_scene(path: Path, **block: Any) -> Scene:
    values = {"file": str(path), "concentration": "ice", **block}
    return Scene.model_validate({"name": "t", "domain": SMALL, "mask": values})


def test_shipped_scenes_pass(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)
    for name in ("arctic_1981", "smoke"):
        scene = load_scene(project / f"config/scenes/{name}.yaml")
        mask_file.check_mask_file(scene)


def test_good_mask_passes(tmp_path: Path) -> None:
    ice_file().to_netcdf(tmp_path / "ice.nc")
    mask_file.check_mask_file(mask_scene(tmp_path / "ice.nc", water="sst"))


def two_names(data: xr.Dataset) -> xr.Dataset:
    for name in ("ice", "sst"):
        data[name].attrs["standard_name"] = "sea_ice_area_fraction"
    return data


def curvilinear(data: xr.Dataset) -> xr.Dataset:
    data = data.rename({"lat": "j", "lon": "i"}).drop_vars(["i", "j"])
    data["latitude"] = (("j", "i"), np.zeros((30, 72)), {"units": "degrees_north"})
    return data


def two_levels(data: xr.Dataset) -> xr.Dataset:
    return xr.concat([data, data], "member")


def bad_time(data: xr.Dataset) -> xr.Dataset:
    data["time"].attrs["units"] = "fortnights since 1981"
    return data


def no_mapping(data: xr.Dataset) -> xr.Dataset:
    data = data.rename({"lat": "y", "lon": "x"})
    for axis in "xy":
        data[axis].attrs = {"standard_name": f"projection_{axis}_coordinate", "units": "m"}
    return data


def bad_mapping(data: xr.Dataset) -> xr.Dataset:
    data = no_mapping(data)
    data["ice"].attrs["grid_mapping"] = "crs"
    data["crs"] = ((), 0, {"grid_mapping_name": "crumpled"})
    return data


def acres(data: xr.Dataset) -> xr.Dataset:
    data = bad_mapping(data)
    data["x"].attrs["units"] = "acres"
    return data


def words(data: xr.Dataset) -> xr.Dataset:
    data["ice"] = (("lat", "lon"), np.full((30, 72), "x"))
    return data


def other_grid(data: xr.Dataset) -> xr.Dataset:
    data["sst"] = (("y2", "x2"), np.zeros((2, 2)))
    data["y2"] = ("y2", [1.0, 2.0], {"units": "degrees_north"})
    data["x2"] = ("x2", [1.0, 2.0], {"units": "degrees_east"})
    return data


@pytest.mark.parametrize(
    ("change", "block", "sentence"),
    [
        (None, {"concentration": "icee"}, "asks for variable 'icee', .* did you mean 'ice'"),
        (None, {"water": "seasurface"}, "mask.water asks for variable 'seasurface'"),
        (None, {"thickness": "hice"}, "mask.thickness asks for variable 'hice'"),
        (None, {"concentration": ""}, "no variable has standard_name .*: ice, sst"),
        (two_names, {"concentration": ""}, "several variables have standard_name"),
        (curvilinear, {}, r"dimensions \(time, j, i\) on a curvilinear grid"),
        (two_levels, {}, "variable 'ice' has 2 values along 'member'"),
        (bad_time, {}, "time variable 'time' with units 'fortnights since 1981'"),
        (no_mapping, {}, "lies on projected coordinates but has no grid_mapping"),
        (bad_mapping, {}, "the grid mapping 'crs' names no known projection"),
        (acres, {}, "coordinate 'x' has units 'acres', not m or km"),
        (words, {}, "variable 'ice' holds no numbers"),
        (other_grid, {"water": "sst"}, "'sst' is not on the grid of 'ice'"),
    ],
)
def test_bad_mask_is_refused(
    tmp_path: Path,
    change: Callable[[xr.Dataset], xr.Dataset] | None,
    block: dict[str, Any],
    sentence: str,
) -> None:
    data = ice_file()
    (change(data) if change else data).to_netcdf(tmp_path / "ice.nc")
    with pytest.raises(FloeError, match=sentence) as caught:
        mask_file.check_mask_file(mask_scene(tmp_path / "ice.nc", **block))
    assert str(caught.value).startswith(str(tmp_path / "ice.nc"))
    assert "\n" not in str(caught.value)


def test_mask_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FloeError, match="none.nc: there is no such file"):
        mask_file.check_mask_file(mask_scene(tmp_path / "none.nc"))
    with pytest.raises(FloeError, match="^mask.file names no file"):
        mask_file.check_mask_file(Scene.model_validate({"name": "t", "mask": {"file": ""}}))


@pytest.mark.parametrize("content", [b"", b"not NetCDF", b"\x89HDF\r\n\x1a\n" + b"\0" * 200])
def test_mask_that_is_no_netcdf(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "ice.nc").write_bytes(content)
    with pytest.raises(FloeError, match="ice.nc: cannot be read as NetCDF"):
        mask_file.check_mask_file(mask_scene(tmp_path / "ice.nc"))


def test_mask_that_is_cut_short(tmp_path: Path) -> None:
    ice_file().to_netcdf(tmp_path / "ice.nc")
    whole = (tmp_path / "ice.nc").read_bytes()
    (tmp_path / "ice.nc").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(FloeError, match=r"ice.nc: .*cannot be read"):
        mask_file.check_mask_file(mask_scene(tmp_path / "ice.nc"))


def test_projection_is_checked_first() -> None:
    scene = Scene.model_validate({"name": "t", "domain": {"crs": "EPSG:4326"}})
    with pytest.raises(FloeError, match="'EPSG:4326' is not a projection in metres"):
        mask_file.check_mask_file(scene)
    beyond = {"x_min": -1e8, "x_max": 1e8, "y_min": -1e8, "y_max": 1e8, "spacing": 1e7}
    with pytest.raises(FloeError, match="lies outside of the projection"):
        mask_file.check_mask_file(Scene.model_validate({"name": "t", "domain": beyond}))
