# SPDX-License-Identifier: GPL-2.0-or-later
"""Labelled images: read where they lie, whichever way they are written; refused in one sentence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
import xarray as xr
from PIL import Image
from rasterio.transform import Affine, from_origin

from floeflow.core.errors import FloeError
from floeflow.core.grids import mask_grid
from floeflow.masks.floe_mask import floe_mask
from floeflow.masks.labels import read_labels
from floeflow.scene.blocks import Domain, Labels

DOMAIN = Domain(
    crs="EPSG:3413", x_min=-1.6e6, x_max=-1.59e6, y_min=2.0e5, y_max=2.1e5, spacing=5000.0
)
PIXEL = 500.0


def numbers() -> np.ndarray:
    """North up, 30 by 30 pixels from 1 km west and north of the scene's corner."""
    made = np.zeros((30, 30), np.uint16)
    made[5:12, 6:20] = 4
    made[12:25, 6:14] = 300
    return made


def tiff(path: Path, values: np.ndarray, **changes: Any) -> Labels:
    place = from_origin(DOMAIN.x_min - 2 * PIXEL, DOMAIN.y_max + 2 * PIXEL, PIXEL, PIXEL)
    bands = values if values.ndim == 3 else values[None]
    keys = {"crs": "EPSG:3413", "transform": place} | changes
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=bands.shape[2],
        height=bands.shape[1],
        count=bands.shape[0],
        dtype=bands.dtype,
        **keys,
    ) as image:
        image.write(bands)
    return Labels(file=str(path))


def netcdf(path: Path, values: np.ndarray, south_up: bool, crs: bool = True) -> Labels:
    x = DOMAIN.x_min + PIXEL * (np.arange(30) - 1.5)
    y = DOMAIN.y_max - PIXEL * (np.arange(30) - 1.5)
    order = slice(None, None, -1 if south_up else 1)
    attrs = {"grid_mapping": "grid"} if crs else {}
    data = xr.Dataset(
        {"floe": (("y", "x"), values[order].astype(np.int32), attrs), "grid": ((), 0)},
        coords={
            "x": ("x", x / 1000, {"standard_name": "projection_x_coordinate", "units": "km"}),
            "y": (
                "y",
                y[order] / 1000,
                {"standard_name": "projection_y_coordinate", "units": "km"},
            ),
        },
    )
    data["grid"].attrs["crs_wkt"] = rasterio.crs.CRS.from_epsg(3413).to_wkt()
    data.to_netcdf(path)
    return Labels(file=str(path))


def check(labels: Labels) -> None:
    """The scene's 20 by 20 pixels, south first."""
    found = read_labels(labels, DOMAIN)
    np.testing.assert_array_equal(found.numbers, numbers()[2:22, 2:22][::-1])
    assert found.grid.x_edges[0] == pytest.approx(DOMAIN.x_min)
    assert found.grid.y_edges[-1] == pytest.approx(DOMAIN.y_max)


def test_geotiff_in_the_scenes_projection(tmp_path: Path) -> None:
    check(tiff(tmp_path / "floes.tif", numbers()))


def test_geotiff_with_rows_from_south_to_north(tmp_path: Path) -> None:
    place = Affine(PIXEL, 0, DOMAIN.x_min - 1000, 0, PIXEL, DOMAIN.y_max + 1000 - 30 * PIXEL)
    check(tiff(tmp_path / "floes.tif", numbers()[::-1].copy(), transform=place))


@pytest.mark.parametrize("south_up", [False, True])
def test_netcdf_either_way_up_in_kilometres(tmp_path: Path, south_up: bool) -> None:
    check(netcdf(tmp_path / "floes.nc", numbers(), south_up))


def test_png_takes_the_scenes_corner_and_the_keys_pixel(tmp_path: Path) -> None:
    path = tmp_path / "floes.png"
    Image.fromarray(numbers()[2:22, 2:22]).save(path)
    check(Labels(file=str(path), pixel=PIXEL))


