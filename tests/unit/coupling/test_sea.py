# SPDX-License-Identifier: GPL-2.0-or-later
"""The sea on the scene's grid: shares, heat and salt that close, water that cools and freezes."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.column.settings import column_settings
from floeflow.column.unsolved import UnsolvedError
from floeflow.core.errors import FloeError
from floeflow.coupling import columns as coupling_columns
from floeflow.coupling.columns import advance_columns, totals
from floeflow.coupling.gates import far_share, gate_fluxes
from floeflow.coupling.growth import growth_places, without
from floeflow.coupling.initial import make_state
from floeflow.coupling.rims import SIDES, export_ice, inflow_ice
from floeflow.coupling.sea.birth import OpenIce, icy, place_discs
from floeflow.coupling.sea.ice import add_terms, held_by
from floeflow.coupling.sea.places import SeaPlaces, sea_places
from floeflow.coupling.sea.shares import build_shares
from floeflow.coupling.sea.water import (
    freezing_points,
    gain_heat,
    heat_capacity,
    read_water,
    relax_heat,
    with_water,
)
from floeflow.coupling.series import series_dataset, volumes
from floeflow.coupling.window_end import end_at_sea
from floeflow.dynamics.motion import Motion
from floeflow.packings.packing import make_packing
from floeflow.scene.load import build_scene
from floeflow.state.elements import element_arrays
from floeflow.state.schema import check_state
from floeflow.transfer import Grid

HALF = 2.0e5  # m
EFFECTS = ["wind", "ocean_drag", "thermodynamics", "snow", "shortwave", "lateral_melt"]
EFFECTS += ["frazil", "mixed_layer", "rims"]


def scene_of(scheme: str = "zero_layer", **more):
    domain = {
        f"{axis}_{end}": sign * HALF for axis in "xy" for end, sign in (("min", -1), ("max", 1))
    }
    keys = {
        "name": "pool",
        "effects": EFFECTS,
        "domain": {**domain, "spacing": 5.0e4},
        "packing": {"elements": 30, "relaxations": 2},
        "column": {"scheme": scheme, "categories": 1 if scheme == "zero_layer" else 3},
        **more,
    }
    return build_scene(keys)


def mask_of(scene, warm: float = 2.0) -> xr.Dataset:
    """Ice on the left half, warm water (K above freezing) on the right, land in one corner."""
    spacing = scene.domain.spacing / scene.mask.refine
    x = np.arange(-HALF + 0.5 * spacing, HALF, spacing)
    ice = np.broadcast_to(x < 0.0, (x.size, x.size)).astype(float)
    land = np.zeros((x.size, x.size), dtype=np.int8)
    land[:6, :6] = 1
    ice = np.where(land > 0, 0.0, ice)
    sst = np.full(ice.shape, 273.15 - 0.054 * 34.0) + warm * (1.0 - ice)
    fields = {"siconc": 0.9 * ice, "sithick": 1.5 * ice, "land": land, "sst": sst}
    fields["cell_area"] = np.full(ice.shape, spacing**2)
    data = {name: (("y", "x"), values) for name, values in fields.items()}
    return xr.Dataset(data, {"x": x, "y": x}, {"crs": scene.domain.crs})


def pool(scheme: str = "zero_layer", warm: float = 2.0, **more):
    """Scene, its state at the start and its sea."""
    scene = scene_of(scheme, **more)
    mask = mask_of(scene, warm)
    packing = make_packing(mask, scene.packing, scene.seed, coast_effect=False)
    nodes = np.arange(-HALF + 2.5e4, HALF, 5.0e4)
    return scene, make_state(scene, packing, None, mask), sea_places(mask, nodes, nodes)


def weather(scene, air: float, heat: float = 0.0, seconds: float = 86400.0) -> xr.Dataset:
    nodes = np.arange(-HALF + 2.5e4, HALF, 5.0e4)
    values = {
        "wind_u": 8.0,
        "wind_v": 0.0,
        "ocean_u": 0.02,
        "ocean_v": 0.0,
        "air_temperature": air,
        "specific_humidity": 1.0e-3,
        "air_pressure": 1.01e5,
        "longwave_down": 180.0,
        "shortwave_down": 0.0,
        "snowfall": 1.0e-6,
        "ocean_heat_flux": heat,
    }
    shape = (2, nodes.size, nodes.size)
    data = {name: (("time", "y", "x"), np.full(shape, value)) for name, value in values.items()}
    return xr.Dataset(data, {"time": [0.0, seconds], "y": nodes, "x": nodes})


def windows(scene, state, places, forcing, count: int):
    """State after windows of the column and the sea alone, and the sums of their terms."""
    total: dict[str, float] = {}
    for _ in range(count):
        state, each, terms, found = advance_columns(
            MPI.COMM_SELF, scene, state, forcing, (0.0, 86400.0), state["area"].values, places
        )
        terms = add_terms(totals(each), terms)
        state, more, _ = end_at_sea(scene, state, found, places)
        for part in (terms, more):
            for name, value in part.items():
                total[name] = total.get(name, 0.0) + value
    return state, total


def stocks(scene, state, places) -> dict[str, float]:
    """Heat (J), salt (kg) and water (kg) of ice and sea, and ice volume (m3)."""
    settings = column_settings(scene)
    water = read_water(state, places.area, settings)
    mobile = state["type"].values == 1
    names = [name for name in state.data_vars if state[name].dims[0] == "element"]
    held = held_by({name: state[name].values[mobile] for name in names}, settings)
    area = state["area"].values[mobile]
    ice = {name: float(area @ value) for name, value in held.items()}
    return {
        "heat": ice["energy"] + water.total_heat,
        "salt": ice["salt"] + water.total_salt,
        "water": ice["water"],
        "ice": ice["ice_volume"],
    }


def test_shares_are_whole_and_a_packed_sea_has_no_water_between():
    grid = Grid(np.arange(0.5, 8) * 1e5, np.arange(0.5, 8) * 1e5)
    rng = np.random.default_rng(1)
    # A jittered lattice of elements that fills the left half to its last square metre.
    px, py = np.meshgrid(np.arange(0.25, 4, 0.5) * 1e5, np.arange(0.25, 8, 0.5) * 1e5)
    x, y = (p.ravel() + rng.uniform(-1.2e4, 1.2e4, p.size) for p in (px, py))
    area = np.full(x.size, 2.5e9)
    sea = np.full(grid.shape, 1e10)
    shares = build_shares(x, y, area, grid, sea)
    np.testing.assert_allclose(shares.matrix.sum(axis=1), 1.0, rtol=1e-12)
    amount = rng.normal(size=x.size)
    assert shares.give(amount).sum() == pytest.approx(amount.sum(), abs=1e-9)
    field = rng.normal(size=sea.size)
    # Reading and giving are adjoint: <give a, f> = <a, read f>.
    assert shares.give(amount) @ field == pytest.approx(amount @ shares.read(field), rel=1e-12)
    # Away from the ice's edge, which hats blur over the cells beside it.
    inner = shares.open_area.reshape(grid.shape)[:, :2]
    assert inner.max() < 0.02 * 1e10
    assert shares.open_area.reshape(grid.shape)[:, 5:].min() > 0.99e10


def test_crowded_elements_see_no_more_than_there_is():
    grid = Grid(np.arange(0.5, 3) * 1e5, np.arange(0.5, 3) * 1e5)
    sea = np.zeros((3, 3))
    sea[1, 1] = 1e10
    x = y = np.array([1.5e5, 1.5e5, 2.9e5])  # two over each other, one on land
    area = np.array([1e10, 0.5e10, 0.5e10])
    shares = build_shares(x, y, area, grid, sea)
    stock = np.zeros(9)
    stock[4] = 3.0
    assert area @ shares.read_stock(stock) == pytest.approx(3.0 * 1e10, rel=1e-12)
    assert shares.open_area.max() == 0.0


@pytest.mark.parametrize("scheme", ["zero_layer", "bl99", "mushy"])
def test_heat_salt_and_water_of_ice_and_sea_close(scheme: str):
    scene, first, places = pool(scheme, warm=0.1)
    forcing = weather(scene, 243.0, heat=5.0)
    last, terms = windows(scene, first, places, forcing, 4)
    check_state(last)
    before, after = stocks(scene, first, places), stocks(scene, last, places)
    assert terms["sea_born"] > 0  # the water beside the ice was cold enough to freeze
    came = sum(terms[f"energy_{name}"] for name in ("atmosphere", "ocean", "snowfall"))
    moved = abs(terms["energy_atmosphere"])
    assert after["heat"] - before["heat"] == pytest.approx(came, abs=1e-11 * moved)
    assert terms["energy_stored"] == pytest.approx(came, abs=1e-11 * moved)
    salt = terms["sea_salt_deep"]
    assert after["salt"] - before["salt"] == pytest.approx(salt, abs=1e-9 * abs(salt))
    grown = sum(v for k, v in terms.items() if k.startswith("growth_"))
    assert after["ice"] - before["ice"] == pytest.approx(grown, rel=1e-10)
    assert float(last["area"].sum()) + last.attrs["unclaimed_water"] == pytest.approx(
        float(first["area"].sum()) + first.attrs["unclaimed_water"], rel=1e-12
    )


@pytest.mark.parametrize("scheme", ["bl99", "mushy"])
def test_solves_for_temperatures_are_counts_of_the_window(scheme: str):
    scene, state, places = pool(scheme)
    cold, area, hours = weather(scene, 250.0), state["area"].values, (0.0, 7200.0)
    _, each, terms, _ = advance_columns(MPI.COMM_SELF, scene, state, cold, hours, area, places)
    # Of each category with ice in each step of an hour, whatever the areas.
    assert 0 < terms["temperature_solves"] < 2 * 3 * 200
    assert terms["temperature_solves"].is_integer() and terms["temperature_unconverged"] == 0
    assert not [name for name in each if name.startswith("temperature_")]
    data = series_dataset(Motion(state), terms, 0.0)
    assert data["temperature_rescued"].attrs["units"] == "1"


def test_a_column_without_a_solution_stops_the_run_and_names_the_place(monkeypatch):
    scene, state, places = pool()

    def stuck(*_):
        raise UnsolvedError(np.array([2, 4]), 30, 1e-3)

    monkeypatch.setattr(coupling_columns, "advance_slice", stuck)
    x, y = (state[name].values[state["type"].values == 1][2] for name in "xy")
    place = re.escape(f"in 2 of 30 columns, first in the one at ({x:.6g}, {y:.6g}) m: they still")
    with pytest.raises(FloeError, match=place):
        windows(scene, state, places, weather(scene, 250.0), 1)


def test_warm_water_does_not_freeze_before_it_is_cold():
    scene, first, places = pool(warm=2.0)
    forcing = weather(scene, 253.0)
    capacity = heat_capacity(column_settings(scene))
    state, terms = windows(scene, first, places, forcing, 1)
    right = np.s_[:, 5:]
    freezing = 273.15 - 0.054 * 34.0
    cooled = first["sea_temperature"].values[right] - state["sea_temperature"].values[right]
    assert (cooled > 0.05).all() and (state["sea_temperature"].values[right] > freezing).all()
    assert terms["sea_born"] == 0
    # What the air took per square metre is what the water lost.
    assert cooled.mean() * capacity < 800.0 * 86400.0
    assert state["pending_freeze"].values[right].max() == 0.0
    count = first.sizes["element"]
    for _ in range(14):
        state, terms = windows(scene, state, places, forcing, 1)
        if terms["sea_born"]:
            break
    assert terms["sea_born"] > 0 and state.sizes["element"] > count
    born = state["id"].values > count
    assert (state["x"].values[born] > 0.0).any()
    # Over open water that was never below its freezing point by more than it lacks.
    assert (state["sea_temperature"].values >= freezing - 1e-9).all()


def test_heat_from_below_keeps_the_sea_open():
    scene, first, places = pool(warm=0.5)
    cold, terms = windows(scene, first, places, weather(scene, 258.0), 6)
    kept, warmed = windows(scene, first, places, weather(scene, 258.0, heat=400.0), 6)
    assert terms["sea_born"] > 0 and warmed["sea_born"] == 0
    sea = places.area.sum()
    # Where elements overlap a cell has more area to warm than sea.
    assert warmed["energy_ocean"] == pytest.approx(400.0 * 6 * 86400.0 * sea, rel=1e-3)


def test_relaxation_brings_what_it_says():
    scene, state, places = pool()
    water = read_water(state, places.area, column_settings(scene))
    target = np.full(water.area.size, 276.0)
    after, gained = relax_heat(water, target, 86400.0, 86400.0)
    assert after.total_heat - water.total_heat == pytest.approx(gained, rel=1e-10)
    far = (after.heat - water.capacity * 2.85) / (water.heat - water.capacity * 2.85)
    np.testing.assert_allclose(far[water.area > 0], np.exp(-1.0), rtol=1e-9)


def test_heat_that_is_lacking_is_no_temperature():
    scene, state, places = pool()
    water = read_water(state, places.area, column_settings(scene))
    cold = gain_heat(water, -3.0e8 * water.area)
    state = with_water(state, cold)
    freezing = freezing_points(water.salinity, water.settings).reshape(places.area.shape)
    assert (state["sea_temperature"].values >= freezing).all()
    assert state["pending_freeze"].values.max() > 0.0
    again = read_water(state, places.area, column_settings(scene))
    np.testing.assert_allclose(again.heat, cold.heat, rtol=0, atol=1e-3)


@pytest.mark.parametrize("air", [243.0, 271.3])
def test_growth_by_places_is_that_of_the_sums(air: float):
    """New ice and what melts back of it, and an element that dissolves: nothing is lost."""
    scene, state, places = pool(warm=0.0)
    state["ice_fraction"][:2] = 0.004
    state["ice_volume"][:2] = 0.001
    state["snow_volume"][:2] = 0.0
    forcing = weather(scene, air)
    state, each, terms, found = advance_columns(
        MPI.COMM_SELF, scene, state, forcing, (0.0, 86400.0), state["area"].values, places
    )
    assert found is not None and len(found.cells)
    made = growth_places(state, (each,), (found,), places)
    _, more, back = end_at_sea(scene, state, found, places)
    assert back is not None and more["sea_gone"] + more["sea_born"] + more["sea_melted_back"] > 0
    left, total = without(made, back), add_terms(totals(each), terms, more)
    whole = sum(values.sum() for name, values in left.items() if name.startswith("growth_"))
    wanted = sum(value for name, value in total.items() if name.startswith("growth_"))
    assert whole == pytest.approx(wanted, rel=1e-12)
    fresh = total["growth_new_ice"] - total["sea_melted_back"]
    assert left["growth_new_ice"].sum() == pytest.approx(fresh, rel=1e-12)
    cover = total["ice_area_grown"] + total["ice_area_dissolved"]
    assert left["ice_area_grown"].sum() == pytest.approx(cover, rel=1e-12)
    assert len(left["grown_x"]) == len(each["growth_base"]) + len(found.cells)


@pytest.mark.parametrize("ridging", [True, False])
def test_ice_used_up_alone_is_the_seas(ridging):
    more = [*EFFECTS, "friction", "ridging"] if ridging else EFFECTS
    scene, state, places = pool(effects=more)
    state["area"][0] *= 0.04
    state["x"][0], state["y"][0] = 1.8e5, 1.8e5
    none = OpenIce(np.zeros(0, int), np.zeros(0), _no_columns(state), _shares(state, places))
    after, terms, back = end_at_sea(scene, state, none, places)
    assert terms["sea_gone"] == (1.0 if ridging else 0.0)
    before, now = stocks(scene, state, places), stocks(scene, after, places)
    assert now["heat"] == pytest.approx(before["heat"], rel=1e-13)
    assert back is not None
    lost = float(state["area"][0] * state["ice_volume"][0].sum()) if ridging else 0.0
    assert float(back.volume.sum()) == pytest.approx(lost, rel=1e-13)


def test_melted_elements_give_their_water_back():
    scene, state, places = pool()
    thin = state.copy(deep=True)
    thin["ice_fraction"][:3] = 0.004
    thin["ice_volume"][:3] = 0.001
    thin["snow_volume"][:3] = 0.0
    none = OpenIce(np.zeros(0, int), np.zeros(0), _no_columns(thin), _shares(thin, places))
    after, terms, _ = end_at_sea(scene, thin, none, places)
    assert terms["sea_gone"] == 3 and after.sizes["element"] == thin.sizes["element"] - 3
    lost = float((thin["area"] * thin["ice_volume"].sum("category"))[:3].sum())
    assert terms["growth_dissolved"] == pytest.approx(-lost, rel=1e-12)
    owned = float(thin["area"][:3].sum())
    assert after.attrs["unclaimed_water"] - thin.attrs["unclaimed_water"] == pytest.approx(owned)
    before, now = stocks(scene, thin, places), stocks(scene, after, places)
    assert now["heat"] == pytest.approx(before["heat"], rel=1e-13)


def _no_columns(state: xr.Dataset):
    return {
        str(name): state[name].values[:0]
        for name in state.data_vars
        if state[name].dims[:2] == ("element", "category")
    }


def _shares(state: xr.Dataset, places: SeaPlaces):
    x, y, area = (state[name].values for name in ("x", "y", "area"))
    return build_shares(x, y, area, places.grid, places.area)


def test_new_discs_meet_no_other_and_no_land():
    scene, state, places = pool()
    discs = np.stack([state[name].values for name in ("x", "y", "radius")], axis=1)
    cells = np.flatnonzero(places.area.ravel() > 0)
    asked, area = np.full(cells.size, 2), np.full(cells.size, 1.2e9)
    x, y, radius, row = place_discs(places, discs, cells, asked, area)
    assert len(x) > 10 and np.bincount(row).max() <= 2
    every = np.concatenate([discs, np.stack([x, y, radius], axis=1)])
    apart = np.hypot(*(every[:, None, :2] - every[None, :, :2]).transpose(2, 0, 1))
    gap = apart - every[:, 2] - every[None, :, 2].T
    np.fill_diagonal(gap, 1.0)
    assert gap[:, len(discs) :].min() > -1e-6
    ashore = (x < -HALF + 6 * 1.25e4 + radius * 0.99) & (y < -HALF + 6 * 1.25e4 + radius * 0.99)
    corner = np.hypot(np.maximum(x + HALF - 7.5e4, 0), np.maximum(y + HALF - 7.5e4, 0))
    assert not (ashore & (corner < radius * 0.99)).any()


def test_small_discs_take_the_ice_that_forms_beside_them():
    scene, state, places = pool(warm=0.0)
    places = replace(places, shore=np.zeros_like(places.shore))  # no room for a new disc
    # Discs off a coast: each stands for five times its area, and water opened beside them.
    state["radius"] = state["radius"] * np.sqrt(0.84 / 5.0)
    opened = 0.3 * state["area"]
    state["area"] = state["area"] - opened
    state.attrs["unclaimed_water"] += float(opened.sum())
    last, terms = windows(scene, state, places, weather(scene, 243.0), 1)
    assert terms["sea_born"] == 0
    assert terms["sea_joined"] > 0.9 * float(opened.sum())
    iced = last["pending_freeze"].values[:, :3]  # of the left half, away from the open water
    assert iced.max() < 0.01 * last["pending_freeze"].values.max()
    before, after = stocks(scene, state, places), stocks(scene, last, places)
    assert after["heat"] - before["heat"] == pytest.approx(terms["energy_stored"], rel=1e-11)
    grown = sum(v for k, v in terms.items() if k.startswith("growth_"))
    assert after["ice"] - before["ice"] == pytest.approx(grown, rel=1e-10)
    typical = float(state.attrs["typical_area"])
    assert float(last["area"].max()) <= 2.0 * max(typical, float(state["area"].max()))


def test_no_more_water_is_given_than_is_no_element_s():
    """Where elements overlap by the shares, cells seem open whose water is another's."""
    scene, state, places = pool(warm=0.0)
    places = replace(places, shore=np.zeros_like(places.shore))
    opened = 0.3 * state["area"]
    state["area"] = state["area"] - opened
    state.attrs["unclaimed_water"] = there = 0.1 * float(opened.sum())
    last, terms = windows(scene, state, places, weather(scene, 243.0), 1)
    assert 0.0 < terms["sea_joined"] <= there * (1.0 + 1e-12)
    assert last.attrs["unclaimed_water"] >= -1e-9 * there


