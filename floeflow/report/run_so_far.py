# SPDX-License-Identifier: GPL-2.0-or-later
"""A report of a run as far as it came: of one that stopped, or that is still under way.

The chunks that are published count whole; of the next one those windows that lie finished in
``.windows`` up to the last that kept its state. Nothing of the run is changed.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import xarray as xr

from floeflow.core.atomic_write import write_text
from floeflow.core.errors import FloeError
from floeflow.coupling import growth, resume
from floeflow.coupling.chunk import join_series
from floeflow.diagnostics.analyses import Analyses
from floeflow.diagnostics.cf_output import join_times
from floeflow.diagnostics.collect import read_grid
from floeflow.diagnostics.diagnostics import RunFiles, analyse, diagnose, write_json
from floeflow.diagnostics.gridded import make_grid
from floeflow.diagnostics.gridded_tendencies import make_tendencies
from floeflow.diagnostics.study_summaries import read_summary
from floeflow.report.report import Material, build_report, read_numbers
from floeflow.scene import Scene
from floeflow.scene.load import read_resolved
from floeflow.scene.windows import window_chunks, window_name
from floeflow.state import read_dataset, read_state, write_dataset
from floeflow.state.snapshots import read_snapshots

PAGE, FIGURES = "report_so_far.html", "figures_so_far"


@dataclass(frozen=True)
class SoFar:
    """What a run has left so far.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``.
    scene : Scene
        As it was resolved.
    chunks : tuple of str
        Names of the published chunks, in order.
    windows : tuple of str
        Names of the finished windows after them.
    """

    folder: Path
    scene: Scene
    chunks: tuple[str, ...]
    windows: tuple[str, ...]

    @property
    def last(self) -> str:
        """Name of the last window."""
        return (*self.chunks, *self.windows)[-1]

    def path(self, kind: str, name: str, suffix: str = ".nc") -> Path:
        """A file of a chunk.

        Parameters
        ----------
        kind : str
            Folder in the results.
        name : str
            Of the chunk.
        suffix : str, optional
            Ending of the file's name.

        Returns
        -------
        Path
            It may not exist yet.
        """
        return self.folder / kind / f"{name}{suffix}"

    def work(self, window: str, part: str) -> Path:
        """A file of a window that is not published yet.

        Parameters
        ----------
        window : str
            Name of the window.
        part : str
            Name of the file.

        Returns
        -------
        Path
            It may not exist yet.
        """
        return resume.work_folder(self.folder, window) / part


def find_so_far(folder: Path) -> SoFar:
    """Find what a run has left.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``.

    Returns
    -------
    SoFar
        Scene, and names of the chunks and windows that are finished, in order.

    Raises
    ------
    FloeError
        Where the folder holds no run, or no window is finished.
    """
    if not (folder / "scene.yaml").is_file():
        raise FloeError(f"{folder}: holds no run (there is no scene.yaml in it)")
    scene = read_resolved(folder / "scene.yaml")
    chunks: list[str] = []
    windows: list[str] = []
    for name, names in window_chunks(scene.time.windows, scene.workflow.windows_per_job).items():
        kinds = (("elements", ".nc"), ("series", ".nc"), ("cost", ".json"), ("state", ".nc"))
        if all((folder / kind / f"{name}{suffix}").is_file() for kind, suffix in kinds):
            chunks.append(name)
            continue
        before = folder / "state" / f"{chunks[-1] if chunks else window_name(0)}.nc"
        windows = _finished(folder, names, before)
        break
    if not chunks and not windows:
        raise FloeError(f"{folder}: no window is finished yet, so there is nothing to report")
    return SoFar(folder, scene, tuple(chunks), tuple(windows))


def _finished(folder: Path, names: Sequence[str], before: Path) -> list[str]:
    """Windows of a chunk that are there, up to the last with a state, of this run alone.

    What is older than the state at the chunk's start was left by a run of other settings.
    """
    if not before.is_file():
        return []
    started, found, with_state = before.stat().st_mtime, [], 0
    for name in names:
        work = resume.work_folder(folder, name)
        parts = [work / part for part in (resume.ELEMENTS, resume.SERIES, resume.COST)]
        if not all(part.is_file() and part.stat().st_mtime >= started for part in parts):
            break
        found.append(name)
        if (work / resume.STATE).is_file():
            with_state = len(found)
    return found[:with_state]


def _files(run: SoFar, scratch: Path) -> RunFiles:
    """Files for the diagnostics; those of unpublished windows are joined in a scratch folder."""
    elements = [run.path("elements", name) for name in run.chunks]
    series = [run.path("series", name) for name in run.chunks]
    cost = [run.path("cost", name, ".json") for name in run.chunks]
    if run.windows:
        elements += [run.work(window, resume.ELEMENTS) for window in run.windows]
        parts = [read_dataset(run.work(window, resume.SERIES)) for window in run.windows]
        series.append(scratch / "series.nc")
        write_dataset(join_series(parts), series[-1])
        records = []
        for window in run.windows:
            text = run.work(window, resume.COST).read_text(encoding="utf-8")
            records += [{**record, "window": int(window)} for record in json.loads(text)]
        cost.append(scratch / "cost.json")
        write_text(json.dumps(records), cost[-1])
    grid = scratch / "grid.nc" if "grid_output" in run.scene.effects else None
    if grid is not None:
        join_times(list(_grids(run))).to_netcdf(grid)
    return RunFiles(run.path("state", window_name(0)), elements, series, cost, grid)


def _grids(run: SoFar) -> Iterator[xr.Dataset]:
    """Fields on the grid at all boundaries, made anew: chunks may be of an older program."""
    mask = read_dataset(run.folder / "preprocess/mask.nc")
    yield make_grid(run.scene, read_state(run.path("state", window_name(0))), mask)
    paths = [run.path("elements", name) for name in run.chunks]
    paths += [run.work(window, resume.ELEMENTS) for window in run.windows]
    for snapshot in read_snapshots(paths):
        yield make_grid(run.scene, snapshot, mask)


def _tendencies(run: SoFar, files: RunFiles) -> xr.Dataset | None:
    """What changed the ice of the cells in the windows so far, where scene and windows have it."""
    if files.grid is None or not growth.wanted(run.scene):
        return None
    # Windows may be of an older program, which did not say where ice grew.
    if any(growth.COVER not in state for state in read_snapshots(files.elements)):
        return None
    mask = read_dataset(run.folder / "preprocess/mask.nc")
    return make_tendencies(run.scene, files.grid, mask, read_snapshots(files.elements))


def report_so_far(folder: Path) -> str:
    """Write a report of what a run has left so far.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``; gets ``report_so_far.html`` and ``figures_so_far/``.

    Returns
    -------
    str
        A sentence that says how far the run came and where the page lies.

    Raises
    ------
    FloeError
        Where there is no run, no finished window, or a damaged file.
    """
    run = find_so_far(folder)
    scene, last = run.scene, run.last
    done, total = int(last), scene.time.windows
    state = run.work(last, resume.STATE) if run.windows else run.path("state", last)
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        files = _files(run, scratch)
        analyses = Analyses(scene)
        data, numbers = diagnose(files, scene.effects, scene.domain, analyses)
        write_json(numbers, scratch / "diagnostics.json")
        estimates = folder / "effects.json"
        material = Material(
            diagnostics=data,
            numbers=read_numbers(scratch / "diagnostics.json"),
            analyses=analyse(replace(files, last=state), analyses),
            first_state=read_state(files.first),
            last_state=read_state(state),
            grid=read_grid(files.grid) if files.grid else None,
            mask=read_dataset(folder / "preprocess/mask.nc"),
            packing=read_dataset(folder / "preprocess/packing.nc"),
            benchmarks=sorted((folder / "benchmarks").rglob("*.tsv")),
            estimates=read_summary(estimates) if estimates.is_file() else {"estimates": []},
            partial=_how_far(done, total) if done < total else "",
            tendencies=_tendencies(run, files),
        )
        page = build_report(scene, material, folder / FIGURES)
    write_text(page, folder / PAGE)
    return f"{_how_far(done, total)} Report: {folder / PAGE}"


def _how_far(done: int, total: int) -> str:
    if done == total:
        return f"All {total} windows are done."
    return f"This run has not ended: {done} of {total} windows are done."
