# SPDX-License-Identifier: GPL-2.0-or-later
"""Masks that look fine and would be read wrong: pole holes, flags, scales, thicknesses, times.

The files are built after the specifications of the products that they stand for.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.core import grids
from floeflow.core.errors import FloeError
from floeflow.masks import mask
from floeflow.masks.mask_file import check_mask_file
from floeflow.scene.blocks import Scene

POLE = {"x_min": -1.0e6, "x_max": 1.0e6, "y_min": -1.0e6, "y_max": 1.0e6, "spacing": 1.0e5}


def scene_of(path: Path, domain: dict[str, Any] = POLE, **block: Any) -> Scene:
    values = {"file": str(path), "land": "none", "minimum_concentration": 0.0, "refine": 1, **block}
    return Scene.model_validate({"name": "test", "domain": domain, "mask": values})


def lonlat(step: float = 0.5, top: float = 90.0) -> xr.Dataset:
    lat = np.arange(75.0 + step / 2, top, step)
    lon = np.arange(0.0, 360.0, 1.0)
    attrs = {"standard_name": "sea_ice_area_fraction", "units": "1"}
    return xr.Dataset(
        {"siconc": (("lat", "lon"), np.full((lat.size, lon.size), 0.9), attrs)},
        {
            "lat": ("lat", lat, {"units": "degrees_north"}),
            "lon": ("lon", lon, {"units": "degrees_east"}),
        },
    )


def projected(
    values: np.ndarray, attrs: dict[str, Any], cell: float = 2.5e4, crs: str = "EPSG:6931"
) -> xr.Dataset:
    """A square raster around the pole, values (n, n), rows running down as satellites' do."""
    side = cell * values.shape[0]
    axis = -side / 2 + cell * (np.arange(values.shape[0]) + 0.5)
    attrs = {"standard_name": "sea_ice_area_fraction", "grid_mapping": "crs", **attrs}
    data = xr.Dataset(
        {"ice": (("y", "x"), values, attrs), "crs": ((), 0, pyproj.CRS(crs).to_cf())},
        {"x": ("x", axis), "y": ("y", axis[::-1])},
    )
    for name in "xy":
        data[name].attrs = {"standard_name": f"projection_{name}_coordinate", "units": "m"}
    return data


def latitudes(scene: Scene) -> np.ndarray:
    grid = grids.mask_grid(scene.domain, scene.mask.refine)
    return grids.to_lonlat(grids.scene_crs(scene.domain), *grid.mesh())[1]


@pytest.mark.parametrize("ends", ["missing", "cut off"])
@pytest.mark.parametrize("land", ["none", "mask"])
def test_a_pole_hole_of_smmr_is_neither_land_nor_water(
    tmp_path: Path, ends: str, land: str
) -> None:
    """84.5 N: 600 km from the pole, beyond the reach of filling."""
    data = lonlat()
    if ends == "missing":
        data["siconc"].values[data["lat"].values > 84.5] = np.nan
    else:
        data = data.sel(lat=slice(0.0, 84.5))
    data.to_netcdf(tmp_path / "ice.nc")
    made = mask.make_mask(scene_of(tmp_path / "ice.nc", land=land), None)
    np.testing.assert_allclose(made["siconc"], 0.9, rtol=1e-12)
    assert not made["land"].values.any()
    assert "the hole around the pole, north of 84." in made.attrs["notes"]


def test_missing_land_beside_the_hole_stays_land(tmp_path: Path) -> None:
    data = lonlat()
    data["siconc"].values[data["lat"].values > 87.2] = np.nan
    data["siconc"].values[np.ix_(data["lat"].values < 83.5, data["lon"].values > 300)] = np.nan
    data.to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc", land="mask", fill_reach=0.0)
    made, lat = mask.make_mask(scene, None), latitudes(scene)
    assert made["land"].values.any() and (lat[made["land"].values > 0] < 84).all()
    assert (made["siconc"].values[lat > 84] > 0.89).all()


def test_there_is_no_hole_at_the_south_pole(tmp_path: Path) -> None:
    data = lonlat()
    data = data.assign_coords(lat=-data["lat"].values)
    data["lat"].attrs["units"] = "degrees_north"
    data["siconc"].values[data["lat"].values < -84.5] = np.nan
    data.to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc", POLE | {"crs": "EPSG:6932"}, land="mask")
    made, lat = mask.make_mask(scene, None), latitudes(scene)
    assert made["land"].values[lat < -85.5].all() and not made["land"].values[lat > -83.5].any()


