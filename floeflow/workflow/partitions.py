# SPDX-License-Identifier: GPL-2.0-or-later
"""How long a job may run where it goes: Slurm lets one that asks for more wait for ever, unsaid."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Sequence


def partition_minutes(arguments: Sequence[str] = ()) -> int | None:
    """Longest time of the partition that jobs go to, minutes; none where Slurm sets no limit.

    Parameters
    ----------
    arguments : sequence of str
        Snakemake's command line, which may name a partition with ``slurm_partition=``.

    Returns
    -------
    int or None
        minutes.
    """
    named = re.search(r"\bslurm_partition=['\"]?([\w.-]+)", " ".join(arguments))
    partition = named[1] if named else os.environ.get("SBATCH_PARTITION", "")
    try:
        done = subprocess.run(
            ["sinfo", "--noheader", "--format=%P %l"], capture_output=True, text=True, check=False
        )
    except OSError:
        return None
    return longest(done.stdout, partition)


def longest(table: str, partition: str = "") -> int | None:
    """Limit of a partition, else of the default one, in what ``sinfo`` says; none if unknown.

    Parameters
    ----------
    table : str
        Output of ``sinfo``.
    partition : str, optional
        Name; empty for the default one.

    Returns
    -------
    int or None
        minutes.
    """
    for line in table.splitlines():
        name, _, limit = line.strip().partition(" ")
        if name.rstrip("*") == partition or (not partition and name.endswith("*")):
            return minutes(limit)
    return None


def minutes(limit: str) -> int | None:
    """Minutes of Slurm's ``days-hours:minutes:seconds``; none where it is no time.

    Parameters
    ----------
    limit : str
        As Slurm prints it.

    Returns
    -------
    int or None
        minutes; seconds are left out.
    """
    found = re.fullmatch(r"(?:(\d+)-)?(?:(\d+):)?(\d+):(\d+)", limit.strip())
    if found is None:
        return None
    days, hours, rest = (int(part or 0) for part in found.groups()[:3])
    return (days * 24 + hours) * 60 + rest


def within(asked: int, limit: int | None, rule: str) -> int:
    """What a job may ask for, with a sentence where that is less than it wants.

    Parameters
    ----------
    asked : int
        minutes.
    limit : int or None
        Of the partition (minutes); None if unknown.
    rule : str
        Name, for the warning.

    Returns
    -------
    int
        minutes.
    """
    if limit is None or asked <= limit:
        return asked
    print(
        f"floeflow: warning: {rule} would ask for {asked} minutes, and the partition allows "
        f"{limit}: it asks for that, and if this ends it, goes on behind the last finished window; "
        "fewer windows in a job (workflow.windows_per_job) or another partition avoid it",
        file=sys.stderr,
        flush=True,
    )
    return limit
