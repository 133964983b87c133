# SPDX-License-Identifier: GPL-2.0-or-later
"""The mask stage: one field in any form of file gives one mask; nothing missing becomes ice."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.core import grids
from floeflow.core.errors import FloeError
from floeflow.masks import mask
from floeflow.scene.blocks import Scene

DOMAIN = {"x_min": -1.0e6, "x_max": 1.0e6, "y_min": -1.2e6, "y_max": 0.8e6, "spacing": 2.0e5}


def scene_of(path: Path, domain: dict[str, Any] = DOMAIN, **block: Any) -> Scene:
    values = {"file": str(path), "land": "none", "minimum_concentration": 0.0, **block}
    return Scene.model_validate({"name": "test", "domain": domain, "mask": values})


def concentration(lon: np.ndarray, lat: np.ndarray) -> np.ndarray:
    """A smooth field without a kink at the pole or the dateline."""
    colatitude = np.radians(90.0 - lat)
    return 0.5 + 0.9 * np.sin(colatitude) * np.cos(np.radians(lon)) * np.cos(colatitude) ** 2


def field() -> xr.Dataset:
    lon, lat = np.arange(0.0, 360.0), np.arange(60.5, 90.0)
    values = concentration(*np.meshgrid(lon, lat))
    return xr.Dataset(
        {
            "siconc": (
                ("lat", "lon"),
                values,
                {"standard_name": "sea_ice_area_fraction", "units": "1"},
            )
        },
        coords={
            "lat": ("lat", lat, {"units": "degrees_north"}),
            "lon": ("lon", lon, {"units": "degrees_east"}),
        },
    )


def expected(scene: Scene) -> np.ndarray:
    grid = grids.mask_grid(scene.domain, scene.mask.refine)
    return concentration(*grids.to_lonlat(grids.scene_crs(scene.domain), *grid.mesh()))


def test_smooth_field_is_interpolated_over_dateline_and_pole(tmp_path: Path) -> None:
    field().to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc")
    error = np.abs(mask.make_mask(scene, None)["siconc"].values - expected(scene))
    # Bilinear error: step^2 / 8 times the largest second derivative, along each axis.
    assert error.max() < 2 * np.radians(1.0) ** 2 / 8 * 1.3


def percent(data: xr.Dataset) -> xr.Dataset:
    data["siconc"].values *= 100.0
    data["siconc"].attrs["units"] = "%"
    return data


def western(data: xr.Dataset) -> xr.Dataset:
    attrs = data["lon"].attrs
    data = data.assign_coords(lon=(data["lon"] + 180.0) % 360.0 - 180.0).sortby("lon")
    data["lon"].attrs = attrs
    return data


FORMS: dict[str, Callable[[xr.Dataset], xr.Dataset]] = {
    "per cent": percent,
    "descending latitudes": lambda data: data.isel(lat=slice(None, None, -1)),
    "longitudes -180..180": western,
    "longitude first": lambda data: data.transpose("lon", "lat"),
    "single level": lambda data: data.expand_dims("zlev"),
    "first meridian again": lambda data: xr.concat(
        [data, data.isel(lon=[0]).assign_coords(lon=[360.0])], "lon", combine_attrs="override"
    ),
}


@pytest.mark.parametrize("form", FORMS)
def test_form_of_the_file_does_not_matter(tmp_path: Path, form: str) -> None:
    field().to_netcdf(tmp_path / "plain.nc")
    data = FORMS[form](field())
    data["lon"].attrs["units"] = "degrees_east"
    data.to_netcdf(tmp_path / "other.nc")
    plain = mask.make_mask(scene_of(tmp_path / "plain.nc"), None)
    other = mask.make_mask(scene_of(tmp_path / "other.nc"), None)
    np.testing.assert_allclose(other["siconc"], plain["siconc"], rtol=0, atol=1e-14)


def test_projected_file_gives_the_same(tmp_path: Path) -> None:
    x = np.arange(-3.0e6, 3.0e6, 2.5e4)
    crs = pyproj.CRS.from_epsg(3413)
    values = concentration(*grids.to_lonlat(crs, *np.meshgrid(x, x)))
    attrs = {"standard_name": "sea_ice_area_fraction", "units": "1", "grid_mapping": "crs"}
    axis = {"units": "km"}
    data = xr.Dataset(
        {"ice": (("y", "x"), np.clip(values, 0, 1)[::-1], attrs), "crs": ((), 0, crs.to_cf())},
        coords={
            "y": ("y", x[::-1] / 1e3, {"standard_name": "projection_y_coordinate", **axis}),
            "x": ("x", x / 1e3, {"standard_name": "projection_x_coordinate", **axis}),
        },
    )
    data.to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc")
    error = np.abs(mask.make_mask(scene, None)["siconc"].values - expected(scene))
    assert error.max() < 1e-4


def test_per_cent_by_name_but_shares_by_value(tmp_path: Path) -> None:
    data = field()
    data["siconc"].attrs["units"] = "percent"
    data.to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc")
    assert mask.make_mask(scene, None)["siconc"].values.max() > 0.5


def test_nearest_time_is_taken(tmp_path: Path) -> None:
    times = [np.datetime64("1981-12-20"), np.datetime64("1981-12-30"), np.datetime64("1982-01-20")]
    data = xr.concat([0.1 * field(), 0.5 * field(), 0.9 * field()], "time")
    data = data.assign_coords(time=times)
    data["siconc"].attrs = field()["siconc"].attrs
    data.to_netcdf(tmp_path / "many.nc")
    one = 0.5 * field()
    one["siconc"].attrs = field()["siconc"].attrs
    one.to_netcdf(tmp_path / "one.nc")
    many = mask.make_mask(scene_of(tmp_path / "many.nc"), None)
    np.testing.assert_allclose(
        many["siconc"], mask.make_mask(scene_of(tmp_path / "one.nc"), None)["siconc"], atol=1e-15
    )


def with_hole(path: Path, fill: float = -999.0) -> None:
    """Ice of 0.8 everywhere, missing on a patch around 84 N, 0 E."""
    data = field()
    lon, lat = np.meshgrid(data["lon"], data["lat"])
    hole = ((lon < 12) | (lon > 348)) & (np.abs(lat - 84) < 3)
    data["siconc"].values[:] = np.where(hole, np.nan, 0.8)
    data["sst"] = (("lat", "lon"), np.where(lon < 180, 271.0, np.nan), {"units": "K"})
    data.to_netcdf(path, encoding={"siconc": {"_FillValue": fill}, "sst": {"_FillValue": fill}})


def hole_of(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    grid = grids.mask_grid(scene.domain, scene.mask.refine)
    lon, lat = grids.to_lonlat(grids.scene_crs(scene.domain), *grid.mesh())
    east = (lon + 180) % 360 - 180
    return (np.abs(east) < 10) & (np.abs(lat - 84) < 2), east


def test_missing_values_take_the_nearest_known(tmp_path: Path) -> None:
    with_hole(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc", fill_reach=1.0e6)
    np.testing.assert_allclose(mask.make_mask(scene, None)["siconc"], 0.8, atol=1e-12)


def test_missing_values_beyond_reach_are_no_ice(tmp_path: Path) -> None:
    with_hole(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc", fill_reach=0.0)
    found = mask.make_mask(scene, None)["siconc"].values
    inside, _ = hole_of(scene)
    assert inside.sum() > 20
    assert (found[inside] == 0).all()
    assert found.min() == 0 and found.max() == pytest.approx(0.8)


def test_missing_where_water_is_known_is_open_water(tmp_path: Path) -> None:
    with_hole(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc", water="sst", fill_reach=1.0e7)
    found = mask.make_mask(scene, None)["siconc"].values
    inside, east = hole_of(scene)
    # East of Greenwich the sea surface temperature says water; west of it nothing is known there.
    assert (found[inside & (east > 1)] == 0).all()
    assert found[inside & (east < -9)] == pytest.approx(0.8)


def test_land_from_missing_values(tmp_path: Path) -> None:
    with_hole(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc", land="mask")
    made = mask.make_mask(scene, None)
    inside, _ = hole_of(scene)
    assert (made["land"].values[inside] == 1).all()
    assert (made["siconc"].values[made["land"].values == 1] == 0).all()
    patch = np.radians(24) * (np.sin(np.radians(87)) - np.sin(np.radians(81))) * 6371.0e3**2
    assert made["land"].values.mean() == pytest.approx(patch / 2.0e6**2, rel=0.05)


def test_land_and_minimum_concentration_cut_the_ice(tmp_path: Path) -> None:
    field().to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(
        tmp_path / "ice.nc", land="global_land_mask", minimum_concentration=0.5, land_fraction=0.3
    )
    share = np.linspace(0, 1, 1600).reshape(40, 40)
    made = mask.make_mask(scene, share)
    solid = share >= 0.3
    assert (made["land"].values == solid).all()
    assert (made["siconc"].values[solid] == 0).all()
    some = made["siconc"].values[made["siconc"].values > 0]
    assert some.size and some.min() >= 0.5


def test_totals_of_a_uniform_field(tmp_path: Path) -> None:
    data = field()
    data["siconc"].values[:] = 0.7
    data.to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc", ice_thickness=2.0)
    made = mask.make_mask(scene, None)
    area = made["cell_area"]
    assert float((made["siconc"] * area).sum()) == pytest.approx(0.7 * 2.0e6**2, rel=1e-12)
    volume = float((made["siconc"] * made["sithick"] * area).sum())
    assert volume == pytest.approx(0.7 * 1.4 * 2.0e6**2, rel=1e-12)


def test_thickness_rules_and_file(tmp_path: Path) -> None:
    data = field()
    data["h"] = (("lat", "lon"), np.full(data["siconc"].shape, 150.0), {"units": "cm"})
    data["h"].values[:, :180] = np.nan
    data.to_netcdf(tmp_path / "ice.nc")
    constant = mask.make_mask(scene_of(tmp_path / "ice.nc", thickness_rule="constant"), None)
    ice = constant["siconc"].values > 0
    assert set(constant["sithick"].values[ice]) == {2.0}
    assert (constant["sithick"].values[~ice] == 0).all()
    tabled = mask.make_mask(scene_of(tmp_path / "ice.nc", thickness_rule="climatology"), None)
    shares = tabled["siconc"].values[ice]
    assert 0.3 < (tabled["sithick"].values[ice] / shares).min() < 3.0
    assert np.ptp(tabled["sithick"].values[ice] / shares) > 0.1
    given = mask.make_mask(
        scene_of(tmp_path / "ice.nc", thickness="h", thickness_is="in_ice", fill_reach=0.0), None
    )
    thick = given["sithick"].values
    assert thick.max() == pytest.approx(1.5)
    # Ice without thickness is no ice.
    assert ((given["siconc"].values > 0) == (thick > 0)).all()


def test_off_the_files_grid_there_is_open_water(tmp_path: Path) -> None:
    data = field().sel(lon=slice(0, 90))
    data["siconc"].values[:] = 0.9
    data.to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc")
    found = mask.make_mask(scene, None)["siconc"].values
    grid = grids.mask_grid(scene.domain, scene.mask.refine)
    lon, lat = grids.to_lonlat(grids.scene_crs(scene.domain), *grid.mesh())
    lon = lon % 360
    assert found[(lon > 1) & (lon < 89) & (lat < 89)] == pytest.approx(0.9)
    assert (found[(lon > 91) & (lon < 359)] == 0).all()


def broken(tmp_path: Path, **changes: Any) -> Scene:
    """A scene on a file with a fault."""
    data = field()
    for name, change in changes.items():
        if name == "attrs":
            data["siconc"].attrs |= change
        if name == "values":
            data["siconc"].values[:] = change
    data.to_netcdf(tmp_path / "bad.nc")
    return scene_of(tmp_path / "bad.nc")


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"attrs": {"units": "kelvin"}}, "neither a share nor per cent"),
        ({"values": 25.5}, "outside 0..1: check its units"),
        ({"values": -0.5}, "outside 0..1: check its units"),
        ({"values": np.nan}, "has no value that is not missing"),
    ],
)
def test_bad_values_are_refused(tmp_path: Path, changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(FloeError, match=sentence) as caught:
        mask.make_mask(broken(tmp_path, **changes), None)
    assert "bad.nc: variable 'siconc'" in str(caught.value)


def test_bad_thickness_is_refused(tmp_path: Path) -> None:
    data = field()
    data["h"] = (("lat", "lon"), np.full(data["siconc"].shape, 9999.0), {"units": "m"})
    data.to_netcdf(tmp_path / "bad.nc")
    with pytest.raises(FloeError, match=r"'h' reaches from 9999 to 9999 m, outside 0..50 m"):
        mask.make_mask(scene_of(tmp_path / "bad.nc", thickness="h", thickness_is="in_ice"), None)


@pytest.mark.parametrize("crs", ["EPSG:4326", "nonsense", "EPSG:2263"])
def test_bad_projection_is_refused(crs: str) -> None:
    domain = Scene.model_validate({"name": "t", "domain": {"crs": crs}}).domain
    with pytest.raises(FloeError, match="^domain.crs: '"):
        grids.scene_crs(domain)
