# SPDX-License-Identifier: GPL-2.0-or-later
"""Straits open and shut as the fine mask has them; seas without a way out are land."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import label

from floeflow.core.grids import Grid, from_lonlat, mask_grid, scene_crs
from floeflow.masks.land import land_samples
from floeflow.masks.straits import keep_straits
from floeflow.scene.blocks import Domain

SPLIT = 5


def coarse(water: np.ndarray) -> np.ndarray:
    ny, nx = (n // SPLIT for n in water.shape)
    return water.reshape(ny, SPLIT, nx, SPLIT).mean(axis=(1, 3)) <= 0.5


def two_seas(passage: bool) -> np.ndarray:
    """Seas in the west and east of a land of 10 cells, with a crooked passage of one sample."""
    water = np.zeros((100, 150), bool)
    water[:, :50] = water[:, 100:] = True
    if passage:
        water[33, 50:76] = water[33:58, 75] = water[57, 75:100] = True
    return water


def joined(land: np.ndarray, one: tuple[int, int], two: tuple[int, int]) -> bool:
    part, _ = label(~land)
    return bool(part[one] == part[two] > 0)


def test_a_narrow_strait_is_open_and_one_cell_wide() -> None:
    water = two_seas(True)
    land = keep_straits(coarse(water), water)
    assert not joined(coarse(water), (3, 2), (3, 25))
    assert joined(land, (3, 2), (3, 25))
    opened = coarse(water) & ~land
    # 26 + 24 + 25 samples, of five a cell, and a corner at most.
    assert 14 <= opened.sum() <= 17


def test_no_passage_stays_shut() -> None:
    water = two_seas(False)
    np.testing.assert_array_equal(keep_straits(coarse(water), water), coarse(water))


def test_bays_and_rough_shores_open_nothing() -> None:
    rng = np.random.default_rng(1)
    water = np.zeros((100, 100), bool)
    water[:, 50:] = True
    water[:, 47:50] = rng.random((100, 3)) < 0.5
    land = keep_straits(coarse(water), water)
    assert not (coarse(water) & ~land).any()


def test_a_thin_spit_parts_two_seas() -> None:
    water = np.ones((100, 100), bool)
    water[:, 52] = False
    assert joined(coarse(water), (5, 2), (5, 17))
    land = keep_straits(coarse(water), water)
    assert not joined(land, (5, 2), (5, 17))


def test_inland_seas_are_land() -> None:
    water = np.zeros((100, 100), bool)
    water[:, :50] = True
    water[40:60, 70:90] = True
    land = keep_straits(coarse(water), water)
    assert land[:, 11:].all() and not land[:, :10].any()


def test_all_land_and_all_water() -> None:
    for water in (np.zeros((20, 20), bool), np.ones((20, 20), bool)):
        np.testing.assert_array_equal(keep_straits(coarse(water), water), coarse(water))


# A place on each side (longitude, latitude), and the half width of the window (m).
STRAITS = {
    "Nares": ((-72.0, 78.2), (-58.0, 82.3), 4.5e5),
    "Bering": ((-172.0, 64.3), (-168.0, 67.3), 3.5e5),
    "Vilkitsky": ((98.0, 77.3), (110.0, 77.3), 3.0e5),
}


@pytest.fixture(scope="module", params=[25e3, 50e3])
def arctic(request: pytest.FixtureRequest):
    """Windows about each strait on cells of this size."""
    found = {}
    crs = scene_crs(Domain())
    for name, (one, two, half) in STRAITS.items():
        at = np.array([from_lonlat(crs, *np.array(place)) for place in (one, two)])
        low = np.floor((at.mean(axis=0) - half) / 5e4) * 5e4
        size = np.ceil(2 * half / 5e4) * 5e4
        domain = Domain(
            x_min=low[0], x_max=low[0] + size, y_min=low[1], y_max=low[1] + size, spacing=5e4
        )
        grid = mask_grid(domain, round(5e4 / request.param))
        found[name] = grid, at, land_samples(grid, crs)
    return found


def at_sea(grid: Grid, land: np.ndarray, place: np.ndarray) -> tuple[int, int]:
    """The cell of a place, or the nearest one at sea."""
    x, y = grid.mesh()
    away = np.where(land, np.inf, np.hypot(x - place[0], y - place[1]))
    assert away.min() < 1.5e5
    row, column = np.unravel_index(int(away.argmin()), away.shape)
    return int(row), int(column)


@pytest.mark.parametrize("name", STRAITS)
def test_straits_are_as_in_the_1_km_mask(arctic, name: str) -> None:
    grid, (one, two), (share, water) = arctic[name]
    land = keep_straits(share >= 0.5, water)
    split = water.shape[0] // land.shape[0]
    fine = Grid(grid.x, grid.y, grid.spacing / split, grid.x_min, grid.y_min)
    part, _ = label(water)
    rows, columns = [], []
    for place in (one, two):
        row, column = at_sea(grid, land, place)
        rows.append(row), columns.append(column)
    fine_parts = [
        set(np.unique(part[r * split : (r + 1) * split, c * split : (c + 1) * split])) - {0}
        for r, c in zip(rows, columns, strict=True)
    ]
    assert fine.spacing <= 4000.0
    assert fine_parts[0] & fine_parts[1], "open on the fine mask"
    assert joined(land, (rows[0], columns[0]), (rows[1], columns[1]))
