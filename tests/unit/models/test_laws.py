# SPDX-License-Identifier: GPL-2.0-or-later
"""Another law is its header and its name in a list: no other file names one."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from support.liggghts import PRINT, discs
from support.ranks import mpirun

SHARED = {"ElasticLine"}  # which laws begin from


def law_names(models: Path, file: str) -> set[str]:
    lists = re.findall(
        r"^#define FLOE_\w+\((?:LAW|FORCE)\) (.*)$", (models / file).read_text(), re.M
    )
    return {name for line in lists for name in re.findall(r"(?:LAW|FORCE)\((\w+)\)", line)}


@pytest.mark.parametrize(("file", "least"), [("laws/laws.h", 4), ("laws/forces.h", 1)])
def test_no_file_but_its_own_and_the_list_names_a_law(project: Path, file: str, least: int) -> None:
    models = project / "liggghts_models"
    names = law_names(models, file)
    assert len(names) >= least
    sources = [
        p for p in models.rglob("*") if p.suffix in {".cpp", ".h"} and p.parent.name != "tests"
    ]
    for name in names:
        inside = {p.name for p in sources if re.search(rf"\b{name}\b", p.read_text())}
        (own,) = inside - {Path(file).name}
        assert f"struct {name}" in (models / "laws" / own).read_text()


@pytest.mark.slow
@pytest.mark.mpi
def test_the_law_of_the_page_is_a_header_and_a_line(project: Path, tmp_path: Path) -> None:
    """The plugin is built with the law that the page shows, and a bond breaks by it."""
    page = (project / "docs/models/laws.md").read_text()
    (law,) = re.findall(r"^    struct FuseBond.*?^    };\n", page, re.MULTILINE | re.DOTALL)
    models = tmp_path / "models"
    shutil.copytree(project / "liggghts_models", models)
    header = '#include "bond.h"\nnamespace floe {\n' + law + "}\n"
    (models / "laws/fuse_bond.h").write_text(header)
    lists = models / "laws/laws.h"
    text = lists.read_text().replace("LAW(ParallelBond)", "LAW(ParallelBond) LAW(FuseBond)")
    lists.write_text(text.replace("\n#include", '\n#include "fuse_bond.h"\n#include', 1))
    build = tmp_path / "build"
    for words in (
        ["-S", models, "-B", build],
        ["--build", build, "--target", "liggghts-floe", "test_laws"],
    ):
        subprocess.run(["cmake", *words], check=True, capture_output=True, text=True)
    subprocess.run([build / "test_laws"], check=True)
    script = (
        discs(
            [(0.0, 0.0), (2.0, 0.0)],
            "bonds yes bond_law fuse fuse_extension 0.02 bond_damping 0 reach 1.5 friction no",
        )
        + "group fixed id 1\nset group fixed type 2\nfix log all floe/breakage 1 file broken.txt\n"
        + "run 0\nfloe_bonds gap 0.1 thickness 1\ngroup free id 2\n"
        + "velocity free set 30 0 0 units box\n"
        + "compute far all reduce max x\nthermo_style custom step c_far f_motion[28]\nthermo 1\n"
        + PRINT
        + "run 20\n"
    )
    (tmp_path / "in.script").write_text(script)
    done = mpirun(1, [build / "liggghts-floe", "-in", "in.script"], tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = re.findall(r"^ +(\d+) +(\S+) +([01])\s*$", done.stdout, re.MULTILINE)
    far, bonds = (np.array([float(row[k]) for row in rows]) for k in (1, 2))
    assert set(bonds) == {0.0, 1.0}
    np.testing.assert_array_equal(bonds == 1.0, far - 2.0 <= 0.02)
    assert (tmp_path / "broken.txt").read_text().splitlines()[1].split()[6] == "tension"
