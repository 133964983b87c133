# SPDX-License-Identifier: GPL-2.0-or-later
"""What LIGGGHTS' walls tell of forces: meshes with stress, stored forces, rows of contacts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.liggghts import PRINT, discs, run_script, write_wall

pytestmark = pytest.mark.mpi

SHOW = (
    "compute total all reduce sum fx fy\n"
    "thermo_style custom step f_face[1] f_face[2] c_total[1] c_total[2]\nthermo 20\n" + PRINT
)


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_mesh_feels_what_it_gives(tmp_path: Path, ranks: int) -> None:
    """A wall closes on discs that no others touch: the mesh has their force, to the bit's width."""
    write_wall(tmp_path / "wall.stl", [(0.0, -6.0), (0.0, 6.0)])
    places = [(1.2, 3.0), (1.2, -3.0)]
    script = discs(places, "ridging yes contact_damping 0.1") + (
        "fix face all mesh/surface/stress file wall.stl type 2\n"
        "fix move all move/mesh mesh face linear 20 5 0.\n"
        "fix wall all wall/gran model floe mesh n_meshes 1 meshes face store_force yes\n"
        "compute rows all wall/gran/local id force torque\n"
        "dump rows all local 200 rows.txt c_rows[3] c_rows[4] c_rows[5] c_rows[9]\n"
        'dump_modify rows format "%.9g %.17g %.17g %.17g"\n'
        "dump atoms all custom 200 atoms.txt id fx fy tqz f_force_wall[1] f_force_wall[2]\n"
        'dump_modify atoms sort id format "%d %.17g %.17g %.17g %.17g %.17g"\n'
    )
    done = run_script(tmp_path, script + SHOW + "run 200\n", ranks)
    table = done.tables[-1]
    assert table["3"][-1] > 1e4 and abs(table["4"][-1]) > 1e2
    np.testing.assert_allclose(table["1"][1:], -table["3"][1:], rtol=1e-9)
    np.testing.assert_allclose(table["2"][1:], -table["4"][1:], rtol=1e-9)
    atoms, rows = done.dump("atoms.txt"), done.dump("rows.txt")
    np.testing.assert_array_equal(atoms[:, 1:3], atoms[:, 4:6])
    rows = rows[np.argsort(rows[:, 0])]
    np.testing.assert_allclose(rows[:, 1:], atoms[:, 1:4], rtol=1e-9)


def test_a_mesh_feels_as_much_as_under_a_stock_law(tmp_path: Path) -> None:
    """At rest the force of the wall is what presses on the disc, whatever the law is."""
    write_wall(tmp_path / "wall.stl", [(-6.0, -1.0), (6.0, -1.0)])
    script = discs([(0.0, 0.0)], "contact_young 1e8 contact_damping 1 friction no") + (
        "fix face all mesh/surface/stress file wall.stl type 2\n"
        "fix wall all wall/gran model floe mesh n_meshes 1 meshes face\n"
        "fix push all addforce 0 -1e5 0\n"
    )
    done = run_script(tmp_path, script + SHOW + "run 4000\n")
    assert done.tables[-1]["2"][-1] == pytest.approx(-1e5, rel=1e-6)
    stock = script.replace("model floe mesh", "model hertz mesh").replace(
        "pair_style gran model floe contact_young 1e8 contact_damping 1 friction no",
        "soft_particles yes\npair_style gran model hertz",
    )
    stock = stock.replace("floe/integrate thickness 1", "nve/sphere")
    properties = (
        "fix m1 all property/global youngsModulus peratomtype 1e9 1e9\n"
        "fix m2 all property/global poissonsRatio peratomtype 0.3 0.3\n"
        "fix m3 all property/global coefficientRestitution peratomtypepair 2 0.3 0.3 0.3 0.3\n"
    )
    stock = stock.replace("neighbor", properties + "neighbor", 1)
    done = run_script(tmp_path, stock + SHOW + "fix drag all viscous 1e5\nrun 8000\n")
    assert done.tables[-1]["2"][-1] == pytest.approx(-1e5, rel=1e-3)


def test_a_wall_is_there_for_its_group_only(tmp_path: Path) -> None:
    """A mesh as a plane, though LIGGGHTS asks its laws for all elements at a mesh."""
    write_wall(tmp_path / "wall.stl", [(0.0, -8.0), (0.0, 8.0)])
    script = discs([(0.99, 0.0), (0.99, 5.0)], "contact_young 1e8 contact_damping 0")
    dump = "dump d all custom 1 end.txt id fx\ndump_modify d sort id\nrun 0\n"
    mesh = (
        "fix face all mesh/surface file wall.stl type 2\n"
        "fix wall one wall/gran model floe mesh n_meshes 1 meshes face\n"
    )
    for wall in (mesh, "fix wall one wall/gran model floe primitive type 2 xplane 0.0\n"):
        end = run_script(tmp_path, script + "group one id 1\n" + wall + dump).dump("end.txt")
        np.testing.assert_allclose(end[:, 1], [1e6, 0.0], rtol=1e-9)
