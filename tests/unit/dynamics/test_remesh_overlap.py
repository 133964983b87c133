# SPDX-License-Identifier: GPL-2.0-or-later
"""What polygons share, and the cells of the sea."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from floeflow.dynamics.remesh.overlap import carried_polygons, covered, make_pieces, overlap
from floeflow.packings import fresh_cells as cells
from floeflow.packings import packing
from floeflow.scene.blocks import Packing
from floeflow.state.cells import read_cells
from floeflow.state.schema import COAST, MOBILE
from unit.packings.test_packing import coastline


def hull(random: np.random.Generator, corners: int) -> shapely.Polygon:
    """A convex polygon."""
    while True:
        found = shapely.convex_hull(shapely.multipoints(random.normal(size=(corners, 2))))
        if found.geom_type == "Polygon" and found.area > 1e-3:
            return found


def bent(random: np.random.Generator, corners: int) -> shapely.Polygon:
    """A star-shaped polygon with corners that turn inwards."""
    angle = np.sort(random.uniform(0, 2 * np.pi, corners) + np.arange(corners) * 1e-3)
    reach = random.uniform(0.3, 2.0, corners)
    found = shapely.Polygon(np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=1))
    return found if found.is_valid and found.area > 1e-3 else hull(random, corners + 3)


@given(st.integers(0, 10**6), st.sampled_from([0.0, 1e7]))
@settings(max_examples=40)
def test_shared_areas_and_centres_are_those_of_geos(seed: int, far: float) -> None:
    random = np.random.default_rng(seed)
    make = [hull, bent]
    one, two = (
        np.array([make[random.integers(2)](random, random.integers(4, 9)) for _ in range(6)])
        for _ in range(2)
    )
    one, two = (shapely.transform(p, lambda xy: xy * 1e4 + far) for p in (one, two))
    one, two = shapely.orient_polygons(one), shapely.orient_polygons(two)
    source, target, area, centre = overlap(one, two)
    right = shapely.intersection(one[source], two[target], grid_size=1e-6)
    np.testing.assert_allclose(area, shapely.area(right), rtol=1e-7, atol=1e-2)
    whole = shapely.area(right) > 1e4
    middle = shapely.get_coordinates(shapely.centroid(right[whole]))
    np.testing.assert_allclose(centre[whole], middle, atol=1e-2)
    missing = shapely.area(shapely.intersection(one[:, None], two[None, :])).sum() - area.sum()
    assert abs(missing) < 1e-7 * (shapely.area(one).sum() + shapely.area(two).sum()) + 1.0


def test_a_shared_side_is_no_overlap() -> None:
    # GEOS 3.14 gives the whole first polygon.
    first = shapely.Polygon(
        [(-121618.04194630578, 340832.80025976733), (-129431.87535675082, 250000),
         (-3791.186570644175, 250000), (-9644.067498671531, 360963.34652912617),
         (-22658.608159158903, 368160.0493101359)]
    )  # fmt: skip
    second = shapely.Polygon(
        [(-9644.067498671531, 360963.34652912617), (-3791.1865706441745, 250000), (100000, 250000),
         (126964.64145640802, 259036.2155802822), (125572.31187982496, 319730.0486048814),
         (49780.326740370656, 377380.74767900916)]
    )  # fmt: skip
    both = np.array([first, second])
    source, target, area, _ = overlap(both, both)
    assert source.tolist() == target.tolist() == [0, 1]
    np.testing.assert_allclose(area, shapely.area(both), rtol=1e-12)


def test_slices_of_the_old_cells_give_the_same_rows() -> None:
    random = np.random.default_rng(8)
    old = shapely.orient_polygons(np.array([hull(random, 7) for _ in range(30)]))
    new = shapely.orient_polygons(np.array([hull(random, 7) for _ in range(20)]))
    whole = overlap(old, new)
    parts = [overlap(old[a:b], new) for a, b in ((0, 11), (11, 30))]
    np.testing.assert_array_equal(np.append(parts[0][0], parts[1][0] + 11), whole[0])
    for k in (1, 2, 3):
        np.testing.assert_array_equal(np.concatenate([p[k] for p in parts]), whole[k])


def test_old_cells_are_carried_turned_and_scaled() -> None:
    square = np.array([[1.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.0, 2.0]])
    place, theta = np.array([[10.0, 20.0]]), np.array([np.pi / 2])
    found = carried_polygons(np.array([0, 4]), square, place, theta, np.array([16.0]))[0]
    # The centre (2, 1) is turned to (-1, 2) and the sides are doubled.
    assert found.equals(shapely.box(7.0, 20.0, 11.0, 24.0)) or found.area == pytest.approx(16.0)
    np.testing.assert_allclose(found.centroid.coords[0], (9.0, 22.0))


def test_pieces_add_up_to_the_effective_area() -> None:
    old = np.array([shapely.box(0, 0, 2, 2), shapely.box(9, 9, 10, 10), shapely.box(1, 1, 3, 2)])
    new = np.array([shapely.box(0, 0, 1, 2), shapely.box(1, 0, 2, 1)])
    pairs = overlap(old, new)
    np.testing.assert_allclose(covered(pairs[0], pairs[2], old), [0.75, 0.0, 0.0])
    pieces = make_pieces(pairs, np.array([0]), np.array([30.0]), 2)
    np.testing.assert_allclose(pieces.area, [20.0, 10.0])
    assert pieces.matrix().shape == (1, 2)


@pytest.fixture(scope="module")
def sea() -> tuple[xr.Dataset, xr.Dataset, xr.Dataset]:
    mask = coastline()
    packed = packing.make_packing(mask, Packing(elements=150), 7)
    return mask, packed, cells.make_cells(mask, packed, 7)


def test_cells_tile_the_sea_and_keep_the_packing(sea: tuple) -> None:
    mask, packed, data = sea
    found = read_cells(data)
    reached = cells.reachable(
        packing.grid_of(mask), mask["siconc"].values > 0, mask["land"].values > 0
    )
    assert found.area.sum() == pytest.approx(mask["cell_area"].values[reached].sum(), rel=1e-12)
    assert (np.diff(found.id) > 0).all() and shapely.is_valid(found.polygons).all()
    mobile = packed["type"].values == MOBILE
    count = mobile.sum()
    assert len(found.id) > count
    np.testing.assert_array_equal(found.id[:count], packed["id"].values[mobile])
    np.testing.assert_array_equal(found.radius[:count], packed["radius"].values[mobile])
    assert found.id[count] == packed["id"].values[-1] + 1
    pair = overlap(found.polygons, found.polygons)
    assert (pair[0] == pair[1]).all()


def test_discs_of_cells_overlap_with_none_and_not_with_the_coast(sea: tuple) -> None:
    _, packed, data = sea
    coast = packed["type"].values == COAST
    places = np.concatenate(
        [np.stack([d["x"], d["y"]], axis=1) for d in (data, packed.isel(element=coast))]
    )
    radius = np.append(data["radius"].values, packed["radius"].values[coast])
    pairs = cKDTree(places).query_pairs(2 * radius.max(), output_type="ndarray")
    mobile = (pairs < data.sizes["element"]).any(axis=1)
    apart = np.hypot(*(places[pairs[:, 1]] - places[pairs[:, 0]]).T)
    assert (apart - radius[pairs].sum(axis=1))[mobile].min() >= 0.0


def test_a_sea_without_ice_has_no_cells() -> None:
    mask = coastline()
    mask["siconc"][:] = 0.0
    packed = packing.make_packing(mask, Packing(elements=150), 7)
    assert len(read_cells(cells.make_cells(mask, packed, 7)).id) == 0
