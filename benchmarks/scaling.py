# SPDX-License-Identifier: GPL-2.0-or-later
"""The element model over ranks: ``make bench-scaling``.

Strong and weak scaling on one to eight ranks, what a rank sends in a step, how evenly a pack
that fills half of its box is shared, whether all numbers of ranks give the same. Then a figure of
what a day of the Arctic would take on up to 1024 cores (`scaling_model`). Writes
``results/benchmarks/scaling.json`` and ``scaling.png``.

More ranks than cores are run for their results; their times say nothing.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from demcases import Own, resident_bytes
from mpi4py import MPI
from scaling_model import draw

from floeflow.core.mpi import mpi_environment
from floeflow.core.records import Record, write_records
from floeflow.state.bonds import Arrays, without

OUT = Path("results") / "benchmarks" / "scaling.json"
RANKS = (1, 2, 4, 8)
# Rafts of weak scaling: as many times as wide and as high as that of one rank.
GROWN = {1: (1, 1), 2: (2, 1), 4: (2, 2), 8: (4, 2)}


@dataclass(frozen=True)
class Case:
    """What is run in one launch.

    Parameters
    ----------
    name : str
        Kind of the case.
    columns, rows : int
        Of the raft.
    ranks : int
        MPI ranks.
    steps, repeats : int
        Steps of a turn, and turns.
    bonds, deterministic : bool
        Switches of the engine.
    corner : bool
        Whether one more element lies so far away that the raft fills half of the box.
    even : bool
        Whether LIGGGHTS divides the box, into equal parts.
    """

    name: str
    columns: int
    rows: int
    ranks: int
    steps: int
    repeats: int
    bonds: bool = False
    deterministic: bool = False
    corner: bool = False
    even: bool = False


@dataclass(frozen=True)
class Plan:
    """Rafts of strong and weak scaling, steps of a turn, and turns."""

    strong: tuple[int, int]
    weak: tuple[int, int]
    steps: int
    repeats: int


FULL = Plan((245, 240), (125, 120), 100, 5)
QUICK = Plan((30, 24), (20, 15), 20, 3)


def cases(plan: Plan) -> Iterator[Case]:
    """All launches, those to be compared one after the other."""
    strong = Case("strong", *plan.strong, 1, plan.steps, plan.repeats)
    columns, rows = plan.weak
    for bonds in (False, True):
        kind = "bonded" if bonds else "contacts"
        for ranks in RANKS:
            yield replace(strong, name=f"strong_{kind}", ranks=ranks, bonds=bonds)
        for ranks in RANKS:
            wide, high = columns * GROWN[ranks][0], rows * GROWN[ranks][1]
            yield Case(f"weak_{kind}", wide, high, ranks, plan.steps, plan.repeats, bonds=bonds)
    half = replace(strong, columns=columns, rows=rows, corner=True)
    for even in (True, False):
        name = "half_full_even" if even else "half_full_cut"
        for ranks in RANKS[1:]:
            yield replace(half, name=name, ranks=ranks, even=even)
    for ranks in RANKS:
        same = replace(half, name="deterministic", ranks=ranks, deterministic=True)
        yield replace(same, repeats=1)


class Raft(Own):
    """A raft of the element model, alone or in a box that it fills by half."""

    def __init__(self, comm: MPI.Comm, case: Case, folder: Path) -> None:
        size = case.columns, case.rows
        more = {"deterministic": case.deterministic}
        super().__init__(comm, size, folder, bonds=case.bonds, friction=True, **more)
        if case.corner:
            self._elements = with_stray(self._elements)
        if case.even:
            self._engine._division = lambda *_: None  # type: ignore[method-assign]

    def counted(self, steps: int, log: Path) -> dict[str, tuple[float, float]]:
        """Advance; mean and largest number of a rank's elements, ghosts and listed neighbours."""
        self._engine._command(f"run {steps} pre no post yes")
        found = re.findall(r"^(Nlocal|Nghost|Neighs): +(\S+) ave (\S+) max", log.read_text(), re.M)
        return {name: (float(mean), float(most)) for name, mean, most in found}


def with_stray(elements: Arrays) -> Arrays:
    """A raft and one element more, as far to its right as the raft is wide."""
    stray = {name: values[-1:].copy() for name, values in elements.items()}
    stray["id"] += 1
    stray["x"][:] = 2.0 * elements["x"].max() - elements["x"].min()
    return {name: np.concatenate([values, stray[name]]) for name, values in elements.items()}


def run_case(case: Case, folder: Path) -> None:
    """Be a rank of a launch; the first writes what was found."""
    comm = MPI.COMM_WORLD
    before = resident_bytes()
    with Raft(comm, case, folder) as raft:
        raft.run(2)
        memory = comm.allreduce(resident_bytes() - before, MPI.MAX)
        seconds = []
        for _ in range(case.repeats if case.steps else 0):
            comm.barrier()
            began = time.perf_counter()
            raft.run(case.steps)
            comm.barrier()
            seconds.append(time.perf_counter() - began)
        counts = raft.counted(1, folder / "log.own")
        began = time.perf_counter()
        state = without(raft.state(), np.zeros(0, np.int64))
        gathered = comm.allreduce(time.perf_counter() - began, MPI.MAX)
    if comm.rank == 0:
        np.savez(folder / "state.npz", **state)
        n = len(state["id"])
        found = {"n": n, "seconds": seconds, "gather_seconds": gathered, "memory": memory}
        (folder / "found.json").write_text(json.dumps({**found, "counts": counts}))


