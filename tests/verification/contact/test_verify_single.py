# SPDX-License-Identifier: GPL-2.0-or-later
"""One element alone: straight motion, terminal drift, inertial circle, spin-down."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI
from scipy.integrate import solve_ivp

from floeflow.dynamics.engine.engine import Engine
from support.contact import figures
from support.full_ice import full_params
from support.rafts import discs, uniform

SELF = MPI.COMM_SELF


def test_constant_velocity_is_exact(log: Path) -> None:
    one = discs(100.0, 200.0)
    one["u"][:], one["v"][:], one["omega"][:] = 0.5, -0.25, 2.0**-10
    with Engine(SELF, full_params(time_step=2.0), log) as engine:
        engine.load(one)
        engine.run(100_000)
        out = engine.elements()
    assert out["x"][0] == 100.0 + 100_000 and out["y"][0] == 200.0 - 50_000
    assert out["u"][0] == 0.5 and out["v"][0] == -0.25 and out["omega"][0] == 2.0**-10
    assert out["theta"][0] == 200_000 / 2**10


@pytest.mark.parametrize("relative", [False, True])
def test_terminal_drift_for_any_thickness_at_one_step(log: Path, relative: bool) -> None:
    params = full_params(time_step=60.0, wind=True, ocean_drag=True, relative_wind=relative)
    share = math.sqrt(params.wind_stress_factor / params.ocean_stress_factor)
    terminal = 30.0 * (share / (1 + share) if relative else share)
    thickness = 10.0 ** np.arange(1, -7, -1)
    with Engine(SELF, params, log) as engine:
        engine.load(discs(1e4 * np.arange(8), np.zeros(8), thickness=thickness))
        engine.set_forcing(uniform(wind=(30.0, 0.0)))
        fastest = np.zeros(8)
        for _ in range(10_000):
            engine.run(1)
            fastest = np.maximum(fastest, engine.elements()["u"])
        out = engine.elements()
    np.testing.assert_allclose(out["u"], terminal, rtol=1e-8)
    assert (fastest <= 1.01 * terminal).all()
    assert (out["v"] == 0).all()


# The reference README gives these coefficients for both runs. The curve of the thick element obeys
# another pair (found from its acceleration, linear in 1, u and u^2 to 1e-13 m/s2), and a density of
# 900 kg/m3. The wind's speed follows from either terminal velocity.
RADIUS, DENSITY, WIND = 178.4, 900.0, 0.1
DRAG = {
    "thin": (0.001, 1.225 * 0.015, 1017 * 0.0045),
    "thick": (1.0, 1.225 * 0.0012, 1017 * 0.0055),
}


def drift(times: np.ndarray, name: str, half_relative: bool) -> np.ndarray:
    """Speed from rest by an adaptive solver; DEMSI's wind stress is rho C |u_a - u| u_a."""
    thickness, air, water = DRAG[name]

    def slope(_: float, u: np.ndarray) -> np.ndarray:
        lee = WIND - u if half_relative else WIND
        return (air * lee * WIND - water * u * abs(u)) / (DENSITY * thickness)

    span = (0.0, float(times[-1]))
    return solve_ivp(slope, span, [0.0], "LSODA", times, rtol=1e-10, atol=1e-14).y[0]


def drift_of_engine(log: Path, times: np.ndarray, name: str) -> np.ndarray:
    thickness, air, water = DRAG[name]
    switches = {"time_step": 60.0, "wind": True, "ocean_drag": True}
    params = full_params(**switches, wind_stress_factor=air, ocean_stress_factor=water)
    one = discs(0.0, 0.0, RADIUS, thickness)
    one["mass"] = DENSITY * thickness * one["ice_area"]
    speeds = [0.0]
    with Engine(SELF, params, log) as engine:
        engine.load(one)
        engine.set_forcing(uniform(wind=(WIND, 0.0)))
        for span in np.diff(times):
            engine.run(round(span / 60.0))
            speeds.append(engine.elements()["u"][0])
    return np.array(speeds)


