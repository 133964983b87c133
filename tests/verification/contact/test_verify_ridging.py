# SPDX-License-Identifier: GPL-2.0-or-later
"""Two unbonded elements pressed together and released, and single ridges: force against closing.

Element 1 is fixed, element 2 weighs 1e27 kg and keeps the velocity that it is given. Closed form:
`ridge_law.py`, after Hopkins (1994, 1996) as in docs/theory/contact.md.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine
from floeflow.state.bonds import Arrays
from support.contact import figures
from support.contact.ridge_law import EDGE, RidgeLaw, Ridging, demsi_force
from support.full_ice import full_params
from support.rafts import bonded, discs

SELF = MPI.COMM_SELF
RADIUS, HEAVY, MODULUS = 2500.0, 1e27, 1e8


def pair_of(thickness: float, speed: float) -> Arrays:
    pair = discs([12500.0, 12500.0 + 2 * RADIUS], [15000.0] * 2, RADIUS, thickness)
    pair["type"][0] = 2
    pair["mass"][1], pair["u"][1] = HEAVY, -speed
    return pair


def driven(engine: Engine, count: int, every: int) -> dict[str, np.ndarray]:
    """Path of the loaded pair: closing of the centres, force and history after each piece.

    The force (N) is the impulse that the fixed element took over the piece's last step.
    """
    rows = []
    for _ in range(count):
        engine.run(every - 1)
        # The force of a step belongs to what is at its start.
        before = engine.diagnostics()["impulse_fixed_x"]
        elements, contact = engine.elements(), engine.contacts()
        engine.run(1)
        impulse = engine.diagnostics()["impulse_fixed_x"] - before
        travel = 2 * RADIUS - (elements["x"][1] - elements["x"][0])
        ridge = [float(contact[f"ridge_{n}"].sum()) for n in ("closing", "thickness")]
        force = abs(impulse) / engine.params.time_step
        rows.append((travel, force, *ridge, elements["ridged_area"][1]))
    names = ("travel", "force", "closing", "thickness", "area")
    return dict(zip(names, np.array(rows).T, strict=True))


def turned_back(engine: Engine, speed: float) -> None:
    """Load what the engine holds once more, with another velocity of element 2."""
    elements, contacts = engine.elements(), engine.contacts()
    elements["u"][1] = speed
    engine.load(elements, None, contacts)


@pytest.mark.parametrize("h", [0.1, 0.25, 1.0])
def test_pressed_together_and_released(log: Path, h: float, show) -> None:
    params = full_params(
        time_step=0.05, ridging=True, friction=False, contact_damping=0.0,
        compressive_strength=1e5, contact_modulus=MODULUS,
    )  # fmt: skip
    with Engine(SELF, params, log) as engine:
        engine.load(pair_of(h, 1.0))
        loading = driven(engine, 60, 100)  # 300 m
        turned_back(engine, 1.0)
        release = driven(engine, 40, 20)
        again = driven(engine, 1, 4000)  # discs still overlap, by less than what ridged
    ridge = Ridging(RidgeLaw(), 2 * EDGE * RADIUS, 2 * RADIUS, h)
    stiffness = 0.5 * MODULUS * h
    closing = np.array([ridge.closing_after(t, stiffness) for t in loading["travel"]])
    force = np.array([min(stiffness * t, ridge.force(c)) for t, c in zip(
        loading["travel"], closing, strict=True)])  # fmt: skip
    np.testing.assert_allclose(loading["closing"], closing, rtol=0, atol=1e-4 * closing[-1])
    np.testing.assert_allclose(loading["force"], force, rtol=1e-4)
    thickness = np.array([ridge.thick(c) for c in loading["closing"]])
    np.testing.assert_allclose(loading["thickness"], thickness, rtol=1e-12)
    np.testing.assert_allclose(loading["area"], ridge.length * loading["closing"], rtol=1e-12)
    # Released, it is elastic: nothing of the ridge comes back, and there is no tension.
    ridged = release["closing"][0]
    assert (release["closing"] == ridged).all() and 0 <= ridged - loading["closing"][-1] < 0.1
    elastic = stiffness * np.maximum(release["travel"] - ridged, 0.0)
    np.testing.assert_allclose(release["force"], elastic, rtol=0, atol=1e-4 * force[-1])
    assert (release["force"] == 0).any() and (release["force"] > 0).any()
    assert again["force"][0] == 0 and again["closing"][0] == ridged
    if h == 0.25:
        lines = {"closed form": (closing + force / stiffness, force / ridge.length / 1e3)}
        points = {
            "pressed": (loading["travel"], loading["force"] / ridge.length / 1e3),
            "released": (release["travel"], release["force"] / ridge.length / 1e3),
        }
        label = ("closing of the centres (m)", "force per contact length (kN/m)")
        show("ridging_pair", figures.curves, lines, points, *label)


THICKNESSES = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 1.0)


def test_single_ridges_force_against_displacement(log: Path, show) -> None:
    params = full_params(
        time_step=0.1, ridging=True, friction=False, contact_damping=0.0,
        compressive_strength=1e5, contact_modulus=MODULUS,
    )  # fmt: skip
    lines, points, last = {}, [], 0.0
    with Engine(SELF, params, log) as engine:
        for h in THICKNESSES:
            engine.load(pair_of(h, 2.0))
            path = driven(engine, 25, 100)
            work = engine.diagnostics()["dissipation_ridging"]
            ridge = Ridging(RidgeLaw(), 2 * EDGE * RADIUS, 2 * RADIUS, h)
            law = np.array([ridge.force(c) for c in path["closing"]])
            np.testing.assert_allclose(path["force"], law, rtol=3e-4)
            # Thicker ice is stronger, a longer ridge too.
            assert path["force"][0] > last and (np.diff(path["force"]) > 0).all()
            last = path["force"][0]
            fine = np.linspace(0.0, path["closing"][-1], 2001)
            force = np.array([ridge.force(c) for c in fine])
            assert work == pytest.approx(np.trapezoid(force, fine), rel=2e-3)
            lines[f"{h:g} m"] = (fine, force / ridge.length / 1e3)
            points.append((path["closing"], path["force"] / ridge.length / 1e3))
    label = ("closing (m)", "force per contact length (kN/m)")
    ours = {"FloeFlow": tuple(np.concatenate(p) for p in zip(*points, strict=True))}
    show("ridging_single", figures.curves, lines, ours, *label)


@pytest.mark.parametrize("h", [0.1, 0.2, 0.3])
def test_work_of_ridging_beside_the_potential_energy_of_a_ridge(h: float) -> None:
    # Continuum models take the work as 17 times the gain of potential energy (Rothrock 1975; Flato
    # & Hibler 1995), with ridges of 2 h to 2 sqrt(100 m h), all thicknesses alike (Hibler 1980).
    closing = np.linspace(0.0, 200.0, 2001)
    ridge = Ridging(RidgeLaw(), 1.0, 1e6, h)
    work = np.trapezoid([ridge.force(c) for c in closing], closing)
    low, high = 2 * h, 2 * np.sqrt(100.0 * h)
    per_volume = 0.5 * 9.81 * 917.0 * (1026.0 - 917.0) / 1026.0  # J/m3 and m of thickness
    ridged = 2 / 3 * (high**3 - low**3) / (high**2 - low**2)
    gain = per_volume * h * closing[-1] * (ridged - h)
    assert 15.0 < work / gain < 19.0


SPEED, STEP = 60.0, 1.0 / 15.0


def demsi_run(shared: Path, name: str) -> xr.Dataset:
    path = shared / "reference" / "demsi" / "two_elements" / f"{name}_compression_force.nc"
    with xr.open_dataset(path, decode_times=False) as data:
        return data.load()


def test_unbonded_beside_demsi(log: Path, shared: Path, show) -> None:
    demsi = demsi_run(shared, "unbonded")
    moved = 2 * RADIUS - (demsi["x"].values[:, 1, 0] - demsi["x"].values[:, 0, 0])
    seconds = 60
    params = full_params(
        time_step=STEP, ridging=True, friction=False, contact_damping=0.1,
        compressive_strength=2.5e8, contact_modulus=1e9,
    )  # fmt: skip
    with Engine(SELF, params, log) as engine:
        engine.load(pair_of(0.2, SPEED))
        ours = driven(engine, seconds, 15)
    # The same motion, to the step at whose start the force is taken.
    np.testing.assert_allclose(ours["travel"] + SPEED * STEP, moved[1 : seconds + 1], rtol=1e-9)
    # DEMSI's elements lose no area: its radii never change.
    assert (demsi["radius"].values == RADIUS).all()
    ridge = Ridging(RidgeLaw(strength=2.5e8), 2 * EDGE * RADIUS, 2 * RADIUS, 0.2)
    np.testing.assert_allclose(ours["area"], ridge.length * ours["closing"], rtol=1e-12)
    piling = ours["thickness"] < 0.3
    law = np.array([ridge.force(c) for c in ours["closing"]])
    np.testing.assert_allclose(ours["force"][piling], law[piling], rtol=3e-3)
    travel = SPEED * STEP * np.arange(1, 15 * seconds + 1)
    theirs = demsi_force(travel, SPEED, STEP)
    # Its contact is as long as the diameter, its ridge stays as thick as it began, and the start
    # of its law, 26126 N/m2 times thickness, lacks the length: it begins with next to no force.
    linear = 26126.0 * 0.2 + 928.0 * 0.2**2 * 2 * RADIUS * travel
    np.testing.assert_allclose(theirs, linear, rtol=1e-3)
    assert theirs[0] < 0.06 * ridge.force(0.0)
    lines = {
        "ridging law": (ours["travel"][piling], law[piling] / 1e6),
        "law in DEMSI's source": (travel[: 15 * piling.sum()], theirs[: 15 * piling.sum()] / 1e6),
    }
    points = {"FloeFlow": (ours["travel"][piling], ours["force"][piling] / 1e6)}
    show("ridging_demsi", figures.curves, lines, points, "closing (m)", "force (MN)")


def test_bond_broken_in_compression_beside_demsi(log: Path, shared: Path, show) -> None:
    demsi = demsi_run(shared, "bonded")
    whole = demsi["bondLength"].values[:, 0] > 0
    pair = pair_of(1.0, SPEED)
    params = full_params(
        time_step=STEP, bonds=True, ridging=True, friction=False, bond_damping=0.0, reach=1.5,
        contact_damping=0.0, compressive_strength=2.5e8, tensile_share=4e21, contact_modulus=1e9,
    )  # fmt: skip
    with Engine(SELF, params, log) as engine:
        engine.load(pair, bonded(pair, share=1.0))
        seconds, bonds = 40, []
        path = {}
        for _ in range(seconds):
            piece = driven(engine, 1, 15)
            path = {n: np.append(path.get(n, []), v) for n, v in piece.items()}
            bonds.append(len(engine.bonds()["id_lo"]))
    held = np.array(bonds) > 0
    # Ours holds to 1250 m; DEMSI's ends run ahead by 1.035, so it breaks at 1208 m.
    assert path["travel"][held].max() < 1250.0 < path["travel"][~held].min() + 2 * SPEED * STEP
    demsi_travel = SPEED * demsi["time"].values
    assert demsi_travel[whole].max() < 1250.0 / 1.035043625 < demsi_travel[~whole].min()
    # Up to there it is the bond's: E h L / l per metre.
    bond = 1e9 * 1.0 * path["travel"][held]
    np.testing.assert_allclose(path["force"][held], bond, rtol=1e-9)
    # Then the softer contact begins with no more energy than the bond had, and goes up to the
    # force that crushes 1 m of ice; DEMSI begins a new ridge of 0.2 m from nothing.
    stiffness = 0.5 * 1e9
    first = path["travel"][~held][0]
    takeover = 1e9 * 1250.0 * np.sqrt(0.5) + stiffness * (first - 1250.0)
    assert path["force"][~held][0] == pytest.approx(takeover, rel=5e-3)
    ridge = Ridging(RidgeLaw(strength=2.5e8), 2 * RADIUS, 2 * RADIUS - 1250.0, 1.0)
    closing = path["closing"][~held]
    plastic = closing > 0
    crush = 5000.0 * 2.5e8 * path["thickness"][~held]
    np.testing.assert_allclose(path["force"][~held][plastic], crush[plastic], rtol=2e-3)
    travel = SPEED * STEP * np.arange(1, 15 * seconds + 1)
    broken = travel > 1250.0 / 1.035043625
    bonded_part = np.where(broken, np.nan, 1.035043625 * 1e9 * travel)
    bonded_part[broken] = demsi_force(travel[broken] - travel[broken][0], SPEED, STEP)
    assert ridge.thick(0.0) == 1.0
    assert np.nanmax(bonded_part[broken]) < 1e-2 * path["force"][~held].min()
    show(
        "ridging_broken_bond", figures.curves,
        {"law in DEMSI's source": (travel, bonded_part / 1e9)},
        {"FloeFlow": (path["travel"], path["force"] / 1e9)}, "closing (m)", "force (GN)",
    )  # fmt: skip
