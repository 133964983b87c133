# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes: cells that meshio reads back are the packing's, carried and turned with the elements."""

import re
from types import SimpleNamespace
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
import shapely

from floeflow.core.errors import FloeError
from floeflow.core.meshes import write_polygons, write_series
from floeflow.core.polygons import DISC_CORNERS, body_outlines, carried_outlines
from floeflow.diagnostics.collect import read_grid
from floeflow.diagnostics.mesh_series import (
    bond_lines,
    cell_fields,
    write_bonds,
    write_discs,
    write_grids,
    write_meshes,
)
from floeflow.state import read_dataset, read_state
from support.scripts import load_script
from support.synthetic import make_run


@pytest.fixture(scope="module")
def packing(run):
    return read_dataset(run.folder / "preprocess" / "packing.nc")


@pytest.fixture(scope="module")
def written(packing, states, tmp_path_factory):
    folder = tmp_path_factory.mktemp("mesh") / "new"
    paths = write_meshes(packing, states, folder)
    assert paths == [folder / f"{window:04d}.vtu" for window in range(len(states))]
    return folder


def read(path):
    """Rings and fields by id, from a mesh that meshio reads."""
    found = meshio.read(path)
    assert (found.points[:, 2] == 0).all()
    rings, fields = {}, {}
    for index, block in enumerate(found.cells):
        assert block.type == "polygon"
        for row, corners in enumerate(block.data):
            ident = int(found.cell_data["id"][index][row])
            assert ident not in rings
            rings[ident] = found.points[corners, :2]
            fields[ident] = {name: data[index][row] for name, data in found.cell_data.items()}
    return rings, fields


def cell_of(packing, index):
    first, last = packing["cell_start"].values[index : index + 2]
    return np.stack([packing[name].values[first:last] for name in ("cell_x", "cell_y")], axis=1)


def test_first_mesh_is_the_packing(written, packing):
    rings, _ = read(written / "0000.vtu")
    assert sorted(rings) == packing["id"].values.tolist()
    assert len({len(ring) for ring in rings.values()}) > 4
    for index, ident in enumerate(packing["id"].values):
        cell = cell_of(packing, index)
        if len(cell):
            np.testing.assert_allclose(rings[ident], cell, rtol=0, atol=1e-8)
            continue
        centre = packing["x"].values[index], packing["y"].values[index]
        reach = np.hypot(*(rings[ident] - centre).T)
        assert len(rings[ident]) == DISC_CORNERS
        np.testing.assert_allclose(reach, packing["radius"].values[index], rtol=1e-9)


def test_cells_move_and_turn_with_their_elements(written, packing, states):
    rings, _ = read(written / "0003.vtu")
    first, last = states[0], states[3]
    theta = last["theta"].values
    assert np.ptp(theta) > 0.1
    for index in np.flatnonzero(np.diff(packing["cell_start"].values)):
        start = shapely.Point(first["x"].values[index], first["y"].values[index])
        cell = shapely.affinity.rotate(
            shapely.Polygon(cell_of(packing, index)), theta[index], start, use_radians=True
        )
        way = [last[name].values[index] - first[name].values[index] for name in "xy"]
        cell = shapely.affinity.translate(cell, *way)
        expected = shapely.get_coordinates(cell)[:-1]
        np.testing.assert_allclose(rings[index + 1], expected, rtol=0, atol=1e-7)


def test_orientation_counts_from_that_of_the_first_state(packing, states):
    turned = [state.assign(theta=state["theta"] + 1.0) for state in states]
    plain = carried_outlines(body_outlines(packing, states[0]), states[2])
    again = carried_outlines(body_outlines(packing, turned[0]), turned[2])
    np.testing.assert_allclose(again.x, plain.x, rtol=0, atol=1e-7)
    np.testing.assert_allclose(again.y, plain.y, rtol=0, atol=1e-7)


