# SPDX-License-Identifier: GPL-2.0-or-later
"""A bonded square under a surface stress that grows outward: aggregates, ranks, restart."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.core.mpi import mpi_environment
from floeflow.dynamics.engine.engine import Engine
from floeflow.state.bonds import Arrays
from support.contact import figures
from support.contact import hopkins_square as case

SHORT = 200e3  # side of the square of the short forms, m
SMALLEST = 3  # elements: aggregates from this size on enter the exponent


def torn(
    log: Path, seed: int, seconds: float, side: float = case.SIDE
) -> tuple[Arrays, Arrays, np.ndarray, float]:
    """Elements, bonds and aggregate numbers at the end; share of bonds that broke."""
    elements, bonds = case.square(seed, side)
    params = case.stable(elements, bonds)
    with Engine(MPI.COMM_SELF, params, log) as engine:
        engine.load(elements, bonds)
        engine.set_forcing(case.outward_wind(params, side))
        engine.run(round(seconds / params.time_step))
        out, held, sums = engine.elements(), engine.bonds(), engine.diagnostics()
    broken = sums["bonds_broken"] / len(bonds["id_lo"])
    return out, held, case.aggregates(len(elements["id"]), held), broken


def test_the_square_holds_what_it_should() -> None:
    elements, bonds = case.square(1, SHORT)
    assert elements["ice_area"].sum() == pytest.approx(SHORT**2, rel=1e-12)
    assert elements["radius"].min() >= 3e3 and elements["radius"].max() <= 5e3
    assert case.aggregates(len(elements["id"]), bonds).max() == 0  # one piece
    # Known exponent: sizes drawn from a power law.
    random = np.random.default_rng(0)
    sizes = np.floor(2.5 * (1 - random.uniform(size=20_000)) ** (-1 / 1.2) + 0.5)
    alpha, error, _ = case.exponent(sizes, SMALLEST)
    assert abs(alpha - 2.2) < 3 * error + 0.02


def test_it_fragments_into_aggregates(log: Path) -> None:
    out, _, number, broken = torn(log, 1, 2000.0, SHORT)
    sizes = np.bincount(number)
    assert 0.1 < broken < 0.9
    assert sizes.max() < 0.3 * len(number) and (sizes >= SMALLEST).sum() > 10
    _, error, count = case.exponent(sizes, SMALLEST)
    assert count == (sizes >= SMALLEST).sum() and error < 0.5
    # The pieces move outward.
    assert (out["x"] * out["u"] + out["y"] * out["v"] > 0).mean() > 0.9


@pytest.mark.slow
def test_exponent_of_aggregate_sizes_over_ten_seeds(log: Path, show) -> None:
    runs = [torn(log, seed, 30_000.0) for seed in range(1, 11)]
    sizes = [np.bincount(number) for _, _, number, _ in runs]
    single = np.array([case.exponent(s, SMALLEST)[:2] for s in sizes])
    alpha, error, count = case.exponent(np.concatenate(sizes), SMALLEST)
    print(f"exponent {alpha:.3f} +- {error:.3f} from {count} aggregates; seeds: {single[:, 0]}")
    assert error < 0.1
    assert np.abs(single[:, 0] - alpha).max() < 4 * single[:, 1].max()
    every = np.sort(np.concatenate(sizes))[::-1]
    rank = np.arange(1, len(every) + 1)
    tail = every >= SMALLEST
    fit = count * (every[tail] / SMALLEST) ** (1 - alpha)
    lines = {f"exponent {alpha:.2f} ± {error:.2f}": (every[tail], fit)}
    show(
        "uniform_stress_sizes", figures.curves, lines, {"ten seeds": (every, rank)},
        "elements in an aggregate", "aggregates of at least that size", "log",
    )  # fmt: skip
    out, _, number, _ = runs[0]
    show("uniform_stress_map", figures.aggregates, out, number)


Result = dict[str, np.ndarray]


def on_ranks(
    folder: Path, ranks: int, side: float, start: Path | None = None, deterministic: bool = False
) -> dict[int, Result]:
    folder.mkdir(parents=True)
    tests = Path(__file__).parents[2]
    command = [
        "mpirun",
        "-n",
        str(ranks),
        sys.executable,
        str(tests / "support/contact/hopkins_square.py"),
    ]
    command += [str(folder), str(side)] + ([str(start)] if start else [])
    command += ["deterministic"] if deterministic else []
    path = os.pathsep.join([str(tests), os.environ.get("PYTHONPATH", "")])
    environment = mpi_environment() | {"PYTHONPATH": path}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    out = {}
    for step in (case.CUT, case.LAST):
        if (folder / f"{step}.npz").exists():
            with np.load(folder / f"{step}.npz") as data:
                out[step] = {name: data[name] for name in data.files}
    return out


@pytest.fixture(scope="module")
def ranks(tmp_path_factory: pytest.TempPathFactory) -> dict[int, dict[int, Result]]:
    folder = tmp_path_factory.mktemp("ranks")
    return {n: on_ranks(folder / str(n), n, SHORT) for n in (1, 2)}


def same_ice(one: Result, two: Result) -> None:
    for name in ("bond.id_lo", "bond.id_hi"):
        np.testing.assert_array_equal(two[name], one[name])
    for name in ("bond.crack_a", "bond.crack_b"):
        np.testing.assert_array_equal(two[name] > 0, one[name] > 0)
        # A crack ends where the strength is met, after some 0.5 m of displacement: what positions
        # may differ by, 4e-4 m, moves it by 1e-3 of the line.
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-3)
    for name in ("element.x", "element.y"):
        scale = np.ptp(one[name])
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-9 * scale)


@pytest.mark.mpi
def test_one_and_two_ranks_agree_over_1000_steps(ranks: dict[int, dict[int, Result]]) -> None:
    cut, last = (ranks[1][step] for step in (case.CUT, case.LAST))
    assert len(last["bond.id_lo"]) < 0.98 * len(cut["bond.id_lo"])  # cut in the midst of it
    assert ((cut["bond.crack_a"] + cut["bond.crack_b"]) > 0).sum() > 20
    for step in (case.CUT, case.LAST):
        same_ice(ranks[1][step], ranks[2][step])


def same_bits(one: Result, two: Result) -> None:
    assert one.keys() == two.keys()
    for name, values in one.items():
        np.testing.assert_array_equal(two[name], values, err_msg=name)


@pytest.mark.mpi
def test_deterministic_sums_give_the_same_bits_on_any_ranks(
    ranks: dict[int, dict[int, Result]], tmp_path: Path
) -> None:
    runs = {n: on_ranks(tmp_path / str(n), n, SHORT, deterministic=True) for n in (1, 2, 4)}
    for n in (2, 4):
        for step in (case.CUT, case.LAST):
            same_bits(runs[1][step], runs[n][step])
    # And the same ice as without.
    same_ice(ranks[1][case.CUT], runs[1][case.CUT])
    state = tmp_path / "state.npz"
    np.savez(state, **runs[4][case.CUT])
    again = on_ranks(tmp_path / "again", 2, SHORT, state, deterministic=True)
    same_bits(runs[1][case.LAST], again[case.LAST])


@pytest.mark.mpi
def test_a_state_cut_in_the_midst_of_fracture_continues_on_two_ranks(
    ranks: dict[int, dict[int, Result]], tmp_path: Path
) -> None:
    state = tmp_path / "state.npz"
    np.savez(state, **ranks[1][case.CUT])
    again = on_ranks(tmp_path / "again", 2, SHORT, state)[case.LAST]
    same_ice(ranks[1][case.LAST], again)


@pytest.mark.mpi
@pytest.mark.slow
def test_the_whole_square_on_one_two_and_four_ranks(tmp_path: Path) -> None:
    runs = {n: on_ranks(tmp_path / str(n), n, case.SIDE) for n in (1, 2, 4)}
    for n in (2, 4):
        for step in (case.CUT, case.LAST):
            same_ice(runs[1][step], runs[n][step])
    for before, after in ((1, 1), (1, 2), (4, 1)):
        state = tmp_path / f"{before}.npz"
        np.savez(state, **runs[before][case.CUT])
        again = on_ranks(tmp_path / f"{before}.{after}", after, case.SIDE, state)
        same_ice(runs[before][case.LAST], again[case.LAST])
