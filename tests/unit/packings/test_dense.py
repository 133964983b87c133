# SPDX-License-Identifier: GPL-2.0-or-later
"""Dense packs: size distributions, concentration as whole floes, compaction by the plugin."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from floeflow.core.grids import Grid
from floeflow.core.near import deepest_overlap
from floeflow.coupling.compaction import Box, compact, compactor
from floeflow.packings.dense import disc_sizes
from floeflow.packings.elements import grid_of
from floeflow.packings.packing import make_packing
from floeflow.scene.blocks import Discs, Packing
from floeflow.state.walls import join, plane
from unit.packings.test_packing import coastline, mask_of


@pytest.mark.parametrize("sizes", ["equal", "bidisperse", "lognormal", "power_law"])
def test_sizes_follow_their_distribution(sizes: str) -> None:
    keys = Discs(sizes=sizes, smallest=0.4, largest=3.0)
    radius = disc_sizes(20_000, keys, np.random.default_rng(1))
    assert (radius**2).mean() == pytest.approx(1.0, rel=1e-12)
    if sizes == "equal":
        assert np.ptp(radius) == 0.0
    elif sizes == "bidisperse":
        assert np.unique(radius)[1] / np.unique(radius)[0] == pytest.approx(1.4)
        assert np.mean(radius > radius.mean()) == pytest.approx(0.5)
    elif sizes == "lognormal":
        assert np.log(radius).std() == pytest.approx(0.3, rel=0.03)
    else:
        # n(r) ~ r^-3 between cut-offs of 1 to 7.5: the number above r falls as r^-2.
        share = radius / radius.min()
        for level in (1.5, 2.0, 4.0):
            above = (level**-2 - 7.5**-2) / (1 - 7.5**-2)
            assert np.mean(share > level) == pytest.approx(above, abs=0.01)


def bidisperse(count: int, fill: float) -> tuple[np.ndarray, np.ndarray, float]:
    radius = np.where(np.arange(count) % 2, 1.0, 1.4) * 1000.0
    side = float(np.sqrt(np.pi * (radius**2).sum() / fill))
    return np.random.default_rng(3).uniform(0, side, (count, 2)), radius, side


def test_a_periodic_pack_of_two_sizes_reaches_close_packing(tmp_path: Path) -> None:
    places, radius, side = bidisperse(300, 0.83)
    box = Box(np.empty((0, 2)), np.empty(0), None, (0.0, 0.0, side, side))
    made = compact(places, radius, box, 2e-3, tmp_path)
    assert made.overlap < 2e-3
    assert ((made.places >= 0) & (made.places < side)).all()
    # Across the edges too: the pack and its copies, by the obvious way.
    moved = [made.places + [i * side, j * side] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    every = np.concatenate(moved)
    distance = np.hypot(*(made.places[:, None] - every).transpose(2, 0, 1))
    reach = radius[:, None] + np.tile(radius, 9)
    share = np.where(distance > 0, 1.0 - distance / reach, 0.0)
    assert share.max() == pytest.approx(made.overlap, abs=1e-12)


def test_a_wall_at_the_rim_is_the_rim(tmp_path: Path) -> None:
    """And pushes no second time: the pack is the same with and without, to the bit."""
    grid = Grid(1e3 * (np.arange(4) + 0.5), 1e3 * (np.arange(3) + 0.5), 1e3, 0.0, 0.0)
    rng = np.random.default_rng(2)
    places, radius = rng.uniform(0, 1, (40, 2)) * (4e3, 2.4e3), np.full(40, 240.0)
    none = np.empty((0, 2)), np.empty(0)
    rim = [plane(0.0, 0.0, (1.0, 0.0)), plane(4e3, 3e3, (-1.0, 0.0), (-0.5, 0.0))]
    inner = [plane(0.0, 0.0, (0.0, 1.0)), plane(1e3, 2.5e3, (0.0, -1.0))]
    free, walled, lower = (
        compactor(grid, tmp_path, walls and join(walls))(places, radius, *none, 1e-3)
        for walls in (None, rim, inner)
    )
    np.testing.assert_array_equal(free, walled)
    # A wall within holds the discs before it.
    assert free[:, 1].max() > 2.4e3 > lower[:, 1].max()


def test_jammed_discs_say_what_overlap_is_left(tmp_path: Path) -> None:
    places, radius, side = bidisperse(16, 0.95)
    box = Box(np.empty((0, 2)), np.empty(0), None, (0.0, 0.0, side, side))
    made = compact(places, radius, box, 1e-3, tmp_path)
    assert made.overlap > 1e-3


def packed(mask, tmp_path: Path, elements: int = 250, **discs):
    keys = Packing(generator="dense", elements=elements, discs=Discs(**discs))
    return make_packing(mask, keys, 5, True, compactor(grid_of(mask), tmp_path))


def test_concentration_is_whole_floes_with_open_water(tmp_path: Path) -> None:
    siconc = np.full((20, 20), 0.3)
    siconc[:, 10:] = 0.6
    mask = mask_of(siconc, np.zeros((20, 20), bool))
    made = packed(mask, tmp_path)
    assert (made["ice_fraction"].values == 1.0).all()
    area, radius = made["area"].values, made["radius"].values
    # The mask's areas on the earth are 0 to 5 % above those on the map.
    assert (area > np.pi * radius**2 * 0.999).all() and (area < 1.06 * np.pi * radius**2).all()
    wanted = float((mask["siconc"] * mask["cell_area"]).sum())
    assert area.sum() == pytest.approx(wanted, rel=1e-12)
    volume = (area * made["ice_volume"].values[:, 0]).sum()
    held = float((mask["siconc"] * mask["sithick"] * mask["cell_area"]).sum())
    assert volume == pytest.approx(held, rel=1e-12)
    thin = made["x"].values < float(mask["x"][10]) - 0.5 * 5e4
    # A third of the ice lies in the thin half, to a few floes.
    assert area[thin].sum() / area.sum() == pytest.approx(1 / 3, abs=0.03)
    assert deepest_overlap(np.stack([made["x"], made["y"]], axis=1), radius, len(radius)) == 0.0


def test_floes_stay_within_coast_and_rim(tmp_path: Path) -> None:
    mask = coastline()
    made = packed(mask, tmp_path, 120)
    grid, mobile = grid_of(mask), made["type"].values == 1
    row, column = grid.cell_of(made["x"].values, made["y"].values)
    assert not (mask["land"].values[row, column] > 0)[mobile].any()
    x, y, radius = (made[name].values[mobile] for name in ("x", "y", "radius"))
    rim = [x - grid.x_edges[0], grid.x_edges[-1] - x, y - grid.y_edges[0], grid.y_edges[-1] - y]
    assert min((side - radius).min() for side in rim) > -0.02 * radius.mean()
