# SPDX-License-Identifier: GPL-2.0-or-later
"""LIGGGHTS' log: whether it can be written, and its end to stand behind a sentence."""

from __future__ import annotations

from pathlib import Path


def log_tail(log: Path) -> str:
    """Last five lines of a log, to stand behind a sentence; empty where there is none.

    Parameters
    ----------
    log : Path
        LIGGGHTS' log.

    Returns
    -------
    str
        Begins with a line break and the log's name.
    """
    try:
        tail = log.read_text(errors="replace").splitlines()[-5:]
    except OSError:
        return ""
    return "".join(f"\n  {line}" for line in [f"(tail of {log})", *tail])


def open_fault(log: Path) -> str | None:
    """Why a log cannot be written; None if it can.

    Parameters
    ----------
    log : Path
        LIGGGHTS' log.

    Returns
    -------
    str or None
        The operating system's reason.
    """
    try:
        log.open("a").close()
    except OSError as error:
        return error.strerror or type(error).__name__
    return None
