# SPDX-License-Identifier: GPL-2.0-or-later
"""Input scripts of LIGGGHTS with the models, and what it prints, dumps and logs."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from support.ranks import run_liggghts

HEAD = """\
units si
dimension 2
atom_style granular
atom_modify map array
newton off
communicate single vel yes
"""
PRINT = "thermo_modify norm no lost error format float %.17g\n"
# A wall of triangles: straight lines in the plane of the ice, upright.
FACET = "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n"


@dataclass
class Done:
    """A finished run: its tables of thermodynamic output, one for each `run`."""

    code: int
    out: str
    err: str
    folder: Path

    @property
    def tables(self) -> list[dict[str, np.ndarray]]:
        """Columns by place, "0", "1" and so on: LIGGGHTS cuts long names short."""
        found = re.findall(r"^ *Step [^\n]*\n(?:.*\n)*?(?=Loop time)", self.out, re.MULTILINE)
        tables = []
        for text in found:
            head, *lines = text.splitlines()
            # Ranks print as they like: another's word may stand between the rows.
            rows = np.array(
                [
                    [float(v) for v in line.split()]
                    for line in lines
                    if len(line.split()) == len(head.split()) and line.split()[0].isdigit()
                ]
            )
            tables.append({str(k): rows[:, k] for k in range(rows.shape[1])})
        return tables

    def value(self, name: str) -> float:
        """What ``print "name ${x}"`` printed last."""
        return float(re.findall(rf"^{name} (\S+)$", self.out, re.MULTILINE)[-1])

    def dump(self, name: str) -> np.ndarray:
        """Rows of the last frame of a dump."""
        frame = (self.folder / name).read_text().split("ITEM: TIMESTEP")[-1]
        lines = re.split(r"ITEM: (?:ATOMS|ENTRIES)[^\n]*\n", frame)[-1].splitlines()
        return np.array([[float(v) for v in line.split()] for line in lines])


def run_script(folder: Path, text: str, ranks: int = 1, *, works: bool = True) -> Done:
    """Run a script; where it must work, it did."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "in.script").write_text(text)
    done = run_liggghts(folder, "in.script", ranks)
    if works:
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return Done(done.returncode, done.stdout, done.stderr, folder)


def discs(
    places: list[tuple[float, float]],
    style: str,
    fix: str = "thickness 1",
    *,
    boundary: str = "f f p",
    skin: float = 0.2,
    step: float = 1e-4,
) -> str:
    """Discs of 1 m radius in a box of 40 m, with laws and an integrator named ``motion``."""
    return (
        HEAD
        + f"boundary {boundary}\nregion box block -20 20 -20 20 -20 20 units box\n"
        + "create_box 2 box\n"
        + "".join(f"create_atoms 1 single {x!r} {y!r} 0 units box\n" for x, y in places)
        + "set group all diameter 2\nset group all density 900\n"
        + f"neighbor {skin} bin\nneigh_modify delay 0 every 1 check yes\n"
        + f"pair_style gran model floe {style}\npair_coeff * *\n"
        + f"timestep {step}\nfix motion all floe/integrate {fix}\n"
    )


def raft(
    style: str = "",
    fix: str = "wind yes ocean_drag yes wind_velocity 30 -10",
    *,
    boundary: str = "m m p",
    setup: str = "",
) -> str:
    """12 x 10 discs of 1 km radius in a hexagonal lattice, the leftmost of them fixed.

    They are bonded when ``run 0`` and ``floe_bonds gap 1 thickness 1`` follow.
    """
    return (
        HEAD
        + f"boundary {boundary}\nlattice hex 2000\n"
        + "region box block -3 16 -3 9 -2 2 units lattice\ncreate_box 2 box\n"
        + "region ice block -0.1 11.6 -0.1 4.7 -0.1 0.1 units lattice\n"
        + "create_atoms 1 region ice\nset group all diameter 2000\nset group all density 900\n"
        + "region shore block -0.1 0.1 INF INF INF INF units lattice\nset region shore type 2\n"
        + setup
        + "neighbor 200 bin\nneigh_modify delay 0 every 1 check yes exclude type 2 2\n"
        + "pair_style gran model floe bonds yes bond_young 1e9 poisson 0.3 bond_damping 0.1 "
        + "compressive_strength 1e4 tensile_share 0.1 contact_young 1e8 contact_damping 0.3 "
        + f"friction_coefficient 0.3 reach 1.2 {style}\npair_coeff * *\ntimestep 0.4\n"
        + f"fix motion all floe/integrate thickness 1 {fix}\n"
    )


BOND = "run 0\nfloe_bonds gap 1 thickness 1\n"


def write_wall(path: Path, corners: list[tuple[float, float]], height: float = 4.0) -> None:
    """Write straight lines from corner to corner as an STL file, two triangles a line."""
    text = "solid wall\n"
    for (xa, ya), (xb, yb) in zip(corners, corners[1:], strict=False):
        low, high = -height, height
        for triangle in (
            ((xa, ya, low), (xb, yb, low), (xb, yb, high)),
            ((xa, ya, low), (xb, yb, high), (xa, ya, high)),
        ):
            lines = "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in triangle)
            text += FACET.format(lines)
    path.write_text(text + "endsolid wall\n")
