# SPDX-License-Identifier: GPL-2.0-or-later
"""What LIGGGHTS prints of forces, energies and stresses is that of the models."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.liggghts import BOND, PRINT, discs, raft, run_script

pytestmark = pytest.mark.mpi

# Two discs of 1 m that overlap by 1 cm: springs of 1 m thickness in series.
OVERLAP, STIFFNESS = 0.01, 1e8 / 2
PAIR = discs([(0.0, 0.0), (2.0 - OVERLAP, 0.0)], "contact_young 1e8 contact_damping 0 friction no")
STRESS = (
    "compute stress all stress/atom\ncompute energy all pe/atom\ncompute gpe all pe\n"
    "compute t all temp\ncompute p all pressure t\ncompute mx all reduce max fx\n"
    "compute sum all reduce sum c_stress[1] c_stress[2] c_stress[4] c_energy\n"
    "thermo_style custom step c_gpe c_p c_sum[1] c_sum[2] c_sum[3] c_sum[4] c_mx\n" + PRINT
)


def test_energy_pressure_and_stress_of_a_pressed_pair(tmp_path: Path) -> None:
    done = run_script(tmp_path, PAIR + STRESS + "run 0\n")
    table = done.tables[0]
    force, distance = STIFFNESS * OVERLAP, 2.0 - OVERLAP
    energy, pressure, xx, yy, xy, atoms, largest = (table[str(k)][0] for k in range(1, 8))
    assert largest == pytest.approx(force, rel=1e-12)
    assert energy == pytest.approx(0.5 * STIFFNESS * OVERLAP**2, rel=1e-12)
    assert atoms == pytest.approx(energy, rel=1e-12)
    # LIGGGHTS' stress times volume is minus the virial; in two dimensions pressure is per area.
    assert xx == pytest.approx(-force * distance, rel=1e-12)
    assert yy == xy == 0.0
    assert pressure == pytest.approx(force * distance / 2 / 40**2, rel=1e-12)


@pytest.mark.parametrize("ranks", [1, 2])
def test_stress_of_a_raft_is_that_of_its_bonds(tmp_path: Path, ranks: int) -> None:
    rows = (
        "compute bond all floe/bond/local id1 id2 force_x force_y energy\n"
        "dump rows all local 1000 bonds.txt c_bond[1] c_bond[2] c_bond[3] c_bond[4] c_bond[5]\n"
        'dump_modify rows format "%.9g %.9g %.17g %.17g %.17g"\n'
        "dump atoms all custom 1000 atoms.txt id x y vx vy mass\n"
        'dump_modify atoms sort id format "%d %.17g %.17g %.17g %.17g %.17g"\n'
    )
    strong = "compressive_strength 1e7 friction no"
    # Bonds reach over gaps, and hold all of the pairs that touch.
    done = run_script(
        tmp_path, raft(strong) + BOND + STRESS + rows + "thermo 500\nrun 1000\n", ranks
    )
    bonds, atoms = done.dump("bonds.txt"), done.dump("atoms.txt")
    lo, hi = (atoms[bonds[:, k].astype(int) - 1] for k in (0, 1))
    d, f = hi[:, 1:3] - lo[:, 1:3], bonds[:, 2:4]
    virial = -np.einsum("ki,kj->ij", d, f)
    kinetic = np.einsum("k,ki,kj->ij", atoms[:, 5], atoms[:, 3:5], atoms[:, 3:5])
    table = done.tables[-1]
    stress = -(virial + kinetic)
    assert len(bonds) == 317
    got = [table[str(k)][-1] for k in (3, 4)]
    assert got == pytest.approx([stress[0, 0], stress[1, 1]], rel=1e-7)
    assert table["5"][-1] == pytest.approx(stress[0, 1], rel=1e-7)
    assert table["1"][-1] == pytest.approx(bonds[:, 4].sum(), rel=1e-7)
    assert table["6"][-1] == pytest.approx(table["1"][-1], rel=1e-9)


def test_forces_are_right_whatever_reads_them(tmp_path: Path) -> None:
    """Without a dump, beside one and after it: the same numbers, and not zero."""
    show = (
        "compute mx all reduce max fx\nvariable total equal fcm(all,x)\n"
        "thermo_style custom step c_mx v_total\nthermo 100\n" + PRINT
    )
    script = raft() + BOND + show
    plain = run_script(tmp_path / "plain", script + "run 300\nrun 300\n").tables
    dumped = run_script(
        tmp_path / "dumped",
        script + "dump d all custom 100 d.txt id fx\nrun 300\nundump d\nrun 300\n",
    ).tables
    for a, b in zip(plain[-2:], dumped[-2:], strict=True):
        np.testing.assert_array_equal(a["1"], b["1"])
    later = np.concatenate([plain[-2]["1"][1:], plain[-1]["1"]])
    assert np.all(later > 100.0)
    assert len(np.unique(later)) > 5


def test_spins_are_spins_and_enforce2d_works(tmp_path: Path) -> None:
    script = raft() + BOND
    end = (
        "compute rotation all erotate/sphere\n"
        "thermo_style custom step c_rotation f_motion[32]\nthermo 100\n"
        + PRINT
        + "dump d all custom 500 end.txt id x y omegaz omegax omegay\n"
        + 'dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g"\nrun 500\n'
    )
    free = run_script(tmp_path / "free", script + end)
    flat = run_script(tmp_path / "flat", script + "fix flat all enforce2d\n" + end)
    np.testing.assert_array_equal(free.dump("end.txt"), flat.dump("end.txt"))
    table = free.tables[-1]
    assert np.all(free.dump("end.txt")[:, 4:] == 0.0)
    # LIGGGHTS takes a ball's inertia, 2/5 m r2; a disc has 1/2 m r2, which f_motion[32] sums.
    np.testing.assert_allclose(table["1"][1:] / 0.4, table["2"][1:] / 0.5, rtol=1e-12)
    assert table["2"][-1] > 0.0


@pytest.mark.parametrize("ranks", [1, 2])
def test_rows_of_pairs_hold_forces_and_histories(tmp_path: Path, ranks: int) -> None:
    rows = (
        "compute pairs all pair/gran/local id force torque history\n"
        "dump rows all local 1 rows.txt c_pairs[1] c_pairs[2] c_pairs[4] c_pairs[5] c_pairs[9]"
        " c_pairs[11] c_pairs[12]\n"
        "dump atoms all custom 1 atoms.txt id fx fy tqz\n"
        'dump_modify atoms sort id format "%d %.17g %.17g %.17g"\n'
        'dump_modify rows format "%.9g %.9g %.17g %.17g %.17g %.17g %.17g"\n'
        "velocity all ramp vx -0.1 0.1 y -1 3 units box\nrun 40\n"
    )
    places = [(0.0, 0.0), (1.98, 0.0), (1.0, 1.71), (-0.9, 1.72)]
    done = run_script(tmp_path, discs(places, "contact_damping 0.2") + rows, ranks)
    pairs, atoms = done.dump("rows.txt"), done.dump("atoms.txt")
    assert len(pairs) == 5
    assert np.all(np.abs(pairs[:, 2:6]).max(axis=0) > 0.0)  # forces, torque and slip
    total = np.zeros((4, 3))
    for one, two, fx, fy, torque, *_ in pairs:
        total[int(one) - 1] += fx, fy, torque
        total[int(two) - 1] -= fx, fy, -torque  # equal discs: equal levers
    np.testing.assert_allclose(total, atoms[:, 1:], rtol=1e-9, atol=1e-9 * np.abs(atoms).max())
