# SPDX-License-Identifier: GPL-2.0-or-later
"""Errors reach the user, and what would go wrong without a word is refused or works."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from floeflow.core.mpi import mpi_environment
from floeflow.dynamics.engine.plugin import plugin_path
from support.liggghts import BOND, HEAD, PRINT, discs, raft, run_script, write_wall

pytestmark = pytest.mark.mpi


def run_into_a_file(folder: Path, script: str, ranks: int) -> tuple[str, str]:
    """Standard output and error of a run that fails, each redirected to a file."""
    (folder / "in.script").write_text(script)
    program = plugin_path().with_name("liggghts-floe")
    with open(folder / "out", "w") as out, open(folder / "err", "w") as err:
        done = subprocess.run(
            ["mpirun", "-n", str(ranks), str(program), "-in", "in.script"],
            cwd=folder,
            env=mpi_environment(),
            stdout=out,
            stderr=err,
            check=False,
        )
    assert done.returncode != 0
    return (folder / "out").read_text(), (folder / "err").read_text()


@pytest.mark.parametrize("ranks", [1, 2])
def test_the_reason_is_there_when_output_goes_to_a_file(tmp_path: Path, ranks: int) -> None:
    wild = raft().replace("timestep 0.4", "timestep 40") + BOND + "thermo 1\nrun 100\n"
    out, err = run_into_a_file(tmp_path, wild, ranks)
    assert "floe_bonds: 317 bonds" in out
    for text in (out, err) if ranks == 1 else (err,):
        assert re.search(r"ERROR on proc \d: Element \d+ .*, last force", text)
    _, err = run_into_a_file(tmp_path, raft() + "runn 1\n", ranks)
    assert "ERROR: " in err


def test_elements_outside_of_the_group_stay_with_a_warning(tmp_path: Path) -> None:
    """As with LIGGGHTS' own integrators; another fix may move them, and their bonds turn along."""
    places = [(0.0, 0.0), (2.0, 0.0), (0.0, 10.0)]
    script = discs(places, "bonds yes compressive_strength 1e9 reach 1.3") + "group two id 2\n"
    script = script.replace("fix motion all", "fix motion rest").replace(
        "timestep", "group rest id 1 3\ntimestep"
    )
    end = (
        "run 0\nfloe_bonds gap 0.1 thickness 1\nvelocity all set 1 0 0 units box\n"
        "dump d all custom 100 end.txt id x y\nrun 100\n"
    )
    done = run_script(tmp_path / "still", script + end)
    assert "WARNING: 1 elements are outside of the group of fix floe/integrate" in done.out
    places_now = done.dump("end.txt")
    still = places_now[places_now[:, 0] == 2][0]
    assert list(still[1:]) == [2.0, 0.0]
    moved = run_script(tmp_path / "moved", script + "fix two two nve/sphere\n" + end)
    assert "outside of the group" not in moved.out
    assert moved.dump("end.txt")[moved.dump("end.txt")[:, 0] == 2][0, 1] > 2.005


def test_two_integrators_are_refused(tmp_path: Path) -> None:
    done = run_script(tmp_path, raft() + "fix again all floe/integrate\nrun 0\n", works=False)
    assert "There may be only one fix floe/integrate" in done.out


def test_bonds_need_the_lists_of_the_elements_that_are_there(tmp_path: Path) -> None:
    gone = (
        "run 0\nregion hole block 5.9 8.1 -0.1 2.3 INF INF units lattice\ngroup gone region hole\n"
        "delete_atoms group gone compress no\nfloe_bonds gap 1 thickness 1\n"
    )
    done = run_script(tmp_path, raft() + gone, works=False)
    assert "floe_bonds needs lists of the present neighbours: give `run 0` right before" in done.out


