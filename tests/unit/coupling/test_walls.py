# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of scenes: faces from keys and meshes, what is refused, windows of ice between them."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.coupling.coupled_windows import advance_window
from floeflow.coupling.initial import make_state
from floeflow.diagnostics.budgets import dem_energy_budget, momentum_budget
from floeflow.dynamics.motion import engine_params
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import EFFECTS
from floeflow.scene.load import parse_scene
from floeflow.state.elements import element_arrays, pair_arrays
from floeflow.state.files import read_state, write_state
from floeflow.state.scene_walls import cut, make_walls
from floeflow.state.schema import check_state, expected_variables
from floeflow.state.walls import clearance, distances, join, lines, plane, too_near

SCENE = """
effects: [{effects}]
domain: {{x_min: 0.0, x_max: 4.0e4, y_min: 0.0, y_max: 4.0e4, spacing: 1.0e4}}
time: {{window: 3600.0}}
forcing: {{step: 3600.0}}
dynamics: {{samples: 6, compressive_strength: 2.0e4, contact_damping: 0.2}}
walls: {{{walls}}}
"""
SQUEEZE = "left_velocity: [1.0, 0.2]"


def a_scene(walls: str = SQUEEZE, effects: str = "friction, ridging, walls") -> Scene:
    return parse_scene(SCENE.format(walls=walls, effects=effects).encode(), "walled")


def a_packing(rows: int = 6, gap: float = 1.0) -> xr.Dataset:
    """Discs of random thickness that fill the square between 0 and 40 km."""
    radius = 2e4 / rows
    centre = radius * (2 * np.arange(rows) + 1)
    x, y = (a.ravel() for a in np.meshgrid(centre, centre))
    n = len(x)
    thickness = np.random.default_rng(3).uniform(0.2, 1.5, (n, 1))
    element = {
        "id": np.arange(1, n + 1), "type": np.ones(n, np.int8), "x": x, "y": y,
        "radius": np.full(n, gap * radius), "area": np.full(n, 4 * radius**2),
    }  # fmt: skip
    column = {"ice_fraction": np.ones((n, 1)), "ice_volume": thickness}
    data = {name: ("element", values) for name, values in element.items()}
    data |= {name: (("element", "category"), values) for name, values in column.items()}
    data["cell_start"] = ("element_bound", np.zeros(n + 1, np.int64))  # no outlines
    data |= {f"cell_{axis}": ("vertex", np.zeros(0)) for axis in "xy"}
    return xr.Dataset(data, attrs={"ocean_area": 1.7e9, "unclaimed_water": 1e8})


def squeezed(scene: Scene, folder: Path, windows: int = 2) -> tuple[list[xr.Dataset], xr.Dataset]:
    """States at all boundaries, through files, and the series of the windows."""
    states, series = [make_state(scene, a_packing(), None)], []
    folder.mkdir(exist_ok=True)
    for window in range(windows):
        path = folder / f"{window}.nc"
        write_state(states[-1], path)
        log, forcing = folder / "liggghts.log", xr.Dataset()
        done = advance_window(
            MPI.COMM_SELF, scene, read_state(path), forcing, log, lambda **_: None
        )
        states.append(done.state)
        series.append(done.series)
    return states, xr.concat(series, "window")


def write_mesh(path: Path, z: float = 300.0) -> None:
    """A square tower of 4 km, its four sides of two triangles each."""
    corners = np.array([(18e3, 18e3), (22e3, 18e3), (22e3, 22e3), (18e3, 22e3)])
    points = [(*corner, height) for height in (z - 500.0, z) for corner in corners]
    sides = [[(k, (k + 1) % 4, 4 + k), ((k + 1) % 4, 4 + (k + 1) % 4, 4 + k)] for k in range(4)]
    meshio.write(path, meshio.Mesh(np.array(points), [("triangle", np.array(sum(sides, [])))]))


def test_the_rim_stands_on_the_rectangle() -> None:
    scene = a_scene("")
    assert scene.walls.names == ("left", "right", "bottom", "top")
    apart = distances(join(make_walls(scene)), np.array([[1e4]]), np.array([[1.5e4]]))
    np.testing.assert_allclose(apart, [[1e4, 3e4, 1.5e4, 2.5e4]], rtol=1e-14)


def test_a_plane_and_its_distance() -> None:
    wall = plane(1.0, 2.0, (3.0, 4.0), (0.5, 0.0))
    assert distances(wall, np.array([4.0]), np.array([6.0]))[0] == pytest.approx(5.0)
    assert distances(wall, np.array([1.0]), np.array([0.0]))[0] == pytest.approx(-1.6)
    assert distances(wall, np.array([4.0]), np.array([6.0]), 10.0)[0] == pytest.approx(2.0)
    with pytest.raises(FloeError, match="normal of a plane must be finite and not 0"):
        plane(0.0, 0.0, (0.0, 0.0))


