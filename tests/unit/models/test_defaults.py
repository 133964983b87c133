# SPDX-License-Identifier: GPL-2.0-or-later
"""A script that leaves keywords out gets what a scene gets."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from floeflow.core.constants import AIR_DENSITY, CONTACT_SHEAR_RATIO, SEAWATER_DENSITY
from floeflow.dynamics.engine.params import EngineParams
from floeflow.dynamics.motion import engine_params
from floeflow.scene.blocks import Dynamics
from floeflow.scene.load import parse_scene
from support.liggghts import BOND, raft, run_script

pytestmark = pytest.mark.mpi


def test_defaults_are_those_of_scenes(tmp_path: Path) -> None:
    d = Dynamics()
    words = (
        f"bond_young {d.young_modulus!r} poisson {d.poisson_ratio!r} "
        f"bond_damping {d.bond_damping!r} compressive_strength {d.compressive_strength!r} "
        f"tensile_share {d.tensile_share!r} friction_angle {d.friction_angle!r} "
        f"contact_young {d.contact_modulus!r} contact_shear_ratio {CONTACT_SHEAR_RATIO!r} "
        f"contact_damping {d.contact_damping!r} friction_coefficient {d.friction_coefficient!r} "
        f"ridge_force {d.ridge_force!r} ridge_hardening {d.ridge_hardening!r} "
        f"ridge_thickness {d.ridge_thickness!r} lead_softening {d.lead_softening!r} "
    )
    drag = (
        f"wind yes ocean_drag yes wind_velocity 30 -10 air_drag {AIR_DENSITY * d.air_drag!r} "
        f"water_drag {SEAWATER_DENSITY * d.ocean_drag!r}"
    )
    plain = "wind yes ocean_drag yes wind_velocity 30 -10"
    ends = []
    for keywords, fix in ((words, drag), ("", plain)):
        script = re.sub(
            r"pair_style gran model floe .*",
            f"pair_style gran model floe bonds yes ridging yes reach 1.2 {keywords}",
            raft(fix=fix),
        )
        done = run_script(
            tmp_path / str(len(ends)),
            script
            + BOND
            + "velocity all ramp vx 0.3 -0.3 y 0 14000 units box\n"
            + "dump d all custom 200 end.txt id x y vx vy\n"
            + 'dump_modify d sort id format "%d %.17g %.17g %.17g %.17g"\nrun 200\n',
        )
        ends.append(done.dump("end.txt"))
    np.testing.assert_array_equal(ends[0], ends[1])


def test_the_engine_without_laws_has_those_of_a_scene_without_keys() -> None:
    scene, plain = engine_params(parse_scene(b"effects: []", "a"), 1.0), EngineParams(1.0)
    numbers = [f.name for f in fields(plain) if isinstance(getattr(plain, f.name), float)]
    assert len(numbers) > 15 and "tensile_share" in numbers
    for name in numbers:
        assert getattr(plain, name) == getattr(scene, name), name


def test_the_page_tells_the_defaults_of_the_header(project: Path) -> None:
    header = (project / "liggghts_models/laws/defaults.h").read_text()
    given = dict(re.findall(r"constexpr double (\w+) = ([^;]+);", header))
    told: dict[str, str] = {}
    for page in ("pair_floe.md", "fix_floe_integrate.md"):
        text = (project / "docs/models" / page).read_text()
        told |= dict(re.findall(r"^\| `(\w+)` \|.*\| ([^|]+?) \|$", text, re.MULTILINE))
    missing = given.keys() - told.keys()
    # Constants that no keyword sets.
    assert missing <= {"ice_density", "edge_share"}
    assert {k: float(told[k]) for k in given.keys() - missing} == {
        k: float(v) for k, v in given.items() if k not in missing
    }


def test_angles_are_in_degrees(tmp_path: Path) -> None:
    done = run_script(tmp_path, raft("friction_angle 0.6") + "run 0\n", works=False)
    assert "friction_angle must lie between 2 and 90 degrees" in done.out
