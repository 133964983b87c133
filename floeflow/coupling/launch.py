# SPDX-License-Identifier: GPL-2.0-or-later
"""Start the MPI ranks of a chunk, show their progress, turn their faults into one sentence."""

import contextlib
import json
import logging
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from floeflow.core import mpi
from floeflow.core.errors import FloeError
from floeflow.coupling.job import Job
from floeflow.coupling.progress import show_progress
from floeflow.scene import Scene

# Settings of Open MPI and PMIx that a user may have made.
_OWN = re.compile(r"(OMPI|PMIX|PRTE)_MCA_")


def run_ranks(job: Job, ranks: int, log: Path, launcher: tuple[str, ...] = ("mpirun",)) -> None:
    """Advance a job's windows on so many ranks.

    Parameters
    ----------
    job : Job
        What to do.
    ranks : int
        Number of MPI ranks.
    log : Path
        Gets what the ranks say on standard error.
    launcher : tuple of str
        Words that start an MPI program, such as ``srun --mpi=pmix``.

    Raises
    ------
    FloeError
        The sentence of the rank at fault, or the tail of its logs.
    """
    program = [sys.executable, "-m", "floeflow.coupling.coupled_windows"]
    command = [*launcher, "-n", str(ranks), *program]
    log.parent.mkdir(parents=True, exist_ok=True)
    fault = ""
    windows = job.read_scene().time.windows
    with open(log, "w") as errors, show_progress(windows) as show:
        try:
            ranks_process = subprocess.Popen(
                command,
                env=mpi.mpi_environment(),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )
        except OSError as error:
            raise FloeError(f"{launcher[0]} cannot be started: {error.strerror}") from None
        with ranks_process:
            assert ranks_process.stdin is not None and ranks_process.stdout is not None
            # MPI that does not start reads nothing; its log says why.
            with contextlib.suppress(BrokenPipeError):
                ranks_process.stdin.write(job.to_json() + "\n")
            with contextlib.suppress(BrokenPipeError):
                ranks_process.stdin.close()
            for text in ranks_process.stdout:
                for event in _events(text):
                    if "step" in event:
                        show(event)
                    fault = fault or str(event.get("error", ""))
    if ranks_process.returncode:
        raise FloeError(fault or _last_words(job, log, ranks_process.returncode))


def _events(text: str) -> Iterator[dict[str, Any]]:
    """Events of one line: what ranks say at once arrives joined."""
    decoder = json.JSONDecoder()
    while text := text.strip():
        try:
            event, end = decoder.raw_decode(text)
        except ValueError:
            logging.info("ranks: %s", text)
            return
        text = text[end:]
        if isinstance(event, dict):
            yield event


def _last_words(job: Job, log: Path, code: int) -> str:
    """Make the sentence for ranks that ended without giving one."""
    logs = [Path(job.folder) / "log/windows" / f"{w}.liggghts.log" for w in job.windows[job.done :]]
    for path in [*reversed(logs), log]:
        if path.is_file():
            for text in reversed(path.read_text(errors="replace").splitlines()):
                if re.match(r"ERROR|\w*Error\b|FATAL|LIGGGHTS: ", text.strip()):
                    span = f"windows {job.windows[job.done]} to {job.windows[-1]}"
                    return f"{span}: {text.strip()} ({path})"
    text = log.read_text(errors="replace")
    chosen = [f"{name}={os.environ[name]}" for name in sorted(os.environ) if _OWN.match(name)]
    where = f"; set in the environment: {', '.join(chosen)}" if chosen else ""
    if told := _told_by_mpi(text):
        return f"the ranks ended with code {code}, and MPI says: {told}{where} (see {log})"
    if "ORTE_ERROR_LOG" in text:
        # Open MPI loses its own words where several ranks fail at once.
        return f"the ranks ended with code {code}: MPI did not start{where} (see {log})"
    words = [line.strip(" -") for line in text.splitlines()]
    last = next((line for line in reversed(words) if line), "nothing said")
    return f"the ranks ended with code {code}: {last} (see {log})"


def _told_by_mpi(text: str) -> str:
    """What Open MPI says in the first of its boxes: a sentence, then names and values.

    Empty where there is none, or only that which says that the program itself ended.
    """
    boxes = (box.strip() for box in re.split(r"^-{40,}$", text, flags=re.MULTILINE)[1::2])
    for box in boxes:
        if box and not re.match(r"Primary job\s+terminated|MPI_ABORT was invoked", box):
            values = re.findall(r"^ *(\w[\w ]*?) *: +(\S.*?) *$", box, flags=re.MULTILINE)
            first = re.split(r"[.:](?:\s|$)", " ".join(box.split()), maxsplit=1)[0]
            return first + (f" ({', '.join(map(' '.join, values))})" if values else "")
    return ""


def warn_of_step(scene: Scene) -> None:
    """Warn on the terminal and in the log of a time step above the critical one.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    share = scene.dynamics.step_share
    if share > 1:
        text = f"dynamics.step_share is {share:g}: at such a time step the ice may blow up"
        logging.warning("%s", text)
        print(f"floeflow: warning: {text}", file=sys.stderr, flush=True)