def test_flags_tell_land_hole_and_missing_apart(tmp_path: Path) -> None:
    """NSIDC-0051: bytes of 0.4 per cent, 251 pole hole, 252 unused, 253 coast, 254 land, 255."""
    raw = np.full((96, 96), 200, np.uint8)
    data = projected(
        raw,
        {
            "units": "1",
            "scale_factor": 0.004,
            "flag_values": np.array([251, 252, 253, 254, 255], np.uint8),
            "flag_meanings": "pole_hole_mask unused coast land missing",
        },
    )
    x, y = np.meshgrid(data["x"], data["y"])
    raw[np.hypot(x, y) < 3.1e5] = 251
    raw[x > 6e5], raw[x < -9e5], raw[(x > 5e5) & (x < 6e5)] = 254, 252, 253
    data["ice"].values[:] = raw
    data.to_netcdf(tmp_path / "ice.nc")
    made = mask.make_mask(scene_of(tmp_path / "ice.nc", land="mask", fill_reach=2e5), None)
    assert made["land"].values[:, made["x"].values > 5e5].all()
    assert not made["land"].values[:, made["x"].values < 5e5].any()
    np.testing.assert_allclose(made["siconc"].values[made["land"].values == 0], 0.8, rtol=1e-9)


def test_flags_without_attributes_are_refused_or_named_in_the_scene(tmp_path: Path) -> None:
    raw = np.full((96, 96), 125, np.uint8)
    raw[:, :30], raw[:10] = 252, 254
    data = projected(raw, {"units": "1", "scale_factor": 0.004})
    data.to_netcdf(tmp_path / "ice.nc")
    with pytest.raises(FloeError, match=r"reaches from 0.5 to 1.016 as a share.* mask.flags"):
        mask.make_mask(scene_of(tmp_path / "ice.nc"), None)
    flags = {"missing": (252,), "land": (254,)}
    made = mask.make_mask(scene_of(tmp_path / "ice.nc", flags=flags, land="mask"), None)
    assert made["land"].values[-1].all() and made["land"].values.mean() < 0.15
    assert float(made["siconc"].max()) == 0.5


@pytest.mark.parametrize("unit", ["km", "m"])
def test_a_projection_in_kilometres(tmp_path: Path, unit: str) -> None:
    """OSI-SAF and others: x in km and +units=km in the projection's text, or x without units."""
    values = np.zeros((96, 96))
    values[:, 48:] = 1.0  # ice where x > 0
    text = "+proj=laea +lat_0=90 +lon_0=0 +ellps=WGS84 +units=km"
    data = projected(values, {"units": "1"})
    data["crs"].attrs = {"proj4_string": text}
    for name in "xy":
        scale = 1e-3 if unit == "km" else 1.0
        attrs = data[name].attrs | {"units": unit}
        data = data.assign_coords({name: (name, data[name].values * scale, attrs)})
    data.to_netcdf(tmp_path / "ice.nc")
    made = mask.make_mask(scene_of(tmp_path / "ice.nc"), None)
    np.testing.assert_allclose(made["siconc"].values[:, made["x"].values > 0], 1.0)
    np.testing.assert_allclose(made["siconc"].values[:, made["x"].values < 0], 0.0)


@pytest.mark.parametrize("spacing", [2.5e4, 5e4, 1e5])
@pytest.mark.parametrize("shift", [0.0, 4e3])
def test_fine_data_are_meant_over_coarse_cells(
    tmp_path: Path, spacing: float, shift: float
) -> None:
    """12.5 km checkerboard: half ice, half water in every cell of 25 to 100 km."""
    row, column = np.indices((192, 192))
    data = projected(((row + column) % 2).astype(float), {"units": "1"}, 1.25e4)
    data = data.assign_coords(x=("x", data["x"].values + shift, data["x"].attrs))
    data.to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc", POLE | {"spacing": spacing})
    made = mask.make_mask(scene, None)
    np.testing.assert_allclose(made["siconc"], 0.5, atol=1e-9)


