# SPDX-License-Identifier: GPL-2.0-or-later
"""One field in every format of file gives one mask; formats without their library say so."""

from __future__ import annotations

import builtins
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.core.input_files import open_input
from floeflow.masks import mask
from floeflow.masks.mask_file import check_mask_file
from floeflow.scene.blocks import Scene

DOMAIN = {"x_min": -5e5, "x_max": 5e5, "y_min": -5e5, "y_max": 5e5, "spacing": 1e5}
CELLS, CELL = 60, 2.5e4


def scene_of(path: Path, **block: Any) -> Scene:
    values = {"file": str(path), "land": "none", "minimum_concentration": 0.0, "refine": 1, **block}
    return Scene.model_validate({"name": "t", "domain": DOMAIN, "mask": values})


def counts() -> np.ndarray:
    """Whole per cent, rows from the top: ice grows with x, water in the lower half."""
    values = np.zeros((CELLS, CELLS), np.uint8)
    values[: CELLS // 2] = np.arange(CELLS)
    return values


def right(scene: Scene) -> np.ndarray:
    x = np.arange(-4.5e5, 5e5, 1e5)
    columns = (x + CELLS * CELL / 2) / CELL - 0.5
    ice = np.zeros((10, 10))
    ice[5:] = columns / 100.0
    return ice


def axes() -> tuple[np.ndarray, np.ndarray]:
    x = -CELLS * CELL / 2 + CELL * (np.arange(CELLS) + 0.5)
    return x, x[::-1]


def dataset() -> xr.Dataset:
    x, y = axes()
    attrs = {"standard_name": "sea_ice_area_fraction", "units": "%", "grid_mapping": "crs"}
    data = xr.Dataset(
        {"ice": (("y", "x"), counts(), attrs), "crs": ((), 0, pyproj.CRS("EPSG:6931").to_cf())},
        {
            "x": ("x", x, {"standard_name": "projection_x_coordinate", "units": "m"}),
            "y": ("y", y, {"standard_name": "projection_y_coordinate", "units": "m"}),
        },
    )
    return data


def as_zarr(folder: Path) -> tuple[Path, dict[str, Any]]:
    dataset().to_zarr(folder / "ice.zarr", consolidated=False)
    return folder / "ice.zarr", {}


def as_geotiff(folder: Path) -> tuple[Path, dict[str, Any]]:
    rasterio = pytest.importorskip("rasterio")
    edge = CELLS * CELL / 2
    place = rasterio.transform.from_origin(-edge, edge, CELL, CELL)
    shape = {"width": CELLS, "height": CELLS, "count": 1, "dtype": "uint8"}
    path = folder / "ice.tif"
    with rasterio.open(path, "w", "GTiff", crs="EPSG:6931", transform=place, **shape) as file:
        file.write(counts(), 1)
        file.units = ["%"]
    return path, {}


def as_png(folder: Path) -> tuple[Path, dict[str, Any]]:
    image = pytest.importorskip("PIL.Image")
    image.fromarray(counts()).save(folder / "ice.png")
    first = -CELLS * CELL / 2 + CELL / 2
    (folder / "ice.pgw").write_text(f"{CELL}\n0\n0\n{-CELL}\n{first}\n{-first}\n")
    return folder / "ice.png", {"scale": 0.01, "crs": "EPSG:6931"}


def without_mapping(folder: Path) -> tuple[Path, dict[str, Any]]:
    data = dataset().drop_vars("crs")
    del data["ice"].attrs["grid_mapping"]
    for axis in "xy":
        data[axis].attrs = {}
    data.to_netcdf(folder / "ice.nc")
    return folder / "ice.nc", {"crs": "EPSG:6931"}


@pytest.mark.parametrize("write", [as_zarr, as_geotiff, as_png, without_mapping])
def test_every_format_gives_the_same_mask(
    tmp_path: Path, write: Callable[[Path], tuple[Path, dict[str, Any]]]
) -> None:
    path, block = write(tmp_path)
    scene = scene_of(path, **block)
    check_mask_file(scene)
    np.testing.assert_allclose(mask.make_mask(scene, None)["siconc"], right(scene), atol=1e-9)


@pytest.mark.parametrize("header", [True, False])
def test_nsidc_binary(tmp_path: Path, header: bool) -> None:
    """NSIDC-0051: Arctic, 448 x 304 bytes behind 300 of header; 251 pole hole, 254 land."""
    raw = np.full((448, 304), 200, np.uint8)
    raw[:, :100] = 254
    rows, columns = np.indices(raw.shape)
    x, y = -3.85e6 + 2.5e4 * (columns + 0.5), 5.85e6 - 2.5e4 * (rows + 0.5)
    raw[np.hypot(x, y) < 3.1e5] = 251
    text = bytearray(b"\0" * 300)
    fields = {0: "00255", 6: " 304", 12: " 448", 102: " 1981", 108: "  365"}
    for at, value in fields.items():
        text[at : at + len(value)] = value.encode()
    path = tmp_path / ("nt_19811231_n07_v1.1_n.bin" if not header else "ice.bin")
    path.write_bytes((bytes(text) if header else b"") + raw.tobytes())
    made = mask.make_mask(scene_of(path, land="mask"), None)
    assert "0.5 days from the start" in made.attrs["notes"]
    assert "the hole around the pole, north of 87.2 N" in made.attrs["notes"]
    np.testing.assert_allclose(made["siconc"], 0.8, rtol=1e-9)
    with open_input(path) as data:
        assert data["x"].values[0] == -3837500.0 and data["y"].values[0] == 5837500.0


def test_nsidc_header_of_another_grid(tmp_path: Path) -> None:
    text = b"00255\0  316\0  332\0".ljust(300, b"\0")
    (tmp_path / "ice.bin").write_bytes(text + bytes(448 * 304))
    with pytest.raises(FloeError, match="its header tells of 332 rows and 316 columns"):
        check_mask_file(scene_of(tmp_path / "ice.bin"))


def test_a_real_nsidc_file(shared: Path) -> None:
    """Ice area of the scene against the product's own numbers and cell areas."""
    path = shared / "data/nt_20150201_f17_v1.1_n.bin"
    domain = {"x_min": -6e6, "x_max": 6e6, "y_min": -6e6, "y_max": 6e6, "spacing": 1e5}
    values = {"file": str(path), "land": "mask", "minimum_concentration": 0.0}
    scene = Scene.model_validate(
        {"name": "t", "domain": domain, "mask": values, "time": {"start": "2015-02-01"}}
    )
    made = mask.make_mask(scene, None)
    raw = np.fromfile(path, np.uint8)[300:].reshape(448, 304)
    area = np.fromfile(shared / "data/psn25area_v3.dat", "<i4").reshape(448, 304) * 1e3
    known = raw <= 250
    own = float((raw / 250.0 * area)[known].sum())
    hole = float(area[raw == 251].sum())
    total = float((made["siconc"] * made["cell_area"]).sum())
    assert total - 0.98 * hole == pytest.approx(own, rel=0.03)


def test_grib(tmp_path: Path) -> None:
    """Ice in GRIB, on longitude and latitude, written by ecCodes."""
    eccodes = pytest.importorskip("eccodes")
    handle = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib2")
    lat, lon = np.arange(90.0, 59.0, -1.0), np.arange(0.0, 360.0, 1.0)
    keys = {"Ni": lon.size, "Nj": lat.size, "latitudeOfFirstGridPointInDegrees": 90.0,
            "latitudeOfLastGridPointInDegrees": 60.0, "longitudeOfFirstGridPointInDegrees": 0.0,
            "longitudeOfLastGridPointInDegrees": 359.0, "iDirectionIncrementInDegrees": 1.0,
            "jDirectionIncrementInDegrees": 1.0, "dataDate": 19811231, "dataTime": 0,
            "paramId": 31}  # fmt: skip
    for key, value in keys.items():
        eccodes.codes_set(handle, key, value)
    values = np.clip((lat[:, None] - 80.0) / 10.0, 0.0, 1.0) + 0.0 * lon
    eccodes.codes_set_values(handle, values.ravel())
    with (tmp_path / "ice.grib").open("wb") as file:
        eccodes.codes_write(handle, file)
    eccodes.codes_release(handle)
    scene = scene_of(tmp_path / "ice.grib", concentration="siconc")
    check_mask_file(scene)
    found = mask.make_mask(scene, None)["siconc"].values
    x, y = np.meshgrid(np.arange(-4.5e5, 5e5, 1e5), np.arange(-4.5e5, 5e5, 1e5))
    from floeflow.core import grids

    _, latitude = grids.to_lonlat(pyproj.CRS("EPSG:6931"), x, y)
    expected = np.clip((latitude - 80.0) / 10.0, 0.0, 1.0)
    assert np.abs(found - expected).max() < 0.02
    assert list(tmp_path.iterdir()) == [tmp_path / "ice.grib"]  # no index is left behind


@pytest.mark.parametrize(
    ("name", "content", "library", "sentence"),
    [
        ("ice.tif", b"II*\0", "rasterio", "is a GeoTIFF, which needs the package rasterio"),
        ("ice.grib", b"GRIB", "cfgrib", "is a GRIB file, which needs the package cfgrib"),
        ("ice.zarr.zip", b"PK", "zarr", "is a Zarr store, which needs the package zarr"),
    ],
)
def test_formats_without_their_library(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    content: bytes,
    library: str,
    sentence: str,
) -> None:
    (tmp_path / name).write_bytes(content)
    whole = builtins.__import__

    def without(module: str, *rest: Any, **more: Any) -> Any:
        if module.split(".")[0] == library:
            raise ImportError(library)
        return whole(module, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(FloeError, match=sentence):
        open_input(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("ice.tif", b"II*\0junk", "cannot be read as GeoTIFF"),
        ("ice.png", b"\x89PNG junk", "cannot be read as PNG"),
        ("ice.grib", b"GRIBjunkjunk", "cannot be read as GRIB|holds no GRIB message"),
        ("ice.zarr.zip", b"PK junk", "cannot be read as Zarr"),
        ("ice.nc", b"junk", "cannot be read as NetCDF"),
    ],
)
def test_damaged_files(tmp_path: Path, name: str, content: bytes, sentence: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FloeError, match=f"{name}: .*{sentence}|{name}: ({sentence})"):
        open_input(tmp_path / name)


def test_pictures_that_cannot_be_a_mask(tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    image.fromarray(np.zeros((4, 4, 3), np.uint8)).save(tmp_path / "colour.png")
    with pytest.raises(FloeError, match="is a picture in colours"):
        open_input(tmp_path / "colour.png")
    image.fromarray(np.zeros((4, 4), np.uint8)).save(tmp_path / "grey.png")
    with pytest.raises(FloeError, match=r"has no world file \(grey.pgw\)"):
        open_input(tmp_path / "grey.png")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FloeError, match="is a folder, and no Zarr store"):
        open_input(tmp_path / "empty")
