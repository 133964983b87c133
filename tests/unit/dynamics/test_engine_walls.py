# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of LIGGGHTS with the contact laws: planes and triangle meshes, moving ones included."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine, EngineError
from support.full_ice import full_params
from support.rafts import discs
from support.ranks import run_liggghts

PLANE = "fix wall all wall/gran model floe primitive type 2 xplane 0.0"
STIFFNESS = 1e8 * 0.8  # contact modulus times thickness


# LIGGGHTS sorts triangles into bins: the box is several times as wide and deep as they are.
SCRIPT = """
units si
dimension 2
atom_style granular
newton off
communicate single vel yes
boundary m m p
processors * * 1
region box block -30000 30000 -30000 30000 -30000 30000 units box
create_box 2 box
neighbor 200 bin
neigh_modify delay 0
pair_style gran model floe friction {friction} contact_young 1e8 contact_damping 0
pair_coeff * *
fix motion all floe/integrate thickness 0.8
fix face all mesh/surface file wall.stl type 2
{move}
fix wall all wall/gran model floe mesh n_meshes 1 meshes face
create_atoms 1 single {x} 300 0
set group all diameter 2000 density {density}
timestep 0.1
run {steps}
variable u equal vcm(all,x)
variable v equal vcm(all,y)
print "moves ${{u}} ${{v}} m/s"
"""


def along_a_mesh(
    folder: Path, x: float, density: float, steps: int, move: str = ""
) -> tuple[float, float]:
    """Velocity of a disc beside a wall at x = 0 of two triangles, across the plane of the ice."""
    corners = ((-9e3, -900), (9e3, -900), (9e3, 900), (-9e3, 900))
    a, b, c, d = (f"vertex 0 {y} {z}" for y, z in corners)
    faces = "".join(
        f"facet normal 1 0 0\nouter loop\n{p}\n{q}\n{r}\nendloop\nendfacet\n"
        for p, q, r in ((a, b, c), (a, c, d))
    )
    (folder / "wall.stl").write_text(f"solid wall\n{faces}endsolid wall\n")
    friction = "yes" if move else "no"
    text = SCRIPT.format(x=x, density=density, steps=steps, move=move, friction=friction)
    (folder / "in.mesh").write_text(text)
    done = run_liggghts(folder, "in.mesh", 1)
    assert done.returncode == 0, done.stdout + done.stderr
    found = re.search(r"^moves (\S+) (\S+) m/s", done.stdout, re.MULTILINE)
    assert found is not None
    return float(found[1]), float(found[2])


def start(engine: Engine, disc: dict[str, np.ndarray], commands: list[str]) -> None:
    engine.load(disc)
    for line in [*commands, "run 0 post no"]:
        engine._command(line)


def disc_at(x: float, y: float = 0.0) -> dict[str, np.ndarray]:
    # The second, fixed one makes the box larger; nothing touches it.
    out = discs([x, 9e3], [y, 0.0], thickness=0.8)
    out["type"][1] = 2
    return out


def test_a_pressed_disc_has_the_closed_form_force(tmp_path: Path) -> None:
    params = full_params(time_step=0.1, friction=False)
    disc = disc_at(995.0, 300.0)
    with Engine(MPI.COMM_SELF, params, tmp_path / "log") as engine:
        start(engine, disc, [PLANE])
        engine.run(1)
        out, sums = engine.elements(), engine.diagnostics()
        force = 5.0 * STIFFNESS
        assert out["u"][0] == pytest.approx(0.1 * force / disc["mass"][0], rel=1e-12)
        assert out["v"][0] == 0.0 and out["omega"][0] == 0.0
        engine.run(2000)
        first = engine.elements()["u"][0]
        engine.run(100)
        assert engine.elements()["u"][0] == first > 0  # it has left the wall, and nothing pulls
        momentum = first * disc["mass"][0]
        assert engine.diagnostics()["impulse_wall_x"] + sums["impulse_wall_x"] > 0
        # The force of `run 0` acts in the first step and is evaluated again in none.
        given = engine.diagnostics()["impulse_wall_x"] + 0.1 * force
        assert given == pytest.approx(momentum, rel=1e-9)


