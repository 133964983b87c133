# SPDX-License-Identifier: GPL-2.0-or-later
"""Coasts as closed lines that keep straits, and as meshes that a scene's walls read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from floeflow.core.errors import FloeError
from floeflow.core.grids import Grid
from floeflow.core.meshes import read_triangles
from floeflow.packings.coast_mesh import coast_segments, land_polygons, write_coast_mesh
from floeflow.state.scene_walls import cut

SIDE = 1.0e4


def islands() -> tuple[Grid, np.ndarray]:
    """Stairs with a bay, a strait of one cell, an island of one cell, a lake."""
    axis = SIDE * (np.arange(60) + 0.5)
    grid = Grid(axis, axis.copy(), SIDE, 0.0, 0.0)
    y, x = np.mgrid[:60, :60]
    land = x + y < 40
    land[5:10, 8:15] = False
    land |= (x + y > 41) & (x + y < 70) & (y > 20) & (x > 4)
    land[55, 50] = True
    return grid, land


@pytest.mark.parametrize("radius", [2.0e3, 1.0e4, 3.0e4])
def test_lines_are_closed_and_follow_the_land(radius: float) -> None:
    grid, land = islands()
    polygons = land_polygons(grid, land)
    segments = coast_segments(polygons, radius)
    starts, ends = (np.unique(segments[:, k], axis=0) for k in (0, 1))
    # Each corner ends one line and begins another.
    assert len(starts) == len(ends) == len(segments)
    np.testing.assert_array_equal(starts, ends)
    coast = shapely.union_all(polygons).boundary
    lines = shapely.linestrings(segments)
    away = shapely.distance(shapely.points(segments[:, 0]), coast)
    assert away.max() <= 1e-6
    middles = shapely.line_interpolate_point(lines, 0.5, normalized=True)
    assert shapely.distance(middles, coast).max() < 2.0 * radius + 1e-6


def test_the_sea_lies_to_the_left() -> None:
    grid, land = islands()
    segments = coast_segments(land_polygons(grid, land), 1.0)
    along = segments[:, 1] - segments[:, 0]
    left = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    at = segments.mean(axis=1) + 0.1 * SIDE * left
    inside = (at > 0).all(axis=1) & (at < 60 * SIDE).all(axis=1)
    row, column = grid.cell_of(*at[inside].T)
    assert not land[row, column].any()


def test_a_strait_stays_open() -> None:
    grid, land = islands()
    segments = coast_segments(land_polygons(grid, land), 1.2 * SIDE)
    lines = shapely.linestrings(segments)
    first = [line for line in lines if line.length > 0]
    crossing = shapely.STRtree(first).query(first, predicate="crosses")
    assert crossing.shape[1] == 0
    # The channel of one cell between the two lands: no line crosses its middle.
    x = (np.arange(8, 18) + 0.5) * SIDE
    middle = shapely.linestrings([[(at, 41.5 * SIDE - at) for at in (x[0], x[-1])]])
    assert shapely.intersects(lines, middle).sum() == 0


@pytest.mark.parametrize("ending", ["stl", "vtu"])
def test_the_mesh_cuts_the_ice_in_the_coast(tmp_path: Path, ending: str) -> None:
    grid, land = islands()
    segments = coast_segments(land_polygons(grid, land), SIDE)
    path = tmp_path / f"coast.{ending}"
    write_coast_mesh(segments, 2000.0, path)
    if ending == "vtu":
        import meshio

        assert len(meshio.read(path).cells_dict["triangle"]) == 2 * len(segments)
        return
    found = cut(*read_triangles(path), str(path))
    total = np.hypot(*(found[:, 1] - found[:, 0]).T).sum()
    assert total == pytest.approx(np.hypot(*(segments[:, 1] - segments[:, 0]).T).sum(), rel=1e-5)


def test_no_coast_is_said(tmp_path: Path) -> None:
    assert coast_segments([], 1.0).shape == (0, 2, 2)
    with pytest.raises(FloeError, match="no coast"):
        write_coast_mesh(np.empty((0, 2, 2)), 1.0, tmp_path / "a.stl")
    with pytest.raises(FloeError, match="written as .stl or .vtu"):
        write_coast_mesh(np.zeros((1, 2, 2)), 1.0, tmp_path / "a.obj")
