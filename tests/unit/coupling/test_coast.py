# SPDX-License-Identifier: GPL-2.0-or-later
"""The coast as closed lines: no element passes it, whatever pushes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
import xarray as xr
from mpi4py import MPI

from floeflow.coupling.initial import make_state
from floeflow.dynamics.motion import move
from floeflow.dynamics.remesh.absorb import ashore
from floeflow.dynamics.remesh.remesh import remesh
from floeflow.packings.bonds import make_bonds
from floeflow.packings.coastline import coastline, off_shore
from floeflow.packings.elements import grid_of
from floeflow.packings.packing import make_packing
from floeflow.scene.blocks import Scene
from floeflow.state.elements import pair_arrays
from floeflow.state.schema import MOBILE, check_state
from floeflow.state.walls import clearance, crossed, lines, unsafe

SIDE, WINDOW = 10e3, 43200.0


def a_mask(land: np.ndarray, thickness: float = 0.5) -> xr.Dataset:
    """Mask of cells of 10 km, ice wherever there is no land."""
    ice = np.where(land, 0.0, 1.0)
    dims, (ny, nx) = ("y", "x"), land.shape
    return xr.Dataset(
        {
            "siconc": (dims, ice),
            "sithick": (dims, thickness * ice),
            "land": (dims, land.astype(np.int8)),
            "cell_area": (dims, np.full(ice.shape, SIDE**2)),
        },
        coords={"x": SIDE * (np.arange(nx) + 0.5), "y": SIDE * (np.arange(ny) + 0.5)},
        attrs={"crs": "EPSG:6931"},
    )


def bay() -> np.ndarray:
    """Land in the south with a bay in it, and an island of two cells that touch at a corner."""
    land = np.zeros((20, 24), dtype=bool)
    land[:4] = True
    land[2:4, 8:15] = False
    land[8, 5] = land[9, 6] = True
    return land


def a_scene(count: int = 120) -> Scene:
    return Scene.model_validate(
        {
            "name": "bay",
            "packing": {"elements": count},
            "effects": ["wind", "ocean_drag", "coast", "friction", "bonds", "ridging"],
            "time": {"window": WINDOW},
            "dynamics": {"samples": 2},
        }
    )


def onshore(speed: float, begin: float) -> xr.Dataset:
    """Wind to the south, on the axes of a window."""
    time, axis = begin + np.array([0.0, WINDOW]), np.array([-1e6, 1e6])
    shape = (2, 2, 2)
    fields = {name: np.zeros(shape) for name in ("wind_u", "ocean_u", "ocean_v")}
    fields["wind_v"] = np.full(shape, -speed)
    return xr.Dataset(
        {name: (("time", "y", "x"), values) for name, values in fields.items()},
        coords={"time": time, "x": axis, "y": axis},
    )


def on_land(state: xr.Dataset, land: np.ndarray) -> np.ndarray:
    """Ids of mobile elements whose centre lies on a land cell."""
    mobile = state["type"].values == MOBILE
    column, row = (np.floor(state[a].values[mobile] / SIDE).astype(int) for a in "xy")
    inside = (row >= 0) & (row < land.shape[0]) & (column >= 0) & (column < land.shape[1])
    ashore = np.zeros(mobile.sum(), dtype=bool)
    ashore[inside] = land[row[inside], column[inside]]
    return np.asarray(state["id"].values[mobile][ashore])


def test_the_lines_lie_in_the_land_and_close_it() -> None:
    land = bay()
    start, corner = coastline(grid_of(a_mask(land)), land)
    rings = [shapely.Polygon(corner[a:b]) for a, b in zip(start[:-1], start[1:], strict=True)]
    whole = shapely.union_all(rings)
    y, x = np.nonzero(land)
    cells = shapely.union_all(shapely.box(SIDE * x, SIDE * y, SIDE * (x + 1), SIDE * (y + 1)))
    assert whole.difference(cells).area < 1.0
    assert 0.98 * cells.area < whole.area <= cells.area
    assert len(rings) == 3


def anywhere(places: np.ndarray) -> np.ndarray:
    return np.ones(len(places), dtype=bool)


def test_a_sea_without_land_has_no_lines() -> None:
    land = np.zeros((4, 5), dtype=bool)
    start, corner = coastline(grid_of(a_mask(land)), land)
    assert list(start) == [0] and corner.shape == (0, 2)
    places = np.array([[1e4, 1e4]])
    np.testing.assert_array_equal(off_shore(places, start, corner, 1e3, anywhere), places)


def test_places_on_the_line_are_moved_to_sea() -> None:
    land = bay()
    start, corner = coastline(grid_of(a_mask(land)), land)
    on_line = np.array([[45e3, 40e3], [80e3, 25e3], [1e5, 1e5]])
    moved = off_shore(on_line, start, corner, 1e3, anywhere)
    assert moved[0, 1] > 40e3 and moved[1, 0] > 80e3
    np.testing.assert_array_equal(moved[2], on_line[2])


@pytest.mark.parametrize("speed", [12.0, 30.0])
def test_no_centre_goes_ashore_in_days_of_wind(tmp_path: Path, speed: float) -> None:
    land, scene = bay(), a_scene()
    mask = a_mask(land)
    packing = make_packing(mask, scene.packing, 1)
    state = make_state(scene, packing, make_bonds(packing, 0.2, 0.8, False))
    check_state(state)
    assert not len(on_land(state, land))
    volume = float(state["area"] @ state["ice_volume"].sum("category"))
    ridged = pushed = 0.0
    for k in range(6):
        forcing = onshore(speed, k * WINDOW)
        motion = move(MPI.COMM_SELF, scene, state, forcing, tmp_path / "log", lambda **_: None)
        budget = motion.budget
        ridged += budget["ridged_area"]
        pushed += budget["impulse_coast_y"]
        # The coast's push closes the budget of momentum.
        for axis in "xy":
            given = sum(budget[f"impulse_{n}_{axis}"] for n in ("wind", "ocean", "coast"))
            change = budget[f"momentum_{axis}_end"] - budget[f"momentum_{axis}_start"]
            size = sum(abs(budget[f"impulse_{n}_y"]) for n in ("wind", "ocean", "coast"))
            assert abs(change - given) < 1e-8 * size
        state, _ = remesh(scene, motion.state, None)
        state.attrs |= {"time": (k + 1) * WINDOW, "window": k + 1}
        check_state(state)
        assert not len(on_land(state, land)), f"window {k + 1}"
        assert not len(ashore(scene, state))
    assert ridged > 0.0 and pushed > 0.0
    assert float(state["area"] @ state["ice_volume"].sum("category")) == pytest.approx(
        volume, rel=1e-12
    )
    owned = float(state["area"].sum()) + state.attrs["unclaimed_water"]
    assert owned == pytest.approx(state.attrs["ocean_area"], rel=1e-12)
    mobile = state["type"].values == MOBILE
    faces = pair_arrays(state, "wall_face")
    room = clearance(faces, state["x"].values[mobile], state["y"].values[mobile])
    assert (room > 0.1 * state["radius"].values[mobile]).all()


def two_ashore() -> tuple[Scene, xr.Dataset]:
    """A state of which two elements were put on the land."""
    land, scene = bay(), a_scene()
    packing = make_packing(a_mask(land), scene.packing, 1)
    state = make_state(scene, packing, make_bonds(packing, 0.2, 0.8, False))
    state["x"].values[:2], state["y"].values[:2] = [55e3, 75e3], [85e3, 30e3]
    return scene, state


def test_elements_ashore_are_found() -> None:
    scene, state = two_ashore()
    assert list(ashore(scene, state)) == [0, 1]
    afloat = scene.model_copy(update={"effects": tuple(e for e in scene.effects if e != "coast")})
    assert not len(ashore(afloat, state))


def test_ice_pushed_ashore_joins_what_is_afloat() -> None:
    scene, state = two_ashore()
    held = float(state["area"] @ state["ice_volume"].sum("category"))
    after, terms = remesh(scene, state, None)
    check_state(after)
    assert not len(ashore(scene, after))
    assert terms["merge_elements"] == 2.0
    now = float(after["area"] @ after["ice_volume"].sum("category"))
    assert now == pytest.approx(held, rel=1e-13)
    # The ids of those that took it stay.
    assert set(after["id"].values) == set(state["id"].values[2:])


def test_ways_across_a_line_are_seen() -> None:
    land = bay()
    packing = make_packing(a_mask(land), a_scene().packing, 1)
    state = make_state(a_scene(), packing, make_bonds(packing, 0.2, 0.8, False))
    faces = pair_arrays(state, "wall_face")
    start = np.array([[55e3, 45e3], [55e3, 45e3], [20e3, 95e3]])
    end = np.array([[55e3, 35e3], [75e3, 45e3], [20e3, 95e3]])
    np.testing.assert_array_equal(crossed(faces, start, end), [True, False, False])


def test_a_wide_disc_is_not_moved_across_a_line() -> None:
    line = lines(np.array([[[-50e3, 0.0], [50e3, 0.0]]]), (0.0, 0.1))
    radius = np.full(3, 10e3)
    # From 3 km before the line to 4 km behind it, along it, and away from it.
    start = np.array([[0.0, 3e3], [0.0, 6e3], [0.0, 3e3]])
    end = np.array([[0.0, -4e3], [2e3, 6e3], [0.0, 8e3]])
    np.testing.assert_array_equal(unsafe(line, start, end, radius), [True, False, False])
    # Later the line lies between the places of the third.
    np.testing.assert_array_equal(unsafe(line, start, end, radius, 5e4), [False, False, True])
