# SPDX-License-Identifier: GPL-2.0-or-later
"""Gridded output: what the fields say of the ice, and what CF readers find."""

import json
import logging
from types import SimpleNamespace

import netCDF4
import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.core.constants import ICE_DENSITY, SNOW_DENSITY
from floeflow.core.errors import FloeError
from floeflow.diagnostics.budgets import grid_budget
from floeflow.diagnostics.cf_output import join_files, join_times, write_grid
from floeflow.diagnostics.gridded import gridded_fields, hat_reach, make_grid, sea_room
from floeflow.diagnostics.ice_fields import strain_rates
from floeflow.scene import load_scene
from floeflow.state import SCHEMA_VERSION, write_dataset, write_state
from floeflow.state.snapshots import write_snapshots
from floeflow.transfer import Grid
from support.scripts import load_script

CELL, SIZE, REFINE = 1.0e5, 8, 4
X0, Y0 = -4.0e5, 2.0e5
SCENE = """
name: pack
effects: [{effects}]
domain: {{crs: "EPSG:3413", x_min: -4.0e5, x_max: 4.0e5, y_min: 2.0e5, y_max: 1.0e6,
         spacing: 1.0e5}}
"""
ALL = "wind, ocean_drag, coriolis, friction, thermodynamics, snow"


@pytest.fixture
def scene(tmp_path):
    return scene_of(tmp_path, ALL)


def scene_of(folder, effects):
    path = folder / "scene.yaml"
    path.write_text(SCENE.format(effects=effects))
    return load_scene(path)


def make_mask(land_columns=0):
    """Mask grid; the first columns of mask cells are land."""
    n = SIZE * REFINE
    land = np.zeros((n, n), np.int8)
    land[:, :land_columns] = 1
    area = np.full((n, n), (CELL / REFINE) ** 2 * 0.96)
    axis = CELL / REFINE * (np.arange(n) + 0.5)
    return xr.Dataset(
        {"land": (("y", "x"), land), "cell_area": (("y", "x"), area)},
        coords={"y": Y0 + axis, "x": X0 + axis},
    )


def make_state(right=4.0e5, left=X0, per_cell=2, snow=True, thickness=None):
    """A lattice that fills the scene from left to right; a coast element in its middle."""
    step = CELL / per_cell
    x, y = (
        axis.ravel()
        for axis in np.meshgrid(
            np.arange(left + step / 2, right, step), np.arange(Y0 + step / 2, Y0 + 8e5, step)
        )
    )
    n = len(x) + 1
    fraction = np.append(0.8 + 1e-7 * x, 0.0)
    thick = np.append(2.0 + 1e-6 * x if thickness is None else thickness(x, y), 0.0)
    x, y = np.append(x, 0.0), np.append(y, 6e5)
    values = {
        "theta": np.zeros(n),
        "u": 0.1 + 1e-7 * y,
        "v": -0.05 + 1e-7 * x,
        "omega": np.zeros(n),
        "radius": np.full(n, step / 2),
        "area": np.append(np.full(n - 1, 0.96 * step**2), 0.0),
    }
    data = xr.Dataset(
        {
            "id": ("element", np.arange(1, n + 1)),
            "type": ("element", np.append(np.ones(n - 1), 2).astype(np.int8)),
            "x": ("element", x),
            "y": ("element", y),
            **{name: ("element", v) for name, v in values.items()},
            "ice_fraction": (("element", "category"), fraction[:, None]),
            "ice_volume": (("element", "category"), (fraction * thick)[:, None]),
        }
    )
    if snow:
        data["snow_volume"] = 0.1 * data["ice_fraction"]
        data["surface_temperature"] = 250.0 + 0.0 * data["ice_fraction"]
    for name in ("id_lo", "id_hi"):
        data[f"contact_{name}"] = ("contact", np.zeros(0, dtype=np.int64))
    for name in ("slip", "rest_overlap"):
        data[f"contact_{name}"] = ("contact", np.zeros(0))
    data.attrs = {
        "schema_version": SCHEMA_VERSION,
        "scene": "pack",
        "effects": " ".join((ALL if snow else "wind").split(", ")),
        "window": 2,
        "time": 172800.0,
        "start": "1981-12-31T00:00:00",
        "seed": 1,
        "crs": "EPSG:3413",
        "ocean_area": 6.4e11,
        "unclaimed_water": 0.0,
        "provenance": json.dumps({}),
    }
    return data


GRID = Grid(X0 + CELL * (np.arange(SIZE) + 0.5), Y0 + CELL * (np.arange(SIZE) + 0.5))


