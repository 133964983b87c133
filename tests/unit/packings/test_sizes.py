# SPDX-License-Identifier: GPL-2.0-or-later
"""Sizes that vary by place: what the size function asks for is what the cells have."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from floeflow.core.errors import FloeError
from floeflow.core.grids import from_lonlat, scene_crs, to_lonlat
from floeflow.packings.elements import grid_of
from floeflow.packings.packing import make_packing
from floeflow.packings.sizes import relative_size, strait_width
from floeflow.scene.blocks import Domain, Packing, Sizes
from unit.packings.test_packing import SPACING, check_no_overlap, check_sums, mask_of, mobile


def bay():
    """Land in the west, open water in the east."""
    siconc = np.full((40, 60), 0.9)
    siconc[:, 55:] = 0.0
    land = np.zeros((40, 60), bool)
    land[:, :5] = True
    return mask_of(siconc, land)


def test_cells_are_as_large_as_asked_for() -> None:
    mask = bay()
    keys = Sizes(coast=0.3, edge=0.5, reach=1.0e6)
    made = make_packing(mask, Packing(elements=2000, size=keys), 1, False)
    check_sums(mask, made)
    check_no_overlap(made)
    grid = grid_of(mask)
    wanted = relative_size(grid, mask["siconc"].values > 0, mask["land"].values > 0, keys, 1e4, "")
    row, column = grid.cell_of(made["x"].values, made["y"].values)
    got = np.sqrt(made["area"].values / (mask["cell_area"].values[row, column] / SPACING**2))
    ratio = got / wanted[row, column]
    ratio /= np.median(ratio)
    # One size function from 0.3 to 1: a factor of 11 in area.
    for low, high in ((0.3, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 1.01)):
        there = (wanted[row, column] >= low) & (wanted[row, column] < high)
        assert there.sum() > 50
        assert np.median(ratio[there]) == pytest.approx(1.0, abs=0.06)
    assert ratio.std() < 0.2


def test_own_sizes_spread_as_asked_for() -> None:
    mask = bay()
    areas = {}
    for spread in (0.0, 0.3):
        made = make_packing(mask, Packing(elements=1500, size=Sizes(spread=spread)), 1, False)
        check_sums(mask, made)
        check_no_overlap(made)
        areas[spread] = np.log(np.sqrt(made["area"].values[mobile(made)])).std()
    assert areas[0.0] < 0.1
    assert areas[0.3] == pytest.approx(0.3, abs=0.07)


def test_straits_get_elements_across() -> None:
    land = np.zeros((40, 60), bool)
    land[:16, 20:40] = land[22:, 20:40] = True
    mask = mask_of(np.ones((40, 60)), land)
    width = strait_width(grid_of(mask), land)
    assert width[18:20, 28:32].max() <= 6 * SPACING * 1.3
    assert width[18:20, 28:32].min() >= 6 * SPACING / 1.7
    assert width[20, 5] > 10 * SPACING
    packing = Packing(elements=400, size=Sizes(across=5, smallest=0.2))
    made = make_packing(mask, packing, 1, False)
    check_sums(mask, made)
    grid = grid_of(mask)
    there = abs(made["x"].values - grid.x[30]) < 5 * SPACING
    across = 6 * SPACING / np.sqrt(made["area"].values[there])
    assert np.median(across) > 4


def polygon_file(path: Path, size: object) -> str:
    """A square of 600 km about a place in the ice."""
    crs = scene_crs(Domain())
    x0, y0 = 5.0e5, 1.0e6
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * 3.0e5 + [x0, y0]
    lon, lat = to_lonlat(crs, *corners.T)
    ring = np.stack([lon, lat], axis=1).tolist()
    feature = {
        "type": "Feature",
        "properties": {"size": size},
        "geometry": {"type": "Polygon", "coordinates": [ring]},
    }
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    x, y = from_lonlat(crs, lon, lat)
    np.testing.assert_allclose(np.stack([x, y], axis=1), corners, atol=1e-3)
    return str(path)


def test_a_polygon_says_how_fine(tmp_path: Path) -> None:
    mask = bay()
    keys = Sizes(polygons=polygon_file(tmp_path / "fine.json", 0.4), reach=2e5)
    made = make_packing(mask, Packing(elements=900, size=keys), 1, False)
    side = np.sqrt(made["area"].values)
    inside = (abs(made["x"].values - 5.0e5) < 2.5e5) & (abs(made["y"].values - 1.0e6) < 2.5e5)
    far = np.hypot(made["x"].values - 5.0e5, made["y"].values - 1.0e6) > 7e5
    assert np.median(side[inside]) / np.median(side[far]) == pytest.approx(0.4, abs=0.04)
    with pytest.raises(FloeError, match="needs a property 'size' above 0 and up to 1"):
        keys = Sizes(polygons=polygon_file(tmp_path / "bad.json", 3))
        make_packing(mask, Packing(size=keys), 1, False)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "not GeoJSON"),
        ('{"type": "Topology"}', "not GeoJSON of polygons"),
        ('{"type": "FeatureCollection", "features": []}', "holds no polygon"),
        (
            '{"type": "Feature", "geometry": {"type": "Point", "coordinates": [0, 80]}}',
            "is a Point",
        ),
        ('{"type": "Polygon", "coordinates": [[[0, 80], [1, "x"], [1, 81], [0, 80]]]}', "coordin"),
        ('{"type": "Polygon", "coordinates": [[[4e5, 1e6], [5e5, 1e6], [5e5, 2e6]]]}', "coordin"),
    ],
)
def test_what_is_no_polygon_is_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "fine.json"
    path.write_text(text)
    with pytest.raises(FloeError, match=said):
        make_packing(bay(), Packing(size=Sizes(polygons=str(path))), 1, False)


def test_no_file_of_polygons_is_said() -> None:
    with pytest.raises(FloeError, match="^no/such.json: cannot be read"):
        make_packing(bay(), Packing(size=Sizes(polygons="no/such.json")), 1, False)
