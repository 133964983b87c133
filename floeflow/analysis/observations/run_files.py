# SPDX-License-Identifier: GPL-2.0-or-later
"""A finished run, as far as comparisons read it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import xarray as xr

from floeflow.analysis.observations.drift_errors import Carrier, carrier, velocity_carrier
from floeflow.core.errors import FloeError
from floeflow.diagnostics.collect import read_grid
from floeflow.diagnostics.diagnostics import remapped_windows
from floeflow.diagnostics.followed import Frame, frame_of
from floeflow.scene import Scene
from floeflow.scene.load import read_resolved
from floeflow.scene.windows import window_chunks, window_name
from floeflow.state import read_dataset, read_state
from floeflow.state.snapshots import read_snapshots


@dataclass(frozen=True)
class FinishedRun:
    """``results/<scene>`` of a run that has ended.

    Parameters
    ----------
    folder : Path
        Where it lies.
    scene : Scene
        As it was resolved.
    """

    folder: Path
    scene: Scene

    @cached_property
    def grid(self) -> xr.Dataset:
        """Fields at all boundaries, shares of 1."""
        path = self.folder / "grid.nc"
        if not path.is_file():
            raise FloeError(f"{path}: there is none: the scene lacks the effect grid_output")
        return read_grid(path)

    @cached_property
    def numbers(self) -> dict[str, Any]:
        """Headline numbers."""
        text = (self.folder / "diagnostics.json").read_text(encoding="utf-8")
        found: dict[str, Any] = json.loads(text)["headline"]
        return found

    @cached_property
    def diagnostics(self) -> xr.Dataset:
        """Series of the run."""
        return read_dataset(self.folder / "diagnostics.nc")

    def frames(self, first: int, last: int) -> Iterator[Frame]:
        """Elements at the boundaries from one to another, one after the other.

        Parameters
        ----------
        first : int
            Numbers of the boundaries.
        last : int
            Numbers of the boundaries.

        Returns
        -------
        iterator of Frame
            In the order of time.
        """
        if first == 0:
            yield frame_of(read_state(self.folder / f"state/{window_name(0)}.nc"))
        time = self.scene.time
        chunks = window_chunks(time.windows, self.scene.workflow.windows_per_job)
        for name, windows in chunks.items():
            if int(windows[-1]) < first or int(windows[0]) > last:
                continue
            for snapshot in read_snapshots([self.folder / f"elements/{name}.nc"]):
                if first <= int(snapshot.attrs["window"]) <= last:
                    yield frame_of(snapshot)

    def carriers(self, first: int, last: int) -> list[Carrier | None]:
        """Displacements of the ice in all windows; None before one boundary and after another.

        Parameters
        ----------
        first : int
            Numbers of the boundaries.
        last : int
            Numbers of the boundaries.

        Returns
        -------
        list of Carrier or None
            (windows,).
        """
        remapped = remapped_windows(self.diagnostics)
        found: list[Carrier | None] = [None] * self.scene.time.windows
        before: Frame | None = None
        for frame in self.frames(first, last):
            if before is not None and before.id.size and frame.id.size:
                make = velocity_carrier if frame.window in remapped else carrier
                found[frame.window - 1] = make(before, frame)
            before = frame
        return found


def open_run(folder: Path) -> FinishedRun:
    """The run in a folder.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``.

    Raises
    ------
    FloeError
        Where there is none, or it has not ended.
    """
    if not (folder / "scene.yaml").is_file():
        raise FloeError(f"{folder}: holds no run (there is no scene.yaml in it)")
    for name in ("diagnostics.json", "diagnostics.nc"):
        if not (folder / name).is_file():
            raise FloeError(f"{folder}: its run has not ended (there is no {name})")
    return FinishedRun(folder, read_resolved(folder / "scene.yaml"))