def gridded(state, land_columns=0, transfer="conservative"):
    """Fields of a state, and the area of sea in the cells."""
    room = sea_room(make_mask(land_columns), GRID, hat_reach(state, GRID))
    return gridded_fields(state, room, transfer), room.area


NX, NY = np.meshgrid(GRID.x, GRID.y)


def test_linear_ice_comes_out_as_it_is():
    """Products of linear fields are not linear: volumes carry the averages a little with them."""
    fields, _ = gridded(make_state())
    np.testing.assert_allclose(fields["siconc"], 0.8 + 1e-7 * NX, rtol=1e-10)
    np.testing.assert_allclose(fields["sithick"], 2.0 + 1e-6 * NX, rtol=1e-4)
    np.testing.assert_allclose(fields["sivol"], fields["siconc"] * fields["sithick"], rtol=1e-12)
    np.testing.assert_allclose(fields["siu"], 0.1 + 1e-7 * NY, rtol=1e-3)
    np.testing.assert_allclose(fields["siv"], -0.05 + 1e-7 * NX, rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(fields["sisnthick"], 0.1, rtol=1e-12)
    assert (fields["remap_method"] == 2).all()


def test_linear_thickness_of_even_ice_is_exact():
    state = make_state()
    state["ice_volume"] = state["ice_volume"] / state["ice_fraction"].where(
        state["ice_fraction"] > 0, 1.0
    )
    state["ice_fraction"] = state["ice_fraction"].where(state["ice_fraction"] == 0, 1.0)
    fields, _ = gridded(state)
    np.testing.assert_allclose(fields["siconc"], 1.0, rtol=1e-12)
    np.testing.assert_allclose(fields["sithick"], 2.0 + 1e-6 * NX, rtol=1e-10)


def test_edge_is_partly_covered_and_beyond_it_there_is_no_ice():
    state = make_state(right=0.5e5)
    fields, sea = gridded(state)
    np.testing.assert_allclose(fields["siconc"][:, :4], (0.8 + 1e-7 * NX)[:, :4], rtol=1e-10)
    inside = fields["siconc"][:, 4]
    assert ((inside > 0.3) & (inside < 0.5)).all()
    assert (fields["siconc"][:, 6:] == 0).all() and (fields["sivol"][:, 6:] == 0).all()
    assert np.isnan(fields["sithick"][:, 6:]).all() and np.isnan(fields["siu"][:, 6:]).all()
    low, high = state["ice_fraction"].values[:-1].min(), state["ice_fraction"].values.max()
    assert (fields["siconc"] <= high).all() and low > 0


def test_no_ice_on_land_and_full_cells_at_the_coast():
    """Land to the middle of the second cell; the sea beside it is full, so its cells are."""
    state = make_state(left=X0 + 1.5e5)
    fields, sea = gridded(state, land_columns=6)
    np.testing.assert_allclose(sea[0, :3] / (0.96 * CELL**2), [0, 0.5, 1], rtol=1e-12)
    assert np.isnan(fields["siconc"][:, 0]).all() and (fields["remap_method"][:, 0] == 0).all()
    expected = (0.8 + 1e-7 * NX)[:, 1:]
    assert np.abs(fields["siconc"][:, 1:] / expected - 1).max() < 0.02
    total = (state["area"] * state["ice_fraction"][:, 0]).values.sum()
    assert abs(fields["siarea_residual"]) < 1e-14 * total
    assert np.nansum(fields["siconc"] * sea) == pytest.approx(total, rel=1e-14)


def uneven():
    """A state that no transfer brings to the grid without an error."""
    state = make_state(right=2.3e5, thickness=lambda x, y: 1 + np.sin(x / 1e5) ** 2)
    state["ice_fraction"] *= 1 - 0.2 * np.sin(state["x"] / 1.5e5) ** 2
    return state


@pytest.mark.parametrize(("transfer", "method"), [("mls", 2), ("shepard", 1), ("nearest", 4)])
def test_plain_averages_leave_totals_open_and_say_so(transfer, method):
    state = uneven()
    fields, sea = gridded(state, transfer=transfer)
    ice = fields["siconc"] > 0
    assert (fields["remap_method"][ice] == method).all()
    total = float((state["area"] * state["ice_volume"].sum("category")).sum())
    missing = float(fields["sivolume_residual"])
    assert 1e-6 * total < abs(missing) < 0.05 * total
    assert np.nansum(fields["sivol"] * sea) == pytest.approx(total + missing, rel=1e-12)
    budget = grid_budget(
        *("ice_volume", "Ice volume on the grid", "m3"),
        xr.DataArray([total + missing], dims="grid", coords={"grid_window": ("grid", [0])}),
        *(np.array([total]), np.zeros(1)),
    )
    assert budget.summary()["verdict"] == "open"
    thick = (state["ice_volume"] / state["ice_fraction"]).values[:-1]
    assert (fields["sithick"][ice] >= thick.min() - 1e-12).all()
    assert (fields["sithick"][ice] <= thick.max() + 1e-12).all()


def test_transfers_differ_as_their_orders_do():
    """A plane is exact for least squares, and off by its slope to the nearest element."""
    state = make_state(per_cell=3)
    off = {}
    for transfer in ("mls", "shepard", "nearest"):
        fields, _ = gridded(state, transfer=transfer)
        off[transfer] = np.abs(fields["sithick"] - (2.0 + 1e-6 * NX)).max()
    assert off["mls"] < 1e-12 < off["shepard"]
    state["x"] = state["x"] + 0.2e5
    fields, _ = gridded(state, transfer="nearest")
    thick = (state["ice_volume"] / state["ice_fraction"]).values[:-1, 0]
    away = np.hypot(state["x"].values[:-1] - GRID.x[3], state["y"].values[:-1] - GRID.y[4])
    assert fields["sithick"][4, 3] == pytest.approx(thick[np.argmin(away)], rel=1e-14)


def test_totals_are_those_of_the_elements():
    state = make_state(right=2.3e5, thickness=lambda x, y: 1 + np.sin(x / 1e5) ** 2)
    state["ice_fraction"] *= 1 - 0.2 * np.sin(state["x"] / 1.5e5) ** 2
    fields, sea = gridded(state)
    area, ice = state["area"].values, state["ice_fraction"].values[:, 0]
    snow = np.nansum(fields["siconc"] * fields["sisnthick"] * sea)
    assert snow == pytest.approx((area * state["snow_volume"].values[:, 0]).sum(), rel=1e-13)
    for field, name, residual in (
        ("siconc", ice, "siarea_residual"),
        ("sivol", state["ice_volume"].values[:, 0], "sivolume_residual"),
    ):
        elements = (area * name).sum()
        grid = np.nansum(fields[field] * sea)
        assert grid == pytest.approx(elements, rel=1e-13)
        assert abs(fields[residual]) <= 1e-13 * elements
    volume, snowy = (state[name].values[:, 0] for name in ("ice_volume", "snow_volume"))
    mass = area * (ICE_DENSITY * volume + SNOW_DENSITY * snowy)
    on_grid = sea * (
        ICE_DENSITY * fields["sivol"] + SNOW_DENSITY * fields["siconc"] * fields["sisnthick"]
    )
    for field, name in (("siu", "u"), ("siv", "v")):
        momentum = (mass * state[name].values).sum()
        assert np.nansum(on_grid * fields[field]) == pytest.approx(momentum, rel=1e-12)


def test_elements_that_left_the_grid_are_not_on_it():
    state = make_state()
    state["x"] = state["x"] + 1.2 * CELL
    fields, sea = gridded(state)
    ice = (state["area"] * state["ice_fraction"][:, 0]).values
    gone = state["x"].values - state["radius"].values >= 4e5
    assert fields["siarea_outside"] == pytest.approx(ice[gone].sum(), rel=1e-13)
    assert ice[gone].sum() > 0.05 * ice.sum()
    total = np.nansum(fields["siconc"] * sea)
    assert total == pytest.approx(ice[~gone].sum(), rel=1e-13)


def test_more_ice_than_sea_is_said():
    """Elements that overlap by a fifth: the grid is full, and what has no room is counted."""
    state = make_state()
    state["area"] = 1.2 * state["area"]
    state["ice_fraction"] = state["ice_fraction"].where(state["ice_fraction"] == 0, 1.0)
    fields, sea = gridded(state)
    np.testing.assert_allclose(fields["siconc"], 1.0, rtol=1e-14)
    assert fields["siarea_residual"] == pytest.approx(-0.2 * sea.sum(), rel=1e-12)


@pytest.mark.parametrize("per_cell", [0.5, 1, 2])
def test_no_ice_farther_than_one_cell_from_an_element(per_cell):
    state = make_state(right=-1e5, per_cell=per_cell)
    fields, _ = gridded(state)
    edge = (state["x"] + state["radius"]).values[:-1].max()
    assert (fields["siconc"][NX - edge > CELL] == 0).all()
    assert (fields["siconc"][NX < edge] > 0).all()


def test_thickness_stays_within_its_elements():
    state = make_state(right=1.1e5, thickness=lambda x, y: np.where(x > 0, 0.01, 4.0))
    fields, sea = gridded(state)
    assert np.nanmin(fields["sithick"]) >= 0.01 * (1 - 1e-12)
    assert np.nanmax(fields["sithick"]) <= 4.0 * (1 + 1e-12)


def test_elements_without_ice_give_no_thickness_and_no_elements_no_ice():
    bare = make_state()
    for name in ("ice_fraction", "ice_volume", "snow_volume"):
        bare[name] = 0.0 * bare[name]
    for state in (bare, make_state(right=X0)):
        fields, sea = gridded(state)
        assert (fields["siconc"] == 0).all() and (fields["sivol"] == 0).all()
        assert np.isnan(fields["sithick"]).all() and np.isnan(fields["siu"]).all()
        assert fields["siarea_residual"] == 0


def test_hats_are_about_two_elements_wide():
    for per_cell, reach in ((0.25, 8), (0.5, 4), (1, 2), (2**0.5, 2), (2, 1), (10, 1)):
        assert hat_reach(make_state(per_cell=per_cell), GRID) == reach
    assert hat_reach(make_state(right=X0), GRID) == 1


def test_sparse_elements_leave_no_holes():
    fields, _ = gridded(make_state(per_cell=0.5))
    expected = 0.8 + 1e-7 * NX
    assert np.abs(fields["siconc"] / expected - 1).max() < 0.2
    assert np.isfinite(fields["siu"]).all()


def test_file_is_cf(scene, tmp_path):
    path = tmp_path / "grid" / "0002.nc"
    write_grid(make_grid(scene, make_state(right=0.5e5), make_mask(6)), path)
    assert [p.name for p in path.parent.iterdir()] == ["0002.nc"]
    with netCDF4.Dataset(path) as file:
        assert file.Conventions == "CF-1.11"
        for name in ("siconc", "sithick", "sivol", "sisnthick", "siu", "siv"):
            variable = file[name]
            assert variable.dimensions == ("time", "y", "x")
            assert variable._FillValue == 1e20
            assert variable.coordinates == "lat lon"
            crs = pyproj.CRS.from_cf(
                {
                    k: file[variable.grid_mapping].getncattr(k)
                    for k in file[variable.grid_mapping].ncattrs()
                }
            )
            assert crs == pyproj.CRS("EPSG:3413")
            measure = variable.cell_measures.removeprefix("area: ")
            assert file[measure].dimensions == ("y", "x") and file[measure].units == "m2"
            assert variable.cell_methods.startswith("area: mean where ")
            assert variable.cell_methods.endswith(" time: point")
        for axis in ("time", "y", "x"):
            bounds = file[file[axis].bounds]
            assert bounds.dimensions == (axis, "bnds") and "_FillValue" not in bounds.ncattrs()
        assert file["y_bnds"][0].tolist() == [2e5, 3e5]
        assert file["time"].units == "seconds since 1981-12-31 00:00:00"
    with xr.open_dataset(path, decode_coords="all") as data:
        assert data["time"].values[0] == np.datetime64("1982-01-02")
        assert np.isnan(data["siconc"].values[0, :, 0]).all()
        assert data["lat"].values.max() < 90 and data["lat"].values.min() > 75
        assert {"time_bnds", "x_bnds", "y_bnds", "crs", "sea_area"} <= set(data.coords)
        fraction = data["sea_area_fraction"].values[0]
        np.testing.assert_allclose(fraction, [0, 0.5, 1, 1, 1, 1, 1, 1])


def test_without_thermodynamics_there_is_no_snow(tmp_path):
    data = make_grid(scene_of(tmp_path, "wind"), make_state(snow=False), make_mask())
    assert "sisnthick" not in data and "sithick" in data


def test_states_of_one_mask_share_the_sea_in_the_cells(tmp_path):
    scene, mask = scene_of(tmp_path, "wind"), make_mask()
    first, second = make_state(snow=False), make_state(right=0.5e5, snow=False)
    rooms = {}
    shared = [make_grid(scene, state, mask, rooms=rooms) for state in (first, second)]
    assert set(rooms) == {hat_reach(state, GRID) for state in (first, second)}
    for made, state in zip(shared, (first, second), strict=True):
        assert made.identical(make_grid(scene, state, mask))


def later(state, window):
    """The state at another window's end."""
    moved = state.copy(deep=True)
    moved.attrs |= {"window": window, "time": 86400.0 * window}
    return moved


def test_rule_writes_the_same_bytes_twice(scene, tmp_path, caplog):
    write_state(make_state(), tmp_path / "0000.nc")
    write_snapshots([later(make_state(), k) for k in (1, 2)], tmp_path / "elements.nc")
    write_dataset(make_mask(), tmp_path / "mask.nc")
    files = []
    for name in ("a.nc", "b.nc"):
        rule = SimpleNamespace(
            input=SimpleNamespace(
                scene=tmp_path / "scene.yaml",
                start=[tmp_path / "0000.nc"],
                elements=tmp_path / "elements.nc",
                mask=tmp_path / "mask.nc",
            ),
            output=SimpleNamespace(fields=tmp_path / name),
        )
        with caplog.at_level(logging.INFO):
            load_script("postprocess/fields").main(rule)
        assert "siarea: grid minus elements" in caplog.text
        files.append((tmp_path / name).read_bytes())
    assert files[0] == files[1]


def test_files_joined_are_the_fields_of_all_times(scene, tmp_path):
    """Chunks of two and of one time in a file; the joined one is as if made at once."""
    states = [later(make_state(right=X0 + k * CELL), k) for k in (1, 2, 3)]
    made = [make_grid(scene, state, make_mask()) for state in states]
    parts = [tmp_path / "0002.nc", tmp_path / "0003.nc"]
    write_grid(join_times(made[:2]), parts[0])
    write_grid(join_times(made[2:]), parts[1])
    join_files(parts, tmp_path / "grid.nc")
    write_grid(join_times(made), tmp_path / "once.nc")
    with netCDF4.Dataset(tmp_path / "grid.nc") as one, netCDF4.Dataset(tmp_path / "once.nc") as two:
        assert one.dimensions["time"].isunlimited() and len(one.dimensions["time"]) == 3
        assert {n: one.getncattr(n) for n in one.ncattrs()} == {
            n: two.getncattr(n) for n in two.ncattrs()
        }
        assert set(one.variables) == set(two.variables)
        for name, variable in one.variables.items():
            other = two[name]
            assert variable.dimensions == other.dimensions and variable.dtype == other.dtype
            assert variable.__dict__.keys() == other.__dict__.keys(), name
            # Missing values are where they were.
            np.testing.assert_array_equal(
                np.ma.getmaskarray(variable[...]), np.ma.getmaskarray(other[...]), err_msg=name
            )
            np.testing.assert_array_equal(variable[...], other[...], err_msg=name)
    with xr.open_dataset(tmp_path / "grid.nc") as data:
        assert data["window"].values.tolist() == [1, 2, 3]
        shares = [float(data["siconc"][k].sum()) for k in range(3)]
        assert shares[0] < shares[1] < shares[2]


def test_a_damaged_part_is_named_and_nothing_is_joined(scene, tmp_path):
    write_grid(make_grid(scene, make_state(), make_mask()), tmp_path / "0001.nc")
    (tmp_path / "0002.nc").write_bytes(b"no NetCDF")
    with pytest.raises(FloeError, match="0002.nc: cannot be read as NetCDF"):
        join_files([tmp_path / "0001.nc", tmp_path / "0002.nc"], tmp_path / "grid.nc")
    assert not (tmp_path / "grid.nc").exists()


def test_faults_are_one_sentence(scene, tmp_path):
    mask = make_mask().isel(x=slice(0, 30))
    with pytest.raises(FloeError, match="mask: its 32 x 30 cells do not divide 8 x 8"):
        make_grid(scene, make_state(), mask)
    (tmp_path / "file").write_text("in the way")
    data = make_grid(scene, make_state(), make_mask())
    with pytest.raises(FloeError, match="cannot be written"):
        write_grid(data, tmp_path / "file" / "grid.nc")


def test_strain_rates_of_linear_motion_are_exact():
    x, y = np.meshgrid(1e5 * np.arange(6.0), 5e4 * np.arange(5.0))
    u, v = 1e-6 * x + 3e-6 * y, -2e-6 * x + 4e-6 * y
    divergence, shear = strain_rates(u, v, (1e5, 5e4))
    np.testing.assert_allclose(divergence, 5e-6)
    np.testing.assert_allclose(shear, np.hypot(3e-6, 1e-6))
    # Turning alone deforms nothing; a cell without neighbours says nothing.
    still, turned = strain_rates(-1e-5 * y, 1e-5 * x, (1e5, 5e4))
    np.testing.assert_allclose(still, 0.0, atol=1e-20)
    np.testing.assert_allclose(turned, 0.0, atol=1e-20)
    lonely = np.full((3, 3), np.nan)
    lonely[1, 1] = 1.0
    assert np.isnan(strain_rates(lonely, lonely, (1.0, 1.0))).all()
