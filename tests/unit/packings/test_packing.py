# SPDX-License-Identifier: GPL-2.0-or-later
"""The packing's invariants: areas, ice, overlaps, cells, edges, coast, reproducibility."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import shapely
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.packings import bonds, packing, tessellation
from floeflow.packings.elements import grid_of
from floeflow.scene.blocks import Packing
from floeflow.state import walls
from floeflow.state.files import checksum

SPACING = 5.0e4


def mask_of(siconc: np.ndarray, land: np.ndarray, sithick: np.ndarray | None = None) -> xr.Dataset:
    """A mask whose cells are a little larger on the earth than on the map, by place."""
    ny, nx = siconc.shape
    thick = 2.0 * siconc if sithick is None else sithick
    siconc, thick = (np.where(land, 0.0, values) for values in (siconc, thick))
    area = SPACING**2 * (1.0 + 0.05 * np.linspace(0, 1, ny)[:, None] * np.ones(nx))
    dims = ("y", "x")
    return xr.Dataset(
        {"siconc": (dims, siconc), "sithick": (dims, np.where(siconc > 0, thick, 0.0)),
         "land": (dims, land.astype(np.int8)), "cell_area": (dims, area)},
        coords={"x": SPACING * (np.arange(nx) - 9.5), "y": SPACING * (np.arange(ny) + 0.5)},
        attrs={"crs": "EPSG:6931"},
    )  # fmt: skip


def coastline(seed: int = 1) -> xr.Dataset:
    """Land along two sides, an island, a channel one cell wide, a bay, open water, a lone cell."""
    rng = np.random.default_rng(seed)
    siconc = rng.uniform(0.2, 1.0, (30, 40))
    siconc[:, 30:] = 0.0
    siconc[2, 36] = 0.7
    land = np.zeros((30, 40), dtype=bool)
    land[:5, :12] = land[22:, :25] = True
    land[12:15, 14:18] = True
    land[25, 3:25] = False
    land[10, 22:26] = True
    return mask_of(siconc, land, rng.uniform(0.5, 4.0, siconc.shape))


@pytest.fixture(scope="module")
def mask() -> xr.Dataset:
    return coastline()


@pytest.fixture(scope="module")
def packed(mask: xr.Dataset) -> xr.Dataset:
    return packing.make_packing(mask, Packing(elements=300), 7)


def mobile(packed: xr.Dataset) -> np.ndarray:
    return packed["type"].values == 1


def check_sums(mask: xr.Dataset, packed: xr.Dataset) -> None:
    area = mask["cell_area"].values
    siconc, sithick = mask["siconc"].values, mask["sithick"].values
    effective = packed["area"].values
    for got, wanted in (
        (effective, area * (siconc > 0)),
        (effective * packed["ice_fraction"].values[:, 0], area * siconc),
        (effective * packed["ice_volume"].values[:, 0], area * siconc * sithick),
    ):
        assert got.sum() == pytest.approx(wanted.sum(), rel=1e-12)
    ocean = area[mask["land"].values == 0].sum()
    assert packed.attrs["ocean_area"] == pytest.approx(ocean, rel=1e-14)
    total = effective.sum() + packed.attrs["unclaimed_water"]
    assert total == pytest.approx(ocean, rel=1e-12)


def check_places(mask: xr.Dataset, packed: xr.Dataset) -> None:
    """Mobile elements on ice, coast elements on land, all on the grid."""
    grid, x, y = grid_of(mask), packed["x"].values, packed["y"].values
    assert ((x >= grid.x_edges[0]) & (x <= grid.x_edges[-1])).all()
    assert ((y >= grid.y_edges[0]) & (y <= grid.y_edges[-1])).all()
    row, column = grid.cell_of(x, y)
    is_mobile = mobile(packed)
    assert (mask["siconc"].values[row, column][is_mobile] > 0).all()
    assert (mask["land"].values[row, column][~is_mobile] == 1).all()
    assert (packed["area"].values[is_mobile] > 0).all()


def check_no_overlap(packed: xr.Dataset) -> None:
    """Discs of ice with each other and with the coast's, which may overlap among themselves."""
    x, y, radius = (packed[name].values for name in ("x", "y", "radius"))
    distance = np.hypot(x[:, None] - x, y[:, None] - y)
    reach = radius[:, None] + radius
    np.fill_diagonal(distance, np.inf)
    coast = ~mobile(packed)
    distance[coast[:, None] & coast] = np.inf
    assert (reach <= distance).all()
    assert (radius > 0).all()