def test_areas_add_up_and_rings_stay_whole(written, packing):
    cells = [cell_of(packing, index) for index in range(packing.sizes["element"])]
    whole = sum(shapely.Polygon(cell).area for cell in cells if len(cell))
    for name in ("0000.vtu", "0003.vtu"):
        rings, fields = read(written / name)
        mobile = [shapely.Polygon(ring) for i, ring in rings.items() if fields[i]["type"] == 1]
        assert all(cell.is_valid and cell.exterior.is_ccw for cell in mobile)
        assert sum(cell.area for cell in mobile) == pytest.approx(whole, rel=1e-12)


def test_a_cell_that_is_not_convex_comes_back_as_it_is(tmp_path):
    """An L, as the ice's edge cuts them, between a triangle and a square."""
    x = np.array([0, 1, 0, 5, 9, 9, 6, 6, 5, 10, 11, 11, 10], float)
    y = np.array([0, 0, 1, 0, 0, 1, 1, 4, 4, 0, 0, 1, 1], float)
    start = np.array([0, 3, 9, 13])
    ids = np.array([7, 8, 9])
    write_polygons(tmp_path / "l.vtu", start, x, y, {"id": ids})
    rings, _ = read(tmp_path / "l.vtu")
    areas = {ident: shapely.Polygon(ring).area for ident, ring in rings.items()}
    assert areas == {7: 0.5, 8: 7.0, 9: 1.0}
    for index, ident in enumerate(ids):
        there = slice(*start[index : index + 2])
        np.testing.assert_array_equal(rings[ident], np.stack([x[there], y[there]], axis=1))


def test_fields_are_those_of_the_state(written, states):
    _, fields = read(written / "0002.vtu")
    state = states[2]
    for index, ident in enumerate(state["id"].values):
        here = state.isel(element=index)
        found = fields[ident]
        assert found["type"] == here["type"] and found["area"] == here["area"]
        assert found["speed"] == np.hypot(here["u"], here["v"])
        np.testing.assert_array_equal(found["velocity"], [here["u"], here["v"], 0.0])
        assert found["spin"] == here["omega"]
        fraction = float(here["ice_fraction"][0])
        assert found["ice_fraction"] == fraction
        names = {"thickness": "ice_volume", "snow_thickness": "snow_volume"}
        for name, amount in names.items():
            expected = float(here[amount][0]) / fraction if fraction else np.nan
            np.testing.assert_allclose(found[name], expected, rtol=1e-15)
        warm = float(here["surface_temperature"][0]) if fraction else np.nan
        np.testing.assert_allclose(found["surface_temperature"], warm, rtol=1e-15)


def test_categories_are_averaged_over_the_ice(states):
    state = states[0].isel(element=[0])
    two = state.isel(category=[0, 0]).copy(deep=True)
    two["ice_fraction"].values[:] = [[0.2, 0.6]]
    two["ice_volume"].values[:] = [[0.1, 1.5]]
    two["surface_temperature"].values[:] = [[240.0, 260.0]]
    fields = cell_fields(two)
    assert fields["ice_fraction"][0] == pytest.approx(0.8)
    assert fields["thickness"][0] == pytest.approx(2.0)
    assert fields["surface_temperature"][0] == pytest.approx(255.0)


def test_without_thermodynamics_no_snow_is_shown(tmp_path):
    run = make_run(tmp_path, effects=("wind",), windows=1)
    fields = cell_fields(read_state(run.state(1)))
    assert not {"snow_thickness", "surface_temperature"} & set(fields)


def test_series_names_the_files_and_their_times(written, states):
    found = ElementTree.parse(written / "elements.pvd").getroot()
    assert found.tag == "VTKFile" and found.get("type") == "Collection"
    sets = list(found.iter("DataSet"))
    assert [float(each.get("timestep")) for each in sets] == [s.attrs["time"] for s in states]
    files = [written / each.get("file") for each in sets]
    assert all(file.is_file() for file in files)
    assert sorted(path.name for path in written.iterdir()) == sorted(
        ["elements.pvd", *(file.name for file in files)]
    )


