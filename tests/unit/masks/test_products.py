# SPDX-License-Identifier: GPL-2.0-or-later
"""Masks, land, areas and currents against what real products say of themselves."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.core import grids, vectors
from floeflow.forcings import forcing
from floeflow.masks import land, mask
from floeflow.scene.blocks import Scene
from unit.masks.test_mask import scene_of


def test_areas_are_true_on_a_conformal_projection() -> None:
    domain = Scene.model_validate(
        {"name": "t", "domain": {"crs": "EPSG:3413", "x_min": -2e6, "x_max": 2e6, "y_min": -2e6,
                                 "y_max": 2e6, "spacing": 2.0e4}}
    ).domain  # fmt: skip
    grid, crs = grids.scene_grid(domain), grids.scene_crs(domain)
    area = grids.cell_area(grid, crs)
    _, lat = grids.to_lonlat(crs, *grid.mesh())
    ring = pyproj.Geod(ellps="WGS84").polygon_area_perimeter(np.arange(0, 360, 0.1), [75.0] * 3600)
    cap = area[lat > 75].sum()
    assert cap == pytest.approx(abs(ring[0]), rel=2e-3)
    plane = grid.spacing**2 * (lat > 75).sum()
    assert abs(plane / abs(ring[0]) - 1) > 0.01


def test_land_share_of_known_places() -> None:
    """Greenland's ice sheet is land, the North Pole is not, and a coast is in between."""
    domain = Scene.model_validate(
        {"name": "t", "domain": {"x_min": -1.5e6, "x_max": 0.5e6, "y_min": -2e6, "y_max": 0.4e6,
                                 "spacing": 2e5}}
    ).domain  # fmt: skip
    grid, crs = grids.scene_grid(domain), grids.scene_crs(domain)
    share, _ = land.land_samples(grid, crs)
    row, column = grid.cell_of(*grids.from_lonlat(crs, np.array([-40.0, 0.0]), np.array([75, 90])))
    assert list(share[row, column]) == [1.0, 0.0]
    assert ((share > 0) & (share < 1)).any()


def test_metno_mask_has_the_files_ice(shared: Path) -> None:
    """Projected on a sphere, packed, five days, thickness: totals agree with the file's own."""
    path = shared / "data/metno_arctic20_2016-02-01_05.nc"
    domain = {"x_min": -1.5e6, "x_max": 2.5e6, "y_min": -4.0e6, "y_max": 1.0e6, "spacing": 1.0e5}
    scene = Scene.model_validate(
        {
            "name": "test",
            "domain": domain,
            "mask": {"file": str(path), "land": "none", "minimum_concentration": 0.0,
                     "thickness": "hice", "refine": 5, "fill_reach": 0.0},
            "time": {"start": "2016-02-03T00:00:00"},
        }
    )  # fmt: skip
    made = mask.make_mask(scene, None)
    total = float((made["siconc"] * made["cell_area"]).sum())
    with netCDF4.Dataset(path) as file:
        ice = np.ma.filled(file["aice"][1], 0.0)
        lat = np.radians(file["latitude"][:])
    # Scale of a polar stereographic projection of a sphere, true at 60 N.
    scale = (1 + np.sin(np.radians(60))) / (1 + np.sin(lat))
    own = float((np.clip(ice, 0, 1) * (2.0e4 / scale) ** 2).sum())
    assert total == pytest.approx(own, rel=0.02)
    assert 0.3 < float(made["sithick"].max()) < 10
    # Its thickness is ice volume over the cell's area, as its long name tells.
    volume = float((made["siconc"] * made["sithick"] * made["cell_area"]).sum())
    with netCDF4.Dataset(path) as file:
        deep = np.ma.filled(file["hice"][1], 0.0)
    assert volume == pytest.approx(float((deep * (2.0e4 / scale) ** 2).sum()), rel=0.02)


