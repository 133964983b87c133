# SPDX-License-Identifier: GPL-2.0-or-later
"""One run of a study: the scene with some keys changed, run, and compared with the base run."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import xarray as xr

from floeflow.analysis.studies.compare import (
    RunEnds,
    differences,
    mean_drift,
    read_ends,
    scales,
    totals,
)
from floeflow.analysis.studies.outcome import Outcome, read_outcome
from floeflow.analysis.studies.variants import BASE, Variant
from floeflow.core.errors import FloeError
from floeflow.core.records import cpu_seconds
from floeflow.coupling.chunk import Chunk, run_chunk

# Ice does not drift faster: such a run is unstable though it ended.
FASTEST = 5.0  # m/s


def results_of(reference: RunEnds, ends: RunEnds) -> tuple[dict[str, Any], str]:
    """Headline results of a run, and how far they lie from the base run's; or its fault.

    A run whose results are not finite, or whose ice is faster than any, failed too.

    Parameters
    ----------
    reference : RunEnds
        Start and end of the base run.
    ends : RunEnds
        Of this run.

    Returns
    -------
    tuple of dict of object and str
        Results in SI units, and the fault; empty for none.
    """
    found: dict[str, Any] = {
        "scales": dict(scales(reference)),
        "differences": differences(reference, ends),
        "drift": mean_drift(ends),
        **totals(ends.last),
    }
    fault = instability(ends.last, found["differences"].values())
    return ({}, fault) if fault else (found, "")


def instability(state: xr.Dataset, numbers: Iterable[float]) -> str:
    """Why a run that ended failed all the same; empty where it did not.

    Parameters
    ----------
    state : xarray.Dataset
        With the velocities of its elements.
    numbers : iterable of float
        Its results.
    """
    speed = float(abs(state["u"].values).max(initial=0.0))
    if speed > FASTEST or not all(map(math.isfinite, numbers)):
        return f"unstable: the ice moves at {speed:.3g} m/s"
    return ""


def run_variant(
    variant: Variant, chunk: Chunk, base: Mapping[str, Any] | None, stages: Path
) -> dict[str, Any]:
    """Run a variant and return its record, in JSON types.

    Parameters
    ----------
    variant : Variant
        What it changes.
    chunk : Chunk
        All its windows.
    base : mapping or None
        Record of the study's base run; None for the base run itself.
    stages : Path
        Folder with the CPU seconds of the stages before the windows.

    Raises
    ------
    FloeError
        Where the base run fails. A variant that fails is a result: its record says why.
    """
    fault, began, ran = "", cpu_seconds(), 0
    try:
        ran = run_chunk(chunk)
    except FloeError as error:
        if variant.name == BASE:
            raise FloeError(f"the scene itself does not run: {error}") from None
        fault = str(error)
    # A job that went on after an interruption does not know what all windows took.
    job = cpu_seconds() - began if ran == len(chunk.windows) else None
    outcome = read_outcome(chunk.scene.name, fault, [chunk.path("cost", ".json")], stages, job)
    ends = [str(chunk.state), str(chunk.path("state"))]
    found: dict[str, Any] = {}
    if not fault:
        own = read_ends(*map(Path, ends))
        reference = own if base is None else read_ends(*map(Path, base["ends"]))
        found, outcome.fault = results_of(reference, own)
    return as_record(variant, chunk, outcome, found) | {"ends": ends}


def as_record(
    variant: Variant, chunk: Chunk, outcome: Outcome, results: dict[str, Any]
) -> dict[str, Any]:
    """What is kept of a run.

    Parameters
    ----------
    variant : Variant
        What was changed.
    chunk : Chunk
        What was run.
    outcome : Outcome
        Cost and fault.
    results : dict of object
        Headline results.

    Returns
    -------
    dict of object
        JSON values.
    """
    return {
        "variant": variant.name,
        "group": variant.group,
        "label": variant.label,
        "changes": variant.changes,
        "effects": list(chunk.scene.effects),
        **asdict(outcome),
        "cpu_seconds": outcome.cpu_seconds,
        "results": results,
    }
