# SPDX-License-Identifier: GPL-2.0-or-later
"""Restart files hold bonds, histories, orientations and sums; going on from one changes no bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.liggghts import BOND, HEAD, raft, run_script, write_wall

pytestmark = pytest.mark.mpi

NEIGHBOURS = "neighbor 200 bin\nneigh_modify delay 0 every 1 check yes exclude type 2 2\n"
FIX = "fix motion all floe/integrate thickness 1 wind yes ocean_drag yes wind_velocity 30 -10\n"
END = (
    "thermo_style custom step f_motion[1] f_motion[25] f_motion[23] f_motion[28]\n"
    "thermo 100\nthermo_modify norm no lost error format float %.17g\n"
    "dump d all custom 300 END id x y vx vy omegaz\n"
    'dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g"\n'
)


def go_on(
    folder: Path, file: Path, end: str, ranks: int, steps: int, walls: str = ""
) -> np.ndarray:
    """What a run from a restart file has at its end; its sums are appended to the rows."""
    script = (
        f"{HEAD}boundary m m p\nread_restart {file}\n{NEIGHBOURS}timestep 0.4\n{FIX}{walls}"
        f"{END.replace('END', end)}run {steps}\n"
    )
    done = run_script(folder, script, ranks)
    return np.vstack([done.dump(end), last_sums(done.tables[-1])])


def last_sums(table: dict[str, np.ndarray]) -> np.ndarray:
    """The last row of the sums, as wide as the rows of elements."""
    return np.array([[table[str(k)][-1] for k in range(5)] + [0.0]])


@pytest.mark.parametrize(
    ("style", "before", "after"),
    [("", 1, 1), ("", 2, 2), ("deterministic yes", 1, 2), ("deterministic yes", 2, 1)],
)
def test_a_breaking_raft_goes_on_with_the_same_bits(
    tmp_path: Path, style: str, before: int, after: int
) -> None:
    script = (
        raft(f"ridging yes compressive_strength 3e4 tensile_share 0.3 {style}")
        + BOND
        + "velocity all ramp vx 0.05 -0.05 y 0 14000 units box\n"
        + "restart 60 within.*.bin\nrun 60\nrestart 0\nwrite_restart between.bin\n"
        + END.replace("END", "end.txt")
        + "run 240\n"
    )
    done = run_script(tmp_path, script, before)
    whole = np.vstack([done.dump("end.txt"), last_sums(done.tables[-1])])
    # Bonds break before the files are written, and after.
    assert 50 < done.tables[-1]["2"][0] < whole[-1, 2] - 20
    for file in ("between.bin", "within.60.bin"):
        again = go_on(tmp_path, Path(file), f"{file}.txt", after, 240)
        np.testing.assert_array_equal(again[:-1], whole[:-1])
        # Sums over elements are added up by rank: the same numbers, but not the same bits.
        np.testing.assert_allclose(again[-1], whole[-1], rtol=1e-9)


def test_contacts_with_walls_are_in_the_file(tmp_path: Path) -> None:
    """A plane and a mesh press a raft that ridges and rubs along them."""
    write_wall(tmp_path / "wall.stl", [(24500.0, -5000.0), (24500.0, 22000.0)], 3000.0)
    walls = (
        "fix plane all wall/gran model floe primitive type 2 yplane -980.0\n"
        "fix face all mesh/surface file wall.stl type 2\n"
        "fix mesh all wall/gran model floe mesh n_meshes 1 meshes face\n"
    )
    box = "region box block -3 16 -3 9 -2 2"
    script = (
        raft("ridging yes").replace(box, "region box block -30 40 -30 40 -20 20")
        + walls
        + BOND
        + "run 300\nwrite_restart between.bin\n"
        + END.replace("END", "end.txt")
        + "run 600\n"
    )
    done = run_script(tmp_path, script)
    whole = np.vstack([done.dump("end.txt"), last_sums(done.tables[-1])])
    again = go_on(tmp_path, Path("between.bin"), "again.txt", 1, 600, walls)
    np.testing.assert_array_equal(again[:-1], whole[:-1])


def test_a_damaged_file_and_another_law_are_refused(tmp_path: Path) -> None:
    script = raft() + BOND + "write_restart state.bin\n"
    run_script(tmp_path, script)
    start = f"{HEAD}boundary m m p\nread_restart state.bin\n{NEIGHBOURS}timestep 0.4\n{FIX}"
    bad = start + "pair_style gran model floe bonds no\npair_coeff * *\nrun 1\n"
    done = run_script(tmp_path, bad, works=False)
    assert done.code != 0
    assert "saved simulation state used different contact history model" in done.out
    # The same style with another strength is a parameter, and may change.
    run_script(
        tmp_path,
        start
        + "pair_style gran model floe bonds yes compressive_strength 2e4 reach 1.2\n"
        + "pair_coeff * *\nrun 1\n",
    )


def test_laws_set_between_runs_would_forget_the_bonds(tmp_path: Path) -> None:
    again = "pair_style gran model floe bonds yes reach 1.2\npair_coeff * *\nrun 1\n"
    done = run_script(tmp_path, raft() + BOND + again, works=False)
    assert done.code != 0
    assert "cannot be set between runs, which would forget bonds" in done.out
    # Before the first run the last one holds.
    run_script(tmp_path, raft() + again)
