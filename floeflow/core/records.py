# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark record: what was timed, on what, against whom.

A file under ``results/benchmarks/`` is a list of such records. A ratio is speed over the peer's
speed: above 1 is faster than the peer.
"""

from __future__ import annotations

import json
import os
import platform
import resource
import subprocess
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from pathlib import Path
from statistics import median
from typing import Any

from floeflow.core.atomic_write import write_text

# Key of a window's last record: CPU seconds of the first rank for all of the window.
WINDOW_CPU = "window_cpu_seconds"


@dataclass(frozen=True)
class Record:
    """One timed case.

    Parameters
    ----------
    name : str
        What was timed.
    n : int
        Its size (elements, columns, nodes).
    ranks : int
        MPI ranks or threads.
    seconds : list of float
        Wall seconds of each repeat.
    peer : str
        With what it was timed in turn; empty without a peer.
    peer_seconds : list of float
        Wall seconds of the peer's repeats, in the same order.
    extra : dict
        Further figures, such as ``steps`` or ``element_steps_per_s``.
    """

    name: str
    n: int
    ranks: int
    seconds: list[float]
    peer: str = ""
    peer_seconds: list[float] = field(default_factory=list)
    extra: dict[str, Any] = field(default_factory=dict)

    @property
    def ratio_median(self) -> float | None:
        """Median over repeats of peer's time / own time; None without a peer."""
        pairs = zip(self.peer_seconds, self.seconds, strict=True) if self.peer else ()
        ratios = [peer / own for peer, own in pairs]
        return median(ratios) if ratios else None

    def as_dict(self) -> dict[str, Any]:
        """Return the record as it stands in the file, with version and machine."""
        data = asdict(self)
        extra = data.pop("extra")
        return {
            **data,
            "repeats": len(self.seconds),
            "ratio_median": self.ratio_median,
            "git": git_version(),
            "machine": machine(),
            **extra,
        }


def write_records(records: list[Record], path: Path) -> None:
    """Write records as a JSON list, atomically.

    Parameters
    ----------
    records : list of Record
        Of the stages.
    path : Path
        Replaced in one step.

    Raises
    ------
    FloeError
        Where it cannot be written.
    """
    write_text(json.dumps([record.as_dict() for record in records], indent=1), path)


def cpu_seconds() -> float:
    """CPU seconds of this process and of the children that it waited for."""
    own, children = (
        resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def peak_memory() -> tuple[float, float]:
    """Largest memory that this process had, and that of the largest of its children, MB.

    Resident memory; of children that were waited for, and theirs, such as MPI ranks.
    """
    own, child = (
        resource.getrusage(who).ru_maxrss
        for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return own * 1024 / 1e6, child * 1024 / 1e6


def machine() -> str:
    """Processor and number of cores of this machine."""
    model = platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return f"{model}, {os.cpu_count()} cores"


@lru_cache(maxsize=1)
def git_version() -> str:
    """Short commit of the project, with '+' where files differ; empty outside git.

    That with which the process began: it is asked for with every record.
    """
    here = Path(__file__).resolve().parent
    command = ["git", "-C", str(here), "describe", "--always", "--dirty=+", "--abbrev=10"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
