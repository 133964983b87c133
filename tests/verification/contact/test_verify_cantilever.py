# SPDX-License-Identifier: GPL-2.0-or-later
"""A bonded lattice of 30 x 3 elements, its left column fixed, a force on its right column.

The engine has no force of its own: wind does it. With a stress factor of 1 kg/m3 and no ocean drag
the force on an element is its ice area times |w| w, and only the right column is given an ice area.
The engine finds equilibria by kinetic damping: it runs, and where the kinetic energy has passed a
peak the velocities are set to zero.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI
from scipy.sparse.linalg import eigsh, spsolve

from floeflow.dynamics.engine.engine import Engine, Forcing
from floeflow.dynamics.step.critical import critical_step
from floeflow.state.bonds import Arrays
from support.contact import figures
from support.contact.frame import Frame, equilibrium, frame_of, gradient, hessian, stiffness
from support.contact.glue_line import failed
from support.full_ice import full_params
from support.rafts import bonded, discs, uniform

SELF = MPI.COMM_SELF
COLUMNS, ROWS, RADIUS, THICKNESS, YOUNG, POISSON = 30, 3, 2500.0, 0.2, 1e9, 0.3
LENGTH, WIDTH = 2 * RADIUS * (COLUMNS - 1), 2 * RADIUS * ROWS
SMALL, LARGE = 1e5, 1e9  # N on each element of the right column
UNBREAKABLE = {
    "young_modulus": YOUNG, "poisson_ratio": POISSON, "compressive_strength": 1e30,
    "tensile_share": 1.0, "reach": 1.5, "bonds": True, "friction": False, "wind": True,
    "wind_stress_factor": 1.0,
}  # fmt: skip


@cache
def cantilever() -> tuple[Arrays, Arrays, Frame]:
    i, j = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS))
    elements = discs(2 * RADIUS * i.ravel(), 2 * RADIUS * j.ravel(), RADIUS, THICKNESS)
    elements["type"][i.ravel() == 0] = 2
    elements["ice_area"] = (i.ravel() == COLUMNS - 1).astype(float)
    table = bonded(elements, share=1.0)
    fixed = elements["type"] == 2
    both = fixed[table["id_lo"] - 1] & fixed[table["id_hi"] - 1]
    bonds = {name: values[~both] for name, values in table.items()}
    return elements, bonds, frame_of(elements, bonds, YOUNG, POISSON)


def dead_load(force: float) -> np.ndarray:
    load = np.zeros((COLUMNS * ROWS, 3))
    load[cantilever()[0]["ice_area"] > 0, 1] = -force
    return load.ravel()


def tip(state: np.ndarray) -> float:
    """Mean deflection (m) of the right column."""
    return float((state - cantilever()[2].rest)[cantilever()[0]["ice_area"] > 0, 1].mean())


def settled(log: Path, force: float) -> np.ndarray:
    """State (n, 3) at rest under the load, by the engine."""
    elements, bonds, _ = cantilever()
    params = full_params(time_step=1.0, bond_damping=0.3, **UNBREAKABLE)
    step = 0.5 * critical_step(elements, bonds, params)[0]
    params = full_params(time_step=step, bond_damping=0.3, **UNBREAKABLE)
    now, last = elements, math.inf
    with Engine(SELF, params, log) as engine:
        for _ in range(200):
            engine.load(now, bonds)
            engine.set_forcing(uniform(wind=(0.0, -math.sqrt(force))))
            peak = 0.0
            while True:
                engine.run(50)
                kinetic = engine.diagnostics()["kinetic"]
                if kinetic < peak:
                    break
                peak = kinetic
            now = engine.elements()
            for name in ("u", "v", "omega"):
                now[name] = np.zeros_like(now[name])
            state = np.column_stack([now["x"], now["y"], now["theta"]])
            if abs(tip(state) - last) < 1e-7 * abs(tip(state)):
                return state
            last = tip(state)
    raise AssertionError("no equilibrium")


def test_the_reference_agrees_with_itself() -> None:
    frame = cantilever()[2]
    assembled = stiffness(frame)
    assert abs(assembled - hessian(frame, frame.rest)).max() < 1e-5 * abs(assembled).max()
    assert np.abs(gradient(frame, frame.rest)).max() < 10.0  # N, N m: round-off of 1e15


def test_equilibrium_under_a_small_load(log: Path) -> None:
    frame = cantilever()[2]
    load, free = dead_load(SMALL), frame.free
    linear = np.zeros(free.size)
    linear[free] = spsolve(stiffness(frame)[free][:, free], load[free])
    expected = linear.reshape(-1, 3)
    moved = settled(log, SMALL) - frame.rest
    assert abs(expected[:, 1]).max() < 0.01 * LENGTH
    for k in range(3):
        scale = np.abs(expected[:, k]).max()
        np.testing.assert_allclose(moved[:, k], expected[:, k], rtol=0, atol=1e-3 * scale)
    # Timoshenko: a beam from the fixed column's centres to the right ones', as wide as three
    # elements. Elements turn freely between 3 joints of a section and 2 bonds along it: in series
    # these leave 6 / 5 of an element's section to carry shear, 0.4 of the whole.
    bending = 3 * SMALL * LENGTH**3 / (3 * YOUNG * THICKNESS * WIDTH**3 / 12)
    shear = 3 * SMALL * LENGTH / (0.4 * YOUNG / (2 * (1 + POISSON)) * THICKNESS * WIDTH)
    assert -tip(moved + frame.rest) == pytest.approx(bending + shear, rel=0.03)
    assert 0.005 * bending < shear


def first_mode() -> tuple[float, np.ndarray, np.ndarray]:
    """Angular frequency (1/s), shape (n, 3) with a tip of 1 m, masses (3 n,)."""
    elements, _, frame = cantilever()
    inertia = 0.5 * elements["mass"] * elements["radius"] ** 2
    mass = np.column_stack([elements["mass"], elements["mass"], inertia]).ravel()
    free, root = frame.free, np.sqrt(mass[frame.free])
    matrix = stiffness(frame)[free][:, free].multiply(1 / root[:, None]).multiply(1 / root)
    values, vectors = eigsh(matrix.tocsc(), k=1, sigma=0.0)
    shape = np.zeros(free.size)
    shape[free] = vectors[:, 0] / root
    return math.sqrt(values[0]), shape.reshape(-1, 3) / tip(shape.reshape(-1, 3) + frame.rest), mass


def test_first_natural_frequency(log: Path) -> None:
    elements, bonds, frame = cantilever()
    frequency, shape, mass = first_mode()
    params = full_params(time_step=1.0, bond_damping=0.0, **UNBREAKABLE)
    start = dict(elements)
    speed = 1e-4 * LENGTH * frequency
    start["u"], start["v"], start["omega"] = (speed * shape[:, k] for k in range(3))
    times, place = [0.0], [0.0]
    norm = float((shape.ravel() * mass) @ shape.ravel())
    with Engine(SELF, params, log) as engine:
        engine.load(start, bonds)
        engine.set_forcing(uniform())
        for _ in range(120):
            engine.run(150)
            now = engine.elements()
            moved = np.column_stack([now["x"], now["y"], now["theta"]]) - frame.rest
            times.append(times[-1] + 150.0)
            place.append(float((shape.ravel() * mass) @ moved.ravel()) / norm)
    assert times[-1] > 2 * 2 * math.pi / frequency
    # Zeros of the modal coordinate, between samples by its own sine.
    t, q = np.array(times), np.array(place)
    k = np.flatnonzero(q[1:-1] * q[2:] < 0) + 1
    zeros = t[k] + (t[k + 1] - t[k]) * q[k] / (q[k] - q[k + 1])
    measured = math.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0])
    assert measured == pytest.approx(frequency, rel=1e-3)
    # Euler and Bernoulli's beam is stiffer in shear; discs fill pi / 4 of it with mass.
    density = 917 * math.pi / 4
    beam = 3.516 * math.sqrt(YOUNG * WIDTH**2 / 12 / density) / (LENGTH + RADIUS) ** 2
    assert 0.97 * beam < frequency < beam


def test_large_load_beside_newton_and_demsi(log: Path, shared: Path, show) -> None:
    elements, _, frame = cantilever()
    exact = equilibrium(frame, dead_load(LARGE))
    ours = settled(log, LARGE)
    assert np.abs(ours - exact)[:, :2].max() < 1e-3 * abs(tip(exact))
    assert np.abs(ours - exact)[:, 2].max() < 1e-3 * np.abs(exact[:, 2]).max()
    assert tip(ours) == pytest.approx(tip(exact), rel=1e-3)
    path = shared / "reference" / "demsi" / "cantilever_equilibrium.nc"
    with xr.open_dataset(path, decode_times=False) as data:
        place, kind = data["x"].values, data["type"].values
    moved = place - place[0]
    demsi = moved[-1][kind == 5, 1].mean()
    assert demsi == pytest.approx(tip(ours), rel=1e-3)
    corner = place[0].min(0)
    points = {"DEMSI": tuple((place[-1] - corner).T), "FloeFlow": (ours[:, 0], ours[:, 1])}
    middle = exact[COLUMNS : 2 * COLUMNS]
    show(
        "cantilever_large_load", figures.curves, {"least energy": (middle[:, 0], middle[:, 1])},
        points, "x (m)", "y (m)",
    )  # fmt: skip


STRENGTH = {"compressive": 1e6, "tensile": 1e5, "tan_phi": math.tan(math.radians(35.0))}


def first_to_fail() -> tuple[float, tuple[int, int]]:
    """Load per element (N) at which the small-load solution first meets the envelope; the pair."""
    elements, bonds, frame = cantilever()
    free, unit = frame.free, np.zeros(frame.free.size)
    unit[free] = spsolve(stiffness(frame)[free][:, free], dead_load(1.0)[free])
    q = unit.reshape(-1, 3)

    def bad(load: float) -> np.ndarray:
        out = []
        for xi in (0.0, 1.0):
            parts = []
            for side, row in (("lo", frame.lo), ("hi", frame.hi)):
                x = bonds[f"{side}_ax"] + xi * (bonds[f"{side}_bx"] - bonds[f"{side}_ax"])
                y = bonds[f"{side}_ay"] + xi * (bonds[f"{side}_by"] - bonds[f"{side}_ay"])
                parts.append((q[row, 0] - q[row, 2] * y, q[row, 1] + q[row, 2] * x))
            dx, dy = (load * (hi - lo) for lo, hi in zip(*parts, strict=True))
            length = 2 * RADIUS
            tx = (bonds["lo_bx"] - bonds["lo_ax"]) / length
            ty = (bonds["lo_by"] - bonds["lo_ay"]) / length
            normal, slide = dx * ty - dy * tx, dx * tx + dy * ty
            shear = YOUNG / (2 * (1 + POISSON))
            out.append(failed(normal, slide, 2 * RADIUS, YOUNG, shear, **STRENGTH))
        return out[0] | out[1]

    low, high = 0.0, 1e9
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if bad(middle).any() else (middle, high)
    k = int(np.flatnonzero(bad(high))[0])
    return high, (int(bonds["id_lo"][k]), int(bonds["id_hi"][k]))


def test_breaks_where_the_envelope_is_first_met(log: Path) -> None:
    elements, bonds, _ = cantilever()
    limit, pair = first_to_fail()
    period = 2 * math.pi / first_mode()[0]
    end, full = 20 * period, 1.1 * limit
    times = np.linspace(0.0, 1.01 * end, 2001)
    wind = np.zeros((len(times), 2, 2))
    wind += -np.sqrt(full * times / end)[:, None, None]
    edge = np.array([-1e6, 1e6])
    forcing = Forcing(times, edge, edge, {"wind_u": 0 * wind, "wind_v": wind})
    weak = UNBREAKABLE | {
        "compressive_strength": STRENGTH["compressive"],
        "tensile_share": STRENGTH["tensile"] / STRENGTH["compressive"],
        "friction_angle": math.radians(35.0),
    }
    with Engine(SELF, full_params(time_step=1.0, bond_damping=0.1, **weak), log) as engine:
        engine.load(elements, bonds)
        engine.set_forcing(forcing)
        now = bonds
        for _ in range(int(end / 25)):
            engine.run(25)
            now, time = engine.bonds(), engine.diagnostics()["time"]
            if len(now["id_lo"]) < len(bonds["id_lo"]) or (now["crack_a"] + now["crack_b"]).any():
                break
    hit = np.flatnonzero((now["crack_a"] + now["crack_b"]) > 0)
    cracked = {(int(now["id_lo"][k]), int(now["id_hi"][k])) for k in hit}
    kept = set(zip(now["id_lo"].tolist(), now["id_hi"].tolist(), strict=True))
    gone = set(zip(bonds["id_lo"].tolist(), bonds["id_hi"].tolist(), strict=True)) - kept
    assert pair in cracked | gone
    assert full * time / end == pytest.approx(limit, rel=0.02)
