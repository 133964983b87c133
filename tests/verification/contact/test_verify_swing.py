# SPDX-License-Identifier: GPL-2.0-or-later
"""The cantilever swings under DEMSI's large load, beside DEMSI's run of the same case."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.dynamics.engine.engine import Engine
from floeflow.dynamics.step.critical import critical_step
from support.contact import figures
from support.contact.demsi_bonds import DemsiLaw, swing
from support.full_ice import full_params
from support.rafts import uniform
from verification.contact.test_verify_cantilever import (
    LARGE,
    POISSON,
    RADIUS,
    SELF,
    THICKNESS,
    UNBREAKABLE,
    YOUNG,
    cantilever,
    dead_load,
)

# DEMSI's elements weigh as much as 0.1 m of ice of 900 kg/m3, its bonds are 0.2 m thick.
DEMSI_MASS, DEMSI_DAMPING, STALE = 0.1 * 900.0 * math.pi * RADIUS**2, 1e4, 1.03504


def released(log: Path, damping: float, times: np.ndarray) -> np.ndarray:
    """Mean tip (time,), complex, m, by the engine: the large load is put on at once."""
    elements, bonds, _ = cantilever()
    now = elements | {"mass": np.full(len(elements["id"]), DEMSI_MASS)}
    params = full_params(time_step=1.0, bond_damping=damping, **UNBREAKABLE)
    every = math.ceil(times[1] / (0.25 * critical_step(now, bonds, params)[0]))
    params = full_params(time_step=times[1] / every, bond_damping=damping, **UNBREAKABLE)
    out, end = [], elements["ice_area"] > 0
    with Engine(SELF, params, log) as engine:
        engine.load(now, bonds)
        engine.set_forcing(uniform(wind=(0.0, -math.sqrt(LARGE))))
        for k in range(len(times)):
            engine.run(every if k else 0)
            state = engine.elements()
            out.append(complex(state["x"][end].mean(), state["y"][end].mean()))
    return np.array(out)


def by_demsi(law: DemsiLaw, times: np.ndarray, step: float) -> np.ndarray:
    elements, bonds, _ = cantilever()
    now = elements | {"mass": np.full(len(elements["id"]), DEMSI_MASS)}
    load = dead_load(LARGE).reshape(-1, 3)
    end = elements["ice_area"] > 0
    return swing(now, bonds, load[:, 0] + 1j * load[:, 1], law, times, step)[:, end].mean(1)


def test_swing_under_a_large_load_without_damping(log: Path) -> None:
    times = 600.0 * np.arange(9)  # one swing
    ours = released(log, 0.0, times)
    # Without damping and with a true step DEMSI's elastic law is ours.
    law = by_demsi(DemsiLaw(YOUNG, POISSON, 0.0, 1.0), times, 0.3)
    assert np.abs(ours - law).max() < 1e-3 * np.ptp(ours.imag)


def beside_demsi(
    log: Path, shared: Path, count: int, step: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times (s); ways of the tip (m): DEMSI's, its law's in such steps (s), the engine's."""
    path = shared / "reference" / "demsi" / "cantilever_oscillation.nc"
    with xr.open_dataset(path, decode_times=False) as data:
        times, end = data["time"].values[:count], data["type"].values == 5
        demsi = data["x"].values[:count, end].mean(1) @ [1, 1j]
    stale = by_demsi(DemsiLaw(YOUNG, POISSON, DEMSI_DAMPING, STALE), times, step)
    # The same viscous coefficient of a bond, as a share of critical: c h L / (2 sqrt(k m / 2)).
    stiffness = YOUNG * THICKNESS
    damping = DEMSI_DAMPING * THICKNESS * 2 * RADIUS / (2 * math.sqrt(stiffness * DEMSI_MASS / 2))
    ours = released(log, damping, times)
    return times, demsi - demsi[0], stale - stale[0], ours - ours[0]


def test_swing_beside_demsi(log: Path, shared: Path) -> None:
    _, demsi, stale, ours = beside_demsi(log, shared, 13, 0.6)
    assert np.abs(stale - demsi).max() < 1e-3 * np.ptp(demsi.imag)
    # DEMSI's ends run ahead, which stiffens it: it swings about a place less deep, and faster.
    assert 1.02 < np.ptp(ours.imag) / np.ptp(demsi.imag) < 1.06


@pytest.mark.slow
def test_swing_beside_demsi_at_length(log: Path, shared: Path, show) -> None:
    times, demsi, stale, ours = beside_demsi(log, shared, 73, 0.2)
    # What is left falls with the step: DEMSI's is 1/15 s.
    assert np.abs(stale - demsi).max() < 5e-4 * np.ptp(demsi.imag)
    # Its damping brakes a pair that turns as a whole, ours does not.
    first, last = times < 6000.0, times > 36000.0
    assert np.ptp(demsi[last].imag) < 0.45 * np.ptp(demsi[first].imag)
    assert np.ptp(ours[last].imag) > 0.9 * np.ptp(ours[first].imag)
    hours = times / 3600
    lines = {
        "FloeFlow": (hours, ours.imag / 1e3),
        "bonds with stale ends and braked turning": (hours, stale.imag / 1e3),
    }
    points = {"DEMSI": (hours, demsi.imag / 1e3)}
    show("cantilever_swing", figures.curves, lines, points, "h", "deflection of the tip (km)")
