# SPDX-License-Identifier: GPL-2.0-or-later
"""How the coupling windows of a run are named and cut into chunks."""

from __future__ import annotations

from floeflow.core.errors import FloeError

# Recursive chains of jobs exhaust Python's stack near 400; a chunk is one job deep.
MAX_DEPTH = 140


def window_name(number: int) -> str:
    """Name of a window in file names: at least four digits.

    Parameters
    ----------
    number : int
        From 0, the state before the first window.

    Returns
    -------
    str
        Such as 0001.
    """
    return f"{number:04d}"


def window_chunks(windows: int, per_job: int) -> dict[str, list[str]]:
    """Cut windows 1..n into chunks, each under the name of its last window.

    Chunks start at fixed windows, so that a longer run keeps all full chunks of a shorter one.

    Parameters
    ----------
    windows : int
        Number of windows of the run.
    per_job : int
        Windows in one chunk.

    Returns
    -------
    dict of list of str
        Names of windows, in order, by the name of the last.

    Raises
    ------
    FloeError
        Where the chain of chunks would be too long for the workflow.
    """
    least = -(-windows // MAX_DEPTH)
    if per_job < least:
        raise FloeError(
            f"workflow.windows_per_job is {per_job}: {windows} windows need {least} or more in a "
            f"job, as a workflow may be {MAX_DEPTH} jobs deep"
        )
    chunks = {}
    for first in range(1, windows + 1, per_job):
        names = [window_name(w) for w in range(first, min(first + per_job, windows + 1))]
        chunks[names[-1]] = names
    return chunks
