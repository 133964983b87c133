# SPDX-License-Identifier: GPL-2.0-or-later
"""Ridging through the engine: the plastic path, its area and its energy, and the broken bond."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine, EngineParams
from support.full_ice import full_params
from support.rafts import bonded, discs, lattice

SELF = MPI.COMM_SELF
EDGE = 1 / math.sqrt(3)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return tmp_path / "liggghts.log"


def pressed(
    thickness: tuple[float, float], speed: float = 1.0, overlap: float = 0.0
) -> dict[str, np.ndarray]:
    """A driven element that is pushed into a fixed one."""
    pair = discs([0.0, 2000.0 - overlap], [0.0, 0.0], thickness=np.array(thickness))
    pair["type"][0] = 2
    pair["mass"][1] = 1e27
    pair["u"][1] = -speed
    return pair


@pytest.mark.parametrize("h", [0.2, 2.0])
def test_the_plastic_path_is_the_closed_form(log: Path, h: float) -> None:
    params = full_params(time_step=0.05, ridging=True, friction=False, compressive_strength=1e5)
    length, stiffness = EDGE * 2000.0, params.contact_modulus * h / 2
    with Engine(SELF, params, log) as engine:
        engine.load(pressed((h, h)))
        engine.run(2000)  # 100 m
        contact, out, sums = engine.contacts(), engine.elements(), engine.diagnostics()
    # The strip between the centres keeps its volume.
    ridge, closing = contact["ridge_thickness"][0], contact["ridge_closing"][0]
    assert ridge * (2000.0 - closing) == pytest.approx(h * 2000.0, rel=1e-12)
    per_length = (26126.0 * ridge + 928.0 * ridge**2 * closing) if h < 0.3 else ridge * 1e5
    assert closing == pytest.approx(100.0 - length * per_length / stiffness, rel=1e-4)
    assert contact["rest_overlap"][0] == closing
    # All of it is given by the element that can move.
    assert out["ridged_area"][0] == 0.0
    assert out["ridged_area"][1] == pytest.approx(length * closing, rel=1e-12)
    assert sums["max_overlap"] == pytest.approx(length * per_length / stiffness, rel=1e-4)
    path = np.linspace(0.0, closing, 10001)
    thick = h * 2000.0 / (2000.0 - path)
    force = (26126.0 * thick + 928.0 * thick**2 * path) if h < 0.3 else thick * 1e5
    work = length * np.mean(0.5 * (force[1:] + force[:-1])) * closing
    assert sums["dissipation_ridging"] == pytest.approx(work, rel=1e-3)


def test_the_thinner_element_gives_more_of_its_area(log: Path) -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0], thickness=np.array([0.5, 1.5]))
    pair["mass"][:] = 1e27
    pair["u"][1] = -1.0
    params = full_params(time_step=0.05, ridging=True, compressive_strength=1e5)
    with Engine(SELF, params, log) as engine:
        engine.load(pair)
        engine.run(1000)
        area, contact = engine.elements()["ridged_area"], engine.contacts()
    assert area[0] == pytest.approx(3 * area[1], rel=1e-12) and area[1] > 0
    closed = contact["ridge_closing"][0] * contact["ridge_length"][0]
    assert area.sum() == pytest.approx(closed, rel=1e-12)


@pytest.mark.parametrize("cover", [(0.9, 0.9), (1.0, 0.8)])
def test_leads_close_before_ice_ridges(log: Path, cover: tuple[float, float]) -> None:
    # A tenth of the 2000 m between the centres is open water.
    params = full_params(time_step=0.05, ridging=True, friction=False, compressive_strength=1e5)
    length, stiffness = EDGE * 2000.0, params.contact_modulus / 2
    steps = 0
    with Engine(SELF, params, log) as engine:
        engine.load(pressed((1.0, 1.0), speed=2.0) | {"cover": np.array(cover)})
        for pressed_by in (100.0, 240.0):
            engine.run(round(pressed_by / 0.1) - steps)
            steps = round(pressed_by / 0.1)
            closing = engine.contacts()["ridge_closing"][0]
            path = np.linspace(0.0, closing, 20001)
            open_share = np.maximum(1.0 - 0.9 * 2000.0 / (2000.0 - path), 0.0)
            force = length * 1e5 * 2000.0 / (2000.0 - path) * np.exp(-20.0 * open_share)
            work = np.mean(0.5 * (force[1:] + force[:-1])) * closing
            assert engine.diagnostics()["dissipation_ridging"] == pytest.approx(work, rel=2e-3)
            assert closing == pytest.approx(pressed_by - force[-1] / stiffness, rel=1e-4)
            assert engine.elements()["ridged_area"][1] == pytest.approx(length * closing, rel=1e-12)
    assert closing > 200.0 and force[0] < 0.14 * force[-1]


def test_the_side_with_leads_gives_the_area(log: Path) -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0]) | {"cover": np.array([1.0, 0.9])}
    pair["mass"][:] = 1e27
    pair["u"][1] = -1.0
    params = full_params(time_step=0.05, ridging=True, compressive_strength=1e5)
    with Engine(SELF, params, log) as engine:
        engine.load(pair)
        engine.run(1000)
        area = engine.elements()["ridged_area"]
    assert area[1] == pytest.approx(math.exp(2.0) * area[0], rel=1e-9) and area[0] > 0


def collision(log: Path, step: float) -> tuple[float, float]:
    pair = discs([0.0, 2001.0], [0.0, 300.0])
    pair["u"][:], pair["v"][:] = [2.0, -2.0], [0.1, 0.0]
    params = full_params(time_step=step, ridging=True, compressive_strength=1e5)
    with Engine(SELF, params, log) as engine:
        engine.load(pair)
        first = engine.diagnostics()
        engine.run(round(100.0 / step))
        last = engine.diagnostics()
    energy = [d["kinetic"] + d["rotational"] + d["elastic_contact"] for d in (first, last)]
    lost = sum(last[f"dissipation_{k}"] for k in ("contact", "friction", "ridging"))
    return abs(energy[0] - energy[1] - lost) / energy[0], last["dissipation_ridging"] / energy[0]


def test_energy_lost_in_a_ridging_collision_is_what_was_counted(log: Path) -> None:
    results = [collision(log, 0.2 / 2**k) for k in (0, 3)]
    residuals = [residual for residual, _ in results]
    assert all(ridged > 0.3 for _, ridged in results)
    assert residuals[0] < 1e-3
    assert residuals[1] < 0.25 * residuals[0]


def test_a_ridge_stays_where_it_was_built(log: Path) -> None:
    params = full_params(time_step=0.05, ridging=True, friction=False, compressive_strength=1e5)
    with Engine(SELF, params, log) as engine:
        engine.load(pressed((1.0, 1.0)))
        engine.run(1000)  # 50 m in
        elements, contacts = engine.elements(), engine.contacts()
        area = elements["ridged_area"][1]
        elements["u"][1] = 1.0
        engine.load(elements, None, contacts)
        engine.run(1040)  # apart, past the first touch
        elements, contacts = engine.elements(), engine.contacts()
        assert elements["x"][1] > 2000.0 and len(contacts["id_lo"]) == 1
        elements["u"][1] = -1.0
        engine.load(elements, None, contacts)
        engine.run(1020)  # back to 49 m: not to where the ridge's force begins to be its limit
        assert engine.elements()["ridged_area"][1] == area
        assert engine.diagnostics()["elastic_contact"] > 0.0
        engine.run(60)
        assert engine.elements()["ridged_area"][1] > area


def test_a_bond_that_breaks_in_compression_goes_on_as_a_contact(log: Path) -> None:
    # Discs 100 m apart: the bond reaches across the gap, and so does what remains of it.
    pair = discs([0.0, 2100.0], [0.0, 0.0])
    pair["type"][0] = 2
    pair["mass"][1] = 1e27
    pair["u"][1] = -1.0
    table = bonded(pair, gap=200.0)
    params = full_params(
        time_step=0.01, bonds=True, ridging=True, compressive_strength=1e6, friction=False
    )
    with Engine(SELF, params, log) as engine:
        engine.load(pair, table)
        engine.run(211)  # breaks at 2.1 m
        bonds, contacts = engine.bonds(), engine.contacts()
        sums = engine.diagnostics()
        state = engine.elements()
    assert len(bonds["id_lo"]) == 0 and contacts["rest_overlap"][0] < -100.0
    assert contacts["ridge_length"][0] == pytest.approx(table["length"][0])
    # The contact is softer than the bond: it takes over no more than the bond's elastic energy.
    length, squeeze = table["length"][0], 2.1
    energy = 0.5 * params.young_modulus * length / 2100.0 * squeeze**2
    assert sums["elastic_contact"] == pytest.approx(energy, rel=2e-2)
    # No energy is lost: only the force falls, and half of its fall did no work in the last step.
    stiffness = 0.5 * params.contact_modulus
    fall = params.young_modulus * length / 2100.0 * squeeze - math.sqrt(2 * stiffness * energy)
    assert sums["dissipation_fracture"] == pytest.approx(-0.5 * fall * 0.01, rel=2e-2)
    # And from there up to the ridging force.
    with Engine(SELF, params, log) as engine:
        engine.load(state, None, contacts)
        engine.run(6000)
        contact, sums = engine.contacts(), engine.diagnostics()
    limit = contact["ridge_thickness"][0] * 1e6 * length
    assert contact["ridge_closing"][0] > 10.0
    assert sums["max_overlap"] * 0.5 * params.contact_modulus == pytest.approx(limit, rel=1e-4)


def test_it_meets_again_where_it_opened(log: Path) -> None:
    pair = discs([0.0, 2100.0], [0.0, 0.0])
    pair["type"][0] = 2
    pair["mass"][1] = 1e27
    pair["u"][1] = -1.0
    params = full_params(
        time_step=0.01, bonds=True, ridging=True, compressive_strength=1e6, friction=False
    )
    with Engine(SELF, params, log) as engine:
        engine.load(pair, bonded(pair, gap=200.0))
        engine.run(211)  # breaks at 2.1 m
        for speed in (2.0, -1.0):  # 8 m back, to where it bears nothing, and 3 m on again
            state, contacts = engine.elements(), engine.contacts()
            state["u"][1] = speed
            engine.load(state, None, contacts)
            engine.run(400 if speed > 0 else 300)
            if speed > 0:
                assert engine.diagnostics()["elastic_contact"] == 0.0
                assert (engine.contacts()["rest_overlap"] < -100.0).all()
        out, contact = engine.elements(), engine.contacts()
        push = 2000.0 - (out["x"][1] - out["x"][0]) - contact["rest_overlap"][0]
        stiffness = 0.5 * params.contact_modulus
        assert push > 0.0 and len(contact["id_lo"]) == 1
        energy = engine.diagnostics()["elastic_contact"]
    assert energy == pytest.approx(0.5 * stiffness * push**2, rel=1e-6)


def squeezed() -> tuple[dict[str, np.ndarray], EngineParams]:
    raft = lattice(6, 5)
    random = np.random.default_rng(4)
    raft["thickness"] = random.uniform(0.1, 2.0, 30)
    raft["mass"] = raft["mass"] * raft["thickness"]
    raft["u"], raft["v"] = -2e-4 * raft["x"] + 1.0, -1e-4 * raft["y"]
    return raft, full_params(time_step=0.1, bonds=True, ridging=True, compressive_strength=1e5)


def test_momentum_of_a_ridging_raft_and_its_area(log: Path) -> None:
    raft, params = squeezed()
    with Engine(SELF, params, log) as engine:
        engine.load(raft, bonded(raft))
        engine.run(2000)
        out, contacts, sums = engine.elements(), engine.contacts(), engine.diagnostics()
    for name in ("u", "v"):
        before, after = (m["mass"] @ m[name] for m in (raft, out))
        assert abs(after - before) < 1e-12 * (out["mass"] @ np.abs(out[name]))
    assert sums["dissipation_ridging"] > 0 and (contacts["ridge_closing"] > 0).sum() > 10
    assert (out["ridged_area"] >= 0).all() and (out["ridged_area"] > 0).any()


def test_cut_and_continued_while_ridging(log: Path) -> None:
    # A line, so that no sum depends on the order of its terms.
    line = discs(1995.0 * np.arange(12), np.zeros(12), thickness=np.linspace(0.1, 2.0, 12))
    line["u"] = -2e-4 * line["x"]
    params = full_params(time_step=0.1, ridging=True, compressive_strength=1e5)
    with Engine(SELF, params, log) as engine:
        engine.load(line)
        engine.run(200)
        cut = engine.elements(), engine.contacts()
        engine.run(300)
        whole = engine.elements(), engine.contacts()
        assert (cut[1]["ridge_closing"] > 0).any()
        engine.load(cut[0], None, cut[1], time=20.0)
        engine.run(300)
        for now, then in zip((engine.elements(), engine.contacts()), whole, strict=True):
            assert now.keys() == then.keys()
            for name in now:
                np.testing.assert_array_equal(now[name], then[name], err_msg=name)