def test_a_disc_leaves_a_wall_with_the_restitution_of_the_damped_contact(tmp_path: Path) -> None:
    disc = disc_at(1000.5)
    disc["u"][0] = -0.5
    damping, mass = 0.3, disc["mass"][0]
    w0 = math.sqrt(STIFFNESS / mass)
    beta, w = damping * w0, w0 * math.sqrt(1 - damping**2)
    expected = math.exp(-beta / w * (math.pi - math.atan2(2 * beta * w, w * w - beta * beta)))
    params = full_params(time_step=1e-3 / w0, friction=False, contact_damping=damping)
    with Engine(MPI.COMM_SELF, params, tmp_path / "log") as engine:
        start(engine, disc, [PLANE])
        engine.run(8000)
        assert engine.elements()["u"][0] == pytest.approx(0.5 * expected, rel=2e-3)
        lost = engine.diagnostics()["dissipation_contact"]
        assert lost == pytest.approx(0.5 * mass * 0.25 * (1 - expected**2), rel=1e-2)


def test_a_moving_wall_drags_by_friction(tmp_path: Path) -> None:
    disc = disc_at(999.0)
    disc["mass"][0] = 1e27  # stays pressed
    params = full_params(time_step=0.1, contact_damping=0.0)
    with Engine(MPI.COMM_SELF, params, tmp_path / "log") as engine:
        start(engine, disc, [PLANE + " shear y 0.5"])
        engine.run(200)  # 10 m of sliding
        out = engine.elements()
        limit = 0.3 * STIFFNESS
        # The wall turns the disc about its centre with the lever that is left of the radius.
        stick = 0.3 / 0.5
        work = engine.diagnostics()["dissipation_friction"]
        assert work == pytest.approx(limit * (10.0 - stick), rel=2e-2)
        assert out["v"][0] > 0 and out["omega"][0] < 0
        spin = 0.5 * 1e27 * 1000.0**2 * out["omega"][0]
        assert spin == pytest.approx(-999.0 * 1e27 * out["v"][0], rel=1e-9)


def test_a_disc_ridges_against_a_wall(tmp_path: Path) -> None:
    disc = disc_at(1000.0)
    disc["mass"][0], disc["u"][0] = 1e27, -1.0
    params = full_params(time_step=0.1, friction=False, ridging=True, compressive_strength=1e5)
    with Engine(MPI.COMM_SELF, params, tmp_path / "log") as engine:
        start(engine, disc, [PLANE])
        engine.run(500)  # 50 m
        area, sums = engine.elements()["ridged_area"], engine.diagnostics()
    length = 2000.0 / math.sqrt(3)
    closing = area[0] / length
    force = length * 1e5 * 0.8 * 1000.0 / (1000.0 - closing)
    assert closing == pytest.approx(50.0 - force / STIFFNESS, rel=1e-4)
    # The ice between centre and wall keeps its volume.
    work = length * 1e5 * 0.8 * 1000.0 * -math.log(1 - closing / 1000.0)
    assert sums["dissipation_ridging"] == pytest.approx(work, rel=2e-3)


def test_keywords_of_a_wall_are_refused(tmp_path: Path) -> None:
    with Engine(MPI.COMM_SELF, full_params(time_step=0.1), tmp_path / "log") as engine:
        engine.load(disc_at(1500.0))
        with pytest.raises(EngineError, match="model floe: unknown keyword soft"):
            engine._command(PLANE + " soft yes")


@pytest.mark.mpi
def test_a_mesh_pushes_as_a_plane_does(tmp_path: Path) -> None:
    u, v = along_a_mesh(tmp_path, 995.0, 733.6, 1)
    mass = 733.6 * math.pi * 1000.0**2
    assert u == pytest.approx(0.1 * 5.0 * STIFFNESS / mass, rel=1e-5) and v == 0.0


@pytest.mark.mpi
def test_a_moving_mesh_drags_by_friction(tmp_path: Path) -> None:
    density = 1e15  # stays pressed, for 2 s of sliding
    move = "fix drive all move/mesh mesh face linear 0. 50. 0."
    _, v = along_a_mesh(tmp_path, 999.0, density, 20, move)
    mass = density * math.pi * 1000.0**2
    assert v == pytest.approx(2.0 * 0.3 * STIFFNESS / mass, rel=0.06)