def test_floes_deleted_one_after_the_other_take_their_bonds_along(tmp_path: Path) -> None:
    one = "region one block 1.9 4.1 -0.1 2.3 INF INF units lattice\ngroup one region one\n"
    two = "region two block 5.9 8.1 -0.1 2.3 INF INF units lattice\ngroup two region two\n"
    both = one + two + "group both union one two\n"
    ends = [
        "delete_atoms group both compress no\n",
        "delete_atoms group one compress no\nrun 0\ndelete_atoms group two compress no\n",
    ]
    show = "thermo_style custom step f_motion[28] f_motion[26]\n" + PRINT
    found = []
    for k, end in enumerate(ends):
        script = raft() + BOND + show + both + "run 20\n" + end + "run 0\n"
        table = run_script(tmp_path / str(k), script).tables[-1]
        found.append((table["1"][-1], table["2"][-1]))
    assert found[1] == found[0] and 0 < found[0][0] < 317
    at_once = raft() + BOND + both + "run 20\n" + ends[1].replace("run 0\n", "") + "run 0\n"
    done = run_script(tmp_path / "at_once", at_once, works=False)
    assert done.code != 0 and "bonds would be lost; give `run 0` between" in done.out + done.err


def test_a_wall_that_does_not_fit_the_box_is_named(tmp_path: Path) -> None:
    write_wall(tmp_path / "wall.stl", [(0.0, -3.0), (0.0, 3.0)])
    script = discs([(2.0, 0.0), (4.0, 0.0)], "", boundary="m m p").replace(
        "block -20 20 -20 20 -20 20", "block -0.4 6 -2 2 -2 2"
    )
    wall = (
        "fix face all mesh/surface file wall.stl type 2\n"
        "fix move all move/mesh mesh face linear 0.1 0. 0.\n"
        "fix wall all wall/gran model floe mesh n_meshes 1 meshes face\nrun 100\n"
    )
    done = run_script(tmp_path, script + wall, works=False)
    assert "a triangle of the meshes face does not fit the simulation box, which" in done.out


def test_the_models_survive_the_command_clear(tmp_path: Path) -> None:
    show = "compute mx all reduce max fx\nthermo_style custom step c_mx\n" + PRINT
    script = discs([(0.0, 0.0), (1.99, 0.0)], "") + show + "run 10\n"
    done = run_script(tmp_path, script + "clear\n" + script)
    first, second = (table["1"] for table in done.tables)
    np.testing.assert_array_equal(first, second)
    assert first[0] > 0.0


def test_lists_of_another_length_forget_nothing(tmp_path: Path) -> None:
    """LIGGGHTS makes its lists anew at each run when `one` or `page` are not its defaults."""
    longer = raft("compressive_strength 1e7").replace(
        "check yes exclude", "check yes one 500 page 50000 exclude"
    )
    show = "thermo_style custom step f_motion[28]\n" + PRINT
    script = longer + BOND + show + "run 100\nrun 100\ncompute near all coord/atom 2500\n"
    done = run_script(tmp_path, script + "dump d all custom 100 n.txt id c_near\nrun 100\n")
    assert [table["1"][-1] for table in done.tables[-3:]] == [317.0] * 3
    late = raft() + BOND + "neigh_modify one 500 page 50000\nrun 1\n"
    done = run_script(tmp_path, late, works=False)
    assert "neigh_modify page and one may only be set before the first run" in done.out


def test_the_stock_program_takes_the_models_from_where_they_are_installed(tmp_path: Path) -> None:
    command = ["cmake", "--install", plugin_path().parent, "--prefix", tmp_path / "usr"]
    subprocess.run(command, capture_output=True, check=True)
    (library,) = (tmp_path / "usr").rglob("libfloe-preload.so")
    assert (tmp_path / "usr/bin/liggghts-floe").is_file()
    (tmp_path / "in.script").write_text(raft() + BOND + "run 10\n")
    done = subprocess.run(
        ["liggghts", "-in", "in.script"],
        cwd=tmp_path,
        env=mpi_environment() | {"LD_PRELOAD": str(library)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "floe_bonds: 317 bonds" in done.stdout


def test_head_without_ghost_velocities_is_refused(tmp_path: Path) -> None:
    assert "communicate single vel yes" in HEAD
    done = run_script(
        tmp_path, raft().replace("communicate single vel yes\n", "") + "run 0\n", works=False
    )
    assert "requires ghost atoms store velocity" in done.out