def test_ice_that_leaves_is_counted_by_side():
    scene, state, _ = pool()
    shifted = state.copy(deep=True)
    shifted["x"][0] = -HALF - 1.0
    shifted["y"][1] = HALF + 5.0
    after, terms = export_ice(scene, shifted)
    assert after.sizes["element"] == state.sizes["element"] - 2
    assert terms["export_elements_left"] == 1 and terms["export_elements_top"] == 1
    assert terms["export_elements_right"] == terms["export_elements_bottom"] == 0
    for name in ("ice_area", "ice_volume", "snow_volume"):
        before, now = volumes(shifted, "end"), volumes(after, "end")
        left = sum(terms[f"export_{name}_{side}"] for side in SIDES)
        assert before[f"{name}_end"] - now[f"{name}_end"] == pytest.approx(left, rel=1e-12)
    assert np.isfinite(element_arrays(after, 1e-3)["mass"]).all()
    check_state(after)


def test_ice_flows_in_where_water_opened_at_the_rim():
    scene, state, places = pool(rims={"inflow": ["left"]})
    assert inflow_ice(scene, state, places)[1]["inflow_elements_left"] == 0
    moved = state.copy(deep=True)
    moved["x"] = moved["x"] + 9.0e4
    after, terms = inflow_ice(scene, moved, places)
    count = int(terms["inflow_elements_left"])
    assert count > 2 and after.sizes["element"] == state.sizes["element"] + count
    new = after["id"].values > state["id"].values.max()
    np.testing.assert_allclose(after["ice_fraction"].values[new].sum(axis=1), 0.9)
    gained = float((after["area"] * after["ice_volume"].sum("category"))[new].sum())
    assert terms["inflow_ice_volume_left"] == pytest.approx(gained, rel=1e-12)
    check_state(after)


