# SPDX-License-Identifier: GPL-2.0-or-later
"""A chunk of coupling windows in one MPI launch.

Skips the windows that an interrupted job has finished, starts the ranks for the others, and
publishes what all of them made: the state at the chunk's end, and series, snapshots of the elements
and costs of all windows, one file a chunk.
"""

from __future__ import annotations

import json
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from floeflow.core.atomic_write import write_text
from floeflow.core.file_hash import file_hash
from floeflow.core.lock import hold_alone
from floeflow.coupling import resume
from floeflow.coupling.fluxes import join_fluxes
from floeflow.coupling.job import Job
from floeflow.coupling.launch import run_ranks
from floeflow.coupling.origin import check_origin, window_keys
from floeflow.forcings.files import users_files
from floeflow.scene import Scene
from floeflow.state import read_dataset, read_state, write_dataset
from floeflow.state.snapshots import join_snapshots, split_snapshots


@dataclass(frozen=True)
class Chunk:
    """Windows to advance, and from what.

    Parameters
    ----------
    scene : Scene
        The scene.
    folder : Path
        ``results/<scene>``.
    windows : tuple of str
        Names of the windows, in order.
    state : Path
        State at the chunk's start.
    plugin : Path
        The LIGGGHTS plugin.
    ranks : int
        MPI ranks.
    cells : Path or None
        Fresh cells of a scene that remaps.
    library : str
        Digest of the code that makes the windows.
    mask : Path or None
        The mask, in which the sea is, of a scene with a mixed layer or rims.
    launcher : tuple of str
        Words that start an MPI program.
    """

    scene: Scene
    folder: Path
    windows: tuple[str, ...]
    state: Path
    plugin: Path
    ranks: int
    cells: Path | None = None
    library: str = ""
    mask: Path | None = None
    launcher: tuple[str, ...] = ("mpirun",)

    @property
    def name(self) -> str:
        """Name of the chunk: that of its last window."""
        return self.windows[-1]

    def path(self, kind: str, suffix: str = ".nc") -> Path:
        """Published file of a kind.

        Parameters
        ----------
        kind : str
            Folder in the results, such as ``state``.
        suffix : str, optional
            Ending of the file's name.

        Returns
        -------
        Path
            Where the file lies.
        """
        return self.folder / kind / f"{self.name}{suffix}"


def fixed_hashes(chunk: Chunk) -> dict[str, str]:
    """What goes into the hash of every window of a run; see ``resume.window_hashes``.

    Parameters
    ----------
    chunk : Chunk
        Windows of a run.

    Returns
    -------
    dict of str
        Hashes by what they are of: input files, plugin, library, ranks and keys of the scene.
    """
    files = [file_hash(path) for path in users_files(chunk.scene)]
    return {
        **window_keys(chunk.scene),
        "forcing_files": " ".join(files),
        "plugin": file_hash(chunk.plugin),
        "library": chunk.library,
        "ranks": str(chunk.ranks),
    }


def run_chunk(chunk: Chunk) -> int:
    """Advance a chunk's windows and publish what they made; the number of windows that ran.

    Parameters
    ----------
    chunk : Chunk
        Windows of a run.

    Returns
    -------
    int
        0 where all windows were there with their hashes.

    Raises
    ------
    FloeError
        Where the state is another scene's, the ranks fail, in the sentence of the rank at fault, or
        a file cannot be written. The windows before are kept for the next try.
    """
    fixed = fixed_hashes(chunk)
    lock = chunk.folder / resume.WORK / f"{chunk.windows[0]}.lock"
    with hold_alone(lock, f"window {chunk.windows[0]} of {chunk.folder}"):
        attrs = read_state(chunk.state).attrs
        check_origin(attrs, chunk.state, chunk.scene, int(chunk.windows[0]) - 1)
        start = str(attrs["checksum"])
        hashes = resume.window_hashes(start, chunk.windows, fixed)
        every = chunk.scene.state.keep == "all"
        done = resume.finished_windows(chunk.folder, chunk.windows, hashes, every)
        if done:
            logging.info(
                "windows %s to %s are there already", chunk.windows[0], chunk.windows[done - 1]
            )
        todo = chunk.windows[done:]
        if todo:
            previous = resume.work_folder(chunk.folder, chunk.windows[done - 1]) / resume.STATE
            job = Job(
                scene=chunk.scene.model_dump(mode="json"),
                state=str(previous if done else chunk.state),
                windows=list(chunk.windows),
                done=done,
                hashes=hashes,
                folder=str(chunk.folder),
                fixed=fixed,
                cells=str(chunk.cells or ""),
                mask=str(chunk.mask or ""),
            )
            log = chunk.folder / "log/windows" / f"{chunk.name}.ranks.log"
            run_ranks(job, chunk.ranks, log, chunk.launcher)
        publish(chunk)
    return len(todo)