def test_areas_and_ice_are_those_of_the_mask(mask: xr.Dataset, packed: xr.Dataset) -> None:
    check_sums(mask, packed)
    assert packed.attrs["overlay_correction"] < 1e-9
    assert (packed["ice_fraction"].values <= 1).all()


def shore_lines(packed: xr.Dataset) -> shapely.Geometry:
    corner = np.column_stack([packed["coast_x"].values, packed["coast_y"].values])
    start = packed["coast_start"].values
    of = np.repeat(np.arange(len(start) - 1), np.diff(start))
    return shapely.multilinestrings(list(shapely.linearrings(corner, indices=of)))


def test_no_two_discs_overlap_and_each_touches_one_or_the_coast(packed: xr.Dataset) -> None:
    check_no_overlap(packed)
    x, y, radius = (packed[name].values for name in ("x", "y", "radius"))
    gap = np.hypot(x[:, None] - x, y[:, None] - y) - radius[:, None] - radius
    np.fill_diagonal(gap, np.inf)
    away = shapely.distance(shore_lines(packed), shapely.points(x, y)) - radius
    touching = np.minimum(gap.min(axis=1), away) < 1e-6 * radius
    assert touching[mobile(packed)].mean() > 0.9


def test_discs_do_not_reach_over_the_coast(mask: xr.Dataset, packed: xr.Dataset) -> None:
    """Under 0.1 % of the ice's area (0.5 % when radii did not know the lines)."""
    assert 0.0 <= float(packed["quality_ashore"]) < 1e-3
    is_mobile = mobile(packed)
    x, y, radius = (packed[name].values[is_mobile] for name in ("x", "y", "radius"))
    over = radius - shapely.distance(shore_lines(packed), shapely.points(x, y))
    # Only where the water is too narrow for the smallest disc that there may be.
    slim = 0.25 * np.sqrt((mask["siconc"].values > 0).sum() * SPACING**2 / 300 / np.pi)
    assert (radius[over > 1e-6 * radius] < 1.001 * slim).all()
    # The figure itself, by another way; it takes discs as 24 corners.
    row, column = np.nonzero(mask["land"].values)
    grid = grid_of(mask)
    west, south = grid.x_edges[column], grid.y_edges[row]
    land = shapely.union_all(shapely.box(west, south, west + SPACING, south + SPACING))
    discs = shapely.buffer(shapely.points(x, y), radius, quad_segs=8)
    shown = shapely.area(shapely.intersection(discs, land)).sum()
    ice = (mask["siconc"].values > 0).sum() * SPACING**2
    assert float(packed["quality_ashore"]) == pytest.approx(shown / ice, rel=0.1, abs=1e-7)


def test_discs_keep_clear_of_walls() -> None:
    """A plane at the ice, a line across it: discs end there, and hold the mask's ice."""
    siconc = np.full((20, 24), 0.9)
    siconc[:, :5] = 0.0
    mask = mask_of(siconc, np.zeros((20, 24), dtype=bool))
    across = walls.lines(np.array([[[1.0e5, 2.0e5], [4.0e5, 6.0e5]]]))
    faces = walls.join([walls.plane(-2.5e5, 0.0, (1.0, 0.0)), across])
    made = packing.make_packing(mask, Packing(elements=200), 3, walls=faces)
    x, y, radius = (made[name].values for name in ("x", "y", "radius"))
    room = walls.distances(faces, x[:, None], y[:, None]).min(axis=1)
    assert (room >= radius * (1 - 1e-9)).all()
    assert float(abs(made["quality_area_error"])) < 1e-12


def test_the_coasts_discs_reach_the_ice_that_ends_at_the_coast(packed: xr.Dataset) -> None:
    """Else ice that broke from the coast would never touch it again."""
    ice = mobile(packed)
    x, y, radius = (packed[name].values for name in ("x", "y", "radius"))
    away = shapely.distance(shore_lines(packed), shapely.points(x, y)) - radius
    at_line = ice & (np.abs(away) < 1e-6 * radius)
    gap = np.hypot(x[at_line, None] - x[~ice], y[at_line, None] - y[~ice]) - radius[~ice]
    touching = gap.min(axis=1) - radius[at_line] < 0.01 * radius[at_line]
    assert at_line.sum() > 20 and touching.mean() > 0.8


