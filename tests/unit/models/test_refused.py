# SPDX-License-Identifier: GPL-2.0-or-later
"""What the models cannot do ends with a sentence that says what to change."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.liggghts import BOND, discs, raft, run_script, write_wall

pytestmark = pytest.mark.mpi

PAIR = [(0.0, 0.0), (1.99, 0.0)]


def refused(folder: Path, script: str, ranks: int = 1) -> str:
    """What a script that must end prints."""
    done = run_script(folder, script, ranks, works=False)
    assert done.code == 1, done.out[-2000:] + done.err[-2000:]
    return done.out + done.err


@pytest.mark.parametrize("units", ["lj", "cgs", "micro"])
def test_other_units(tmp_path: Path, units: str) -> None:
    script = discs(PAIR, "").replace("units si", f"units {units}") + "run 0\n"
    assert "pair_style gran model floe: needs `units si`" in refused(tmp_path, script)


def test_three_dimensions(tmp_path: Path) -> None:
    script = discs(PAIR, "", boundary="f f f").replace("dimension 2", "dimension 3") + "run 0\n"
    assert "Fix floe/integrate needs dimension 2" in refused(tmp_path, script)


@pytest.mark.parametrize("style", ["hybrid", "hybrid/overlay"])
def test_a_part_of_a_hybrid_style(tmp_path: Path, style: str) -> None:
    script = discs(PAIR, "").replace(
        "pair_style gran model floe \npair_coeff * *",
        f"pair_style {style} gran model floe\npair_coeff * * gran",
    )
    text = refused(tmp_path, script + "run 0\n")
    assert "pair_style gran model floe cannot be a part of pair_style hybrid" in text


@pytest.mark.parametrize("what", ["run_style respa 2 2\nrun 1\n", "minimize 1e-6 1e-6 10 10\n"])
def test_other_ways_to_move(tmp_path: Path, what: str) -> None:
    text = refused(tmp_path, discs(PAIR, "") + what)
    assert "Fix floe/integrate needs the command run with run_style verlet" in text


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_periodic_box_in_which_pairs_meet_twice(tmp_path: Path, ranks: int) -> None:
    script = discs([(-19.0, 0.0), (19.0, 0.0)], "", boundary="f p p")
    narrow = script.replace("block -20 20 -20 20", "block -20 20 -2 2")
    assert "the periodic box is 4 m wide in y" in refused(tmp_path, narrow + "run 0\n", ranks)
    wide = script.replace("block -20 20 -20 20", "block -20 20 -2.3 2.3")
    run_script(tmp_path / "wide", wide + "run 1\n", ranks)


def test_walls_that_do_not_stand_upright(tmp_path: Path) -> None:
    script = discs([(0.0, 0.0)], "")
    roof = "fix wall all wall/gran model floe primitive type 2 zplane -0.9\nrun 1\n"
    says = "the wall's point nearest to element 1 is not at z = 0: walls must stand upright"
    assert says in refused(tmp_path / "plane", script + roof)
    (tmp_path / "mesh").mkdir()
    write_wall(tmp_path / "mesh/wall.stl", [(0.5, -3.0), (0.5, 3.0)])
    text = (tmp_path / "mesh/wall.stl").read_text()
    # Its upper edge hangs over.
    (tmp_path / "mesh/wall.stl").write_text(text.replace("0.5 -3.0 4.0", "-1.5 -3.0 4.0"))
    mesh = (
        "fix face all mesh/surface file wall.stl type 2\n"
        "fix wall all wall/gran model floe mesh n_meshes 1 meshes face\nrun 1\n"
    )
    assert says in refused(tmp_path / "mesh", script + mesh)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("gap one thickness 1", "floe_bonds: gap must be a number"),
        ("gap 1", "floe_bonds needs gap (not negative), thickness and width (above 0)"),
        ("gap 1 thickness", "floe_bonds needs gap"),
        ("gap 1 thickness 1 breadth 2", "floe_bonds: unknown keyword breadth"),
    ],
)
def test_words_of_floe_bonds(tmp_path: Path, words: str, says: str) -> None:
    assert says in refused(tmp_path, raft() + f"run 0\nfloe_bonds {words}\n")


def test_a_bond_that_is_longer_than_neighbours_reach(tmp_path: Path) -> None:
    script = discs([(0.0, 0.0), (2.1, 0.0)], "bonds yes reach 1.01")
    text = refused(tmp_path, script + "run 0\nfloe_bonds gap 0.2 thickness 1\n")
    assert "floe_bonds: a bond is longer than the pair style's reach" in text


def test_what_liggghts_has_for_three_dimensions_only(tmp_path: Path) -> None:
    """Its own sentences: on the screen and on standard error, and nothing behind them."""
    script = discs(PAIR, "")
    insert = "fix one all particletemplate/sphere 15485863 atom_type 1 density constant 900 "
    done = run_script(tmp_path / "insert", script + insert + "radius constant 1.0\n", works=False)
    says = "ERROR: Fix particletemplate/sphere (id one): this fix is for 3D simulations only ("
    for text in (done.out, done.err):
        (line,) = (line for line in text.splitlines() if line.startswith(says))
        assert line.endswith(")") and line.isascii()
    assert "�" not in done.out + done.err
    pair = "group a id 1\ngroup b id 2\ncompute f a group/group b\nrun 0\n"
    says = "Pair style does not support compute group/group"
    assert says in refused(tmp_path / "group", script + pair)
    body = "group body id 1\nfix body body multisphere\nrun 0\n"
    assert "ERROR: " in refused(tmp_path / "body", script + body)


def test_fixes_that_need_what_is_not_there(tmp_path: Path) -> None:
    no_fix = discs(PAIR, "").split("fix motion")[0] + "run 0\n"
    assert "needs fix floe/integrate" in refused(tmp_path / "fix", no_fix)
    log = discs(PAIR, "") + "fix log all floe/breakage 10\nrun 0\n"
    assert "needs pair_style gran model floe bonds yes" in refused(tmp_path / "log", log)
    walls = discs(PAIR, "").split("pair_style")[0]
    walls += "fix w all wall/gran model floe primitive type 1 xplane 0.0\nrun 0\n"
    assert "needs pair_style gran model floe before it" in refused(tmp_path / "wall", walls)
    assert "WARNING" not in run_script(tmp_path / "all", raft() + BOND + "run 1\n").out


@pytest.mark.parametrize("style", ["nve/sphere", "nve/noforce", "move linear 1 0 0"])
def test_floes_that_two_fixes_move(tmp_path: Path, style: str) -> None:
    text = refused(tmp_path, discs(PAIR, "") + f"fix two all {style}\nrun 1\n")
    assert "2 floes of its group are moved by another fix too (two)" in text


def test_lists_that_are_made_once(tmp_path: Path) -> None:
    script = discs(PAIR, "").replace("check yes", "check yes once yes") + "run 1\n"
    assert "neigh_modify once yes floes that meet later" in refused(tmp_path, script)


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize(
    "words",
    [
        "neigh_modify exclude group a b\n",
        "neigh_modify exclude type 2 2\nset group all type 2\n",
        "displace_atoms b move 9 0 0 units box\n",
    ],
)
def test_bonds_of_floes_that_are_no_neighbours_any_more(
    tmp_path: Path, words: str, ranks: int
) -> None:
    script = discs([(0.0, 0.0), (2.0, 0.0)], "bonds yes compressive_strength 1e9 reach 1.3")
    script += "group a id 1\ngroup b id 2\nrun 0\nfloe_bonds gap 0.1 thickness 1\nrun 10\n"
    run_script(tmp_path / "works", script + "run 1\n", ranks)
    says = "1 bonds would be lost, because their floes are no neighbours any more"
    assert says in refused(tmp_path / "not", script + words + "run 1\n", ranks)
