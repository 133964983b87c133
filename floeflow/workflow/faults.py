# SPDX-License-Identifier: GPL-2.0-or-later
"""What a job could not do, told once and last: the job leaves a sentence, the workflow says it.

Snakemake prints its own account of a failed job, many lines of it. A job therefore writes its
sentence to ``results/<scene>/.fault``, and the main process prints it when it ends. Whose sentence
it is tells the id of the run, not the time: clocks of nodes differ, and may be set back.
"""

from __future__ import annotations

import atexit
import json
import os
import sys
from pathlib import Path

from floeflow.core.atomic_write import write_text
from floeflow.core.lock import RUN_VARIABLE

FAULT = ".fault"
UNKNOWN = "a job ended without saying why (it may have been killed); its log lies in {}"


def leave_fault(folder: Path, sentence: str, log: Path) -> bool:
    """Leave what a job says for the main process; whether that could be written.

    Parameters
    ----------
    folder : Path
        In which it is left.
    sentence : str
        For the user.
    log : Path
        That has the details.

    Returns
    -------
    bool
        False where it could not be written.
    """
    told = {"sentence": sentence, "log": str(log), "run": os.environ.get(RUN_VARIABLE, "")}
    try:
        write_text(json.dumps(told) + "\n", folder / FAULT)
    except Exception:  # a full disk, most of all: then the job must say it itself
        return False
    return True


def take_faults(results: Path, run: str) -> list[str]:
    """Sentences that a run's jobs left, each with its log, which are removed then.

    Parameters
    ----------
    results : Path
        The folder with a folder for each scene.
    run : str
        Id of the run, which its jobs carry in their environment.

    Returns
    -------
    list of str
        Each sentence once.
    """
    found = []
    for path in sorted(results.glob(f"*/{FAULT}")):
        try:
            told = json.loads(path.read_text(encoding="utf-8"))
            if told.get("run") != run:
                continue
            path.unlink()
        except (OSError, ValueError):
            continue
        found.append(f"{told['sentence']} (log: {told['log']})")
    return list(dict.fromkeys(found))


def say_last(sentences: list[str]) -> None:
    """Print sentences when the program ends, after all that Snakemake says.

    Parameters
    ----------
    sentences : list of str
        One a line.
    """
    for sentence in reversed(sentences):
        atexit.register(print, f"floeflow: {sentence}", file=sys.stderr, flush=True)