def test_lost_elements_are_left_out_and_new_ones_refused(packing, states):
    body = body_outlines(packing, states[0])
    fewer = states[1].isel(element=[3, 10, 200])
    found = carried_outlines(body, fewer)
    whole = carried_outlines(body, states[1])
    assert found.id.tolist() == fewer["id"].values.tolist()
    for index, ident in enumerate(found.id):
        there = slice(*whole.start[ident - 1 : ident + 1])
        np.testing.assert_array_equal(
            found.x[slice(*found.start[index : index + 2])], whole.x[there]
        )
    strange = fewer.assign(id=fewer["id"] + 1000)
    with pytest.raises(FloeError, match="element 1004 of state 0001 is not in the packing"):
        carried_outlines(body, strange)
    with pytest.raises(FloeError, match="does not have the elements of the first state"):
        body_outlines(packing, fewer)


def test_no_polygon_is_refused(tmp_path):
    run = make_run(tmp_path, elements=False, windows=1)
    packing = read_dataset(run.folder / "preprocess" / "packing.nc")
    states = [read_state(run.state(0))]
    with pytest.raises(FloeError, match="there is no polygon to write"):
        write_meshes(packing, states, tmp_path)
    assert not list(tmp_path.glob("*.vtu"))


def test_meshes_that_cannot_be_written_leave_nothing(tmp_path):
    for name in ("a.vtu", "a.pvd"):
        (tmp_path / name).mkdir()
    corner = np.array([0.0, 1.0, 0.0])
    with pytest.raises(FloeError, match="a.vtu: cannot be written"):
        write_polygons(tmp_path / "a.vtu", np.array([0, 3]), corner, corner[::-1], {})
    with pytest.raises(FloeError, match="a.pvd: cannot be written"):
        write_series(tmp_path / "a.pvd", ["a.vtu"], [0.0])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.pvd", "a.vtu"]


def test_rule_writes_a_mesh_for_each_boundary_of_all_chunks(run, written, tmp_path):
    load_script("postprocess/mesh_files").main(
        SimpleNamespace(
            input=SimpleNamespace(
                packing=str(run.folder / "preprocess" / "packing.nc"),
                first=str(run.state(0)),
                elements=[str(path) for path in run.of_chunks("elements")],
                states=[str(run.state(int(members[-1]))) for members in run.chunks.values()],
                grid=str(run.grid),
            ),
            output=SimpleNamespace(meshes=str(tmp_path)),
        )
    )
    bonds = ElementTree.parse(tmp_path / "bonds.pvd").getroot()
    files = [each.get("file") for each in bonds.iter("DataSet")]
    assert files == ["bonds_0000.vtu", "bonds_0002.vtu", "bonds_0003.vtu"]
    assert len(meshio.read(tmp_path / files[-1]).cells_dict["line"])
    for name in ("discs", "grid"):
        sets = ElementTree.parse(tmp_path / f"{name}.pvd").getroot().iter("DataSet")
        assert [each.get("file") for each in sets] == [f"{name}_{k:04d}.vtu" for k in range(4)]
    names = ["elements.pvd", *(f"{window:04d}.vtu" for window in (0, *run.windows))]
    for name in names:
        assert (tmp_path / name).read_bytes() == (written / name).read_bytes()


def test_bonds_are_lines_that_turn_with_their_elements(states, tmp_path):
    """As the file has them: places, cracks and stretch of a bond whose element turned and moved."""
    state = states[0].copy(deep=True)
    lo, hi = (int(np.flatnonzero(state["id"] == state[f"bond_id_{e}"][0])[0]) for e in ("lo", "hi"))
    before = bond_lines(state)[0]
    state["theta"].values[lo] += np.pi / 2
    state["bond_crack_a"].values[0], state["bond_crack_b"].values[0] = 0.25, 0.5
    centre = np.array([state["x"].values[lo], state["y"].values[lo]])
    span = float(state["bond_span"][0])
    way = np.array([state[axis].values[hi] for axis in "xy"]) - centre
    for k, axis in enumerate("xy"):
        state[axis].values[hi] = centre[k] + 1.01 * span * way[k] / np.hypot(*way)
    (path,) = write_bonds([state, state.drop_dims("bond")], tmp_path)
    assert path.name == "bonds_0000.vtu"
    found = meshio.read(path)
    line = found.points[found.cells_dict["line"][0], :2]
    turned = (before - centre) @ np.array([[0.0, 1.0], [-1.0, 0.0]]) + centre
    np.testing.assert_allclose(line, turned, atol=1e-6)
    fields = {name: data[0] for name, (data,) in found.cell_data.items()}
    assert fields["crack"] == 0.75 and fields["stretch"] == pytest.approx(0.01)
    assert fields["id_lo"] == state["bond_id_lo"][0] and fields["length"] > 0