def publish(chunk: Chunk) -> None:
    """Write a chunk's files to the places where people and later rules look for them.

    Parameters
    ----------
    chunk : Chunk
        Windows that have ended.

    Raises
    ------
    FloeError
        Where a window's files are missing or a place cannot be written.
    """
    folders = [resume.work_folder(chunk.folder, window) for window in chunk.windows]
    write_dataset(
        join_series([read_dataset(f / resume.SERIES) for f in folders]), chunk.path("series")
    )
    snapshots = [
        part for f in folders for part in split_snapshots(read_dataset(f / resume.ELEMENTS))
    ]
    write_dataset(join_snapshots(snapshots), chunk.path("elements"))
    if chunk.scene.exchange.fluxes:
        parts = [read_dataset(f / resume.FLUXES) for f in folders]
        write_dataset(join_fluxes(parts), chunk.path("fluxes"))
    costs: list[dict[str, Any]] = []
    for window, folder in zip(chunk.windows, folders, strict=True):
        records = json.loads((folder / resume.COST).read_text())
        costs += [{**record, "window": int(window)} for record in records]
    write_text(json.dumps(costs, indent=1) + "\n", chunk.path("cost", ".json"))
    if chunk.scene.state.keep == "all":
        for window, folder in zip(chunk.windows[:-1], folders[:-1], strict=True):
            resume.link(folder / resume.STATE, chunk.folder / "state" / f"{window}.nc")
    resume.link(folders[-1] / resume.STATE, chunk.path("state"))
    remove_shorter(chunk)


def remove_shorter(chunk: Chunk) -> None:
    """Remove what a shorter run published of the same windows; the states stay.

    Whoever reads all files of a folder would count these windows twice.

    Parameters
    ----------
    chunk : Chunk
        Windows that are published.
    """
    for window in chunk.windows[:-1]:
        for kind in ("series", "elements", "fluxes", "fields"):
            (chunk.folder / kind / f"{window}.nc").unlink(missing_ok=True)
        (chunk.folder / "cost" / f"{window}.json").unlink(missing_ok=True)


def join_series(series: list[xr.Dataset]) -> xr.Dataset:
    """Series of consecutive windows in one dataset.

    Parameters
    ----------
    series : list of xarray.Dataset
        Series of each window, with its number as attribute ``window``: samples on ``sample``,
        scalars of the budgets.

    Returns
    -------
    xarray.Dataset
        Samples of all windows on ``sample`` (a boundary stands twice, before and after the column)
        with ``sample_window``; scalars on ``window``.
    """
    samples, scalars = [], []
    for data in series:
        window = int(data.attrs["window"])
        sampled = [str(name) for name in data.variables if data[name].dims == ("sample",)]
        part = data[sampled].reset_coords()
        part["sample_window"] = ("sample", np.full(part.sizes["sample"], window, dtype=np.int64))
        samples.append(part)
        scalars.append(data[[str(name) for name in data.data_vars if not data[name].dims]])
    numbers = np.array([int(data.attrs["window"]) for data in series], dtype=np.int64)
    joined = xr.concat(scalars, "window", join="exact", combine_attrs="drop")
    joined = joined.assign_coords(window=numbers)
    made = xr.merge([xr.concat(samples, "sample", join="exact", combine_attrs="drop"), joined])
    made.attrs = {}
    return made
