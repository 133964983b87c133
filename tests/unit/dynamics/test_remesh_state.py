# SPDX-License-Identifier: GPL-2.0-or-later
"""Whole states through a remap: what is kept, what is made anew, bonds, contacts, guests."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
import xarray as xr
from scipy.spatial import cKDTree

from floeflow.core.constants import EDGE_SHARE
from floeflow.dynamics.remesh.outline import cut
from floeflow.dynamics.remesh.remap import lay, overlapping, remap, traces
from floeflow.dynamics.remesh.remesh import remesh
from floeflow.dynamics.remesh.tables import overlapping_discs
from floeflow.dynamics.ridging.ridging import contact_share
from floeflow.scene import parse_scene
from floeflow.state.cells import Cells
from floeflow.state.elements import joint_thickness
from floeflow.state.schema import COAST, MOBILE, check_state
from support.remesh_cases import coast_case, jiggled, remapped, scales, spacing_of, totals


@pytest.fixture(scope="module")
def case() -> tuple[xr.Dataset, Cells]:
    return coast_case()


def strength(state: xr.Dataset) -> float:
    """Whole length times thickness of all bonds (m2)."""
    whole = 1.0 - state["bond_crack_a"] - state["bond_crack_b"]
    return float((state["bond_length"] * state["bond_thickness"] * whole).sum())


def whole_length(state: xr.Dataset) -> float:
    """Whole length of all bonds (m)."""
    return float(
        (state["bond_length"] * (1.0 - state["bond_crack_a"] - state["bond_crack_b"])).sum()
    )


def quiet(state: xr.Dataset, cells: Cells) -> np.ndarray:
    """Ids of elements that fill their cells, as all around them do and those around these."""
    row = np.searchsorted(state["id"], cells.id).clip(max=state.sizes["element"] - 1)
    there = state["id"].values[row] == cells.id
    full = there & (np.abs(state["area"].values[row] / cells.area - 1.0) < 1e-9)
    beside = (cells.neighbours() > 0).astype(float)
    for _ in range(2):
        full = full & (beside @ (~full).astype(float) == 0)
    return cells.id[full]


def assert_kept(before: xr.Dataset, after: xr.Dataset) -> None:
    first, last, scale = totals(before), totals(after), scales(before)
    for name, value in first.items():
        assert last[name] == pytest.approx(value, abs=1e-12 * scale[name]), name
    ocean = after.attrs["ocean_area"]
    assert float(after["area"].sum()) + after.attrs["unclaimed_water"] == pytest.approx(
        ocean, rel=1e-12
    )


@pytest.mark.parametrize("size", [0.0, 0.2, 0.6])
def test_amounts_are_kept_and_the_state_is_valid(case: tuple, size: float) -> None:
    state, cells = case
    moved = jiggled(state, size * spacing_of(cells))
    after = remapped(moved, cells)
    check_state(after)
    assert_kept(moved, after)
    mobile = after["type"].values == MOBILE
    total = after["ice_fraction"].values.sum(axis=1)[mobile]
    assert total.max() <= 1.0 + 1e-12
    coast = ["x", "y", "radius", "id"]
    kept = (s.isel(element=s["type"].values == COAST)[coast] for s in (moved, after))
    assert next(kept).equals(next(kept))
    # Fresh discs overlap with nothing, or without force.
    known = np.stack([after["contact_id_lo"], after["contact_id_hi"]], axis=1)
    assert not len(overlapping_discs(after, known)[0])


def test_undistorted_inner_elements_stay_as_they_are(case: tuple) -> None:
    state, cells = case
    after = remapped(state, cells)
    still = quiet(state, cells)
    assert len(still) > 30
    a, b = (s.isel(element=np.isin(s["id"], still)) for s in (state, after))
    for name in ("id", "x", "y", "radius", "area", "ice_fraction", "ice_volume", "u", "omega"):
        np.testing.assert_allclose(b[name], a[name], rtol=1e-6, atol=1e-6, err_msg=name)
    assert after.sizes["bond"] > 0.9 * state.sizes["bond"]


def test_cracks_and_strength_are_carried(case: tuple) -> None:
    state, cells = case
    random = np.random.default_rng(2)
    some = state.isel(bond=np.flatnonzero(random.random(state.sizes["bond"]) < 0.6))
    some = some.copy(deep=True)
    some["bond_crack_a"].values[:] = 0.3 * random.random(some.sizes["bond"])
    some["bond_crack_b"].values[:] = 0.1 * random.random(some.sizes["bond"])
    still = quiet(some, cells)
    a, b = (
        s.isel(bond=np.isin(s["bond_id_lo"], still) & np.isin(s["bond_id_hi"], still))
        for s in (some, remapped(some, cells))
    )
    assert a.sizes["bond"] > 20
    for name in ("id_lo", "id_hi", "crack_a", "crack_b", "thickness", "length"):
        np.testing.assert_allclose(b[f"bond_{name}"], a[f"bond_{name}"], atol=1e-6, err_msg=name)
    shifted = remapped(jiggled(some, 0.15 * spacing_of(cells)), cells)
    assert strength(shifted) == pytest.approx(strength(some), rel=0.15)
    # A whole pack stays whole, and one without bonds has none afterwards.
    moved = jiggled(state, 0.15 * spacing_of(cells))
    assert strength(remapped(moved, cells)) > 0.9 * strength(state)
    assert remapped(moved.isel(bond=slice(0, 0)), cells).sizes["bond"] == 0


def test_a_remap_makes_no_pack_stronger(case: tuple) -> None:
    # Half of the bonds are young: thinner than the ice beside them by far.
    state, cells = case
    random = np.random.default_rng(7)
    some = state.isel(bond=np.flatnonzero(random.random(state.sizes["bond"]) < 0.5))
    some = some.copy(deep=True)
    some["bond_thickness"].values[:] *= 0.2
    moved = jiggled(some, 0.25 * spacing_of(cells))
    after = remapped(moved, cells)
    assert 0.8 * strength(moved) < strength(after) <= (1 + 1e-9) * strength(moved)
    assert 0.8 * whole_length(moved) < whole_length(after) <= (1 + 1e-9) * whole_length(moved)


def test_new_bonds_are_free_of_stress(case: tuple) -> None:
    state, cells = case
    after = remapped(jiggled(state, 0.2 * spacing_of(cells)), cells)
    rows = [np.searchsorted(after["id"], after[f"bond_id_{end}"]) for end in ("lo", "hi")]
    for axis in "xy":
        for end in "ab":
            lo, hi = (
                after[axis].values[row] + after[f"bond_{side}_{end}{axis}"].values
                for side, row in zip(("lo", "hi"), rows, strict=True)
            )
            np.testing.assert_allclose(lo, hi, atol=1e-6)


def test_ridged_contacts_go_on(case: tuple) -> None:
    state, cells = case
    bare = state.isel(bond=slice(0, 0))
    pairs = np.stack([state["bond_id_lo"], state["bond_id_hi"]], axis=1)
    rows = np.searchsorted(state["id"], pairs)
    place = np.stack([state["x"], state["y"]], axis=1)
    gap = state["radius"].values[rows].sum(axis=1) - np.hypot(
        *(place[rows[:, 1]] - place[rows[:, 0]]).T
    )
    # The same force per contact length: overlap times the share of its stiffness, over the length.
    length = 2.0 * EDGE_SHARE * state["radius"].values[rows].min(axis=1)
    push = 5e-4 * length / contact_share({"thickness": joint_thickness(state)}, *rows.T)
    made = {"id_lo": pairs[:, 0], "id_hi": pairs[:, 1], "slip": np.zeros(len(pairs)),
            "rest_overlap": gap - push, "ridge_closing": np.full(len(pairs), 30.0),
            "ridge_thickness": np.full(len(pairs), 1.7),
            "ridge_length": length}  # fmt: skip
    touching = bare.drop_vars([n for n in bare if bare[n].dims == ("contact",)])
    for name, values in made.items():
        touching[f"contact_{name}"] = ("contact", values)
    after = remapped(touching, cells)
    check_state(after)
    pressed = after["contact_ridge_closing"].values > 0
    assert pressed.sum() > 0.8 * len(pairs)
    for name, value in (("ridge_closing", 30.0), ("ridge_thickness", 1.7)):
        np.testing.assert_allclose(after[f"contact_{name}"].values[pressed], value, rtol=1e-9)
    rows = [
        np.searchsorted(after["id"], after[f"contact_id_{e}"].values[pressed]) for e in ("lo", "hi")
    ]
    apart = np.hypot(*(after[a].values[rows[1]] - after[a].values[rows[0]] for a in ("x", "y")))
    reach = after["radius"].values[rows[0]] + after["radius"].values[rows[1]]
    elastic = reach - apart - after["contact_rest_overlap"].values[pressed]
    share = contact_share({"thickness": joint_thickness(after)}, *rows)
    length = after["contact_ridge_length"].values[pressed]
    np.testing.assert_allclose(elastic * share / length, 5e-4, rtol=1e-5)
    assert remapped(bare, cells).sizes["contact"] == 0


def test_elements_that_left_the_cells_stay_as_they_are(case: tuple) -> None:
    state, cells = case
    away = state.copy(deep=True)
    away["x"].values[[3, 5]] -= 5e6
    after = remapped(away, cells)
    check_state(after)
    assert_kept(away, after)
    last = max(int(cells.id[-1]), int(state["id"][-1]))
    guests = after.isel(element=after["id"].values > last)
    assert guests["id"].values.tolist() == [last + 1, last + 2]
    for name in ("x", "y", "radius", "area", "u", "ice_volume"):
        np.testing.assert_array_equal(guests[name], away[name].values[[3, 5]])
    back = after.copy(deep=True)
    back["x"].values[-2:] += 5e6
    home = remapped(back, cells)
    assert int(home["id"][-1]) <= last
    assert_kept(back, home)


@pytest.mark.parametrize("beyond", [0.0, 1.01, 1.6])
def test_an_element_wider_than_its_bay_has_not_left_the_cells(case: tuple, beyond: float) -> None:
    """Most of its outline lies on land, but its cell gets no second element beside it.

    Its centre may lie beside the cell's outline, which leaves out small parts of the sea, and its
    outline on land alone.
    """
    state, cells = case
    some = quiet(state, cells)
    row = int(np.flatnonzero(state["id"].values == some[len(some) // 2])[0])
    site = int(np.searchsorted(cells.id, state["id"].values[row]))
    # Two cells far away: the rectangle about the cells is wider than the bay.
    kept = np.unique([site, np.argmin(cells.x + cells.y), np.argmax(cells.x + cells.y)])
    some = {n: getattr(cells, n)[kept] for n in ("id", "x", "y", "radius", "area", "polygons")}
    bay = Cells(**some, lo=cells.lo[:0], hi=cells.hi[:0], ends=cells.ends[:0])
    wide = state.copy(deep=True)
    edge = shapely.shortest_line(
        shapely.points(cells.x[site], cells.y[site]), cells.polygons[site].boundary
    )
    there = shapely.get_coordinates(edge)
    place = there[0] + beyond * (there[1] - there[0])
    wide["x"].values[row], wide["y"].values[row] = place
    if beyond > 1.5:
        ends = np.append(0, np.cumsum(wide["cell_corners"].values))
        turn = slice(int(ends[row]), int(ends[row + 1]))
        for axis, away in zip("xy", there[1] - there[0], strict=True):
            wide[f"corner_{axis}"].values[turn] += 5.0 * away
    more = 1.5 * float(wide["area"].values[row])
    wide["area"].values[row] += more
    wide.attrs["unclaimed_water"] -= more
    assert row in lay(wide, bay).rows
    after = remapped(wide, bay)
    assert_kept(wide, after)
    away = np.hypot(after["x"].values - cells.x[site], after["y"].values - cells.y[site])
    near = np.flatnonzero(away < 1.1 * cells.radius[site])
    assert after["id"].values[near].tolist() == [cells.id[site]]
    # Ice of another that stands at the same place goes into the same element.
    visitor = int(np.flatnonzero(state["id"].values == cells.id[(site + 1) % len(cells.id)])[0])
    for axis in ("x", "y"):
        wide[axis].values[visitor] = wide[axis].values[row]
    both = remapped(wide, cells)
    assert int(cells.id[site]) in both["id"].values
    for made in (after, both):
        places = np.stack([made["x"].values, made["y"].values], axis=1)
        assert not cKDTree(places).query_pairs(1.0)


def test_no_water_is_made_where_an_element_stays(case: tuple) -> None:
    """One that left the cells reaches over one with its disc; that gets no second element."""
    state, cells = case
    wide = state.copy(deep=True)
    sea = shapely.union_all(cells.polygons)
    sites = shapely.points(cells.x, cells.y)
    there = np.isin(cells.id, state["id"].values)
    site = int(np.argmin(np.where(there, shapely.distance(sites, sea.boundary), np.inf)))
    row = int(np.flatnonzero(state["id"].values == cells.id[site])[0])
    edge = shapely.get_coordinates(shapely.shortest_line(sites[site], sea.boundary))[1]
    out = edge - [cells.x[site], cells.y[site]]
    beyond = 2.2 * np.sqrt(cells.area[site] / np.pi) / np.hypot(*out)
    wide["x"].values[row] = cells.x[site] + beyond * out[0]
    wide["y"].values[row] = cells.y[site] + beyond * out[1]
    wide["radius"].values[row] = 1.1 * beyond * float(np.hypot(*out))
    more = 50.0 * float(cells.area.sum())
    wide["area"].values[row] += more
    wide.attrs["unclaimed_water"] -= more
    assert lay(wide, cells).guests.tolist() == [row]
    after = remapped(wide, cells)
    check_state(after)
    assert_kept(wide, after)
    assert int(cells.id[site]) not in after["id"].values


def test_ice_that_enters_an_empty_cell_makes_an_element(case: tuple) -> None:
    state, cells = case
    drifted = state.copy(deep=True)
    drifted["x"].values[state["type"].values == MOBILE] += 1.5 * spacing_of(cells)
    after = remapped(drifted, cells)
    assert_kept(drifted, after)
    born = np.setdiff1d(after["id"], state["id"])
    died = np.setdiff1d(state["id"], after["id"])
    assert len(born) > 2 and len(died) > 2
    assert (after["ice_fraction"].values[np.isin(after["id"], born)].sum(axis=1) > 0).all()
    # Ice, not area, decides: where all has melted the element goes, and its area is water.
    molten = after.copy(deep=True)
    line = float(np.median(after["x"].values))
    for name in ("ice_fraction", "ice_volume", "snow_volume"):
        molten[name].values[after["x"].values > line] = 0.0
    gone = remapped(molten, cells)
    assert_kept(molten, gone)
    mobile = gone["type"].values == MOBILE
    assert gone["x"].values[mobile].max() < line + 2 * spacing_of(cells)
    assert 0 < mobile.sum() < (after["type"].values == MOBILE).sum() - 20


def test_a_trace_of_ice_goes_to_the_ice_beside_it(case: tuple) -> None:
    state, cells = case
    mobile = state["type"].values == MOBILE
    east = mobile & (state["x"].values > np.median(state["x"].values[mobile]))
    faint = state.copy(deep=True)
    for name in ("ice_fraction", "ice_volume", "snow_volume"):
        faint[name].values[east] *= 1e-6
    after = remapped(faint, cells)
    check_state(after)
    assert_kept(faint, after)
    fraction = after["ice_fraction"].values.sum(axis=1)[after["type"].values == MOBILE]
    assert ((fraction == 0) | (fraction > 1e-4)).all()
    assert (fraction > 0).sum() == (mobile & ~east).sum()


def test_a_trace_in_the_last_cell_goes_too(case: tuple) -> None:
    _, cells = case
    ice = 0.5 * cells.area
    ice[-1] = 1e-7 * cells.area[-1]
    goes, part = traces(cells.area, ice, cells)
    assert goes.shape == (len(ice), len(ice))
    after = goes @ ice
    assert after[-1] == 0 and after.sum() == pytest.approx(ice.sum(), rel=1e-14)
    assert part[-1] == pytest.approx(1e-7) and (part[:-1] == 1).all()


def test_a_lead_inside_the_pack_is_given_to_elements(case: tuple) -> None:
    state, cells = case
    place = np.stack([state["x"], state["y"]], axis=1)
    mobile = state["type"].values == MOBILE
    beside = (cells.neighbours() > 0) @ np.isin(cells.id, state["id"][mobile]).astype(float)
    inner = cells.id[beside == np.asarray((cells.neighbours() > 0).sum(axis=1)).ravel()]
    row = int(np.flatnonzero(np.isin(state["id"], inner) & mobile)[0])
    hole = state.isel(element=np.arange(len(place)) != row, bond=slice(0, 0))
    first = np.concatenate([[0], np.cumsum(state["cell_corners"].values)])
    corner = np.r_[0 : first[row], first[row + 1] : first[-1]]
    hole = hole.isel(corner=corner)
    hole.attrs["unclaimed_water"] += float(state["area"][row])
    after = remapped(hole, cells)
    check_state(after)
    assert_kept(hole, after)
    lead = after.isel(element=after["id"].values == int(state["id"][row]))
    assert lead.sizes["element"] == 1
    assert float(lead["ice_fraction"].sum()) < 0.1 * float(state["ice_fraction"][row].sum()) + 0.2
    assert 200 < float(lead["surface_temperature"].squeeze()) < 300


def test_overlap_is_measured(case: tuple) -> None:
    state, cells = case
    still = overlapping(lay(state, cells), cells)
    squeezed = state.copy(deep=True)
    mobile = state["type"].values == MOBILE
    squeezed["x"].values[mobile] *= 0.8
    found = overlapping(lay(squeezed, cells), cells)
    assert still < 0.02 and 0.1 < found < 0.3


def test_cells_are_cut_to_their_share_where_their_content_is() -> None:
    square = np.array([shapely.box(0, 0, 2, 2)] * 3)
    parts = cut(square, np.array([1.0, 0.25, 0.5]), np.array([[1, 1], [1.8, 1.0], [1.0, 0.2]]))
    np.testing.assert_allclose(shapely.area(parts), [4.0, 1.0, 2.0], rtol=1e-9)
    middle = shapely.get_coordinates(shapely.centroid(parts))
    np.testing.assert_allclose(middle, [[1, 1], [1.75, 1], [1, 0.5]], atol=1e-6)


def test_fast_ice_stays_frozen_to_the_coast() -> None:
    state, cells = coast_case(coast_bonds=True)

    def ashore(of: xr.Dataset) -> np.ndarray:
        coast = of["id"].values[of["type"].values == COAST]
        return np.isin(of["bond_id_lo"], coast) | np.isin(of["bond_id_hi"], coast)

    after = remapped(jiggled(state, 0.1 * spacing_of(cells)), cells)
    check_state(after)
    assert ashore(after).sum() > 0.9 * ashore(state).sum() > 20
    free = remapped(state.isel(bond=np.flatnonzero(~ashore(state))), cells)
    assert not ashore(free).any()


def test_layers_of_all_categories_and_the_sea_are_carried() -> None:
    more = "column: {scheme: mushy, categories: 5}\n"
    state, cells = coast_case(more=more)
    random = np.random.default_rng(6)
    layered = [n for n in state if n.startswith(("ice_", "snow_")) and state[n].ndim == 3]
    assert {"ice_enthalpy", "ice_salinity", "snow_enthalpy"} <= set(layered)
    for name in layered:
        state[name].values[:] *= 1.0 + 0.1 * random.random(state[name].shape)
    moved = jiggled(state, 0.3 * spacing_of(cells))
    after = remapped(moved, cells)
    check_state(after)
    assert_kept(moved, after)
    for name in layered:
        rows = [s["type"].values == MOBILE for s in (moved, after)]
        old, new = (s[name].values[row] for s, row in zip((moved, after), rows, strict=True))
        assert new.min() >= old.min() - 1e-9 * np.abs(old).max(), name
        assert new.max() <= old.max() + 1e-9 * np.abs(old).max(), name


def test_the_scene_chooses_the_order_of_the_remap() -> None:
    state, cells = coast_case()
    moved = jiggled(state, 0.3 * spacing_of(cells))
    text = "name: a\neffects: [friction, bonds, ridging, thermodynamics, snow, remap]\n"
    found = {}
    for order in (1, 2):
        scene = parse_scene(f"{text}remap: {{every: 1, order: {order}}}\n".encode(), "a")
        moved.attrs["window"] = 1
        found[order], _ = remesh(scene, moved, cells)
        assert_kept(moved, found[order])
        plain = remap(moved, cells, lay(moved, cells), 0.2, slopes=order == 2)
        assert found[order]["ice_volume"].equals(plain["ice_volume"])
    # Donor cells smear what slopes keep.
    assert not found[1]["ice_volume"].equals(found[2]["ice_volume"])
