# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 8: runs so long that round-off, angles and clocks add up.

A million steps of a raft that nothing slows: an integrator that gains or loses a billionth a step
is seen. Angles beyond many turns lose digits of what they are used for, and so do times that count
from a far epoch. What must hold: energy, momentum and spin as at the start; bonds whole; the same
motion from any angle and any time.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.diagnostics.gridded import gridded_fields, hat_reach, sea_room
from floeflow.dynamics.engine.engine import Engine, Forcing
from floeflow.state.bonds import Arrays
from floeflow.transfer import Grid
from support.full_ice import full_params
from support.rafts import lattice, uniform
from support.remesh_cases import coast_case, jiggled, remapped, spacing_of, totals
from support.stability.packs import neighbours
from support.stability.watch import default_step, watch
from unit.packings.test_packing import coastline

CORIOLIS = 1.4e-4
# Of the gridded file: what is mapped, of which amount of the state, and its name in totals.
TOTALS = (
    ("siconc", "ice_fraction", "siarea"),
    ("sivol", "ice_volume", "sivolume"),
    ("sisnthick", "snow_volume", "sisnvolume"),
)
LAWS = full_params(time_step=1.0, bonds=True, coriolis=True, compressive_strength=1e8)


def canonical_spin(ice: Arrays) -> float:
    """What Coriolis' force leaves of angular momentum: sum m (x v - y u + f (x2 + y2)/2) + I w."""
    x, y, u, v = (ice[name] for name in ("x", "y", "u", "v"))
    orbit = x * v - y * u + 0.5 * CORIOLIS * (x * x + y * y)
    own = 0.5 * ice["mass"] * ice["radius"] ** 2 * ice["omega"]
    return float((ice["mass"] * orbit + own).sum())


def moving_raft() -> tuple[Arrays, Arrays]:
    """A bonded raft that drifts and turns as one body."""
    ice, spin = lattice(4, 4), 1e-4
    bonds = neighbours(ice)
    for name in "xy":
        ice[name] -= ice[name].mean()
    ice |= {"u": 0.3 - spin * ice["y"], "v": spin * ice["x"], "omega": np.full(16, spin)}
    return ice, bonds


