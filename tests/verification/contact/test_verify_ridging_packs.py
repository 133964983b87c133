# SPDX-License-Identifier: GPL-2.0-or-later
"""Ridging in one and two dimensions and against an island: balances, and profiles where known.

All cases run over several windows, with the closing of areas at their ends. Ice of 0.2 m and more,
elements of 2500 m, 100 kPa of compressive strength.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.dynamics.engine.engine import EngineParams, Forcing
from floeflow.dynamics.step.critical import critical_step
from floeflow.state.bonds import Arrays
from floeflow.state.elements import element_arrays
from support.contact import figures
from support.contact.ridge_law import EDGE, RidgeLaw, Ridging
from support.contact.ridging_pack import CELL, LEAST, advance, assert_balance, pack_state
from support.full_ice import full_params
from support.rafts import discs, lattice

RADIUS, LENGTH = 2500.0, 2 * EDGE * 2500.0
LAWS = {"ridging": True, "compressive_strength": 1e5}


def stepped(state: xr.Dataset, window: float, **switches: object) -> tuple[EngineParams, int]:
    """Parameters with half of the critical step or less, and the steps of a window."""
    laws = LAWS | switches
    trial = full_params(time_step=1.0, **laws)
    critical, _ = critical_step(element_arrays(state, LEAST), None, trial)
    steps = math.ceil(window / (0.4 * critical))
    return full_params(time_step=window / steps, **laws), steps


# --- One dimension: a row of elements and a wind that blows it against the coast.

COUNT, THIN, STRESS, WINDOWS = 30, 0.2, 0.09, 26


def row_of_elements() -> xr.Dataset:
    row = discs(2 * RADIUS * np.arange(COUNT + 1), np.zeros(COUNT + 1), RADIUS, THIN)
    row["type"][0] = 2
    return pack_state(row)


def rising_wind(factor: float, rise: float, end: float) -> Forcing:
    """Stress towards the coast: STRESS sin^2(pi t / (2 rise)), then constant."""
    time = np.linspace(0.0, end, 800)
    share = np.sin(0.5 * math.pi * np.minimum(time / rise, 1.0))
    edge, one = np.array([-1e6, 1e6]), np.ones((len(time), 2, 2))
    wind = -math.sqrt(STRESS / factor) * share[:, None, None] * one
    still = {name: 0 * one for name in ("wind_v", "ocean_u", "ocean_v")}
    return Forcing(time, edge, edge, {"wind_u": wind} | still)


def quasi_static_row(stresses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Plastic closing (m) of each contact and area (m2) of each element, from the coast on.

    A contact bears the wind on all elements behind it, and closes until its ridging force is as
    large. Areas follow at each window's end; the stresses (Pa) are those at the windows' ends.
    """
    ridge = Ridging(RidgeLaw(), LENGTH, 2 * RADIUS, THIN)
    area, closing = np.full(COUNT, CELL * RADIUS**2), np.zeros(COUNT)
    volume = THIN * area
    for stress in stresses:
        force = stress * np.cumsum(area[::-1])[::-1]
        now = np.maximum(closing, [ridge.closing_at(f) for f in force])
        thickness, lost = volume / area, LENGTH * (now - closing)
        area, closing = area.copy(), now
        area[0] -= lost[0]  # the coast gives nothing
        share = thickness[1:] / (thickness[:-1] + thickness[1:])
        area[:-1] -= share * lost[1:]
        area[1:] -= (1 - share) * lost[1:]
    return closing, area


