# SPDX-License-Identifier: GPL-2.0-or-later
"""The members of one setting of an ensemble study, and between them a window of the base scene.

That window is the clock: how fast the machine is at the time. The cost of a member is its CPU time
over that of the window which ran before it.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from floeflow.analysis.studies.compare import totals
from floeflow.analysis.studies.ensemble_plan import AGAIN, PARTING, nudges
from floeflow.analysis.studies.ensemble_statistics import run_statistics
from floeflow.analysis.studies.outcome import read_outcome
from floeflow.analysis.studies.run import instability
from floeflow.analysis.studies.variants import BASE, Variant
from floeflow.core.errors import FloeError
from floeflow.core.records import WINDOW_CPU
from floeflow.coupling.chunk import Chunk, fixed_hashes, run_chunk
from floeflow.diagnostics.collect import displacement, mean, read_series
from floeflow.diagnostics.diagnostics import write_json
from floeflow.scene import Scene
from floeflow.scene.load import read_resolved
from floeflow.scene.windows import window_name
from floeflow.state import read_state
from floeflow.state.snapshots import read_snapshots

CLOCK = "clock"


def run_members(variant: Variant, chunk: Chunk, base: Mapping[str, Any] | None) -> dict[str, Any]:
    """Run the members of a setting and return its record, in JSON types.

    Parameters
    ----------
    variant : Variant
        The setting.
    chunk : Chunk
        All windows of the scene with the setting.
    base : mapping or None
        Record of the base scene; None where this is it.

    Returns
    -------
    dict
        ``members``: of each its statistics, the velocities of its boxes, CPU seconds and those of
        the clock, or the sentence with which it failed.

    Raises
    ------
    FloeError
        Where a member of the scene itself fails. One of another setting is a result.
    """
    clock = base_chunk(base, chunk) if base else chunk
    # Whatever the first run on a machine compiles is no part of a cost.
    clock_seconds(clock, chunk.folder / CLOCK)
    members = []
    for number, factor in enumerate(nudges(variant.name)):
        member = kept_member(chunk, clock, number, factor)
        if member["fault"] and variant.name in (BASE, AGAIN):
            raise FloeError(f"the scene itself does not run: {member['fault']}")
        members.append(member)
    record = {
        "variant": variant.name,
        "group": variant.group,
        "label": variant.label,
        "changes": variant.changes,
        "effects": list(chunk.scene.effects),
        "members": members,
    }
    if base is None:
        record["parting"] = parting(chunk)
        record["chunk"] = {
            "scene": str(chunk.folder / "scene.yaml"),
            "state": str(chunk.state),
            "cells": str(chunk.cells or ""),
            "mask": str(chunk.mask or ""),
        }
    return record


def kept_member(chunk: Chunk, clock: Chunk, number: int, factor: float) -> dict[str, Any]:
    """A member and its clock, from its file where an earlier job has finished it.

    One that failed is tried again: a full disk is no property of a setting.

    Parameters
    ----------
    chunk : Chunk
        Windows of the setting.
    clock : Chunk
        Windows of the base scene, whose first is timed.
    number : int
        Of the member.
    factor : float
        Of the wind's stress.

    Returns
    -------
    dict of object
        Statistics or fault, cost, and what it was made from.
    """
    path = chunk.folder / "members" / f"member-{number}.json"
    made_from = {**fixed_hashes(chunk), "factor": factor, "windows": len(chunk.windows)}
    if path.is_file():
        kept: dict[str, Any] = json.loads(path.read_text())
        if kept["made_from"] == made_from:
            return kept
    seconds = clock_seconds(clock, chunk.folder / CLOCK)
    found = run_member(chunk, f"member-{number}", factor)
    member = {"made_from": made_from, "factor": factor, "clock_seconds": seconds, **found}
    if not found["fault"]:
        write_json(member, path)
    return member


def base_chunk(record: Mapping[str, Any], chunk: Chunk) -> Chunk:
    """Windows of the base scene, from its record.

    Parameters
    ----------
    record : mapping of object
        Of the base scene.
    chunk : Chunk
        Of a setting, whose folder is used.

    Returns
    -------
    Chunk
        All windows of the base scene.
    """
    files = record["chunk"]
    scene = read_resolved(Path(files["scene"]))
    return replace(
        chunk,
        scene=scene,
        windows=tuple(window_name(k + 1) for k in range(scene.time.windows)),
        state=Path(files["state"]),
        cells=Path(files["cells"]) if files["cells"] else None,
        mask=Path(files["mask"]) if files["mask"] else None,
    )


def with_stress(scene: Scene, factor: float) -> Scene:
    """The scene with the stress of its wind multiplied.

    Parameters
    ----------
    scene : Scene
        Its keys.
    factor : float
        Positive.

    Returns
    -------
    Scene
        With another drag coefficient of the air.
    """
    drag = scene.dynamics.air_drag * factor
    dynamics = scene.dynamics.model_copy(update={"air_drag": drag})
    return scene.model_copy(update={"dynamics": dynamics})


def clock_seconds(base: Chunk, folder: Path) -> float:
    """CPU seconds of the base scene's first window.

    Parameters
    ----------
    base : Chunk
        Windows of the base scene.
    folder : Path
        For the files of the run; removed.

    Returns
    -------
    float
        s.
    """
    first = replace(base, folder=folder, windows=base.windows[:1])
    run_chunk(first)
    seconds = window_seconds(first)
    shutil.rmtree(folder)
    return seconds


def window_seconds(chunk: Chunk) -> float:
    """CPU seconds that a chunk's windows took.

    Parameters
    ----------
    chunk : Chunk
        Windows that have ended.
    """
    records = json.loads(chunk.path("cost", ".json").read_text())
    return float(sum(record[WINDOW_CPU] for record in records if WINDOW_CPU in record))


def run_member(chunk: Chunk, name: str, factor: float) -> dict[str, Any]:
    """Run a member in a folder of its own, which is left only while it is not finished.

    Parameters
    ----------
    chunk : Chunk
        Windows of the setting.
    name : str
        Of the member's folder.
    factor : float
        Of the wind's stress.

    Returns
    -------
    dict of object
        Statistics and cost, or ``fault`` alone.
    """
    member = replace(
        chunk, scene=with_stress(chunk.scene, factor), folder=chunk.folder / "members" / name
    )
    try:
        run_chunk(member)
    except FloeError as error:
        return {"fault": str(error)}
    first, snapshots, series = read_member(member)
    found, drift = run_statistics(member.scene.domain, first, snapshots[-1], series)
    faults = [instability(last, found.values()) for last in snapshots]
    seconds = window_seconds(member)
    outcome = read_outcome(name, "", [member.path("cost", ".json")], member.folder / "cpu")
    shutil.rmtree(member.folder)
    if any(faults):
        return {"fault": next(filter(None, faults))}
    fields = [[[_or_none(v) for v in row] for row in field] for field in drift.tolist()]
    return {
        "fault": "",
        "statistics": found,
        "start": totals(first),
        "drift": fields,
        "cpu_seconds": seconds,
        "cpu": outcome.cpu,
        "elements": outcome.elements,
        "steps": outcome.steps,
        "element_steps": outcome.element_steps,
        "time_step": outcome.time_step,
    }


def _or_none(value: float) -> float | None:
    """A number as JSON has it: it knows no NaN."""
    return value if np.isfinite(value) else None


def read_member(chunk: Chunk) -> tuple[xr.Dataset, list[xr.Dataset], xr.Dataset]:
    """State 0, snapshots of all windows and series of a finished chunk.

    Parameters
    ----------
    chunk : Chunk
        Windows that have ended.
    """
    samples, scalars = read_series([chunk.path("series")], chunk.scene.effects)
    snapshots = list(read_snapshots([chunk.path("elements")]))
    return read_state(chunk.state), snapshots, xr.merge([samples, scalars])


def parting(chunk: Chunk) -> dict[str, Any]:
    """How fast runs part that differ by little.

    Parameters
    ----------
    chunk : Chunk
        Windows of the base run.

    Returns
    -------
    dict
        ``time`` of the boundaries (s), ``drift``, mean distance from the start (m) at each, and
        ``apart``: of each change of the wind's stress the rms distance (m) from the same elements
        of the unchanged run.
    """
    ends = {}
    for number, nudge in enumerate((0.0, *PARTING)):
        member = replace(
            chunk,
            scene=with_stress(chunk.scene, 1.0 + nudge),
            folder=chunk.folder / "members" / f"parting-{number}",
        )
        run_chunk(member)
        first, ends[nudge], _ = read_member(member)
        shutil.rmtree(member.folder)
    plain = ends.pop(0.0)
    drift = []
    for last in plain:
        moved, step = displacement(first, last)
        drift.append(mean(np.hypot(step[:, 0], step[:, 1]), moved["area"].values))
    apart = {
        f"{nudge:g}": [distance(one, two) for one, two in zip(plain, states, strict=True)]
        for nudge, states in ends.items()
    }
    times = [float(last.attrs["time"] - first.attrs["time"]) for last in plain]
    return {"time": times, "drift": drift, "apart": apart}


def distance(one: xr.Dataset, two: xr.Dataset) -> float:
    """Root mean square distance between the same elements of two snapshots (m).

    Parameters
    ----------
    one : xarray.Dataset
        Snapshots.
    two : xarray.Dataset
        Snapshots.

    Returns
    -------
    float
        Weighted by the area of the first.
    """
    _, here, there = np.intersect1d(
        one["id"].values, two["id"].values, assume_unique=True, return_indices=True
    )
    gaps = np.stack([one[a].values[here] - two[a].values[there] for a in "xy"])
    return float(np.sqrt(mean((gaps**2).sum(axis=0), one["area"].values[here])))