def test_too_near_is_nearer_than_before_and_than_ridges_leave() -> None:
    faces = lines(np.array([[[0.0, -1e4], [0.0, 1e4]]]))
    radius = np.full(5, 100.0)
    start = np.array([[50.0, 0.0], [30.0, 0.0], [10.0, 0.0], [500.0, 0.0], [9e5, 0.0]])
    end = np.array([[34.0, 0.0], [36.0, 0.0], [20.0, 0.0], [36.0, 0.0], [9e5, 1.0]])
    # 35 m are left for ridges: the first comes nearer, the third goes away from the line.
    np.testing.assert_array_equal(too_near(faces, start, end, radius), [True] + 4 * [False])
    old, new = (clearance(faces, *at.T) for at in (start, end))
    np.testing.assert_array_equal(new < np.minimum(old, 35.0), [True] + 4 * [False])
    none = np.zeros((0, 2))
    assert too_near(faces, none, none, np.zeros(0)).shape == (0,)


def test_lines_know_their_neighbours() -> None:
    # The last one is drawn the other way round.
    ends = np.array([[[0, 0], [1, 0]], [[1, 0], [1, 1]], [[0, 0], [0, 2]]], float)
    wall = lines(ends)
    assert wall["before"].tolist() == [2, 0, 0]
    assert wall["after"].tolist() == [1, -1, -1]
    with pytest.raises(FloeError, match=r"more than two lines meet at \(0, 0\) m"):
        lines(np.concatenate([ends, [[[0, 0], [3, 3]]]]))
    with pytest.raises(FloeError, match="a line without length"):
        lines(np.zeros((1, 2, 2)))


def test_a_mesh_is_cut_at_the_ice(tmp_path: Path) -> None:
    write_mesh(tmp_path / "tower.stl")
    walls = join(make_walls(a_scene(f"rim: [], mesh: {tmp_path / 'tower.stl'}")))
    assert len(walls["ax"]) == 8 and (walls["before"] >= 0).all() and (walls["after"] >= 0).all()
    length = np.hypot(walls["bx"] - walls["ax"], walls["by"] - walls["ay"])
    assert length.sum() == pytest.approx(16e3)
    apart = distances(walls, np.array([[20e3], [14e3]]), np.array([[20e3], [19e3]]))
    np.testing.assert_allclose(apart.min(1), [2e3, 4e3])


def test_a_corner_of_a_triangle_in_the_plane_makes_no_line() -> None:
    points = np.array([[0, 0, 0], [1, 0, -1], [0, 1, -1], [0, 0, 1]], float)
    ends = cut(points, np.array([[0, 1, 2], [3, 1, 2]]), "mesh")
    np.testing.assert_allclose(np.sort(ends[0], axis=0), [[0, 0], [0.5, 0.5]])
    assert len(ends) == 1


def test_bad_meshes_are_refused(tmp_path: Path) -> None:
    def fault(name: str) -> str:
        with pytest.raises(FloeError) as found:
            make_walls(a_scene(f"mesh: {tmp_path / name}"))
        return str(found.value)

    assert fault("none.stl").endswith("the mesh cannot be read: No such file or directory")
    (tmp_path / "text.stl").write_text("not a mesh at all\n")
    assert "text.stl" in fault("text.stl") and "mesh" in fault("text.stl")
    (tmp_path / "a.xyz").write_text("1 2 3\n")
    assert fault("a.xyz").endswith("is not a triangle mesh that can be read")
    quad = meshio.Mesh(np.eye(4, 3), [("quad", np.array([[0, 1, 2, 3]]))])
    meshio.write(tmp_path / "quad.vtk", quad)
    assert fault("quad.vtk").endswith("a mesh of triangles and nothing else; found quad")
    write_mesh(tmp_path / "low.stl", z=-100.0)
    assert "no triangle cuts the plane of the ice" in fault("low.stl")


def test_a_wall_in_the_ice_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FloeError, match=r"'plane_1' stands in the ice: .* lies behind it"):
        make_state(a_scene("planes: [[2.0e4, 0, 1, 0, 0, 0]]"), a_packing(), None)
    write_mesh(tmp_path / "tower.stl")
    with pytest.raises(FloeError, match=r"'mesh' stands in the ice: .* radii from it"):
        make_state(a_scene(f"mesh: {tmp_path / 'tower.stl'}"), a_packing(10), None)