def launch(case: Case, folder: Path, watched: bool = False) -> tuple[dict[str, Any], Arrays]:
    """Run a case on its ranks; what it found, and the elements at its end.

    Where ``watched``, Open MPI writes down what each rank sends.
    """
    folder.mkdir(parents=True, exist_ok=True)
    environment = mpi_environment()
    if watched:
        environment["OMPI_MCA_pml_monitoring_enable"] = "2"
        environment["OMPI_MCA_pml_monitoring_enable_output"] = "3"
        environment["OMPI_MCA_pml_monitoring_filename"] = str(folder / "sent")
    command = ["mpirun", "-n", str(case.ranks), sys.executable, __file__]
    command += ["--case", json.dumps(asdict(case)), "--folder", str(folder)]
    subprocess.run(command, env=environment, check=True)
    with np.load(folder / "state.npz") as data:
        state = {name: data[name] for name in data.files}
    return json.loads((folder / "found.json").read_text()), state


def sent(folder: Path) -> tuple[int, int]:
    """Bytes and messages of the rank that sends most, to its neighbours."""
    found = []
    for path in folder.glob("sent.*.prof"):
        rows = re.findall(r"^E\s+\d+\s+\d+\s+(\d+) bytes\s+(\d+) msgs", path.read_text(), re.M)
        found.append((sum(int(b) for b, _ in rows), sum(int(m) for _, m in rows)))
    return max(found, default=(0, 0))


def volume(case: Case, folder: Path) -> dict[str, float]:
    """What the busiest rank sends in a step: of two runs, one without steps."""
    totals = []
    for steps in (0, case.steps):
        part = folder / f"watched{steps}"
        launch(replace(case, steps=steps, repeats=1), part, watched=True)
        totals.append(sent(part))
    (b0, m0), (b1, m1) = totals
    return {"bytes_a_step": (b1 - b0) / case.steps, "messages_a_step": (m1 - m0) / case.steps}


def record(case: Case, found: dict[str, Any], peer: Record | None) -> Record:
    """A launch as a record, beside its peer."""
    mean, most = found["counts"]["Nlocal"]
    n, seconds = found["n"], found["seconds"]
    extra = {
        "steps": case.steps,
        "element_steps_per_s": n * case.steps / median(seconds),
        "oversubscribed": case.ranks > len(os.sched_getaffinity(0)),
        "elements_a_rank": most,
        "imbalance": most / mean,
        "ghosts_a_rank": found["counts"]["Nghost"][1],
        "neighbours_a_rank": found["counts"]["Neighs"][1],
        "gather_seconds": found["gather_seconds"],
        "bytes_per_element": found["memory"] * case.ranks / n,
    }
    if peer is None:
        return Record(case.name, n, case.ranks, seconds, extra=extra)
    name = f"{peer.name} on {peer.ranks}"
    return Record(case.name, n, case.ranks, seconds, name, peer.seconds, extra=extra)


def likeness(state: Arrays, one: Arrays) -> dict[str, Any]:
    """Whether two ends are the same, to the bit and in place (m)."""
    apart = max(float(np.abs(state[axis] - one[axis]).max()) for axis in ("x", "y"))
    same = all(np.array_equal(state[name], one[name]) for name in one)
    return {"apart_m": apart, "same_bits": same}


def measure(plan: Plan, folder: Path) -> list[Record]:
    """Run all cases."""
    records: list[Record] = []
    ends: dict[tuple[str, int], Arrays] = {}
    for number, case in enumerate(cases(plan)):
        part = folder / str(number)
        found, state = launch(case, part)
        # One rank, or the box that LIGGGHTS divides.
        beside = ("half_full_even", case.ranks) if case.name == "half_full_cut" else (case.name, 1)
        peer = next((r for r in records if (r.name, r.ranks) == beside), None)
        made = record(case, found, peer)
        if peer is not None and peer.n == made.n:
            made.extra.update(likeness(state, ends[beside]))
        if case.name.startswith("strong") and case.ranks > 1:
            made.extra.update(volume(case, part))
        ends[case.name, case.ranks] = state
        records.append(made)
    return records


def table(records: list[Record]) -> str:
    """Records as lines of text."""
    lines = [
        f"{'case':18}{'n':>8}{'ranks':>6}{'s':>9}{'M el.-steps/s':>14}{'imbalance':>10}"
        f"{'ghosts':>8}{'pairs':>9}{'B/step':>9}{'apart m':>10}  same bits"
    ]
    for r in records:
        e = r.extra
        sends = f"{e['bytes_a_step']:.0f}" if "bytes_a_step" in e else ""
        apart = f"{e['apart_m']:.1e}" if "apart_m" in e else ""
        note = " (oversubscribed)" if e["oversubscribed"] else ""
        lines.append(
            f"{r.name:18}{r.n:8d}{r.ranks:6d}{median(r.seconds):9.3f}"
            f"{e['element_steps_per_s'] / 1e6:14.1f}{e['imbalance']:10.2f}"
            f"{e['ghosts_a_rank']:8.0f}{e['neighbours_a_rank']:9.0f}{sends:>9}{apart:>10}"
            f"  {e.get('same_bits', '')}{note}"
        )
    return "\n".join(lines)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small rafts for seconds, as a test")
    parser.add_argument("--out", type=Path, default=OUT, help="file for the records")
    parser.add_argument("--figure", type=Path, help="file for the figure (beside the records)")
    parser.add_argument("--case", help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.case:
        run_case(Case(**json.loads(given.case)), given.folder)
        return
    with tempfile.TemporaryDirectory() as folder:
        records = measure(QUICK if given.quick else FULL, Path(folder))
    write_records(records, given.out)
    figure = given.figure or given.out.with_suffix(".png")
    draw(figure)
    print(table(records))
    print(f"written to {given.out} and {figure}")


if __name__ == "__main__":
    main()