def test_a_gate_counts_all_that_passes_however_small_the_steps():
    scene, state, _ = pool()
    line = np.array([0.0, -3e5]), np.array([0.0, 3e5])
    state["x"] = state["x"] - 5e4
    total = np.zeros(2)
    for k in range(12):
        here, there = (state.assign(x=state["x"] + 5e4 * step) for step in (k, k + 1))
        passed = gate_fluxes(here, there, {"line": line})
        total += passed["gate_area_line"], passed["gate_volume_line"]
    every = volumes(state, "end")
    assert total[0] == pytest.approx(every["ice_area_end"], rel=1e-10)
    assert total[1] == pytest.approx(every["ice_volume_end"], rel=1e-10)
    half, along = far_share(line, np.array([0.0]), np.array([0.0]), np.array([1e4]))
    assert half[0] == pytest.approx(0.5) and along[0] == pytest.approx(0.5)
    beside = far_share((line[0], np.array([0.0, -2e5])), np.array([0.0]), np.zeros(1), np.ones(1))
    assert beside[1][0] > 1.0


def test_frazil_stays_in_the_sea_until_there_is_enough():
    scene, state, places = pool(warm=0.0)
    settings = column_settings(scene)
    water = read_water(state, places.area, settings)
    lack = 0.05 * settings.new_ice_thickness * 917.0 * 3.34e5
    state = with_water(state, gain_heat(water, -lack * water.area))
    mild = weather(scene, 271.3)
    mild["longwave_down"] += 125.0
    mild["specific_humidity"] += 2.2e-3
    _, _, _, found = advance_columns(
        MPI.COMM_SELF, scene, state, mild, (0.0, 86400.0), state["area"].values, places
    )
    cover = icy(found).columns["ice_fraction"].sum(axis=1)
    assert len(cover) and cover.max() < 0.15
    after, terms, _ = end_at_sea(scene, state, found, places)
    assert terms["sea_born"] == 0 and terms["growth_dissolved"] < 0
    assert after["pending_freeze"].values.max() > 0.5 * lack
