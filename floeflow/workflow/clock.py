# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that are newer than the clock: it was set back, or that of another node is ahead.

Snakemake takes what a job made for spoiled where an input of it is newer, and removes it. So a run
that would begin with such files is refused before its first job.
"""

from __future__ import annotations

import time
from pathlib import Path

from floeflow.core.errors import FloeError

# Clocks of nodes differ by less, and every job takes longer.
TOLERANCE = 5.0  # s


def clock_sentence(folder: Path) -> str:
    """What is to be said of a scene's results that are newer than the clock; empty without any.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``.

    Returns
    -------
    str
        One line; it names the first such file and how many there are.
    """
    latest = time.time() + TOLERANCE
    newer = [path for path in sorted(folder.rglob("*")) if _age(path) > latest]
    if not newer:
        return ""
    return (
        f"{newer[0]}: is newer than the clock ({len(newer)} such files): the clock was set "
        "back, or another node's is ahead; set it right, or give the files this moment's time with "
        f"find {folder} -type f -newermt now -exec touch -d @$(date +%s) {{}} +"
    )


def check_clock(folder: Path) -> None:
    """Refuse to begin with results that are newer than the clock.

    Parameters
    ----------
    folder : Path
        Folder of results.

    Raises
    ------
    FloeError
        Names a file, and how all of them are given another time.
    """
    if sentence := clock_sentence(folder):
        raise FloeError(sentence)


def _age(path: Path) -> float:
    """Time of a file, s of the epoch; the beginning where it is none, or is gone meanwhile."""
    try:
        return path.stat().st_mtime if path.is_file() else 0.0
    except OSError:
        return 0.0