def test_discs_lie_in_their_power_cells(mask: xr.Dataset, packed: xr.Dataset) -> None:
    is_mobile = mobile(packed)
    places = np.stack([packed["x"].values, packed["y"].values], axis=1)[is_mobile]
    radius = packed["radius"].values[is_mobile]
    diagram = tessellation.power_diagram(places, radius, grid_of(mask))
    rim = shapely.boundary(diagram.polygons)
    inside = shapely.contains(diagram.polygons, shapely.points(places))
    assert inside.all()
    assert (shapely.distance(rim, shapely.points(places)) >= radius * (1 - 1e-9)).all()


def test_mobile_elements_stand_on_ice_and_coast_on_land(
    mask: xr.Dataset, packed: xr.Dataset
) -> None:
    check_places(mask, packed)
    is_mobile = mobile(packed)
    assert is_mobile.sum() >= 300
    for name in ("area", "ice_fraction", "ice_volume"):
        assert (packed[name].values[~is_mobile] == 0).all()


def test_ids_count_mobile_elements_first(packed: xr.Dataset) -> None:
    assert list(packed["id"].values) == list(range(1, packed.sizes["element"] + 1))
    assert (np.diff(packed["type"].values) >= 0).all()


def rings(packed: xr.Dataset) -> list[np.ndarray]:
    xy = np.stack([packed["cell_x"].values, packed["cell_y"].values], axis=1)
    start = packed["cell_start"].values
    return [xy[a:b] for a, b in zip(start[:-1], start[1:], strict=True)]


def test_cells_are_open_anticlockwise_rings_over_the_ice(
    mask: xr.Dataset, packed: xr.Dataset
) -> None:
    is_mobile = mobile(packed)
    found = rings(packed)
    assert all(len(ring) == 0 for ring, here in zip(found, is_mobile, strict=True) if not here)
    mine = [ring for ring, here in zip(found, is_mobile, strict=True) if here]
    for ring in mine:
        nx, ny = np.roll(ring, -1, axis=0).T
        assert ((ring[:, 0] * ny - nx * ring[:, 1]).sum()) > 0
        assert not np.array_equal(ring[0], ring[-1])
    # Parts that land cuts off are left out of the rings, never of the areas.
    plane = sum(shapely.Polygon(ring).area for ring in mine)
    ice = (mask["siconc"].values > 0).sum() * SPACING**2
    assert 0.97 * ice < plane <= ice * (1 + 1e-9)


def test_edges_are_sorted_and_point_left_of_lo_to_hi(packed: xr.Dataset) -> None:
    lo, hi = packed["edge_lo"].values, packed["edge_hi"].values
    assert (lo < hi).all()
    assert (np.diff(lo * 10**6 + hi) > 0).all()
    assert hi.max() <= mobile(packed).sum()
    x, y = packed["x"].values, packed["y"].values
    along = np.stack([x[hi - 1] - x[lo - 1], y[hi - 1] - y[lo - 1]])
    across = np.stack(
        [packed["edge_bx"].values - packed["edge_ax"].values,
         packed["edge_by"].values - packed["edge_ay"].values]
    )  # fmt: skip
    assert (along[0] * across[1] - along[1] * across[0] > 0).all()
    # The edge lies on the radical axis, at a right angle to the line of centres.
    dot = (along * across).sum(axis=0) / np.hypot(*along) / np.hypot(*across)
    assert np.abs(dot).max() < 1e-6


def test_edges_have_equal_power_to_both_discs(packed: xr.Dataset) -> None:
    lo, hi = packed["edge_lo"].values - 1, packed["edge_hi"].values - 1
    x, y, radius = (packed[name].values for name in ("x", "y", "radius"))
    px = 0.5 * (packed["edge_ax"].values + packed["edge_bx"].values)
    py = 0.5 * (packed["edge_ay"].values + packed["edge_by"].values)
    power = [(px - x[k]) ** 2 + (py - y[k]) ** 2 - radius[k] ** 2 for k in (lo, hi)]
    assert np.abs(power[0] - power[1]).max() < 1e-6 * SPACING**2


def test_edges_lie_over_the_ice(mask: xr.Dataset, packed: xr.Dataset) -> None:
    grid = grid_of(mask)
    for share in (0.01, 0.5, 0.99):
        px = packed["edge_ax"].values * (1 - share) + packed["edge_bx"].values * share
        py = packed["edge_ay"].values * (1 - share) + packed["edge_by"].values * share
        row, column = grid.cell_of(px, py)
        assert (mask["siconc"].values[row, column] > 0).all()


