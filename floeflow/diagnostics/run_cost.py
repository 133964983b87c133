# SPDX-License-Identifier: GPL-2.0-or-later
"""What the run cost: wall time and memory by rule, and by part inside the windows."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from floeflow.core.errors import FloeError

WINDOW = "windows"
ORDER = (
    "land",
    "mask",
    "packing",
    "bonds",
    "cells",
    "initial",
    WINDOW,
    "fields",
    "grid",
    "tendencies",
    "diagnostics",
)


@dataclass(frozen=True)
class Stage:
    """What a stage cost."""

    name: str
    jobs: int
    seconds: float
    memory: float = math.nan
    inner: bool = False
    element_steps_per_s: float = math.nan


def stages(benchmarks: Sequence[Path], diagnosed: Mapping[str, Any]) -> list[Stage]:
    """Cost by rule in the order of the way of the data.

    Rules are timed by Snakemake, the windows by themselves, part by part: they share one launch,
    so Snakemake knows them only by the group, start of the interpreter included.

    Parameters
    ----------
    benchmarks : sequence of Path
        Tab-separated files named by rule, or by number in a folder named by rule.
    diagnosed : mapping
        ``diagnostics.json``.

    Returns
    -------
    list of Stage
        Wall time (s) and memory (MB) of each rule, parts of the windows behind theirs.

    Raises
    ------
    FloeError
        For a file that is no benchmark.
    """
    rules: dict[str, list[tuple[float, float]]] = {}
    for path in benchmarks:
        stem = re.sub(r"[_.-]?\d*$", "", path.stem) or path.parent.name
        rules.setdefault(stem, []).append(read_benchmark(path))
    numbers = diagnosed["headline"]
    found = []
    for name, jobs in rules.items():
        seconds = sum(job[0] for job in jobs)
        memory = max((job[1] for job in jobs if math.isfinite(job[1])), default=math.nan)
        found.append(Stage(name, len(jobs), seconds, memory))
    parts = dict(diagnosed["window_seconds"])
    if WINDOW not in rules:
        found.append(Stage(WINDOW, numbers["windows"], sum(parts.values())))
    found.sort(key=lambda stage: ORDER.index(stage.name) if stage.name in ORDER else len(ORDER))
    place = 1 + next(k for k, stage in enumerate(found) if stage.name == WINDOW)
    speed = {"dynamics": numbers["element_steps_per_s"]}
    found[place:place] = [
        Stage(name, numbers["windows"], seconds, math.nan, True, speed.get(name, math.nan))
        for name, seconds in parts.items()
    ]
    return found


def total_seconds(found: Sequence[Stage]) -> float:
    """Wall seconds of all rules; the windows' parts are in their rule's.

    Parameters
    ----------
    found : sequence of Stage
        Of the run.

    Returns
    -------
    float
        s.
    """
    return sum(stage.seconds for stage in found if not stage.inner)


def read_benchmark(path: Path) -> tuple[float, float]:
    """Wall seconds (summed over repeats) and largest memory (MB) of a benchmark file.

    Parameters
    ----------
    path : Path
        Of Snakemake's benchmark.

    Returns
    -------
    seconds : float
        s.
    size : float
        MB, NaN where none is told.

    Raises
    ------
    FloeError
        Where it is none.
    """
    try:
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file, delimiter="\t"))
        seconds = sum(float(row["s"]) for row in rows)
    except (OSError, KeyError, ValueError, TypeError):
        raise FloeError(f"{path}: is not a benchmark of Snakemake") from None
    sizes = [row.get("max_rss") or "" for row in rows]
    known = [float(size) for size in sizes if re.fullmatch(r"[0-9.]+", size)]
    return seconds, max(known, default=math.nan)
