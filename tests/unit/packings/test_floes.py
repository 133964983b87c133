# SPDX-License-Identifier: GPL-2.0-or-later
"""Floes of a labelled image become clusters with their areas, centroids and second moments."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from floeflow.core.grids import Grid
from floeflow.masks.floe_mask import floe_mask
from floeflow.masks.labels import Floes
from floeflow.packings import bonds, packing
from floeflow.packings.floes import floes_of
from floeflow.packings.moments import cluster_moments
from floeflow.scene.blocks import Packing

PIXEL = 250.0


def image() -> np.ndarray:
    """A round floe, a bent one with a hole beside it, a slab, small ones, gaps in the numbers."""
    y, x = np.mgrid[:120, :160]
    numbers = np.zeros((120, 160), np.int32)
    numbers[(x - 40) ** 2 + (y - 50) ** 2 < 30**2] = 7
    bent = (abs(x - 90) < 22) & (abs(y - 60) < 45) & ~((abs(x - 98) < 12) & (y > 40))
    numbers[bent & (numbers == 0)] = 3
    numbers[80:83, 80:83] = 0
    numbers[10:22, 120:158] = 900
    for k in range(6):
        numbers[35 + 12 * k : 40 + 12 * k, 130 : 134 + 2 * k] = 20 + k
    numbers[100:104, 5:9] = numbers[104:108, 9:13] = 40
    return numbers


def mask_of_floes(numbers: np.ndarray, land: np.ndarray | None = None) -> xr.Dataset:
    """Mask on cells of 1.7 pixels and shifted, areas on the earth unlike those on the map."""
    ny, nx = numbers.shape
    pixels = Grid((np.arange(nx) + 0.5) * PIXEL, (np.arange(ny) + 0.5) * PIXEL, PIXEL, 0.0, 0.0)
    side, low = 1.7 * PIXEL, -0.3 * PIXEL
    n = int(np.ceil((max(ny, nx) + 1) / 1.7)) + 1
    axis = low + side * (np.arange(n) + 0.5)
    grid = Grid(axis, axis.copy(), side, low, low)
    land = np.zeros(grid.shape, bool) if land is None else land
    siconc, made = floe_mask(Floes(numbers, pixels), grid, land)
    scale = 1.0 + 0.03 * np.linspace(0, 1, n)[:, None] * np.ones(n)
    dims = ("y", "x")
    mask = xr.Dataset(
        {
            "siconc": (dims, siconc),
            "sithick": (dims, np.where(siconc > 0, 1.5, 0.0)),
            "land": (dims, land.astype(np.int8)),
            "cell_area": (dims, scale * side**2),
        },
        coords={"x": axis, "y": axis.copy()},
        attrs={"crs": "EPSG:3413"},
    ).merge(made)
    mask.attrs |= made.attrs
    return mask


@pytest.fixture(scope="module")
def mask() -> xr.Dataset:
    return mask_of_floes(image())


@pytest.fixture(scope="module")
def packed(mask: xr.Dataset) -> xr.Dataset:
    return packing.make_packing(mask, Packing(generator="floes", elements=150), 3, False)


def floe_rows(mask: xr.Dataset, packed: xr.Dataset) -> np.ndarray:
    numbers = floes_of(mask).number
    assert len(set(numbers)) == len(numbers)
    order = np.argsort(numbers)
    return order[np.searchsorted(numbers, packed["floe"].values, sorter=order)]


def test_area_and_volume_are_those_of_the_mask(mask: xr.Dataset, packed: xr.Dataset) -> None:
    area, siconc = mask["cell_area"].values, mask["siconc"].values
    assert packed["area"].values.sum() == pytest.approx((area * siconc).sum(), rel=1e-12)
    volume = packed["area"].values * packed["ice_volume"].values[:, 0]
    assert volume.sum() == pytest.approx(1.5 * (area * siconc).sum(), rel=1e-12)
    assert (packed["ice_fraction"].values == 1.0).all()


def test_each_floe_keeps_area_centroid_and_second_moments(
    mask: xr.Dataset, packed: xr.Dataset
) -> None:
    floes, of = floes_of(mask), floe_rows(mask, packed)
    places = np.stack([packed["x"].values, packed["y"].values], axis=1)
    y, x = np.mgrid[:120, :160] * PIXEL + 0.5 * PIXEL
    plane, middle, second = cluster_moments(
        places, packed["area"].values, packed["radius"].values, of
    )
    for row, number in enumerate(floes.number):
        mine = image() == number
        area = mine.sum() * PIXEL**2
        # The areal scale of the mask's cells reaches from 1 to 1.03.
        assert area < plane[row] < 1.03 * area
        at = np.array([x[mine].mean(), y[mine].mean()])
        assert np.hypot(*(middle[row] - at)) < 0.01 * np.sqrt(area / np.pi)
        if (of == row).sum() > 1:
            off = np.stack([x[mine], y[mine]]) - at[:, None]
            wanted = off @ off.T / mine.sum() + PIXEL**2 / 12 * np.eye(2)
            assert np.abs(second[row] - wanted).max() < 0.01 * wanted.trace()


def test_a_floe_that_its_discs_cannot_show_gets_one_more() -> None:
    """Three discs in a row have no width but their own: as many fewest as before, or more."""
    # An ellipse three times as long as wide, of three mean elements.
    y, x = np.mgrid[:120, :160] * PIXEL
    ellipse = ((x - 80 * PIXEL) / 3) ** 2 + (y - 60 * PIXEL) ** 2 < (20 * PIXEL) ** 2
    mask = mask_of_floes(ellipse.astype(np.int32))
    made = packing.make_packing(mask, Packing(generator="floes", elements=3), 3, False)
    assert made.sizes["element"] > 3
    assert float(made["quality_moment_error"]) < 0.01
    assert float(made["quality_moment_share"]) == 0.0


def test_bonds_join_each_floe_and_no_two(packed: xr.Dataset) -> None:
    table = bonds.make_bonds(packed, 0.0, 0.8)
    lo, hi = table["bond_id_lo"].values - 1, table["bond_id_hi"].values - 1
    floe = packed["floe"].values
    assert (floe[lo] == floe[hi]).all()
    graph = sparse.csr_matrix((np.ones(len(lo)), (lo, hi)), shape=(len(floe), len(floe)))
    clusters, _ = connected_components(graph, directed=False)
    assert clusters == len(np.unique(floe))
    assert (table["bond_length"].values > 0).all()


def test_no_two_discs_overlap(packed: xr.Dataset) -> None:
    x, y, radius = (packed[name].values for name in ("x", "y", "radius"))
    distance = np.hypot(x[:, None] - x, y[:, None] - y)
    np.fill_diagonal(distance, np.inf)
    assert (radius[:, None] + radius <= distance).all()


def test_a_small_floe_is_one_disc_of_its_area(mask: xr.Dataset, packed: xr.Dataset) -> None:
    alone = packed["floe"].values == 20
    assert alone.sum() == 1
    area = 20 * PIXEL**2
    assert np.pi * packed["radius"].values[alone] ** 2 == pytest.approx(area, rel=1e-9)


def test_pixels_on_land_hold_no_floe() -> None:
    land = np.zeros((96, 96), bool)
    land[:, :30] = True
    cut = mask_of_floes(image(), land)
    made = packing.make_packing(cut, Packing(generator="floes", elements=80), 3, True)
    mobile = made["type"].values == 1
    grid = packing.grid_of(cut)
    row, column = grid.cell_of(made["x"].values, made["y"].values)
    assert not land[row, column][mobile].any() and (~mobile).any()
    wanted = float((cut["siconc"] * cut["cell_area"]).sum())
    assert made["area"].values.sum() == pytest.approx(wanted, rel=1e-12)


def test_an_image_without_floes_makes_no_elements() -> None:
    empty = mask_of_floes(np.zeros((20, 20), np.int32))
    assert packing.make_packing(empty, Packing(generator="floes"), 1).sizes["element"] == 0