def drift_beside_demsi(
    log: Path, shared: Path, name: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times (s) and speeds (m/s) of the engine, of DEMSI's law and of DEMSI, held to each other."""
    _, air, water = DRAG[name]
    path = shared / "reference" / "demsi" / f"terminal_drift_{name}.nc"
    with xr.open_dataset(path, decode_times=False) as data:
        times, demsi = data["time"].values, data["v"].values[:, 0, 0]
    ours = drift_of_engine(log, times, name)
    terminal = WIND * math.sqrt(air / water)
    exact, half = (drift(times, name, half_relative) for half_relative in (False, True))
    np.testing.assert_allclose(ours, exact, rtol=0, atol=1e-3 * terminal)
    np.testing.assert_allclose(demsi, half, rtol=0, atol=1e-3 * terminal)
    # The difference of the two laws: sqrt(1 + s^2 / 4) - s / 2 with s the root of the drags.
    s = math.sqrt(air / water)
    assert half[-1] / terminal == pytest.approx(math.hypot(1, s / 2) - s / 2, rel=0.01)
    return times, ours, half, demsi


def test_drift_from_rest_beside_demsi(log: Path, shared: Path, show) -> None:
    lines, points = {}, {}
    for name in DRAG:
        times, ours, half, demsi = drift_beside_demsi(log, shared, name)
        lines |= {f"{name}, FloeFlow": (times / 3600, ours)}
        lines |= {f"{name}, DEMSI's law solved exactly": (times / 3600, half)}
        points |= {f"{name}, DEMSI": (times / 3600, demsi)}
    show("terminal_drift", figures.curves, lines, points, "h", "m/s")


def test_inertial_circle(log: Path, show) -> None:
    f, turn = 1.4e-4, 20_000
    one = discs(5e4, -3e4)
    one["u"][:] = 0.3
    params = full_params(time_step=2 * math.pi / f / turn, coriolis=True)
    path = [(5e4, -3e4)]
    with Engine(SELF, params, log) as engine:
        engine.load(one)
        engine.set_forcing(uniform(coriolis=f))
        for _ in range(20):
            engine.run(turn // 20)
            path.append((engine.elements()["x"][0], engine.elements()["y"][0]))
        closed = engine.elements()
        engine.run(4 * turn)
        last = engine.elements()
    radius = 0.3 / f
    assert math.hypot(closed["x"][0] - 5e4, closed["y"][0] + 3e4) < 1e-6 * radius
    assert math.hypot(last["u"][0], last["v"][0]) == pytest.approx(0.3, rel=1e-12)
    x, y = np.array(path).T
    np.testing.assert_allclose(np.hypot(x - 5e4, y + 3e4 + radius), radius, rtol=1e-3)
    angle = np.linspace(0, 2 * math.pi, 100)
    circle = {"circle": (5e4 + radius * np.sin(angle), -3e4 - radius + radius * np.cos(angle))}
    show("inertial_circle", figures.curves, circle, {"FloeFlow": (x, y)}, "x (m)", "y (m)")


def test_spin_decays_by_the_quadratic_law(log: Path, show) -> None:
    spin, radius, steps = 1e-3, 1000.0, 600
    factor = full_params(time_step=1.0).ocean_stress_factor
    # m r^2/2 dw/dt = -2/5 A rho C r^3 w^2, with m / A = 917 kg/m2
    tau = 917.0 / (0.8 * factor * radius * spin)
    times = np.arange(0, 11) * 2 * tau
    exact = spin / (1 + times / tau)
    errors = []
    for refine in (1, 2, 4):
        step = 2 * tau / (steps * refine)
        omega = [spin]
        with Engine(SELF, full_params(time_step=step, ocean_drag=True), log) as engine:
            one = discs(0.0, 0.0, radius)
            one["omega"][:] = spin
            engine.load(one)
            engine.set_forcing(uniform())
            for _ in times[1:]:
                engine.run(steps * refine)
                omega.append(engine.elements()["omega"][0])
        errors.append(float(np.abs(np.array(omega) / exact - 1).max()))
    assert errors[0] < 2e-3
    assert errors[1] < 0.6 * errors[0] and errors[2] < 0.6 * errors[1]
    fine = np.linspace(0, times[-1], 200)
    law = {"1 / (1 + t / tau)": (fine, spin / (1 + fine / tau))}
    show("spin_down", figures.curves, law, {"FloeFlow": (times, omega)}, "time (s)", "spin (rad/s)")