def test_one_dimensional_ridging_against_a_coast(log: Path, show) -> None:
    start = state = row_of_elements()
    rise, end = 6e5, 7.8e5
    window = end / WINDOWS
    params, steps = stepped(state, window, friction=False, wind=True, ocean_drag=True)
    forcing = rising_wind(params.wind_stress_factor, rise, end)
    for _ in range(WINDOWS):
        state, sums = advance(state, params, steps, log, forcing)
    assert_balance(start, state)
    times = window * np.arange(1, WINDOWS + 1)
    share = np.sin(0.5 * math.pi * np.minimum(times / rise, 1.0)) ** 2
    closing, area = quasi_static_row(STRESS * share)
    ours = np.zeros(COUNT)
    ours[state["contact_id_hi"].values - 2] = state["contact_ridge_closing"].values
    # What is left falls with the speed at which the wind rises (1e-3 where it rises in half).
    np.testing.assert_allclose(ours[2:], closing[2:], rtol=0, atol=3e-4 * closing.max())
    # The two elements at the coast give ice on unlike sides: their centres move away from it, and
    # the ice between centres, whose volume a ridge keeps, spans 1 % more than the reference knows.
    np.testing.assert_allclose(ours[:2], closing[:2], rtol=0, atol=1e-3 * closing.max())
    np.testing.assert_allclose(state["area"].values[1:], area, rtol=3e-5)
    assert (closing == 0).sum() > 5 and (ours[closing == 0] == 0).all()
    # At rest the coast bears the wind on all that is left.
    push = sums["impulse_fixed_x"] / (steps * params.time_step)
    assert abs(push) == pytest.approx(STRESS * float(state["area"].sum()), rel=1e-4)
    # Geometry: where an element closes on both sides alike its centre stays, and discs take up
    # about a third of the closing by their radii; the rest is overlap without force.
    overlap = state["contact_rest_overlap"].values
    taken = 1 - overlap[2:20] / ours[2:20]
    assert (0.33 < taken).all() and (taken < 0.42).all()
    thickness = (state["ice_volume"].sum("category")).values[1:]
    places = np.arange(1, COUNT + 1)
    lines = {
        "quasi-static: closing": (places, closing / 1e3),
        "quasi-static: thickness": (places, THIN * CELL * RADIUS**2 / area),
    }
    points = {"FloeFlow: thickness": (places, thickness), "FloeFlow: closing": (places, ours / 1e3)}
    label = ("number of the element from the coast", "closing (km), mean thickness (m)")
    show("ridging_row", figures.curves, lines, points, *label)


# --- Two dimensions: a lattice that is shortened evenly.


def test_two_dimensional_ridging_of_an_even_lattice(log: Path) -> None:
    raft = lattice(7, 7, RADIUS, THIN)
    rows = np.rint(raft["y"] / (math.sqrt(3) * RADIUS)).astype(int)
    rim = (rows == 6) | (np.arange(49) % 7 == 0) | (np.arange(49) % 7 == 6)
    raft["type"][rows == 0] = 2
    span, windows, strain = 3e5, 20, 0.08
    raft["v"] = -strain / span * raft["y"]  # what is heavy keeps it, what is not has to follow
    start = state = pack_state(raft)
    params, steps = stepped(state, span / windows, friction=False)
    for _ in range(windows):
        state, _ = advance(state, params, steps, log, heavy=rim)
    assert_balance(start, state)
    # Rows beside the coast and at the rim ridge on one side only: their centres move away from it
    # by a third of what they give, at most. Those inside stay but for what that stirs.
    off = state["y"].values - (1 - strain) * raft["y"]
    assert (off[(rows == 1) | (rows == 6)] > 40.0).all()
    assert (off[(rows == 1) | (rows == 6)] < 0.34 * 290.0).all()
    np.testing.assert_allclose(off[(rows > 1) & (rows < 6)], 0.0, atol=3.0)
    inner_columns = (np.arange(49) % 7 > 0) & (np.arange(49) % 7 < 6)
    aside = (state["x"].values - raft["x"])[inner_columns & (rows > 1) & (rows < 6)]
    np.testing.assert_allclose(aside, 0.0, atol=3.0)
    # Contacts across rows have all closed by the same; those along rows by nothing.
    height = math.sqrt(3) * RADIUS * (1 - strain)
    travel = 2 * RADIUS - math.hypot(RADIUS, height)
    ridge = Ridging(RidgeLaw(), LENGTH, 2 * RADIUS, THIN)
    expected = ridge.closing_after(travel, 0.5 * params.contact_modulus * THIN)
    lo, hi = (state[f"contact_id_{end}"].values - 1 for end in ("lo", "hi"))
    across = rows[lo] != rows[hi]
    assert across.sum() == 6 * 13
    closing = state["contact_ridge_closing"].values
    np.testing.assert_allclose(closing[across], expected, rtol=1e-2)
    amid = (np.arange(49) % 7 > 1) & (np.arange(49) % 7 < 5)
    inside = across & (rows[lo] > 1) & (rows[hi] < 6) & amid[lo] & amid[hi]
    assert inside.sum() > 10
    np.testing.assert_allclose(closing[inside], expected, rtol=3e-3)
    assert (closing[~across] == 0).all()
    # An element inside gives half of each of its four.
    # Rows beside the coast and the rim share with ice of other thickness.
    inner = ~rim & (rows > 2) & (rows < 5) & amid
    lost = (start["area"] - state["area"]).values[inner]
    np.testing.assert_allclose(lost, 2 * LENGTH * expected, rtol=3e-3)


