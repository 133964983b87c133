# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes that repeat themselves: packs, bonds and windows do not know where the sides lie."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.core.near import deepest_overlap
from floeflow.core.period import distances_of, period_of, wrapped
from floeflow.coupling.coupled_windows import advance_window
from floeflow.coupling.first_state import First, first_pack, first_state
from floeflow.dynamics.ridging.overlaps import rest_overlaps
from floeflow.dynamics.step.contact_room import contact_room
from floeflow.scene.blocks import Scene
from floeflow.scene.load import parse_scene
from floeflow.state.bonds import CONTACT_COLUMNS, empty_pairs
from floeflow.state.files import read_state, write_state
from floeflow.state.schema import check_state
from support.full_ice import full_params
from support.rafts import discs
from support.ranks import TESTS, mpirun

SCENE = """
effects: [{effects}]
domain: {{x_min: 0.0, x_max: 1.2e+4, y_min: 0.0, y_max: 1.0e+4, spacing: 1.0e+3}}
mask: {{uniform: 0.8, land: none, thickness_rule: constant, ice_thickness: 0.5}}
packing: {{generator: dense, elements: 150, discs: {{sizes: bidisperse, fill: 0.8}}}}
periodic: {{axes: [{axes}]}}
walls: {{rim: [{rim}], right_velocity: [-0.05, 0.02]}}
time: {{windows: 4, window: 600.0}}
forcing: {{step: 600.0}}
dynamics: {{samples: 2, compressive_strength: 2.0e+4, contact_modulus: 2.0e+7}}
"""
WINDOW = Path(TESTS) / "support/periodic_ranks.py"
UP = "friction, bonds, walls, periodic"


def a_scene(effects: str = UP, axes: str = "y", rim: str = "left, right") -> Scene:
    return parse_scene(SCENE.format(effects=effects, axes=axes, rim=rim).encode(), "repeated")


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> First:
    return first_state(a_scene(), tmp_path_factory.mktemp("packed"))


@pytest.mark.parametrize("bounds", [None, [0.0, 1.0, 2.0], [0.0, 5.0, 1.0, 5.0], ["a"] * 4, 3.0])
def test_a_state_without_its_bounds_is_refused(packed: First, bounds: object) -> None:
    state = packed.state.assign_attrs(period=bounds)
    check_state(packed.state)
    with pytest.raises(FloeError, match="attribute 'period' is missing or holds no bounds"):
        check_state(state)


def moved_up(state: xr.Dataset, way: float) -> xr.Dataset:
    """The same ice, by so many metres further up."""
    places = np.column_stack([state["x"].values, state["y"].values + way])
    x, y = wrapped(places, period_of(state.attrs)).T
    return state.assign(x=("element", x.copy()), y=("element", y.copy()))


def windows(scene: Scene, state: xr.Dataset, folder: Path, count: int) -> list[xr.Dataset]:
    """States at the ends of some windows, each through a file."""
    folder.mkdir()
    states = [state]
    for number in range(count):
        path = folder / f"{number}.nc"
        write_state(states[-1], path)
        log, forcing = folder / "liggghts.log", xr.Dataset()
        done = advance_window(
            MPI.COMM_SELF, scene, read_state(path), forcing, log, lambda **_: None
        )
        states.append(done.state)
    return states[1:]


def rows(state: xr.Dataset, kind: str) -> tuple[np.ndarray, np.ndarray]:
    lo, hi = (state[f"{kind}_id_{end}"].values for end in ("lo", "hi"))
    return np.searchsorted(state["id"].values, lo), np.searchsorted(state["id"].values, hi)


def across(state: xr.Dataset, kind: str) -> np.ndarray:
    """Which pairs of a kind reach across a side of the rectangle in y, (m,)."""
    lo, hi = rows(state, kind)
    return np.abs(state["y"].values[hi] - state["y"].values[lo]) > 5e3


def test_discs_and_bonds_go_on_across_the_sides(packed: First) -> None:
    state = packed.state
    places = np.column_stack([state["x"].values, state["y"].values])
    radius, bounds = state["radius"].values, period_of(state.attrs)
    assert deepest_overlap(places, radius, len(radius), bounds) == 0.0
    beyond = across(state, "bond")
    assert 10 < beyond.sum() < 0.2 * len(beyond)
    lo, hi = rows(state, "bond")
    span = distances_of({"x": places[:, 0], "y": places[:, 1]}, lo, hi, bounds)
    np.testing.assert_allclose(state["bond_span"].values, span, rtol=1e-12)
    # The ends of a line are the same places seen from both elements, a side apart or not.
    for end in "ab":
        one, other = (
            places[row] + np.column_stack([state[f"bond_{side}_{end}{a}"].values for a in "xy"])
            for side, row in (("lo", lo), ("hi", hi))
        )
        off = other - one
        np.testing.assert_allclose(off[:, 0], 0.0, atol=1e-8)
        np.testing.assert_allclose(off[:, 1] - 1e4 * np.rint(off[:, 1] / 1e4), 0.0, atol=1e-8)
    # As many bonds an element near a side as elsewhere.
    near = np.minimum(places[:, 1], 1e4 - places[:, 1]) < 1e3
    held = np.bincount(np.concatenate([lo, hi]), minlength=len(radius))
    assert held[near].mean() == pytest.approx(held[~near].mean(), rel=0.15)


