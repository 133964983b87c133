# SPDX-License-Identifier: GPL-2.0-or-later
"""Stock fixes, computes, walls and dumps beside the models, each held to a number known before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.liggghts import PRINT, discs, run_script, write_wall

pytestmark = pytest.mark.mpi

# Discs of 1 m: springs of 1 m thickness in series, N/m; mass kg.
STIFFNESS, MASS = 1e8 / 2, 900 * np.pi
LAW = "contact_young 1e8 contact_damping 0 friction no"
DUMP = (
    "dump d all custom 1 end.txt id x y vx vy fx fy\n"
    'dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g"\n'
)


def ends(folder: Path, script: str, steps: int, ranks: int = 1) -> np.ndarray:
    """Rows id x y vx vy fx fy after some steps."""
    return run_script(folder, script + DUMP + f"run {steps}\n", ranks).dump("end.txt")


def test_fix_adapt_grows_discs(tmp_path: Path) -> None:
    script = discs([(0.0, 0.0), (2.0, 0.0)], LAW) + (
        "set group all type 2\nvariable d equal 2+1e-5*step\n"
        "fix grow all adapt 1 atom diameter v_d\n"
    )
    end = ends(tmp_path, script, 100)
    assert end[1, 5] == pytest.approx(STIFFNESS * 1e-3, rel=1e-9)


def test_masses_that_fix_adapt_makes_are_told_of(tmp_path: Path) -> None:
    """LIGGGHTS takes a mass with the cube of the diameter, and `set density` pi r2 again."""
    script = discs([(0.0, 0.0)], LAW) + (
        "variable d equal 2+0.01*step\nfix grow all adapt 1 atom diameter v_d\n"
        "compute m all property/atom mass\ncompute sum all reduce sum c_m\n"
        "thermo_style custom step c_sum\n" + PRINT + "run 100\n"
        "unfix grow\nset group all density 900\nrun 0\n"
    )
    done = run_script(tmp_path, script)
    masses = [table["1"][-1] for table in done.tables]
    np.testing.assert_allclose(masses, [MASS * 1.5**3, MASS * 1.5**2], rtol=1e-9)
    assert "WARNING: fix adapt changes the mass of a disc with the cube" in done.out


def test_fix_deform_presses_a_row_around_the_box(tmp_path: Path) -> None:
    """Every gap closes by the strain: one force all along, pressure times height."""
    script = discs([(2.0 * k - 19.0, 0.0) for k in range(20)], LAW, boundary="p f p") + (
        "fix press all deform 1 x erate -1e-3 remap x\ncompute t all temp\n"
        "compute p all pressure t\ncompute fx all reduce max fx\nvariable width equal lx\n"
        "thermo_style custom step c_p[1] c_fx v_width\nthermo 1000\n" + PRINT
    )
    table = run_script(tmp_path, script + "run 1000\n").tables[-1]
    width = table["3"][-1]
    assert width == pytest.approx(40 * (1 - 1e-4), rel=1e-9)
    # The box shrinks at the end of a step: the forces are those of the step before.
    force = STIFFNESS * (40 - width) / 20 * 999 / 1000
    assert table["1"][-1] == pytest.approx(force / 40, rel=1e-4)
    assert abs(table["2"][-1]) < 1e-6 * force  # between two neighbours


def test_forces_of_other_fixes_act(tmp_path: Path) -> None:
    alone = discs([(0.0, 0.0), (10.0, 0.0)], LAW)
    step, steps = 1e-4, 100
    # Leapfrog: the first force acts for a whole step.
    for k, (words, speed) in enumerate(
        (
            ("fix g all gravity 9.81 vector 1.0 0.0 0.0", 9.81 * step * steps),
            ("fix g all addforce 500.0 0.0 0.0", 500.0 / MASS * step * steps),
            ("fix g all setforce 500.0 0.0 0.0", 500.0 / MASS * step * steps),
        )
    ):
        end = ends(tmp_path / str(k), alone + words + "\n", steps)
        np.testing.assert_allclose(end[:, 3], speed, rtol=0.011)
        np.testing.assert_array_equal(end[:, 4], 0.0)
    frozen = "group one id 1\nfix still one freeze\nvelocity one set 0 0 0 units box\n"
    end = ends(tmp_path / "frozen", discs([(0.0, 0.0), (1.99, 0.0)], LAW) + frozen, 50)
    assert end[0, 3] == end[0, 1] == 0.0 and end[1, 3] > 0.0


def test_fix_momentum_takes_the_drift_away(tmp_path: Path) -> None:
    script = discs([(0.0, 0.0), (10.0, 0.0)], LAW) + (
        "group one id 1\nvelocity one set 1 0.5 0 units box\n"
        "fix rest all momentum 10 linear 1 1 0\n"
    )
    end = ends(tmp_path, script, 20)
    np.testing.assert_allclose(end[:, 3:5], [[0.5, 0.25], [-0.5, -0.25]], rtol=1e-9)


def test_fix_rigid_moves_a_body_that_floes_push(tmp_path: Path) -> None:
    """A third disc runs into two: momentum stays, and the body keeps its form."""
    script = discs([(0.0, 0.0), (1.5, 0.0), (3.6, 0.0)], LAW).replace(
        "fix motion all", "fix motion free"
    )
    script = script.replace("timestep", "group body id 1 2\ngroup free id 3\ntimestep")
    script += (
        "neigh_modify exclude group body body\nfix body body rigid single\n"
        "velocity free set -1 0 0 units box\n"
    )
    end = ends(tmp_path, script, 6000)
    assert end[1, 1] - end[0, 1] == pytest.approx(1.5, abs=1e-6)
    assert end[0, 3] == pytest.approx(end[1, 3], rel=1e-6) and end[2, 5] == 0.0
    assert end[:, 3].sum() == pytest.approx(-1.0, rel=2e-3)
    # Elastic, 1 on 2: the one goes back with a third of its speed.
    np.testing.assert_allclose(end[:, 3], [-2 / 3, -2 / 3, 1 / 3], rtol=2e-2)


def test_a_servo_wall_presses_with_the_force_it_is_told(tmp_path: Path) -> None:
    write_wall(tmp_path / "wall.stl", [(-6.0, 1.02), (6.0, 1.02)])
    script = discs([(0.0, 0.0)], "contact_young 2e6 contact_damping 0.3 friction no") + (
        "fix floor all wall/gran model floe primitive type 2 yplane -1.0\n"
        "fix face all mesh/surface/stress/servo file wall.stl type 2 com 0. 1.02 0. ctrlPV force "
        "axis 0. -1. 0. target_val 1e5 vel_max 0.2 kp 0.5\nfix slow all viscous 2e4\n"
        "fix wall all wall/gran model floe mesh n_meshes 1 meshes face\n"
        "thermo_style custom step f_face[2]\nthermo 50000\n" + PRINT
    )
    table = run_script(tmp_path, script + "run 50000\n").tables[-1]
    assert table["1"][-1] == pytest.approx(1e5, rel=0.02)


def test_a_cylinder_around_the_floes_is_a_wall(tmp_path: Path) -> None:
    """A rigid ring of 5 m: the disc alone gives."""
    script = discs([(3.2, 2.4 + 0.0075), (0.0, 0.0)], LAW) + (
        "fix ring all wall/gran model floe primitive type 2 zcylinder 5.0 0.0 0.0\n"
    )
    end = ends(tmp_path, script, 0)
    place = np.array([3.2, 2.4 + 0.0075])
    out = np.hypot(*place)
    force = -1e8 * (out + 1.0 - 5.0) * place / out
    np.testing.assert_allclose(end[0, 5:], force, rtol=1e-9)
    np.testing.assert_array_equal(end[1, 5:], 0.0)


def test_a_turning_wall_drags_by_friction(tmp_path: Path) -> None:
    """A square that turns rubs along the disc that lies at it, with all that friction gives."""
    corners = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0), (-2.0, -2.0)]
    write_wall(tmp_path / "wall.stl", corners)
    script = discs(
        [(2.999, 0.0)], "contact_young 1e8 contact_damping 0 friction_coefficient 0.3"
    ) + (
        "fix face all mesh/surface/stress file wall.stl type 2\n"
        "fix turn all move/mesh mesh face rotate origin 0. 0. 0. axis 0. 0. 1. period 10.\n"
        "fix wall all wall/gran model floe mesh n_meshes 1 meshes face\n"
    )
    end = ends(tmp_path, script, 10)
    normal, tangential = end[0, 5], end[0, 6]
    # By 6e-4 rad, which turns the force a little.
    assert normal > 5e4 and tangential == pytest.approx(0.3 * normal, rel=5e-3)


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_gate_counts_the_floes_that_pass(tmp_path: Path, ranks: int) -> None:
    write_wall(tmp_path / "gate.stl", [(0.0, -6.0), (0.0, 6.0)])
    places = [(-1.0 - 3.0 * k, y) for k in range(3) for y in (-3.0, 3.0)]
    script = discs(places, LAW) + (
        "fix gate all mesh/surface/planar file gate.stl type 2\n"
        "fix flux all massflow/mesh mesh gate vec_side 1. 0. 0. count once\n"
        "velocity all set 10 0 0 units box\n"
        "thermo_style custom step f_flux[1] f_flux[2]\nthermo 5000\n" + PRINT
    )
    table = run_script(tmp_path, script + "run 5000\n", ranks).tables[-1]
    assert table["2"][-1] == 4 and table["1"][-1] == pytest.approx(4 * MASS, rel=1e-9)


@pytest.mark.parametrize("ranks", [1, 2])
def test_computes_of_floes(tmp_path: Path, ranks: int) -> None:
    places = [(0.0, 0.0), (1.98, 0.0), (3.96, 0.0), (9.0, 0.0)]
    show = (
        "compute touch all contact/atom\ncompute near all coord/atom 2.1\ncompute ke all ke\n"
        "compute each all ke/atom\ncompute far all displace/atom\n"
        "compute clump all cluster/atom 2.0\ncompute mid all com\ncompute msd all msd\n"
        "fix mean all ave/atom 1 10 10 fx\n"
        "fix start all store/state 0 x\n"
        "thermo_style custom step c_ke c_mid[1] c_msd[4]\nthermo 10\n"
        + PRINT
        + "dump d all custom 10 end.txt id c_touch c_near c_each c_far[1] c_clump f_mean f_start"
        + " fx\n"
        'dump_modify d sort id format "%d %g %g %.17g %.17g %g %.17g %.17g %.17g"\n'
    )
    script = discs(places, LAW) + "set group all type 2\nset atom 4 type 1\n" + show
    script += "group one id 4\nvelocity one set 1 0 0 units box\nrun 10\n"
    done = run_script(tmp_path, script, ranks)
    end, table = done.dump("end.txt"), done.tables[-1]
    np.testing.assert_array_equal(end[:, 1], [1, 2, 1, 0])
    np.testing.assert_array_equal(end[:, 2], [1, 2, 1, 0])
    np.testing.assert_allclose(end[:, 3], [0, 0, 0, MASS / 2])
    np.testing.assert_allclose(end[:, 4], [0, 0, 0, 1e-3], rtol=1e-6)
    assert len(set(end[:3, 5])) == 1 and end[3, 5] != end[0, 5]
    np.testing.assert_allclose(end[:, 6], end[:, 8], atol=1e-3)
    np.testing.assert_allclose(end[:, 7], [x for x, _ in places])
    push = STIFFNESS * 0.02
    np.testing.assert_allclose(end[:, 8], [-push, 0, push, 0], atol=1e-3)
    assert table["1"][-1] == pytest.approx(MASS / 2)
    assert table["2"][-1] == pytest.approx(np.mean([0.0, 1.98, 3.96, 9.001]))
    assert table["3"][-1] == pytest.approx(1e-6 / 4, rel=1e-6)


def test_dumps_of_floes_and_walls(tmp_path: Path) -> None:
    write_wall(tmp_path / "wall.stl", [(-6.0, -1.5), (6.0, -1.5)])
    script = discs([(0.5, 0.25), (3.0, 0.0)], LAW) + (
        "fix face all mesh/surface file wall.stl type 2\n"
        "fix wall all wall/gran model floe mesh n_meshes 1 meshes face\n"
        "dump a all xyz 1 floes.xyz\ndump b all mesh/stl 1 walls*.stl\n"
        "dump c all custom 1 floes.txt id x y radius\nrun 0\n"
    )
    run_script(tmp_path, script)
    rows = [line.split() for line in (tmp_path / "floes.xyz").read_text().splitlines()[2:]]
    assert {tuple(float(v) for v in row[1:3]) for row in rows} == {(0.5, 0.25), (3.0, 0.0)}
    assert (tmp_path / "walls0.stl").read_text().count("outer loop") == 2
    assert (tmp_path / "floes.txt").read_text().count("\n") == 11


BONDED = "bonds yes compressive_strength 1e9 reach 1.3 friction no bond_damping 0"
FREEZE = "run 0\nfloe_bonds gap 0.1 thickness 1\n"
SHOW = "thermo_style custom step f_motion[28] f_motion[26] f_motion[31]\nthermo 1000\n" + PRINT


@pytest.mark.parametrize("before", [True, False])
def test_bonds_turn_with_floes_that_fix_move_turns(tmp_path: Path, before: bool) -> None:
    """A rigid rotation strains nothing, whichever of the two fixes comes first."""
    move = "fix turn pair move rotate 0 0 0 0 0 1 0.1 units box\n"
    script = discs([(0.0, 0.0), (2.0, 0.0), (10.0, 10.0)], BONDED).replace(
        "fix motion all", (move if before else "") + "fix motion rest"
    )
    script = script.replace("timestep", "group pair id 1 2\ngroup rest id 3\ntimestep")
    script += ("" if before else move) + FREEZE
    script += "compute a all floe/atom angle\ncompute most all reduce max c_a\n"
    script += SHOW.replace("f_motion[31]", "c_most") + "run 250\n"
    table = run_script(tmp_path, script).tables[-1]
    assert table["1"][-1] == 1.0 and table["2"][-1] < 1e-9
    assert table["3"][-1] == pytest.approx(np.pi / 2, rel=1e-9)


@pytest.mark.parametrize("ranks", [1, 2])
def test_displace_atoms_rotate_turns_the_floes_too(tmp_path: Path, ranks: int) -> None:
    script = discs([(0.0, 0.0), (2.0, 0.0)], BONDED) + FREEZE + "run 10\n" + SHOW
    script += "displace_atoms all rotate -3 1 0 0 0 -1 200 units box\n"
    done = run_script(tmp_path, script + DUMP + "run 0\n", ranks)
    end, table = done.dump("end.txt"), done.tables[-1]
    turn = np.radians(-200.0)
    step = 2.0 * np.array([np.cos(turn), np.sin(turn)])
    np.testing.assert_allclose(end[1, 1:3] - end[0, 1:3], step, rtol=1e-9)
    assert table["1"][-1] == 1.0 and table["2"][-1] < 1e-12


def test_an_oscillating_bond_beside_a_floe_that_is_held(tmp_path: Path) -> None:
    """By fix setforce, fix freeze, or type 2: the same oscillation."""
    script = discs([(0.0, 0.0), (2.0, 0.0)], BONDED) + FREEZE
    script += "group one id 1\ngroup two id 2\nvelocity two set 1 0 0 units box\n"
    holds = ["fix hold one setforce 0 0 0\n", "fix hold one freeze\n", "set group one type 2\n"]
    rate = np.sqrt(1.5e7 * np.sqrt(1 / 3) / MASS)  # E h L / d, bond as wide as a hexagon's side
    for k, hold in enumerate(holds):
        end = ends(tmp_path / str(k), script + hold, 100)
        assert list(end[0, 1:5]) == [0.0, 0.0, 0.0, 0.0]
        assert end[1, 1] == pytest.approx(2.0 + np.sin(rate * 1e-2) / rate, rel=1e-6)


def test_wind_that_follows_what_the_script_computes(tmp_path: Path) -> None:
    """The wind stops where a variable or a compute says so; the ice stands at that speed."""
    script = discs(
        [(0.0, 0.0)], "", "wind yes ocean_drag yes wind_velocity v_w 0", boundary="p p p", step=0.5
    )
    rules = {
        "vx": "variable w atom 10*(vx<0.05)\n",
        "property": "compute v all property/atom vx\nvariable w atom 10*(c_v<0.05)\n",
        "vcm": "variable w equal 10*(vcm(all,x)<0.05)\n",
        "sums": f"variable w equal 10*(f_motion[35]<{MASS * 0.05!r})\n",
    }
    for name, rule in rules.items():
        end = ends(tmp_path / name, script + rule, 2000)
        assert end[0, 3] == pytest.approx(0.05, abs=1e-3)


def test_a_loop_of_runs_with_clear_and_print(tmp_path: Path) -> None:
    script = (
        "variable k loop 3\nlabel again\nclear\n"
        + discs([(0.0, 0.0), (2.0, 0.0)], BONDED)
        + FREEZE
        + "velocity all set $k 0 0 units box\nvariable e equal f_motion[31]\n"
        + 'fix say all print 50 "at ${e}" file said.txt\nrun 100\n'
        + 'print "energy ${e}"\nnext k\njump SELF again\n'
    )
    done = run_script(tmp_path, script)
    found = [float(line.split()[1]) for line in done.out.splitlines() if line[:7] == "energy "]
    np.testing.assert_allclose(found, [MASS * k**2 for k in (1, 2, 3)], rtol=1e-9)
    said = [line.split() for line in (tmp_path / "said.txt").read_text().splitlines()[1:]]
    np.testing.assert_allclose([float(w[1]) for w in said], MASS * 9, rtol=1e-9)


def test_floes_from_a_data_file(tmp_path: Path) -> None:
    rows = "7 1 2 900 0 0 0\n9 1 2 900 2 0 0\n20 2 2 900 4 0 0\n"
    speeds = "7 1 0 0 0 0 0.5\n9 0 0 0 0 0 0\n20 0 0 0 0 0 0\n"
    box = "".join(f"-20 20 {k}lo {k}hi\n" for k in "xyz")
    (tmp_path / "floes.data").write_text(
        f"floes\n\n3 atoms\n2 atom types\n\n{box}\nAtoms\n\n{rows}\nVelocities\n\n{speeds}"
    )
    script = discs([], BONDED)
    first, last = script.index("region box"), script.index("neighbor")
    script = script[:first] + "read_data floes.data\n" + script[last:] + FREEZE
    script += SHOW.replace("f_motion[31]", "f_motion[31] f_motion[32]") + DUMP + "run 0\n"
    done = run_script(tmp_path, script)
    end, table = done.dump("end.txt"), done.tables[-1]
    assert table["1"][-1] == 2.0 and table["2"][-1] == 0.0
    assert table["3"][-1] == pytest.approx(MASS / 2)
    assert table["4"][-1] == pytest.approx(MASS / 4 * 0.5**2)
    np.testing.assert_array_equal(end[:, [0, 1, 3]], [[7, 0, 1], [9, 2, 0], [20, 4, 0]])


def test_a_head_on_collision_with_lists_made_at_each_step(tmp_path: Path) -> None:
    """Elastic discs exchange their speeds, with a skin and checks of any kind."""
    script = discs([(-1.25, 0.0), (1.25, 0.0)], LAW)
    script += "group a id 1\ngroup b id 2\n"
    script += "velocity a set 1 0 0 units box\nvelocity b set -1 0 0 units box\n"
    lists = ["neigh_modify check no", "neighbor 0.01 bin", "neighbor 2 nsq", "atom_modify sort 5 3"]
    for k, words in enumerate(lists):
        end = ends(tmp_path / str(k), script + words + "\n", 5000)
        np.testing.assert_allclose(end[:, 3], [-1.0, 1.0], rtol=1e-4)