def test_another_projection_is_brought_to_the_scenes(tmp_path: Path) -> None:
    """The same pixels turned by 45 degrees: areas stay, to the pixels of the rim."""
    from rasterio.warp import Resampling, calculate_default_transform, reproject

    big = np.kron(numbers(), np.ones((8, 8), np.uint16))
    place = from_origin(DOMAIN.x_min - 1000, DOMAIN.y_max + 1000, PIXEL / 8, PIXEL / 8)
    bounds = (DOMAIN.x_min - 1000, DOMAIN.y_max + 1000 - 15000, DOMAIN.x_min + 14000)
    other, width, height = calculate_default_transform(
        "EPSG:3413", "EPSG:5939", 240, 240, *bounds, DOMAIN.y_max + 1000
    )
    turned = np.zeros((height, width), np.uint16)
    reproject(
        big, turned, src_transform=place, src_crs="EPSG:3413", dst_transform=other,
        dst_crs="EPSG:5939", resampling=Resampling.nearest,
    )  # fmt: skip
    labels = tiff(tmp_path / "floes.tif", turned, crs="EPSG:5939", transform=other)
    found = read_labels(labels, DOMAIN)
    for number in (4, 300):
        area = (found.numbers == number).sum() * found.grid.spacing**2
        wanted = (numbers()[2:22, 2:22] == number).sum() * PIXEL**2
        assert area == pytest.approx(wanted, rel=0.02)


def test_the_mask_holds_the_pixels_areas(tmp_path: Path) -> None:
    found = read_labels(tiff(tmp_path / "floes.tif", numbers()), DOMAIN)
    grid = mask_grid(DOMAIN, 3)
    siconc, pixels = floe_mask(found, grid, np.zeros(grid.shape, bool))
    covered = siconc.sum() * grid.spacing**2
    assert covered == pytest.approx((numbers()[2:22, 2:22] > 0).sum() * PIXEL**2, rel=1e-12)
    assert pixels["floe"].values.max() == 300


def refused(labels: Labels, *words: str) -> None:
    with pytest.raises(FloeError) as caught:
        read_labels(labels, DOMAIN)
    text = str(caught.value)
    assert "\n" not in text and all(word in text for word in (*words, "floes"))


def test_what_is_no_labelled_image_is_refused(tmp_path: Path) -> None:
    path, values = tmp_path / "floes.tif", numbers()
    refused(Labels(file=str(tmp_path / "floes.tif")), "no such file", "mask.labels.file")
    path.write_bytes(b"II*\x00 not a picture")
    refused(Labels(file=str(path)), "cannot be read as an image")
    path.unlink()
    refused(tiff(path, np.stack([values] * 3)), "3 bands")
    refused(tiff(path, values.astype(np.float32) + 0.25), "not whole")
    refused(tiff(path, values.astype(np.int16) - 5), "-5")
    refused(tiff(path, values, crs=None), "mask.labels.crs")
    refused(tiff(path, values, transform=Affine.identity()), "mask.labels.pixel")
    refused(tiff(path, values, transform=from_origin(0, 0, PIXEL, PIXEL)), "outside of the scene")
    place = from_origin(DOMAIN.x_min - 1000, DOMAIN.y_max + 1000, PIXEL, 2 * PIXEL)
    refused(tiff(path, values, transform=place), "square")
    turned = from_origin(DOMAIN.x_min, DOMAIN.y_max, PIXEL, PIXEL) * Affine.rotation(20)
    refused(tiff(path, values, transform=turned), "turned")
    refused(netcdf(tmp_path / "floes.nc", values, True, crs=False), "grid_mapping")


def test_more_pixels_than_memory_holds_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("floeflow.masks.labels.MOST_PIXELS", 300)
    refused(tiff(tmp_path / "floes.tif", numbers()), "400 pixels", "smaller domain")


def test_nothing_and_missing_values_are_water(tmp_path: Path) -> None:
    path = tmp_path / "floes.tif"
    assert not read_labels(tiff(path, 0 * numbers()), DOMAIN).numbers.any()
    values = np.where(numbers() == 4, np.nan, numbers().astype(np.float32))
    found = read_labels(tiff(path, values), DOMAIN).numbers
    assert set(np.unique(found)) == {0, 300}
    found = read_labels(tiff(path, numbers(), nodata=300), DOMAIN).numbers
    assert set(np.unique(found)) == {0, 4}
