# SPDX-License-Identifier: GPL-2.0-or-later
"""Boundaries inside a job: kept where Snakemake does not look, trusted only by their hash.

Snakemake deletes the declared outputs of an interrupted job. Each window of a job is therefore
written to ``results/<scene>/.windows/<window>/`` first. Its state carries a hash of all that made
it: the state before, the forcing, the scene keys, the plugin, the number of ranks. A job that finds
such a state with the hash that it would give itself goes on from there.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

import xarray as xr

from floeflow import __version__
from floeflow.core.errors import FloeError
from floeflow.state import read_dataset, read_state

WORK = ".windows"
PARTS = {"state": "state.nc", "series": "series.nc", "cost": "cost.json"}


def work_folder(scene_folder: Path, window: str) -> Path:
    """Folder of a window's own copy of its files."""
    return scene_folder / WORK / window


def file_hash(path: str | Path) -> str:
    """SHA-256 of a file's bytes.

    Raises
    ------
    FloeError
        Where it cannot be read.
    """
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError as error:
        raise FloeError(f"{path}: cannot be read: {error.strerror}") from None


def window_hash(previous: xr.Dataset, forcing: xr.Dataset, fixed: dict[str, str]) -> str:
    """Hash of all that makes a window's state.

    Parameters
    ----------
    previous, forcing : xarray.Dataset
        Read by ``read_dataset``: they carry their checksums.
    fixed : dict
        What is the same for all windows of a run: hashes of the scene keys, plugin, ranks.
    """
    parts = {
        "previous": previous.attrs["checksum"],
        "forcing": forcing.attrs["checksum"],
        "version": __version__,
        **fixed,
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def finished(folder: Path, expected: str) -> xr.Dataset | None:
    """State in a window's folder, where it is whole and was made from the same."""
    try:
        state = read_state(folder / PARTS["state"])
    except FloeError:
        return None
    made_from = json.loads(state.attrs["provenance"]).get("window")
    whole = all((folder / part).is_file() for part in PARTS.values())
    return state if whole and made_from == expected else None


def resume(
    state: xr.Dataset,
    windows: list[str],
    forcing: list[str],
    scene_folder: Path,
    fixed: dict[str, str],
) -> tuple[xr.Dataset, list[str], list[str]]:
    """Skip the windows of a job that are finished already.

    Returns
    -------
    tuple of xarray.Dataset, list of str, list of str
        The state to go on from, the windows left to do and their forcing files.
    """
    for done, (window, path) in enumerate(zip(windows, forcing, strict=True)):
        expected = window_hash(state, read_dataset(path), fixed)
        after = finished(work_folder(scene_folder, window), expected)
        if after is None:
            return state, windows[done:], forcing[done:]
        state = after
    return state, [], []


def publish(scene_folder: Path, windows: list[str]) -> None:
    """Link each window's files to the places where people and later rules look for them.

    Raises
    ------
    FloeError
        Where a place cannot be written.
    """
    for window in windows:
        for kind, part in PARTS.items():
            source = work_folder(scene_folder, window) / part
            place = scene_folder / kind / f"{window}{source.suffix}"
            _link(source, place)


def _link(source: Path, place: Path) -> None:
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
