# SPDX-License-Identifier: GPL-2.0-or-later
"""Hertz' contact law: its closed forms, and the stock law of the same name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.liggghts import PRINT, discs, run_script

pytestmark = pytest.mark.mpi

YOUNG, POISSON, OVERLAP, RATIO = 1e7, 0.3, 0.01, 0.4
LAW = f"contact_law hertz contact_young {YOUNG} poisson {POISSON} contact_damping 0"
# Two discs of 1 m: R* = 1/2 m, E* = E / 2 (1 - nu^2); N/m^1.5.
STIFFNESS = 4 / 3 * YOUNG / (2 * (1 - POISSON**2)) * np.sqrt(0.5)
MASS = 900 * np.pi  # of a disc, kg
SHOW = (
    "compute gpe all pe\ncompute fx all reduce max fx\ncompute fy all reduce max fy\n"
    "compute tz all property/atom tqz\ncompute tq all reduce min c_tz\n"
    "compute vx all reduce max vx\n"
    "thermo_style custom step c_gpe c_fx c_fy c_tq c_vx f_motion[27] f_motion[30]\n" + PRINT
)
PRESSED = [(0.0, 0.0), (2.0 - OVERLAP, 0.0)]


def test_force_and_energy_of_a_pressed_pair_are_hertz_and_the_stock_law_s(tmp_path: Path) -> None:
    script = discs(PRESSED, f"{LAW} friction no")
    row = run_script(tmp_path / "own", script + SHOW + "run 0\n").tables[0]
    assert row["2"][0] == pytest.approx(STIFFNESS * OVERLAP**1.5, rel=1e-12)
    energy = 0.4 * STIFFNESS * OVERLAP**2.5
    assert row["1"][0] == row["6"][0] == pytest.approx(energy, rel=1e-12)
    stock = script.replace(
        f"pair_style gran model floe {LAW} friction no",
        f"fix m1 all property/global youngsModulus peratomtype {YOUNG} {YOUNG}\n"
        f"fix m2 all property/global poissonsRatio peratomtype {POISSON} {POISSON}\n"
        "fix m3 all property/global coefficientRestitution peratomtypepair 2 1 1 1 1\n"
        "soft_particles yes\npair_style gran model hertz",
    ).replace("floe/integrate thickness 1", "nve/sphere")
    show = "compute fx all reduce max fx\nthermo_style custom step c_fx\n" + PRINT
    other = run_script(tmp_path / "stock", stock + show + "run 0\n").tables[0]
    assert row["2"][0] == pytest.approx(other["1"][0], rel=1e-9)


def test_a_collision_is_as_deep_as_its_energy_and_elastic(tmp_path: Path) -> None:
    speed = 2.0  # of approach
    script = discs([(0.0, 0.0), (2.0, 0.0)], f"{LAW} friction no", step=2e-5) + (
        "group left id 1\ngroup right id 2\nvelocity left set 1 0 0 units box\n"
        "velocity right set -1 0 0 units box\nthermo 20\n"
    )
    table = run_script(tmp_path, script + SHOW + "run 12000\n").tables[-1]
    reduced = MASS / 2
    deepest = (1.25 * reduced * speed**2 / STIFFNESS) ** 0.4
    assert table["7"].max() == pytest.approx(deepest, rel=1e-3)
    # Apart again, with the speeds exchanged.
    assert table["6"][-1] == 0.0 and table["5"][-1] == pytest.approx(1.0, rel=1e-6)


def test_tangential_stiffness_follows_the_overlap(tmp_path: Path) -> None:
    step, spin = 1e-4, 0.1
    script = discs(PRESSED, f"{LAW} contact_shear_ratio {RATIO}", step=step) + (
        "group one id 1\nset group one omegaz 0.1\n"
    )
    table = run_script(tmp_path, script + SHOW + "thermo 1\nrun 2\n").tables[-1]
    arm = (2.0 - OVERLAP) / 2
    slip = spin * arm * step * np.arange(3)
    force = RATIO * STIFFNESS * np.sqrt(OVERLAP) * slip
    np.testing.assert_allclose(table["3"], force, rtol=1e-3, atol=1e-9)
    np.testing.assert_allclose(table["4"], -arm * force, rtol=1e-3, atol=1e-9)


def test_a_wall_is_rigid(tmp_path: Path) -> None:
    script = discs([(0.0, 0.0)], f"{LAW} friction no") + (
        f"fix wall all wall/gran model floe primitive type 1 xplane {OVERLAP - 1.0}\n"
    )
    row = run_script(tmp_path, script + SHOW + "run 0\n").tables[0]
    whole = 4 / 3 * YOUNG / (1 - POISSON**2)
    assert row["2"][0] == pytest.approx(whole * OVERLAP**1.5, rel=1e-12)


def test_damping_is_a_share_of_the_critical_one_at_any_speed(tmp_path: Path) -> None:
    """What a pair keeps of its speed does not depend on it: damping goes with the stiffness."""
    kept = []
    for speed in (0.1, 2.0):
        script = discs(
            [(0.0, 0.0), (2.0, 0.0)],
            f"{LAW.replace('contact_damping 0', 'contact_damping 0.2')} friction no",
            step=5e-5,
        ) + (
            f"group left id 1\ngroup right id 2\nvelocity left set {speed / 2} 0 0 units box\n"
            f"velocity right set {-speed / 2} 0 0 units box\nthermo 2000\n"
        )
        table = run_script(tmp_path / str(speed), script + SHOW + "run 8000\n").tables[-1]
        kept.append(table["5"][-1] / (speed / 2))
    assert 0.3 < kept[0] < 0.8 and kept[1] == pytest.approx(kept[0], rel=5e-3)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("contact_law hertzian", "contact_law takes linear or hertz"),
        ("contact_law hertz ridging yes", "ridging yes needs contact_law linear"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, words: str, says: str) -> None:
    done = run_script(tmp_path, discs(PRESSED, words) + "run 0\n", works=False)
    assert done.code != 0 and says in done.out + done.err
