# SPDX-License-Identifier: GPL-2.0-or-later
"""Speed of the discrete element model beside stock LIGGGHTS: ``make bench-dem``.

Started plainly it starts itself on two ranks. The first rank runs the cases of one rank, all of
them in turn in each repeat, while the second sleeps; then both run those of two ranks. Rafts far
beyond the caches are held against what the bandwidth of the memory allows, and ratios to stock
against those of the last release. It prints tables and writes ``results/benchmarks/dem.json``.
"""

from __future__ import annotations

import argparse
import contextlib
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from demcases import Own, Stock, kinetic_energy, resident_bytes
from mpi4py import MPI
from roofline import bytes_per_step, stream_bandwidth
from versions import Version

from floeflow.core.mpi import mpi_environment
from floeflow.core.records import Record, write_records

OUT = Path("results") / "benchmarks" / "dem.json"


@dataclass(frozen=True)
class Plan:
    """Columns and rows of the raft, of ten times it and of a huge one; steps of a turn, repeats."""

    size: tuple[int, int]
    large: tuple[int, int]
    huge: tuple[int, int]
    steps: int
    repeats: int


# Ratios to stock of the last release, on idle cores of an Intel Xeon (docs/performance.md). Stock
# LIGGGHTS stays the same and runs in turn with ours: they tell how the versions compare, if roughly
# on another processor. `--against` is exact.
RELEASE = "0.1.0"
RELEASED = {"unbonded": 4.7, "unbonded_friction": 3.5, "bonded": 2.9}

FULL = Plan((125, 120), (395, 380), (1000, 1000), 300, 7)
QUICK = Plan((20, 15), (60, 50), (60, 50), 20, 5)


def timed(comm: MPI.Comm, program: Own | Stock, steps: int) -> float:
    """Wall seconds of a number of steps, ranks in step."""
    comm.barrier()
    start = time.perf_counter()
    program.run(steps)
    comm.barrier()
    return time.perf_counter() - start


def one_rank(plan: Plan, folder: Path) -> list[Record]:
    """Cases of one rank, interleaved, and the same raft ten times as large."""
    comm = MPI.COMM_SELF
    programs: dict[str, Own | Stock] = {
        "stock_hooke_history": Stock(comm, plan.size, folder),
        "unbonded": Own(comm, plan.size, folder, bonds=False, friction=False),
        "unbonded_friction": Own(comm, plan.size, folder, bonds=False, friction=True),
        "bonded": Own(comm, plan.size, folder, bonds=True, friction=True),
    }
    # What an option costs: beside the same without it.
    options: dict[str, Own] = {
        name + ("_bonded" if bonds else ""): Own(
            comm, plan.size, folder, bonds=bonds, friction=True, **{name: True}
        )
        for name in ("deterministic", "exact_losses", "ridging")
        for bonds in (False, True)
    }
    # What wind and water cost, and means of them over discs.
    options |= {
        f"driven_{at}": Own(comm, plan.size, folder, bonds=False, friction=True, driven=at)
        for at in ("centre", "cell")
    }
    large = {
        "unbonded_friction_10x": Own(comm, plan.large, folder, bonds=False, friction=True),
        "bonded_10x": Own(comm, plan.large, folder, bonds=True, friction=True),
    }
    with contextlib.ExitStack() as stack:
        memory: dict[str, int] = {}
        for name, program in [*large.items(), *programs.items(), *options.items()]:
            before = resident_bytes()
            stack.enter_context(program)
            program.run(2)
            memory[name] = resident_bytes() - before
        alike = likeness(programs)
        seconds: dict[str, list[float]] = {name: [] for name in [*programs, *options, *large]}
        for _ in range(plan.repeats):
            for name, program in [*programs.items(), *options.items()]:
                seconds[name].append(timed(comm, program, plan.steps))
            for name, program in large.items():
                seconds[name].append(timed(comm, program, plan.steps))
        records = []
        for name, program in programs.items():
            peer = "stock_hooke_history"
            extra = {**figures(plan.size, program, plan.steps, seconds[name], memory[name])}
            if name == peer:
                records.append(Record(name, count(plan.size), 1, seconds[name], extra=extra))
                continue
            if name == "unbonded_friction":
                extra |= alike
            peers = seconds[peer]
            records.append(Record(name, count(plan.size), 1, seconds[name], peer, peers, extra))
        for name, program in options.items():
            peer = "bonded" if name.endswith("_bonded") else "unbonded_friction"
            peer = "driven_centre" if name == "driven_cell" else peer
            extra = figures(plan.size, program, plan.steps, seconds[name], memory[name])
            peers = seconds[peer]
            records.append(Record(name, count(plan.size), 1, seconds[name], peer, peers, extra))
        for name, program in large.items():
            # As many steps as the small raft: both read out once in a turn.
            peer = name.removesuffix("_10x")
            extra = figures(plan.large, program, plan.steps, seconds[name], memory[name])
            peers = seconds[peer]
            record = Record(name, count(plan.large), 1, seconds[name], peer, peers, extra)
            grown = count(plan.large) / count(plan.size)
            extra["times_the_elements"] = grown
            extra["times_the_seconds"] = median(
                t / p for t, p in zip(seconds[name], peers, strict=True)
            )
            records.append(record)
    return records


