# SPDX-License-Identifier: GPL-2.0-or-later
"""The examples run, end as they should, and are drawn."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from support.liggghts import Done, run_script

pytestmark = pytest.mark.mpi

FOLDER = Path("liggghts_models") / "examples"


def run_example(project: Path, folder: Path, name: str) -> Done:
    """Run an example beside copies of its files, and draw it."""
    source = project / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    for file in [*source.glob("*.stl"), source / "floes.txt"]:
        shutil.copy(file, folder)
    done = run_script(folder, (source / f"in.{name}").read_text())
    subprocess.run([sys.executable, source / "draw.py", name], cwd=folder, check=True)
    assert (folder / f"{name}.png").stat().st_size > 5000
    return done


def printed(done: Done, name: str) -> float:
    """The number behind a name that the script printed."""
    lines = [line.split() for line in done.out.splitlines()]
    return float([w for w in lines if len(w) >= 2 and w[0] == name][-1][1])


def test_compression_closes_leads_then_ridges(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "compression")
    table = done.tables[-1]
    strain, stress, ridged = table["1"], table["2"], table["3"]
    # The floes lie 2 % apart: nothing resists before.
    assert np.all(stress[strain < 0.019] == 0.0)
    assert np.all(np.diff(ridged) >= 0.0)
    # What went into ridges is below what the plate took away from the pack, and of its order.
    closed = (strain[-1] - 0.02) * 36000 * 41000
    assert 0.05 * closed < ridged[-1] < closed
    # Ice of 1 m ridges between the force that starts it and its strength (1e5 Pa).
    assert 26126 * 0.3 < stress[-1] < 1e5


def test_brazilian_disc_is_split_by_tension(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "brazilian")
    rows = [r.split() for r in (tmp_path / "broken.brazilian").read_text().splitlines()[1:]]
    assert len(rows) == printed(done, "broken") > 20
    _, load = np.loadtxt(tmp_path / "load.brazilian", unpack=True)
    # A disc splits at pi D t sigma / 2 (Hertz 1883), sigma the strength of the sheet: a lattice of
    # lines with a third of its cuts free has no more than the tensile strength of a line, 2.5e5 Pa.
    full = np.pi * 20 / 2 * 2.5e5
    assert 0.15 * full < load.max() < full
    modes = [r[6] for r in rows]
    assert modes.count("tension") > 0.6 * len(modes)


def test_cantilever_bends_as_its_bonds_do(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "cantilever")
    assert printed(done, "deflection") == pytest.approx(printed(done, "theory"), rel=1e-4)


def test_floes_shear_across_a_periodic_boundary(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "shear")
    assert np.all(done.tables[-1]["4"] == 960)
    # The upper side moves right: momentum goes down, which is a negative pressure xy. Floes slide
    # on floes at no more than the friction coefficient, 0.3.
    across, shear = printed(done, "across"), printed(done, "shear")
    assert across > 0.0 and -0.35 * across < shear < -0.1 * across
    frame = done.dump("dump.shear")
    driven, top, bottom = frame[:, 2] > 49000, frame[:, 2] > 33000, frame[:, 2] < 16000
    assert np.all(frame[driven, 4] == 1.0)
    assert frame[top, 4].mean() > frame[bottom, 4].mean() + 0.1


def test_collision_keeps_momentum_and_logs_what_breaks(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "collision")
    before, after = printed(done, "momentum_before"), printed(done, "momentum_after")
    assert after == pytest.approx(before, rel=1e-9) and before > 1e7
    rows = (tmp_path / "broken.collision").read_text().splitlines()[1:]
    assert len(rows) == printed(done, "broken") > 20
    energy = done.tables[-1]["2"]
    assert energy[-1] < 0.9 * energy[0]


def test_restart_ends_where_the_first_run_did(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "restart")
    assert printed(done, "again") == printed(done, "first")
    assert printed(done, "again_broken") == printed(done, "first_broken") > 50


@pytest.mark.slow
def test_an_arch_holds_the_ice(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "ice_arch")
    table = done.tables[-1]
    held, past, push, broken = (table[str(k)] for k in (2, 3, 4, 5))
    assert broken[-1] > 500
    # Less than one floe in twenty has gone, and the shores carry most of the wind at its end.
    assert held[-1] > 0.95 * held[0] and past[-1] > 0
    stress = 1.3 * 1.2e-3 * 20.0**2
    assert -push[-1] > 0.5 * stress * held[-1] * np.pi * 1e6
    assert abs(printed(done, "held_at")) < 0.25 * 20.0 * np.sqrt(1.56e-3 / 5.643)


@pytest.mark.slow
def test_a_cyclone_breaks_the_pack_and_drives_it_ashore(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "cyclone")
    assert 100 < printed(done, "broken") < 3000
    assert done.tables[-1]["3"][-1] < -1e6  # the shore is pushed south
    frame = done.dump("dump.cyclone")
    speed = np.hypot(frame[:, 4], frame[:, 5])
    assert 0.05 < speed.max() < 20 * np.exp(0.5) * np.sqrt(1.56e-3 / 5.643)


@pytest.mark.slow
def test_a_pillar_cuts_a_sheet(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "cylinder")
    assert printed(done, "broken") > 100
    _, load = np.loadtxt(tmp_path / "load.cylinder", unpack=True)
    # No more than crushing over the whole width and thickness (2e5 Pa x 60 m x 1 m).
    assert 1e5 < load.max() < 1.2e7
    # All of it is momentum that the ice lost: the pillar pushes back against the drift.
    assert printed(done, "impulse") < 0.0


@pytest.mark.slow
def test_packings_from_a_file_and_at_random(project: Path, tmp_path: Path) -> None:
    done = run_example(project, tmp_path, "packing")
    assert printed(done, "read") == 41
    floes = printed(done, "left")
    # Discs at rest in the plane need about four contacts each, two for each of them.
    assert floes > 500 and 1.3 * floes < printed(done, "contacts") < 3 * floes
    assert printed(done, "overlap") < 0.01 * 30
