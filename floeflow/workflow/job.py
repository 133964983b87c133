# SPDX-License-Identifier: GPL-2.0-or-later
"""How a rule's module becomes a program: its log, its lock, its way to fail.

Every stage holds the scene's job lock while it runs. A job that outlives a killed workflow is
thereby seen by the next one, which waits for its end (``floeflow.core.lock``).
"""

from __future__ import annotations

import json
import logging
import os
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from floeflow.core.atomic_write import write_text
from floeflow.core.errors import FloeError
from floeflow.core.lock import hold_job
from floeflow.core.records import cpu_seconds, peak_memory
from floeflow.scene import Scene
from floeflow.scene.load import read_resolved
from floeflow.workflow.faults import leave_fault

# A window of a small scene writes less than this.
LEAST_ROOM_MB = 20
# Words for mpirun: all ranks start here, whatever nodes and tasks Slurm knows of.
ALONE = ("--mca", "plm", "isolated", "--mca", "ras", "^slurm")


class Snakemake(Protocol):
    """What a module uses of the object that Snakemake hands to a script."""

    input: Any
    output: Any
    params: Any
    log: Any
    config: Any
    wildcards: Any
    threads: int
    resources: Any
    rule: str


def run_script(main: Callable[[Snakemake], None], snakemake: Snakemake) -> None:
    """Run a rule's script: logging to its log, a fault as one sentence, exit code 1.

    The sentence is left for the main process, which says it last (`floeflow.workflow.faults`).

    Parameters
    ----------
    main : callable
        What the rule does.
    snakemake : Snakemake
        What Snakemake puts into the rule's script.
    """
    log = Path(str(snakemake.log[0]))
    log.parent.mkdir(parents=True, exist_ok=True)
    form = "%(asctime)s %(name)s %(levelname)s %(message)s"
    logging.basicConfig(filename=log, filemode="w", level=logging.INFO, format=form)
    # A log that cannot be written on a full disk must not hide the sentence that says so.
    logging.raiseExceptions = False
    try:
        with hold_job(scene_folder(snakemake)):
            check_room(scene_folder(snakemake))
            main(snakemake)
        _keep_cost(snakemake)
    except FloeError as error:
        logging.error("%s", error)
        if not leave_fault(scene_folder(snakemake), str(error), log):
            print(f"floeflow: {error}", file=sys.stderr, flush=True)
        # Leave without unwinding through Snakemake's preamble, which would print a traceback.
        logging.shutdown()
        os._exit(1)
    except Exception as error:
        logging.exception("unexpected fault")
        said = (
            f"{type(error).__name__}: {str(error)[:200]}: a fault of the program, please report it"
        )
        leave_fault(scene_folder(snakemake), said, log)
        raise


def check_room(folder: Path) -> None:
    """Refuse to begin where the disk is as good as full.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``, or where it will be.

    Raises
    ------
    FloeError
        Names the folder and what is left.
    """
    room = os.statvfs(folder)
    left = room.f_bavail * room.f_frsize / 1e6
    if left < LEAST_ROOM_MB:
        raise FloeError(
            f"{folder}: the disk is full ({left:.0f} MB are left, {LEAST_ROOM_MB} are needed to "
            "begin); make room and run the same command again"
        )


def _keep_cost(snakemake: Snakemake) -> None:
    """Write the job's CPU seconds and memory where studies and the cost model read them."""
    words = [snakemake.rule, *map(str, getattr(snakemake.wildcards, "chunk", "").split())]
    own, child = peak_memory()
    record = {
        "rule": snakemake.rule,
        "cpu_seconds": cpu_seconds(),
        "memory_mb": round(own, 1),
        "largest_child_mb": round(child, 1),
    }
    write_text(
        json.dumps(record) + "\n", scene_folder(snakemake) / "cpu" / f"{'-'.join(words)}.json"
    )


def scene_of(snakemake: Snakemake) -> Scene:
    """Scene of the running job, as the workflow resolved it.

    Parameters
    ----------
    snakemake : Snakemake
        Object that Snakemake gives to scripts.

    Returns
    -------
    Scene
        With all its keys.
    """
    return read_resolved(snakemake.input.scene)


def launcher_of(snakemake: Snakemake) -> tuple[tuple[str, ...], int]:
    """Words that start MPI programs, and the number of ranks.

    On one machine that is ``mpirun`` with the rule's threads. In a job of Slurm it asks for no
    step: that would wait for ever inside of another one. On a cluster the profile sets the
    resource ``mpi``, and the ranks are the job's ``tasks``, which may lie on several nodes.

    Parameters
    ----------
    snakemake : Snakemake
        Object that Snakemake gives to scripts.

    Returns
    -------
    words : tuple of str
        The program first.
    ranks : int
        1 or more.
    """
    mpi = str(snakemake.resources.get("mpi") or "")
    if mpi:
        return tuple(shlex.split(mpi)), int(snakemake.resources.get("tasks"))
    return ("mpirun", *(ALONE if "SLURM_JOB_ID" in os.environ else ())), snakemake.threads


def scene_folder(snakemake: Snakemake) -> Path:
    """``results/<scene>`` of the running stage; the folder of its output where it has no scene.

    Parameters
    ----------
    snakemake : Snakemake
        Object that Snakemake gives to scripts.

    Returns
    -------
    Path
        Relative to the working directory.
    """
    name = getattr(snakemake.wildcards, "scene", None)
    return Path("results") / str(name) if name else Path(str(snakemake.output[0])).parent