def huge_rafts(plan: Plan, folder: Path) -> list[Record]:
    """Both loops on a raft far beyond the caches, with all that a window does besides its steps."""
    records = []
    steps = max(plan.steps // 15, 5)
    for name, bonds in (("unbonded_friction_huge", False), ("bonded_huge", True)):
        program = Own(MPI.COMM_SELF, plan.huge, folder, bonds=bonds, friction=True)
        before, bandwidth = resident_bytes(), stream_bandwidth()
        start = time.perf_counter()
        with program:
            set_up = time.perf_counter() - start
            program.run(2)
            memory = resident_bytes() - before
            seconds = [timed(MPI.COMM_SELF, program, steps) for _ in range(plan.repeats)]
            bandwidth = max(bandwidth, stream_bandwidth())
            start = time.perf_counter()
            program.read_out()
            read_out = time.perf_counter() - start
            program.new_lists(True)
            lists = timed(MPI.COMM_SELF, program, 5) / 5 - median(seconds) / steps
            program.new_lists(False)
            extra = figures(plan.huge, program, steps, seconds, memory)
            extra |= {"set_up_s": set_up, "read_out_s": read_out, "new_lists_s": lists}
            extra |= roofline(plan.huge, program, bandwidth, median(seconds) / steps)
        records.append(Record(name, count(plan.huge), 1, seconds, extra=extra))
    return records


def roofline(
    size: tuple[int, int], program: Own, bandwidth: float, seconds: float
) -> dict[str, float]:
    """Bytes that a step must move, and the share of the memory's bandwidth that it reaches."""
    moved = bytes_per_step(count(size), *program.pairs())
    return {
        "stream_bytes_per_s": bandwidth,
        "bytes_per_step": moved,
        "share_of_bandwidth": moved / seconds / bandwidth,
    }


def other_version(plan: Plan, folder: Path) -> list[Record]:
    """The version here in turn with that of another folder."""
    rafts = {
        f"{loop}{name}": (size, bonds)
        for name, size in (("", plan.size), ("_10x", plan.large))
        for loop, bonds in (("unbonded_friction", False), ("bonded", True))
    }
    with Version(Path(__file__).parents[1], rafts) as own, Version(folder, rafts) as other:
        records = []
        for raft, (size, _) in rafts.items():
            pairs = [
                (own.seconds(raft, plan.steps), other.seconds(raft, plan.steps))
                for _ in range(plan.repeats)
            ]
            seconds, peers = (list(column) for column in zip(*pairs, strict=True))
            extra = {
                "steps": plan.steps,
                "element_steps_per_s": count(size) * plan.steps / median(seconds),
            }
            name = f"{raft}_beside"
            records.append(Record(name, count(size), 1, seconds, "other version", peers, extra))
        return records


def two_ranks(plan: Plan, folder: Path) -> list[Record]:
    """Both ranks on one raft, in turn with the first rank alone (the second sleeps)."""
    records = []
    world = MPI.COMM_WORLD
    for bonds in (False, True):
        name = "bonded" if bonds else "unbonded_friction"
        with contextlib.ExitStack() as stack:
            both = stack.enter_context(Own(world, plan.size, folder, bonds=bonds, friction=True))
            alone = None
            if world.rank == 0:
                alone = Own(MPI.COMM_SELF, plan.size, folder, bonds=bonds, friction=True)
                stack.enter_context(alone)
            seconds, peers = [], []
            for _ in range(plan.repeats):
                seconds.append(timed(world, both, plan.steps))
                if alone is not None:
                    peers.append(timed(MPI.COMM_SELF, alone, plan.steps))
                sleep_until_all(world)
            extra = figures(plan.size, both, plan.steps, seconds, None)
            records.append(
                Record(f"{name}_2_ranks", count(plan.size), 2, seconds, name, peers, extra)
            )
    return records


def sleep_until_all(comm: MPI.Comm) -> None:
    """Barrier that leaves the core to others while it waits."""
    request = comm.Ibarrier()
    while not request.Test():
        time.sleep(0.005)


def likeness(programs: dict[str, Own | Stock]) -> dict[str, Any]:
    """Whether the peers do the same physics: after the first steps, energy and positions."""
    own, stock = programs["unbonded_friction"].state(), programs["stock_hooke_history"].state()
    e_own, e_stock = kinetic_energy(own), kinetic_energy(stock)
    apart = max(float(abs(own[k] - stock[k]).max()) for k in ("x", "y"))
    return {"kinetic_energy_over_peer": e_own / e_stock, "position_apart_m": apart}


def count(size: tuple[int, int]) -> int:
    """Elements of a raft."""
    return size[0] * size[1]


def figures(
    size: tuple[int, int],
    program: Own | Stock,
    steps: int,
    seconds: list[float],
    memory: int | None,
) -> dict[str, Any]:
    """Further figures of a record."""
    typical = median(seconds)
    extra: dict[str, Any] = {
        "steps": steps,
        "element_steps_per_s": count(size) * steps / typical,
    }
    if memory is not None:
        extra["bytes_per_element"] = memory / count(size)
    if isinstance(program, Own):
        extra["pairs"] = sum(program.pairs())
        extra["pair_steps_per_s"] = extra["pairs"] * steps / typical
    return extra


def table(records: list[Record]) -> str:
    """Records as lines of text."""
    lines = [
        f"{'case':26}{'n':>8}{'ranks':>6}{'median s':>10}{'M element-steps/s':>19}"
        f"{'M pair-steps/s':>16}{'bytes/element':>15}  ratio"
    ]
    for r in records:
        pairs = f"{r.extra['pair_steps_per_s'] / 1e6:.1f}" if "pairs" in r.extra else ""
        memory = f"{r.extra['bytes_per_element']:.0f}" if "bytes_per_element" in r.extra else ""
        ratio = f"{r.ratio_median:.2f} x {r.peer}" if r.ratio_median is not None else ""
        lines.append(
            f"{r.name:26}{r.n:8d}{r.ranks:6d}{median(r.seconds):10.3f}"
            f"{r.extra['element_steps_per_s'] / 1e6:19.1f}{pairs:>16}{memory:>15}  {ratio}"
        )
    grown = [r for r in records if "times_the_seconds" in r.extra]
    lines += [
        f"{r.name}: {r.extra['times_the_elements']:.1f} x the elements of {r.peer}, "
        f"{r.extra['times_the_seconds']:.1f} x its time"
        for r in grown
    ]
    lines += [
        f"{r.name}: {r.extra['bytes_per_step'] / r.n:.0f} bytes an element and step, "
        f"{100 * r.extra['share_of_bandwidth']:.0f} % of {r.extra['stream_bytes_per_s'] / 1e9:.1f}"
        f" GB/s; set-up {r.extra['set_up_s']:.1f} s, read out {r.extra['read_out_s']:.1f} s, new "
        f"lists {r.extra['new_lists_s']:.2f} s"
        for r in records
        if "share_of_bandwidth" in r.extra
    ]
    lines += [
        f"{r.name}: {r.ratio_median / RELEASED[r.name]:.2f} x release {RELEASE}, by the ratios to "
        f"{r.peer}"
        for r in records
        if r.name in RELEASED and r.ratio_median is not None and r.n == count(FULL.size)
    ]
    return "\n".join(lines)


def inside(plan: Plan, out: Path, against: Path | None) -> None:
    """Run on two ranks; the first writes."""
    world = MPI.COMM_WORLD
    with tempfile.TemporaryDirectory() as folder:
        records = []
        if world.rank == 0:
            records = one_rank(plan, Path(folder)) + huge_rafts(plan, Path(folder))
            records += other_version(plan, against) if against else []
        sleep_until_all(world)
        records += two_ranks(plan, Path(folder))
    if world.rank == 0:
        write_records(records, out)
        print(table(records))
        print(f"written to {out}")


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a small raft for seconds, as a test")
    parser.add_argument("--out", type=Path, default=OUT, help="file for the records")
    parser.add_argument(
        "--against", type=Path, help="another version to run in turn with: a checkout, set up"
    )
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.inside:
        inside(QUICK if given.quick else FULL, given.out, given.against)
        return 0
    command = ["mpirun", "-n", "2", sys.executable, __file__, "--inside", "--out", str(given.out)]
    command += ["--quick"] if given.quick else []
    command += ["--against", str(given.against)] if given.against else []
    return subprocess.run(command, env=mpi_environment(), check=False).returncode


if __name__ == "__main__":
    raise SystemExit(main())