def test_coast_leaves_no_gap_for_a_mean_element(mask: xr.Dataset, packed: xr.Dataset) -> None:
    """Every side between ice and land has a coast disc within a mean diameter."""
    ice, land = mask["siconc"].values > 0, mask["land"].values > 0
    row, column = np.nonzero(ice[:, :-1] & land[:, 1:])
    grid = grid_of(mask)
    middle = np.stack([grid.x_edges[column + 1], grid.y[row]], axis=1)
    is_mobile = mobile(packed)
    coast = np.stack([packed["x"].values, packed["y"].values], axis=1)[~is_mobile]
    radius = packed["radius"].values
    away = np.hypot(*(middle[:, None] - coast).transpose(2, 0, 1)) - radius[~is_mobile]
    assert away.min(axis=1).max() < radius[is_mobile].mean()


def test_large_patches_have_an_element_of_their_own(mask: xr.Dataset) -> None:
    """A lone ice cell of more than half an element's area holds one, whatever the seed."""
    grid = grid_of(mask)
    lone = np.zeros(grid.shape, dtype=bool)
    lone[2, 36] = True
    cells = int((mask["siconc"].values > 0).sum())
    for seed in range(5):
        made = packing.make_packing(mask, Packing(elements=int(0.6 * cells)), seed)
        row, column = grid.cell_of(made["x"].values, made["y"].values)
        assert (lone[row, column] & mobile(made)).any()
        check_sums(mask, made)


def test_same_seed_same_bits_in_another_process(packed: xr.Dataset) -> None:
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from unit.packings.test_packing import coastline\n"
        "from floeflow.scene.blocks import Packing\n"
        "from floeflow.packings.packing import make_packing\n"
        "from floeflow.state.files import checksum\n"
        "print(checksum(make_packing(coastline(), Packing(elements=300), 7)))\n"
    )
    folder = str(Path(__file__).parents[2])
    run = subprocess.run(
        [sys.executable, "-c", code, folder], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == checksum(packed)


def test_no_coast_without_the_key(mask: xr.Dataset) -> None:
    made = packing.make_packing(mask, Packing(elements=50), 7, coast_effect=False)
    assert mobile(made).all()
    check_sums(mask, made)
    check_no_overlap(made)


def test_no_ice_makes_no_elements() -> None:
    mask = mask_of(np.zeros((6, 8)), np.zeros((6, 8), dtype=bool))
    made = packing.make_packing(mask, Packing(elements=10), 1)
    assert made.sizes["element"] == made.sizes["edge"] == made.sizes["vertex"] == 0
    assert made.attrs["unclaimed_water"] == made.attrs["ocean_area"] > 0
    assert bonds.make_bonds(made, 0.2, 0.0).sizes["bond"] == 0


def test_nothing_but_land() -> None:
    mask = mask_of(np.ones((6, 8)), np.ones((6, 8), dtype=bool))
    made = packing.make_packing(mask, Packing(elements=10), 1)
    assert made.sizes["element"] == 0
    assert made.attrs["ocean_area"] == made.attrs["unclaimed_water"] == 0


@pytest.mark.parametrize("elements", [1, 2, 3, 4, 7])
def test_very_few_elements(elements: int) -> None:
    mask = mask_of(np.full((6, 8), 0.9), np.zeros((6, 8), dtype=bool))
    made = packing.make_packing(mask, Packing(elements=elements), 3)
    assert made.sizes["element"] == elements
    check_sums(mask, made)
    check_no_overlap(made)


@settings(max_examples=60)
@given(
    seed=st.integers(0, 10**6),
    elements=st.integers(1, 60),
    relaxations=st.integers(0, 6),
    ice_share=st.floats(0.05, 1.0),
    land_share=st.floats(0.0, 0.6),
)
def test_any_mask_keeps_the_invariants(
    seed: int, elements: int, relaxations: int, ice_share: float, land_share: float
) -> None:
    """Random specks of ice and land: worse than any coast."""
    rng = np.random.default_rng(seed)
    siconc = rng.uniform(0.01, 1.0, (9, 12)) * (rng.random((9, 12)) < ice_share)
    siconc[4, 5] = 0.5
    land = rng.random((9, 12)) < land_share
    land[4, 5] = False
    mask = mask_of(siconc, land)
    made = packing.make_packing(mask, Packing(elements=elements, relaxations=relaxations), seed)
    check_sums(mask, made)
    check_no_overlap(made)
    check_places(mask, made)
    table = bonds.make_bonds(made, 0.2, 0.0)
    assert (table["bond_length"].values > 0).all()