@pytest.mark.parametrize("steps", [20_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_a_raft_in_inertial_motion(log: Path, steps: int, record):
    ice, bonds = moving_raft()
    params = default_step(ice, bonds, LAWS, 0.8)
    calm = uniform((0.0, 0.0), (0.0, 0.0), CORIOLIS)
    seen = watch(log, ice, params, steps * params.time_step, bonds, forcing=calm)
    mass = ice["mass"].sum()
    speed = np.hypot(*seen.momentum) / mass
    spin = canonical_spin(seen.elements) / canonical_spin(ice)
    kept = seen.energy[-1] / seen.energy[0]
    turns = float(np.abs(seen.elements["theta"]).max() / (2.0 * np.pi))
    record(steps=seen.steps, energy_kept=kept, speed_kept=speed / 0.3, spin_kept=spin, turns=turns)
    assert seen.sums["bonds_cracked"] == 0 and len(seen.bonds["id_lo"]) == len(bonds["id_lo"])
    assert speed == pytest.approx(0.3, rel=1e-12)
    # A leapfrog's places and speeds are half a step apart: the sum swings by that, and stays.
    assert spin == pytest.approx(1.0, abs=1e-4)
    assert kept == pytest.approx(1.0, abs=1e-5)
    assert seen.residual < 0.02


@pytest.mark.parametrize("times", [20, pytest.param(1000, marks=pytest.mark.slow)])
def test_remaps_one_after_the_other(times: int, record):
    """Elements drift at random and are replaced, over and over: nothing leaks, nothing grows."""
    state, cells = coast_case()
    first = totals(state)
    low, high = (f(speeds(state)) for f in (np.min, np.max))
    for k in range(times):
        state = remapped(jiggled(state, 0.2 * spacing_of(cells), seed=k), cells)
        for name in state.data_vars:
            if state[name].dtype.kind == "f":
                assert np.isfinite(state[name].values).all(), f"{name} after remap {k + 1}"
        assert state["ice_fraction"].values.sum(axis=1).max() <= 1.0 + 1e-12
        assert state["ice_volume"].values.min() >= 0.0 and state["area"].values.min() >= 0.0
    last = totals(state)
    lost = max(abs(last[name] - first[name]) / max(abs(first[name]), 1e-300) for name in first)
    record(remaps=times, largest_change_of_a_total=lost, elements=len(state["id"]))
    assert lost < 1e-12
    # Averages of averages never overstep what they came from.
    assert low * (1 + 1e-9) <= speeds(state).min() and speeds(state).max() <= high * (1 + 1e-9)


@pytest.mark.parametrize("times", [50, pytest.param(1000, marks=pytest.mark.slow)])
def test_transfers_to_the_grid_one_after_the_other(times: int, record):
    """Elements drift at random and go to the grid, over and over: each map has all of the ice."""
    state, cells = coast_case()
    # Half as much ice: so it has room in the sea of every cell, wherever it drifts.
    state = state.assign(area=0.5 * state["area"])
    mask = coastline()
    grid = Grid(*(mask[axis].values.reshape(-1, 2).mean(axis=1) for axis in ("x", "y")))
    room = sea_room(mask, grid, hat_reach(state, grid))
    worst, outside = 0.0, 0.0
    for k in range(times):
        state = jiggled(state, 0.05 * spacing_of(cells), seed=k)
        fields = gridded_fields(state, room)
        for name, own, said in TOTALS:
            per_cell = np.nan_to_num(fields[name]) * room.area
            if name == "sisnthick":
                per_cell = per_cell * np.nan_to_num(fields["siconc"])
            away = float(fields[f"{said}_outside"])
            whole = float(state["area"].values @ state[own].values.sum(axis=1))
            worst = max(worst, abs(float(per_cell.sum()) + away - whole) / whole)
            outside = max(outside, away / whole)
    record(transfers=times, largest_change_of_a_total=worst, largest_share_off_the_grid=outside)
    assert worst < 1e-12


def speeds(state: xr.Dataset) -> np.ndarray:
    """Of both axes, mobile elements, m/s."""
    mobile = state["type"].values == 1
    return np.concatenate([state[name].values[mobile] for name in ("u", "v")])


@pytest.mark.parametrize("turns", [1.0, -1e3, 1e6])
def test_angles_of_many_turns_change_nothing(log: Path, turns: float, record):
    """All discs have turned many times: bonds lie in the discs and must not feel it."""
    found = []
    # One step for both: of another in its last digit there might be one more in the same time.
    params = default_step(*moving_raft(), LAWS, 0.8)
    for start in (0.0, turns):
        ice, _ = moving_raft()
        ice["theta"][:] = 2.0 * np.pi * start
        bonds = neighbours(ice)
        calm = uniform((0.0, 0.0), (0.0, 0.0), CORIOLIS)
        found.append(watch(log, ice, params, 1000 * params.time_step, bonds, forcing=calm).elements)
    away = max(float(np.abs(found[1][name] - found[0][name]).max()) for name in "xy")
    record(turns=turns, away=away)
    # An angle of 1e6 turns holds its place on a radius of 1 km to a micrometre.
    assert away < 1e-3
    assert np.abs(found[1]["theta"] - found[0]["theta"] - 2.0 * np.pi * turns).max() < 1e-6


@pytest.mark.parametrize("start", [1e9, 1e11])
def test_times_far_from_the_epoch_change_nothing(log: Path, start: float, record):
    """Wind that turns with time, from time 0 and from a late one."""
    found = []
    for begin in (0.0, start):
        ice, bonds = moving_raft()
        params = default_step(ice, bonds, full_params(**{**vars(LAWS), "wind": True}), 0.8)
        clock = np.linspace(0.0, 4000.0, 9)
        on = np.ones((9, 2, 2))
        wind = {"wind_u": 10.0 * np.sin(clock / 500.0)[:, None, None] * on, "wind_v": 5.0 * on}
        still = {"ocean_u": 0.0 * on, "ocean_v": 0.0 * on, "coriolis": CORIOLIS * on[0]}
        edge = np.array([-1e6, 1e6])
        with Engine(MPI.COMM_SELF, params, log) as engine:
            engine.load(ice, bonds, time=begin)
            engine.set_forcing(Forcing(begin + clock, edge, edge, wind | still))
            engine.run(int(3600.0 / params.time_step))
            found.append(engine.elements())
    away = max(float(np.abs(found[1][name] - found[0][name]).max()) for name in "xy")
    record(start=start, away=away)
    # A clock of 1e11 s ticks in steps of 15 microseconds.
    assert away < 1e-3