def test_discs_are_points_with_the_radius_that_contacts_see(states, tmp_path):
    paths = write_discs(states, tmp_path)
    sets = list(ElementTree.parse(tmp_path / "discs.pvd").getroot().iter("DataSet"))
    assert [each.get("file") for each in sets] == [path.name for path in paths]
    assert [float(each.get("timestep")) for each in sets] == [s.attrs["time"] for s in states]
    found, state = meshio.read(paths[2]), states[2]
    assert found.cells_dict["vertex"].ravel().tolist() == list(range(state.sizes["element"]))
    np.testing.assert_array_equal(found.points[:, 0], state["x"])
    np.testing.assert_array_equal(found.points[:, 1], state["y"])
    np.testing.assert_array_equal(found.point_data["radius"], state["radius"])
    np.testing.assert_array_equal(found.point_data["orientation"], state["theta"])
    for name, values in cell_fields(state).items():
        np.testing.assert_array_equal(found.point_data[name], values)


def test_the_grid_is_read_back_cell_by_cell(run, tmp_path):
    grid = read_grid(run.grid)
    bands = grid["siconc"].values[:, None] * np.array([0.25, 0.75])[:, None, None]
    grid["siitdconc"] = (("time", "iceband", "y", "x"), bands)
    paths = write_grids(grid, tmp_path)
    sets = list(ElementTree.parse(tmp_path / "grid.pvd").getroot().iter("DataSet"))
    assert [each.get("file") for each in sets] == [f"grid_{k:04d}.vtu" for k in range(4)]
    assert [float(each.get("timestep")) for each in sets] == grid["time"].values.tolist()
    found = meshio.read(paths[3])
    quads = found.points[found.cells_dict["quad"], :2]
    cells = shapely.polygons(quads)
    assert shapely.is_ccw(shapely.get_exterior_ring(cells)).all()
    columns = grid.sizes["x"]
    data = {name: values for name, (values,) in found.cell_data.items()}
    for row, column in ((0, 0), (3, 7), (grid.sizes["y"] - 1, columns - 1)):
        at = row * columns + column
        bounds = [grid[f"{axis}_bnds"].values[k] for axis, k in (("x", column), ("y", row))]
        assert cells[at].bounds == (bounds[0][0], bounds[1][0], bounds[0][1], bounds[1][1])
        here = grid.isel(time=3, y=row, x=column)
        for name in ("siconc", "sithick", "siu", "areacello"):
            np.testing.assert_array_equal(data[name][at], here[name])
        np.testing.assert_array_equal(data["siitdconc"][at], here["siitdconc"])
        np.testing.assert_array_equal(data["velocity"][at], [here["siu"], here["siv"], 0.0])
    assert np.nanmax(data["siconc"]) > 0.5 and np.nanmax(np.abs(data["velocity"])) > 0.0


def test_a_grid_whose_rows_go_down_has_the_same_cells(run, tmp_path):
    grid = read_grid(run.grid)
    (up, *_), (down, *_) = (
        write_grids(each, tmp_path / name)
        for name, each in (("up", grid), ("down", grid.isel(y=slice(None, None, -1))))
    )
    assert up.read_bytes() == down.read_bytes()


def test_without_bonds_there_is_no_file_of_them(states, tmp_path):
    assert write_bonds([states[0].drop_dims("bond")], tmp_path) == []
    assert not list(tmp_path.iterdir())


def test_one_module_imports_meshio(project):
    found = [
        path.relative_to(project).as_posix()
        for folder in ("floeflow", "preprocess", "simulate", "postprocess", "studies")
        for path in (project / folder).rglob("*.py")
        if re.search(r"^\s*(import|from) meshio", path.read_text(), re.MULTILINE)
    ]
    assert found == ["floeflow/core/meshes.py"]