def mixed_pack(side: int, thin: float, thick: float, seed: int) -> Arrays:
    """Square lattice of elements, their thickness (m) at random."""
    raft = lattice(side, side, RADIUS)
    raft["thickness"] = np.random.default_rng(seed).uniform(thin, thick, side * side)
    return raft


def test_two_dimensional_ridging_under_a_piston(log: Path, show) -> None:
    raft = mixed_pack(10, 0.2, 1.0, seed=5)
    rows = np.arange(100) // 10
    sides = (np.arange(100) % 10 == 0) | (np.arange(100) % 10 == 9)
    raft["type"][(rows == 0) | (sides & (rows < 9))] = 2
    piston = rows == 9
    raft["v"][piston] = -0.03
    start = state = pack_state(raft, water=1e9)
    params, steps = stepped(state, 2e4, friction=True)
    volumes = (state["area"] * state["ice_volume"].sum("category")).values
    for _ in range(4):
        state, _ = advance(state, params, steps, log, heavy=piston)
    assert_balance(start, state)
    # No ice changes its element, and what became water is what ridged.
    now = (state["area"] * state["ice_volume"].sum("category")).values
    np.testing.assert_allclose(now, volumes, rtol=1e-13)
    lost = (start["area"] - state["area"]).values
    assert state.attrs["unclaimed_water"] - 1e9 == pytest.approx(lost.sum(), rel=1e-12)
    assert (lost >= 0).all() and (lost > 0).sum() > 40
    # The strip that the piston swept is ice that became ridge, but for what stays elastic.
    swept = 0.03 * 8e4 * 8 * 2 * RADIUS
    assert lost.sum() == pytest.approx(swept, rel=0.35)
    percent = 100 * lost / np.where(lost > 0, start["area"].values, 1.0)
    show("ridging_piston", figures.shaded, state, percent, "area turned into ridges (%)")


# --- An island.


def island_pack(columns: int) -> Arrays:
    raft = mixed_pack(columns, 0.05, 0.3, seed=7)
    middle = np.array([raft["x"].mean(), raft["y"].mean()])
    far = np.hypot(raft["x"] - middle[0], raft["y"] - middle[1])
    raft["type"][far < 3.2 * RADIUS] = 2
    return raft


def ride_on_an_island(log: Path, columns: int, days: float) -> tuple[xr.Dataset, xr.Dataset]:
    raft = island_pack(columns)
    start = state = pack_state(raft, water=1e10)
    window = 10800.0
    params, steps = stepped(state, window, friction=True, wind=True, ocean_drag=True)
    edge, one = np.array([-1e6, 1e6]), np.ones((1, 2, 2))
    wind = {"wind_u": 15.0 * one, "wind_v": 0 * one, "ocean_u": 0 * one, "ocean_v": 0 * one}
    forcing = Forcing(np.array([0.0]), edge, edge, wind)
    for _ in range(round(days * 86400 / window)):
        state, sums = advance(state, params, steps, log, forcing)
        for axis in "xy":
            parts = [sums[f"impulse_{name}_{axis}"] for name in ("wind", "ocean", "fixed")]
            change = sums[f"momentum_{axis}"] - sums[f"first_momentum_{axis}"]
            size = sum(map(abs, parts)) + abs(change)
            assert abs(change - parts[0] - parts[1] + parts[2]) < 1e-9 * size
    assert_balance(start, state)
    return start, state


def assert_ridged_upwind(start: xr.Dataset, state: xr.Dataset) -> None:
    island = (state["type"] == 2).values
    middle = state["x"].values[island].mean(), state["y"].values[island].mean()
    x, y = state["x"].values - middle[0], state["y"].values - middle[1]
    lost = 1 - (state["area"] / start["area"].where(~island, 1.0)).values
    near = ~island & (np.abs(y) < 3 * RADIUS)
    upwind, lee = near & (x < 0) & (x > -12 * RADIUS), near & (x > 0)
    assert upwind.sum() > 3
    assert lost[upwind].mean() > 0.02 > 5 * lost[lee].mean()
    # The lee is open: no ice lies where the island's shadow begins.
    assert not (lee & (x < 6 * RADIUS)).any()


def test_ridging_against_an_island(log: Path) -> None:
    assert_ridged_upwind(*ride_on_an_island(log, 13, 1.0))


@pytest.mark.slow
def test_ridging_against_an_island_at_length(log: Path, show) -> None:
    start, state = ride_on_an_island(log, 31, 1.5)
    assert_ridged_upwind(start, state)
    lost = 100 * (1 - state["area"] / start["area"]).values
    show("ridging_island", figures.shaded, state, lost, "area turned into ridges (%)")