@pytest.mark.parametrize(
    ("walls", "sentence"),
    [
        ("rim: []", "'walls' is named but"),
        ("rim: [left, left]", "walls.rim names a side twice"),
        ("left_velocity: [.nan, 0]", "walls.left_velocity"),
        ("planes: [[0, 0, 1, 0]]", "walls.planes"),
    ],
)
def test_bad_keys_are_refused(walls: str, sentence: str) -> None:
    with pytest.raises(FloeError, match=sentence):
        a_scene(walls)


def test_only_walls_bring_walls_to_the_state() -> None:
    both, alone = (expected_variables(e) for e in (("walls", "ridging"), ("walls",)))
    assert {name for name in both if name.startswith("wall_contact_ridge")} == {
        f"wall_contact_ridge_{name}" for name in ("closing", "thickness", "length")
    }
    assert not [name for name in alone if "ridge" in name]
    # The coast is a wall, too.
    assert set(expected_variables(("coast", "ridging"))) == set(both)
    rest = tuple(name for name in EFFECTS if name not in ("walls", "coast"))
    assert not [name for name in expected_variables(rest) if name.startswith("wall")]


def test_ice_that_overlaps_a_wall_at_the_start_is_not_pushed(tmp_path: Path) -> None:
    scene = a_scene("rim: [left, bottom]", "friction, walls")
    packing = a_packing(gap=1.3).isel(element=slice(0, 6, 5), element_bound=slice(0, 3))
    state = make_state(scene, packing, None)
    assert state.sizes["wall_contact"] == 3
    done = advance_window(
        MPI.COMM_SELF, scene, state, xr.Dataset(), tmp_path / "log", lambda **_: None
    )
    assert (done.state["u"].values == 0).all() and (done.state["v"].values == 0).all()


def test_a_moving_wall_ridges_the_ice_and_all_is_conserved(tmp_path: Path) -> None:
    scene = a_scene()
    states, series = squeezed(scene, tmp_path)
    for state in states:
        check_state(state)
    first, last = states[0], states[-1]
    volume = [float(s["area"] @ s["ice_volume"].sum("category")) for s in states]
    np.testing.assert_allclose(volume, volume[0], rtol=1e-12)
    total = [float(s["area"].sum()) + s.attrs["unclaimed_water"] for s in states]
    np.testing.assert_allclose(total, total[0], rtol=1e-12)
    assert last["area"].sum() < 0.95 * first["area"].sum()
    assert last.sizes["wall_contact"] > 10
    assert (last["wall_contact_ridge_closing"] > 10.0).any()
    for axis in "xy":
        assert (momentum_budget(series, axis).relative < 1e-10).all()
    # The wall's work is where the energy comes from.
    assert (series["work_wall"] > 0).all()
    kinetic, elastic = (
        (series[name][:, -1] - series[name][:, 0]).values
        for name in ("kinetic_energy", "elastic_energy")
    )
    energy = dem_energy_budget(series, kinetic, elastic)
    assert energy is not None and (energy.relative < 0.02).all()
    # Ice pushes the walls outwards; from sample to sample the force is the impulse given.
    assert (series["wall_force_left_x"][:, 1:] < 0).all()
    assert (series["wall_force_right_x"][-1, 3:] > 0).all()
    for axis in "xy":
        given = sum(
            -series[f"wall_force_{n}_{axis}"][:, 1:].sum("sample") for n in scene.walls.names
        )
        np.testing.assert_allclose(600.0 * given, series[f"impulse_wall_{axis}"], rtol=1e-9)


def test_forces_of_walls_are_the_same_over_a_boundary(tmp_path: Path) -> None:
    scene = a_scene()
    states, series = squeezed(scene, tmp_path)
    # A wall contact that keeps its elastic overlap times stiffness keeps its force.
    state = states[1]
    contacts, faces = (pair_arrays(state, f"wall_{kind}") for kind in ("contact", "face"))
    row = np.searchsorted(state["id"].values, contacts["id"])
    face = {name: values[contacts["face"]] for name, values in faces.items()}
    apart = distances(face, state["x"].values[row], state["y"].values[row], 3600.0)
    elastic = state["radius"].values[row] - apart - contacts["rest_overlap"]
    ice = element_arrays(state, scene.dynamics.minimum_thickness)
    push = engine_params(scene).contact_modulus * ice["thickness"][row] * np.maximum(elastic, 0)
    on_left = contacts["face"] == 0
    now = -series["wall_force_left_x"].values[1, 0]
    # At the window's start only damping comes on top, and it is held below the ridging force.
    assert push[on_left].sum() == pytest.approx(now, rel=0.05)
