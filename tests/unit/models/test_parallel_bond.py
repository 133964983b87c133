# SPDX-License-Identifier: GPL-2.0-or-later
"""Parallel bonds break whole, where the closed form of a beam says (Potyondy & Cundall 2004)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.liggghts import BOND, PRINT, discs, raft, run_script

pytestmark = pytest.mark.mpi

YOUNG, STRENGTH, TENSILE, SHEAR = 1e9, 1e6, 0.1, 0.05
LAW = (
    f"bonds yes bond_law parallel bond_young {YOUNG} compressive_strength {STRENGTH} "
    f"tensile_share {TENSILE} shear_share {SHEAR} bond_damping 0 reach 1.5 friction no"
)
SHOW = (
    "compute bond all floe/bond/local whole normal_max shear energy force_x force_y\n"
    "compute row all reduce sum c_bond[1] c_bond[2] c_bond[3]\n"
    "compute place all reduce max x y\nthermo_style custom step f_motion[24] f_motion[25] c_row[1]"
    " c_row[2] c_row[3]\nthermo 1\n" + PRINT
)


def pull(folder: Path, velocity: str, steps: int) -> tuple[dict[str, np.ndarray], list[str]]:
    """Table of a run in which one of two bonded discs is fixed, and the line of the breakage."""
    script = (
        discs([(0.0, 0.0), (2.0, 0.0)], LAW, step=2e-5)
        + "group fixed id 1\nset group fixed type 2\nfix log all floe/breakage 1 file broken.txt\n"
        + "run 0\nfloe_bonds gap 0.1 thickness 1 width 0.8\ngroup free id 2\n"
        + f"velocity free set {velocity} units box\n"
        + SHOW
        + f"run {steps}\n"
    )
    done = run_script(folder, script)
    lines = (folder / "broken.txt").read_text().splitlines()[1:]
    return done.tables[-1], lines[0].split() if lines else []


def test_tension_breaks_it_at_the_tensile_strength(tmp_path: Path) -> None:
    table, row = pull(tmp_path, "0.2 0 0", 200)
    broken = table["2"] > 0
    last = table["4"][~broken][-1]
    step = np.diff(table["4"][~broken]).max()
    assert TENSILE * STRENGTH - step <= last <= TENSILE * STRENGTH
    assert row[6] == "tension" and last < float(row[7]) <= last + 1.01 * step
    # Whole until it goes: cracked and broken in the same step.
    np.testing.assert_array_equal(table["1"], table["2"])
    assert set(table["3"]) == {0.0, 1.0}


def test_shear_breaks_it_at_the_shear_strength_whatever_presses(tmp_path: Path) -> None:
    table, row = pull(tmp_path, "-1 0.5 0", 400)
    broken = table["2"] > 0
    shear = np.abs(table["5"][~broken])
    step = np.diff(shear).max()
    assert SHEAR * STRENGTH - step <= shear[-1] <= SHEAR * STRENGTH
    # Far below minus the tensile strength, where a glue line would still hold.
    assert row[6] == "shear" and float(row[7]) < -TENSILE * STRENGTH


def test_bending_breaks_it_at_once_by_its_edge_stress(tmp_path: Path) -> None:
    """A row of beams under a load across: the first to go is at the root, and it goes whole."""
    places = [(2.0 * k, 0.0) for k in range(4)]
    lines = []
    for law in (LAW, LAW.replace("bond_law parallel", "bond_law glue")):
        script = (
            discs(places, law, step=5e-5)
            + "group fixed id 1\nset group fixed type 2\ngroup tip id 4\n"
            + "fix log all floe/breakage 1 file broken.txt\nvariable p equal ramp(0,-12000)\n"
            + "fix load tip addforce 0 v_p 0\nfix brake all viscous 3e4\nrun 0\n"
            + "floe_bonds gap 0.1 thickness 1 width 0.8\n"
            + "compute bond all floe/bond/local id1 whole normal_max\n"
            + "compute worst all reduce max c_bond[3]\n"
            + "thermo_style custom step v_p f_motion[24] f_motion[25] c_worst\nthermo 20\n"
            + PRINT
            + "run 60000\n"
        )
        done = run_script(tmp_path / str(len(lines)), script)
        text = (tmp_path / str(len(lines)) / "broken.txt").read_text()
        lines.append((done.tables[-1], text.splitlines()[1].split()))
    table, row = lines[0]
    # Edge stress 6 M / (h L^2) with M = P x 5 m at the root's line, L = 1.6 m.
    theory = TENSILE * STRENGTH * 1.6**2 / 6 / 5
    at = -table["1"][table["3"] > 0][0]
    assert row[2:4] == ["1", "2"] and row[6] == "tension"
    assert at == pytest.approx(theory, rel=0.02)
    np.testing.assert_array_equal(table["2"], table["3"])
    # A glue line cracks there before it breaks, and holds no less than the beam.
    glue, _ = lines[1]
    assert np.any(glue["2"] > glue["3"])


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_raft_of_beams_breaks_whole_and_goes_on_from_a_file(tmp_path: Path, ranks: int) -> None:
    style = "bond_law parallel compressive_strength 3e4 tensile_share 0.3 deterministic yes"
    show = (
        "thermo_style custom step f_motion[24] f_motion[25]\nthermo 50\n"
        + PRINT
        + "dump d all custom 300 end.txt id x y vx vy\n"
        + 'dump_modify d sort id format "%d %.17g %.17g %.17g %.17g"\n'
    )
    script = (
        raft(style)
        + BOND
        + "velocity all ramp vx 0.05 -0.05 y 0 14000 units box\nrun 60\nwrite_restart half.bin\n"
    )
    done = run_script(tmp_path, script + show + "run 240\n", ranks)
    table, end = done.tables[-1], done.dump("end.txt")
    np.testing.assert_array_equal(table["1"], table["2"])
    assert 10 < table["2"][0] < table["2"][-1]
    again = run_script(
        tmp_path,
        "atom_style granular\nnewton off\ncommunicate single vel yes\nread_restart half.bin\n"
        "neighbor 200 bin\nneigh_modify delay 0 every 1 check yes exclude type 2 2\ntimestep 0.4\n"
        "fix motion all floe/integrate thickness 1 wind yes ocean_drag yes wind_velocity 30 -10\n"
        + show
        + "run 240\n",
        ranks,
    )
    np.testing.assert_array_equal(again.dump("end.txt"), end)


def test_an_unknown_law_is_refused(tmp_path: Path) -> None:
    done = run_script(tmp_path, raft("bond_law beam") + "run 0\n", works=False)
    assert "bond_law takes glue or parallel" in done.out
