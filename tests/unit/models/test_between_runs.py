# SPDX-License-Identifier: GPL-2.0-or-later
"""What a script does between its runs changes what it says, and nothing else; or it is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.liggghts import BOND, HEAD, PRINT, discs, raft, run_script

pytestmark = pytest.mark.mpi

NEIGHBOURS = "neighbor 200 bin\nneigh_modify delay 0 every 1 check yes exclude type 2 2\n"
SHOW = "thermo_style custom step f_motion[28] f_motion[26] f_motion[31]\nthermo 50\n" + PRINT
END = (
    "dump d all custom 1 end.txt id x y vx vy omegaz\n"
    'dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g"\nrun 0\n'
)


@pytest.mark.parametrize("ranks", [1, 2])
def test_another_wind_keeps_bonds_and_orientations(tmp_path: Path, ranks: int) -> None:
    """The same as a variable that changes at that step, to the bit."""
    twist = BOND + "velocity all ramp vx 0.05 -0.05 y 0 14000 units box\n"
    changed = (
        raft("compressive_strength 1e6", "wind yes ocean_drag yes wind_velocity 30 -10")
        + twist
        + "run 100\nfix_modify motion wind_velocity 0 -20\nrun 100\n"
        + END
    )
    variable = (
        raft(
            "compressive_strength 1e6",
            "wind yes ocean_drag yes wind_velocity v_u v_v",
            setup='variable u equal "30*(step<=100)"\nvariable v equal "-10-10*(step>100)"\n',
        )
        + twist
        + "run 100\nrun 100\n"
        + END
    )
    first = run_script(tmp_path / "changed", changed, ranks).dump("end.txt")
    second = run_script(tmp_path / "variable", variable, ranks).dump("end.txt")
    np.testing.assert_array_equal(first, second)
    # And a variable in place of a number, and back.
    swapped = changed.replace(
        "fix_modify motion wind_velocity 0 -20",
        "variable w equal -20\nfix_modify motion wind_velocity 7 v_w\nrun 0\n"
        "fix_modify motion wind_velocity 0 v_w",
    )
    third = run_script(tmp_path / "swapped", swapped, ranks).dump("end.txt")
    np.testing.assert_array_equal(first, third)


@pytest.mark.parametrize("words", ["wind_speed 3 4", "air_drag -1", "wind_velocity 3"])
def test_a_wrong_fix_modify_is_refused(tmp_path: Path, words: str) -> None:
    done = run_script(tmp_path, raft() + BOND + f"fix_modify motion {words}\n", works=False)
    assert done.code != 0 and "Fix floe/integrate: " in done.out


@pytest.mark.parametrize("again", ["unfix motion\nfix motion", "fix motion", "unfix motion\nfix m"])
def test_another_integrator_would_forget_the_orientations(tmp_path: Path, again: str) -> None:
    script = raft() + BOND + f"run 10\n{again} all floe/integrate thickness 1\nrun 10\n"
    done = run_script(tmp_path, script, works=False)
    assert done.code != 0 and "change keywords with fix_modify, and keep the ID" in done.out


def test_another_id_after_a_restart_would_forget_the_orientations(tmp_path: Path) -> None:
    run_script(tmp_path, raft() + BOND + "run 10\nwrite_restart state.bin\n")
    script = (
        f"{HEAD}boundary m m p\nread_restart state.bin\n{NEIGHBOURS}timestep 0.4\n"
        "fix move all floe/integrate thickness 1\nrun 1\n"
    )
    done = run_script(tmp_path, script, works=False)
    assert done.code != 0 and "has another ID in the restart file" in done.out
    run_script(tmp_path, script.replace("fix move", "fix motion"))


@pytest.mark.parametrize("ranks", [1, 2])
def test_ids_that_are_given_anew_would_lose_the_bonds(tmp_path: Path, ranks: int) -> None:
    gone = (
        "region hole block 5.9 8.1 -0.1 2.3 INF INF units lattice\ngroup gone region hole\n"
        "delete_atoms group gone\n"
    )
    for after in ("run 10\n", "write_restart state.bin\n"):
        script = raft() + BOND + "run 10\n" + gone + after
        done = run_script(tmp_path, script, ranks, works=False)
        assert done.code != 0 and "give delete_atoms the words `compress no`" in done.out
    # Before there are pairs, nothing is lost.
    run_script(tmp_path, raft() + gone + BOND + "run 10\n", ranks)


def test_the_log_s_time_counts_steps_of_any_length(tmp_path: Path) -> None:
    """Also across a restart file and the command reset_timestep."""
    log = "fix log all floe/breakage 1 file broken.txt\n"
    pull = "velocity all ramp vx 0.1 -0.1 y 0 14000 units box\n"
    script = raft("compressive_strength 3e4 tensile_share 0.3") + log + BOND
    script += pull + "run 10\ntimestep 0.2\nrun 20\n"
    more = "reset_timestep 1000\nrun 100\n"
    run_script(tmp_path / "whole", script + "write_restart state.bin\n" + more)
    restart = (
        f"{HEAD}boundary m m p\nread_restart state.bin\n{NEIGHBOURS}timestep 0.2\n"
        "fix motion all floe/integrate thickness 1 wind yes ocean_drag yes wind_velocity 30 -10\n"
    )
    (tmp_path / "again").mkdir()
    (tmp_path / "whole/state.bin").rename(tmp_path / "again/state.bin")
    run_script(tmp_path / "again", restart + log + more)
    rows = np.array(
        [
            [float(w) for w in line.split()[:4]]
            for line in (tmp_path / "whole/broken.txt").read_text().splitlines()[1:]
        ]
    )
    step, time = rows[:, 0], rows[:, 1]
    first, second, last = step <= 10, (step > 10) & (step < 1000), step > 1000
    assert np.count_nonzero(last) > 10
    np.testing.assert_allclose(time[first], 0.4 * step[first], rtol=1e-8)
    np.testing.assert_allclose(time[second], 4.0 + 0.2 * (step[second] - 10), rtol=1e-8)
    np.testing.assert_allclose(time[last], 8.0 + 0.2 * (step[last] - 1000), rtol=1e-8)
    again = (tmp_path / "again/broken.txt").read_text().splitlines()[1:]
    whole = (tmp_path / "whole/broken.txt").read_text().splitlines()[1:]
    assert again == whole[-np.count_nonzero(last) :]


def test_bonds_frozen_twice_are_no_damage(tmp_path: Path) -> None:
    show = (
        "compute atom all floe/atom nbond damage\ncompute all all reduce max c_atom[1] c_atom[2]\n"
        "thermo_style custom step c_all[1] c_all[2]\n" + PRINT
    )
    script = raft() + BOND + "floe_bonds gap 1 thickness 1\n" + show + "run 0\n"
    table = run_script(tmp_path, script).tables[-1]
    assert table["1"][-1] == 6.0 and table["2"][-1] == 0.0


def test_two_logs_are_refused(tmp_path: Path) -> None:
    logs = "fix one all floe/breakage 5\nfix two all floe/breakage 5\n"
    done = run_script(tmp_path, raft() + logs + BOND, works=False)
    assert done.code != 0 and "There may be only one fix floe/breakage" in done.out


def test_pieces_of_a_run_and_what_looks_at_it_change_no_bit(tmp_path: Path) -> None:
    start = raft("compressive_strength 3e4 tensile_share 0.3 ridging yes") + BOND
    start += "velocity all ramp vx 0.05 -0.05 y 0 14000 units box\n"
    ends = []
    for k, runs in enumerate(
        (
            "run 200\n",
            "run 60\nrun 0\nrun 140\n",
            "run 90 post no\nrun 110 pre no\n",
            'run 200 every 50 "print step"\n',
            "compute s all stress/atom\ndump s all custom 7 s.txt id c_s[1] fx\nrun 80\nundump s\n"
            "uncompute s\nrun 120\n",
            "group some id <> 5 40\nrun 80\ngroup some delete\nrun 120\n",
        )
    ):
        done = run_script(tmp_path / str(k), start + runs + END)
        ends.append(done.dump("end.txt"))
    # New lists at a `run` sum forces in another order: the same to round-off.
    for end in ends[1:]:
        np.testing.assert_allclose(end, ends[0], rtol=1e-6, atol=1e-8)
    np.testing.assert_array_equal(ends[2], ends[0])


def test_floes_have_the_thickness_of_the_moment_they_are_made(tmp_path: Path) -> None:
    script = (
        discs([(0.0, 0.0)], "", "thickness 2 cover 0.5")
        + "fix_modify motion thickness 0.5 cover 1\ncreate_atoms 1 single 4 0 0 units box\n"
        + "run 0\nfix_modify motion thickness 0.25\ncreate_atoms 1 single 8 0 0 units box\n"
        + "set group all diameter 2\nset group all density 900\n"
        + "compute atom all floe/atom thickness\ndump d all custom 1 end.txt id c_atom\n"
        + "dump_modify d sort id\nrun 0\n"
    )
    end = run_script(tmp_path, script).dump("end.txt")
    np.testing.assert_array_equal(end[:, 1], [2.0, 0.5, 0.25])


def test_floes_that_come_later_are_floes(tmp_path: Path) -> None:
    """Made between two runs: they have a thickness and touch, and the bonds before them stay."""
    pair = discs([(0.0, 0.0), (2.0, 0.0)], "bonds yes compressive_strength 1e9 reach 1.3")
    script = (
        pair
        + "run 0\nfloe_bonds gap 0.1 thickness 1\nrun 5\n"
        + "create_atoms 1 single 4.5 0 0 units box\ngroup new id 3\n"
        + "set group new diameter 2\nset group new density 900\nvelocity new set -1 0 0 units box\n"
        + "compute atom all floe/atom nbond thickness ice_area\n"
        + "dump d all custom 1 end.txt id x c_atom[1] c_atom[2] c_atom[3] fx\n"
        + 'dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g"\n'
        + SHOW
        + "run 6000\n"
    )
    done = run_script(tmp_path, script)
    end = done.dump("end.txt")
    np.testing.assert_array_equal(end[:, 2], [1.0, 1.0, 0.0])
    np.testing.assert_array_equal(end[:, 3], 1.0)
    np.testing.assert_allclose(end[:, 4], np.pi)
    assert done.tables[-1]["1"][-1] == 1.0
    # It came upon the pair, which moves on with a part of its momentum.
    assert end[1, 1] < 1.99 and end[2, 1] > end[1, 1] + 1.9