@pytest.mark.parametrize("effects", [UP, "friction, ridging, walls, periodic"])
def test_a_window_does_not_know_where_the_sides_lie(
    packed: First, tmp_path: Path, effects: str
) -> None:
    scene, start = a_scene(effects), packed.state
    if "ridging" in effects:
        walls = scene.walls.model_copy(update={"right_velocity": (-0.3, 0.02)})
        scene = scene.model_copy(update={"walls": walls})
        start = first_state(scene, tmp_path).state
    here = windows(scene, start, tmp_path / "here", 3)
    last = here[-1]
    # The contact with the longest history comes to lie across the sides.
    name = "contact_ridge_closing" if "ridging" in effects else "contact_slip"
    most = int(np.abs(last[name].values).argmax())
    lo, hi = rows(last, "contact")
    way = -0.5 * float(last["y"].values[lo[most]] + last["y"].values[hi[most]])
    there = windows(scene, moved_up(start, way), tmp_path / "there", 3)
    beyond = across(there[-1], "contact")
    assert beyond[most] and np.abs(there[-1][name].values[most]) > 0.1
    if "bonds" in effects:
        assert 0 < last.sizes["bond"] < start.sizes["bond"]
    else:
        assert last["area"].sum() < start["area"].sum()
    # Round-off grows in broken ice, as a push of 1e-9 m does: tenfold a minute.
    for one, other, close in zip(here, there, (1e-6, 1e-4, 1e-2), strict=True):
        one = moved_up(one, way)
        off = other["y"].values - one["y"].values
        np.testing.assert_allclose(off - 1e4 * np.rint(off / 1e4), 0.0, atol=close)
        np.testing.assert_allclose(other["x"].values, one["x"].values, atol=close)
        for name in ("area", "drift_x", "drift_y"):
            np.testing.assert_allclose(other[name].values, one[name].values, rtol=1e-5, atol=close)
        for name in {"bond_id_lo", "contact_id_lo", "contact_id_hi"} & set(one.variables):
            np.testing.assert_array_equal(other[name].values, one[name].values)
        slip = one["contact_slip"].values
        np.testing.assert_allclose(other["contact_slip"].values, slip, atol=close)


def test_drift_counts_what_goes_out_and_comes_in(tmp_path: Path) -> None:
    scene = a_scene("friction, periodic", "x, y", "left")
    start = first_state(scene, tmp_path).state
    moving = start.assign(u=("element", np.full(start.sizes["element"], 15.0)))
    last = windows(scene, moving, tmp_path / "moving", 2)[-1]
    assert ((last["x"] >= 0) & (last["x"] < 1.2e4)).all()
    # Twice 9 km: everything went out once and more.
    np.testing.assert_allclose(last["drift_x"].values, 1.8e4, rtol=1e-9)
    faster = moving.assign(u=2.0 * moving["u"])
    with pytest.raises(FloeError, match=r"dynamics.samples: ice of 30 m/s goes half around"):
        windows(scene, faster, tmp_path / "faster", 1)


@pytest.mark.mpi
def test_ranks_share_a_repeated_pack(packed: First, tmp_path: Path) -> None:
    write_state(packed.state, tmp_path / "0.nc")
    text = SCENE.format(effects=UP, axes="y", rim="left, right")
    (tmp_path / "repeated.yaml").write_text(
        text.replace("{samples", "{deterministic: true, samples")
    )
    ends = []
    for ranks in (1, 2):
        words = (tmp_path / "repeated.yaml", tmp_path / "0.nc", tmp_path / f"{ranks}-end.nc")
        done = mpirun(ranks, [sys.executable, WINDOW, *words], tmp_path)
        assert done.returncode == 0, done.stderr
        ends.append(read_state(words[-1]))
    xr.testing.assert_identical(*ends)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("rim: [left, right]", "rim: [left, top]"), "walls.rim names 'top'"),
        (("axes: [y]", "axes: [y, y]"), "periodic.axes names an axis twice"),
        (("generator: dense", "generator: tessellation"), "needs packing.generator 'dense'"),
        (("land: none", "land: global_land_mask"), "needs mask.land 'none'"),
        (("rim: [left", "planes: [[0, 0, 1, 1, 0, 0]], rim: [left"), "walls.planes must run along"),
        (("walls, periodic", "walls, rims, periodic"), "cannot be used together"),
    ],
)
def test_what_cannot_repeat_is_refused(change: tuple[str, str], says: str) -> None:
    text = SCENE.format(effects=UP, axes="y", rim="left, right").replace(*change)
    text = text.replace(", discs: {sizes: bidisperse, fill: 0.8}", "") if "tess" in text else text
    with pytest.raises(FloeError, match=says):
        parse_scene(text.encode(), "repeated")


def test_neighbours_across_a_side_count_for_overlaps_and_the_time_step() -> None:
    pair = discs([0.0, 0.0], [100.0, 9900.0])
    bounds = a_scene().period
    found = rest_overlaps(pair, None, empty_pairs(CONTACT_COLUMNS), bounds)
    np.testing.assert_allclose(found["rest_overlap"], [1800.0])
    assert len(rest_overlaps(pair, None, empty_pairs(CONTACT_COLUMNS))["id_lo"]) == 0
    alone, both = (
        contact_room(pair, full_params(1.0, period=each), 10.0) for each in (None, bounds)
    )
    assert (alone.stiffness == 0.0).all() and (both.stiffness > 0.0).all()


def test_nothing_repeats_without_the_effect(tmp_path: Path) -> None:
    made = first_pack(a_scene("friction, bonds, walls"), tmp_path)
    assert "period" not in made.packing.attrs
    y = made.packing["y"].values
    rows = (made.bonds[f"bond_id_{end}"].values - 1 for end in ("lo", "hi"))
    lo, hi = rows
    assert np.abs(y[hi] - y[lo]).max() < 5e3
