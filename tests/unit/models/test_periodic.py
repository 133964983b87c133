# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds, slips and ridges reach across periodic boundaries: a raft may lie anywhere in the box."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.liggghts import HEAD, run_script

pytestmark = pytest.mark.mpi

WIDTH, HEIGHT = 40000.0, 40000.0 * np.sqrt(3.0) / 2.0 * 1.1


def periodic(shift: float) -> str:
    """A bonded band of floes around the box in x, sheared and broken, put `shift` metres aside."""
    places = [
        ((2000.0 * (i + 0.5 * (j % 2)) + shift) % WIDTH, 1732.0508 * j + 2000.0)
        for j in range(12)
        for i in range(20)
    ]
    # In bins of different floes the ids keep their places.
    create = "".join(f"create_atoms 1 single {x!r} {y!r} 0 units box\n" for x, y in places)
    return (
        HEAD
        + "boundary p f p\n"
        + f"region box block 0 {WIDTH} -20000 60000 -20000 20000 units box\ncreate_box 2 box\n"
        + create
        + "set group all diameter 2000\nset group all density 900\n"
        + "neighbor 200 bin\nneigh_modify delay 0 every 1 check yes\n"
        + "pair_style gran model floe bonds yes ridging yes bond_young 1e9 contact_young 1e8 "
        + "compressive_strength 3e4 tensile_share 0.3 reach 1.2\npair_coeff * *\ntimestep 0.4\n"
        + "fix motion all floe/integrate thickness 1 ocean_drag yes\n"
        + "run 0\nfloe_bonds gap 1 thickness 1\n"
        + "velocity all ramp vx 0.1 -0.1 y 0 24000 units box\n"
        + "thermo_style custom step f_motion[28] f_motion[25] f_motion[31] f_motion[29]\n"
        + "thermo 50\nthermo_modify norm no format float %.17g\n"
        + "dump d all custom 300 end.txt id x y vx vy omegaz\n"
        + 'dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g"\nrun 300\n'
    )


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_band_around_the_box_does_not_know_where_it_ends(tmp_path: Path, ranks: int) -> None:
    here = run_script(tmp_path / "here", periodic(500.0), ranks)
    there = run_script(tmp_path / "there", periodic(20500.0), ranks)
    a, b = here.tables[-1], there.tables[-1]
    # 12 rows of 20 bonds around the box, and two upwards from each floe of all rows but the last
    assert a["1"][0] == b["1"][0] == 12 * 20 + 11 * 20 * 2
    assert 50 < a["2"][-1] < 600
    np.testing.assert_array_equal(a["2"], b["2"])
    np.testing.assert_array_equal(a["4"], b["4"])
    np.testing.assert_allclose(a["3"], b["3"], rtol=1e-6)
    end, other = here.dump("end.txt"), there.dump("end.txt")
    aside = np.mod(other[:, 1] - end[:, 1] - 20000.0 + WIDTH / 2, WIDTH) - WIDTH / 2
    np.testing.assert_allclose(aside, 0.0, atol=1e-4)
    np.testing.assert_allclose(other[:, 2:5], end[:, 2:5], rtol=1e-6, atol=1e-6)
