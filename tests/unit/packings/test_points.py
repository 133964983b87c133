# SPDX-License-Identifier: GPL-2.0-or-later
"""The parts of the packing, each on a case with a known answer."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from floeflow.core.grids import Grid
from floeflow.packings import discs, packing, points, tessellation
from floeflow.scene.blocks import Packing
from floeflow.state.files import checksum
from unit.packings.test_packing import coastline, mobile


@pytest.fixture(scope="module")
def packed() -> xr.Dataset:
    return packing.make_packing(coastline(), Packing(elements=300), 7)


def test_hilbert_curve_visits_neighbours() -> None:
    side = 32
    x, y = (part.ravel() + 0.5 for part in np.meshgrid(np.arange(side), np.arange(side)))
    order = np.argsort(points.hilbert_key(x, y, 0.0, 0.0, float(side)))
    step = np.abs(np.diff(x[order])) + np.abs(np.diff(y[order]))
    assert (step == 1).all()


def test_thinning_is_a_largest_set_apart() -> None:
    rng = np.random.default_rng(3)
    cloud = rng.random((500, 2))
    kept = points.thin(cloud, rng.permutation(500), 0.07)
    distance = np.hypot(*(cloud[:, None] - cloud[kept]).transpose(2, 0, 1))
    assert (distance.min(axis=1) <= 0.07).all()
    among = distance[kept]
    np.fill_diagonal(among, np.inf)
    assert among.min() > 0.07


def test_blue_noise_keeps_its_distance() -> None:
    grid = Grid(np.arange(20) + 0.5, np.arange(20) + 0.5, 1.0, 0.0, 0.0)
    ice = np.ones((20, 20), dtype=bool)
    generator = np.random.Generator(np.random.PCG64(5))
    found, _ = points.blue_noise(grid, ice, np.ones((20, 20)), np.ones(200), generator)
    assert len(found) == 200
    distance = np.hypot(*(found[:, None] - found).transpose(2, 0, 1))
    np.fill_diagonal(distance, np.inf)
    # White noise of this density has pairs at a tenth of its mean spacing.
    assert distance.min() > 0.6 * np.sqrt(400 / 200)


def test_power_diagram_of_two_discs_is_their_radical_axis() -> None:
    grid = Grid(np.arange(10) + 0.5, np.arange(10) + 0.5, 1.0, 0.0, 0.0)
    places, radius = np.array([[2.0, 5.0], [7.0, 5.0]]), np.array([1.0, 3.0])
    diagram = tessellation.power_diagram(places, radius, grid)
    # (x - 2)^2 - 1 = (x - 7)^2 - 9
    axis = (49 - 9 - 4 + 1) / 10
    assert diagram.ends[0][:, 0] == pytest.approx([axis, axis], abs=1e-9)
    left = tessellation.overlay(diagram.polygons, grid, np.ones((10, 10), dtype=bool))
    area = np.bincount(left.element, weights=left.area)
    assert area == pytest.approx([10 * axis, 100 - 10 * axis], rel=1e-12)


def test_discs_in_a_row_share_their_strip() -> None:
    """Where many sites have equal power at one point, cells stay convex and tile the plane."""
    x = [32799.59884698439, 33599.866282328134, 34400.133717671866, 35200.40115301561]
    radius = [float.fromhex(f"0x1.90223b5241{last}p+8") for last in ("e81", "d81", "d81", "e81")]
    places = np.column_stack([x, np.full(4, 21375.0)])
    grid = Grid(32625.0 + 250.0 * np.arange(12), 20875.0 + 250.0 * np.arange(5), 250.0, 32500.0,
                20750.0)  # fmt: skip
    diagram = tessellation.power_diagram(places, np.array(radius), grid)
    found = tessellation.overlay(diagram.polygons, grid, np.ones(grid.shape, bool))
    assert found.correction < 1e-9
    inner = np.array([32500.0, 33199.73256465626, 34000.0, 34800.26743534374, 35500.0])
    area = np.bincount(found.element, found.area)
    np.testing.assert_allclose(area, np.diff(inner) * 1250.0, rtol=1e-9)


def test_radii_of_three_in_a_row() -> None:
    places = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]])
    radius = discs.radii(places, np.full(3, 10.0))
    assert radius == pytest.approx([0.5, 0.5, 1.5], rel=1e-9)


def test_neighbours_in_memory_are_near(packed: xr.Dataset) -> None:
    is_mobile = mobile(packed)
    x, y = packed["x"].values[is_mobile], packed["y"].values[is_mobile]
    step = np.hypot(np.diff(x), np.diff(y))
    spacing = 2 * packed["radius"].values[is_mobile].mean()
    assert np.median(step) < 1.5 * spacing


def test_another_seed_gives_other_places(packed: xr.Dataset) -> None:
    other = packing.make_packing(coastline(), Packing(elements=300), 8)
    assert checksum(other) != checksum(packed)
