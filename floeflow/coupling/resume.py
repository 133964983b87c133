# SPDX-License-Identifier: GPL-2.0-or-later
"""Windows inside a chunk: kept where Snakemake does not look, trusted only by their hash.

Snakemake deletes the declared outputs of an interrupted job. Each window of a chunk is therefore
written to ``results/<scene>/.windows/<window>/`` first. Its files carry a hash of all that made
them: the state at the chunk's start, the scene keys, forcing, plugin, library, number of ranks, and
the window's place. If a window with the expected hash exists, the job continues from it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Sequence
from pathlib import Path

from floeflow import __version__
from floeflow.core.errors import FloeError
from floeflow.state import read_dataset, read_state

WORK = ".windows"
STATE, ELEMENTS, SERIES, COST = "state.nc", "elements.nc", "series.nc", "cost.json"
FLUXES = "fluxes.nc"
# A killed chunk goes on at its last state, or at the one before should that be damaged.
STATES_KEPT = 2
# Attribute with the hash in series and snapshots; the state has it in its provenance.
MADE_FROM = "made_from"


def work_folder(scene_folder: Path, window: str) -> Path:
    """Folder of a window's own copy of its files.

    Parameters
    ----------
    scene_folder : Path
        Results of the scene.
    window : str
        Name of the window.

    Returns
    -------
    Path
        Inside of the results; it may not exist yet.
    """
    return scene_folder / WORK / window


def window_hashes(start: str, windows: Sequence[str], fixed: dict[str, str]) -> list[str]:
    """Hash of all that makes each window of a chunk.

    Parameters
    ----------
    start : str
        Checksum of the state at the chunk's start.
    windows : sequence of str
        Names of the chunk's windows.
    fixed : dict
        What is the same for all windows of a run: hashes of scene keys, forcing files, plugin and
        library, number of ranks.

    Returns
    -------
    list of str
        SHA-256 of each window in hexadecimal; each goes into the next.
    """
    found: list[str] = []
    before = start
    for window in windows:
        parts = {"before": before, "window": window, "version": __version__, **fixed}
        before = hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()
        found.append(before)
    return found


def finished_windows(
    scene_folder: Path, windows: Sequence[str], hashes: Sequence[str], every_state: bool = False
) -> int:
    """Number of windows of a chunk, from the first on, that are there and have their hash.

    Parameters
    ----------
    scene_folder : Path
        ``results/<scene>``.
    windows, hashes : sequence of str
        The chunk's windows, and what each must have been made from.
    every_state : bool
        Whether the state of each window must be there, or that of the last one is enough.

    Returns
    -------
    int
        0 to the number of the chunk's windows; what comes after them has to run.
    """
    whole = 0
    for window, expected in zip(windows, hashes, strict=True):
        folder = work_folder(scene_folder, window)
        if not _has_records(folder, expected) or (every_state and not _has_state(folder, expected)):
            break
        whole += 1
    for done in range(whole, 0, -1):
        if _has_state(work_folder(scene_folder, windows[done - 1]), hashes[done - 1]):
            return done
    return 0


def _has_records(folder: Path, expected: str) -> bool:
    try:
        found = [read_dataset(folder / part).attrs.get(MADE_FROM) for part in (SERIES, ELEMENTS)]
    except FloeError:
        return False
    return found == [expected, expected] and (folder / COST).is_file()


def _has_state(folder: Path, expected: str) -> bool:
    try:
        state = read_state(folder / STATE)
    except FloeError:
        return False
    return json.loads(state.attrs["provenance"]).get("window") == expected


def drop_old_states(scene_folder: Path, windows: Sequence[str]) -> None:
    """Remove the states of a chunk's windows but the last ones.

    Parameters
    ----------
    scene_folder : Path
        ``results/<scene>``.
    windows : sequence of str
        Windows of the chunk that are done.
    """
    for window in windows[:-STATES_KEPT]:
        with contextlib.suppress(OSError):
            (work_folder(scene_folder, window) / STATE).unlink(missing_ok=True)


def link(source: Path, place: Path) -> None:
    """Give a file a second name, as new as now; an older file there is replaced.

    Parameters
    ----------
    source : Path
        File that is there.
    place : Path
        Second name.

    Raises
    ------
    FloeError
        Where the place cannot be written.
    """
    temporary = place.with_name(f".{place.name}.{os.getpid()}")
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        temporary.unlink(missing_ok=True)
        os.link(source, temporary)
        # The link has its source's age; Snakemake wants outputs newer than inputs.
        os.utime(temporary)
        os.replace(temporary, place)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise FloeError(f"{place}: cannot be written: {error.strerror}") from None