def test_nsidc_mask_has_the_products_ice_area(shared: Path, tmp_path: Path) -> None:
    """25 km polar stereographic on the Hughes ellipsoid, against the product's own cell areas."""
    raw = np.fromfile(shared / "data/nt_20150201_f17_v1.1_n.bin", dtype=np.uint8)[300:]
    ice = raw.reshape(448, 304).astype(float) / 2.5
    hole = ice == 251 / 2.5
    ice[ice > 100] = np.nan
    area = np.fromfile(shared / "data/psn25area_v3.dat", dtype="<i4").reshape(448, 304) * 1e3
    attrs = {"standard_name": "sea_ice_area_fraction", "units": "%", "grid_mapping": "crs"}
    data = xr.Dataset(
        {"ice": (("y", "x"), ice, attrs), "crs": ((), 0, pyproj.CRS("EPSG:3411").to_cf())},
        coords={
            "x": ("x", -3850e3 + 25e3 * (np.arange(304) + 0.5)),
            "y": ("y", 5850e3 - 25e3 * (np.arange(448) + 0.5)),
        },
    )
    for axis in "xy":
        data[axis].attrs = {"standard_name": f"projection_{axis}_coordinate", "units": "m"}
    data.to_netcdf(tmp_path / "ice.nc", encoding={"ice": {"_FillValue": -1.0}})
    domain = {"x_min": -6e6, "x_max": 6e6, "y_min": -6e6, "y_max": 6e6, "spacing": 1e5}
    scene = scene_of(tmp_path / "ice.nc", domain, land="mask", land_fraction=0.5)
    made = mask.make_mask(scene, None)
    lon, lat = grids.to_lonlat(grids.scene_crs(scene.domain), *grids.mask_grid(
        scene.domain, scene.mask.refine).mesh())  # fmt: skip
    total = float((made["siconc"] * made["cell_area"]).values[lat < 85].sum())
    product_lat = np.fromfile(shared / "data/psn25lats_v3.dat", dtype="<i4").reshape(448, 304) / 1e5
    known = np.isfinite(ice) & ~hole & (product_lat < 85)
    own = float((ice / 100 * area)[known].sum())
    assert total == pytest.approx(own, rel=0.05)


def test_metno_current_along_its_grid(shared: Path) -> None:
    """Components along a rotated projected grid, 17 levels, packed, missing on land."""
    path = shared / "data/metno_arctic20_2016-02-01_05.nc"
    with netCDF4.Dataset(path) as file:
        lat, lon = file["latitude"][:], file["longitude"][:]
        u, v = file["u"][2, 0], file["v"][2, 0]
        stamp = netCDF4.num2date(file["time"][2], file["time"].units)
    crs = pyproj.CRS("EPSG:6931")
    px, py = grids.from_lonlat(crs, lon.filled(), lat.filled())
    jj, ii = 20, 30
    x0, y0 = 1e5 * round(px[jj, ii] / 1e5), 1e5 * round(py[jj, ii] / 1e5)
    domain = {"x_min": x0 - 2e5, "x_max": x0 + 2e5, "y_min": y0 - 2e5, "y_max": y0 + 2e5,
              "spacing": 2e4}  # fmt: skip
    start = stamp.strftime("%Y-%m-%dT%H:%M:%S")
    scene = Scene.model_validate(
        {
            "name": "t",
            "domain": domain,
            "effects": ("ocean_drag",),
            "time": {"start": start, "windows": 1},
        }
    )
    made = forcing.make_forcing(scene, path, 1)
    # The file's x axis on the scene's map, from its own latitudes and longitudes.
    turn = np.arctan2(py[:, 1:] - py[:, :-1], px[:, 1:] - px[:, :-1])[jj, ii]
    rows, columns = slice(jj - 4, jj + 5), slice(ii - 4, ii + 5)
    inside = (np.abs(made["x"] - px[jj, ii]) < 8e4) & (np.abs(made["y"] - py[jj, ii]) < 8e4)
    mine = [float(made[name][0].where(inside).mean()) for name in ("ocean_u", "ocean_v")]
    own = vectors.rotate(u[rows, columns].mean(), v[rows, columns].mean(), turn)
    assert np.hypot(*own) > 0.005
    assert np.hypot(mine[0] - own[0], mine[1] - own[1]) < 0.25 * np.hypot(*own)