def test_area_means_keep_the_ice_area(tmp_path: Path) -> None:
    random = np.random.default_rng(4).random((160, 160))
    projected(random, {"units": "1"}, 1.25e4).to_netcdf(tmp_path / "ice.nc")
    made = mask.make_mask(scene_of(tmp_path / "ice.nc"), None)
    total = float((made["siconc"] * made["cell_area"]).sum())
    assert total == pytest.approx(random.sum() * 1.25e4**2, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "attrs", "kind"),
    [
        ("hi", {"long_name": "grid cell mean ice thickness"}, "cell_mean"),
        ("hice", {"standard_name": "sea_ice_thickness", "long_name": "average ice thickness in "
                  "cell"}, "cell_mean"),
        ("sivol", {"cell_methods": "area: mean where sea time: mean"}, "cell_mean"),
        ("sithick", {"cell_methods": "area: time: mean where sea_ice"}, "in_ice"),
        ("sithick", {"standard_name": "sea_ice_thickness"}, "in_ice"),
        ("h", {"standard_name": "sea_ice_thickness"}, ""),
        ("hi", {}, ""),
    ],
)  # fmt: skip
def test_volume_per_cell_is_no_thickness_of_ice(
    tmp_path: Path, name: str, attrs: dict[str, str], kind: str
) -> None:
    """Half of each cell is ice of 2 m, or the cell holds 2 m of ice in all."""
    data = lonlat()
    data["siconc"].values[:] = 0.5
    data[name] = (("lat", "lon"), np.full(data["siconc"].shape, 2.0), {"units": "m", **attrs})
    data.to_netcdf(tmp_path / "ice.nc")
    scene = scene_of(tmp_path / "ice.nc", thickness=name)
    if not kind:
        for read in (check_mask_file, lambda scene: mask.make_mask(scene, None)):
            with pytest.raises(FloeError, match=f"'{name}' does not tell .* mask.thickness_is"):
                read(scene)
        scene = scene_of(tmp_path / "ice.nc", thickness=name, thickness_is="cell_mean")
        kind = "cell_mean"
    made = mask.make_mask(scene, None)
    volume = float((made["siconc"] * made["sithick"] * made["cell_area"]).sum())
    per_area = {"cell_mean": 2.0, "in_ice": 1.0}[kind]
    assert volume == pytest.approx(per_area * float(made["cell_area"].sum()), rel=1e-9)


def dated(path: Path, day: str, how: str) -> None:
    data = lonlat()
    attrs = {"units": f"days since {day}", "standard_name": "time"}
    if how == "dimension":
        data = data.expand_dims(time=[0.0])
        data["time"].attrs = attrs
    elif how == "scalar":
        data = data.assign_coords(time=((), 0.0, attrs))
    else:
        data = data.expand_dims(time=[31.0])
        data["time"].attrs = attrs | {"bounds": "time_bnds"}
        data["time_bnds"] = (("time", "nv"), [[0.0, 31.0]])
    data.to_netcdf(path)


@pytest.mark.parametrize("how", ["dimension", "scalar"])
def test_a_mask_of_another_year_is_refused(tmp_path: Path, how: str) -> None:
    dated(tmp_path / "ice.nc", "2011-12-31", how)
    for read in (check_mask_file, lambda scene: mask.make_mask(scene, None)):
        with pytest.raises(FloeError, match="10957 days from the scene's start; mask.days_off all"):
            read(scene_of(tmp_path / "ice.nc"))
    mask.make_mask(scene_of(tmp_path / "ice.nc", days_off=11000.0), None)


def test_a_monthly_mean_holds_through_its_month(tmp_path: Path) -> None:
    dated(tmp_path / "ice.nc", "1981-12-01", "month")
    made = mask.make_mask(scene_of(tmp_path / "ice.nc", days_off=0.0), None)
    assert "0.0 days from the start" in made.attrs["notes"]


@pytest.mark.parametrize("packed", [False, True])
def test_units_of_per_cent_beside_small_values_are_told_or_refused(
    tmp_path: Path, packed: bool
) -> None:
    """OISST says percent and means shares; a map of at most 0.4 may be either."""
    data = lonlat()
    data["siconc"].attrs["units"] = "percent"
    for value, told in ((0.9, "no value is above 1: taken as shares"), (0.4, "")):
        data["siconc"].values[:] = value
        encoding = {"siconc": {"dtype": "i2", "scale_factor": 0.1, "_FillValue": -999}}
        path = tmp_path / f"{value}.nc"
        data.to_netcdf(path, encoding=encoding if packed else {})
        if told:
            made = mask.make_mask(scene_of(path), None)
            assert told in made.attrs["notes"]
            np.testing.assert_allclose(made["siconc"], value)
        else:
            with pytest.raises(
                FloeError, match="no value above 0.4: say in mask.scale whether 1 is"
            ):
                mask.make_mask(scene_of(path), None)
        for scale in (1.0, 0.01):
            made = mask.make_mask(scene_of(path, scale=scale), None)
            np.testing.assert_allclose(made["siconc"], scale * value)
