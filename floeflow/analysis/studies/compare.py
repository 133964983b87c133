# SPDX-License-Identifier: GPL-2.0-or-later
"""How far the results of two runs of one scene lie apart.

Runs with the same packing are compared element by element; with another packing the displacement
is interpolated to the first one's elements.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator
from scipy.spatial import cKDTree

from floeflow.analysis.estimate.cost import WORK
from floeflow.analysis.estimate.influence import DRIFT_FLOOR, ICE_FLOOR
from floeflow.diagnostics.collect import displacement, intact, lost_pairs, mean
from floeflow.state import read_state


@dataclass(frozen=True)
class RunEnds:
    """States of a run at its start and end."""

    first: xr.Dataset
    last: xr.Dataset


def read_ends(first: Path, last: Path) -> RunEnds:
    """States at start and end of a run.

    Parameters
    ----------
    first : Path
        NetCDF files of states.
    last : Path
        NetCDF files of states.

    Returns
    -------
    RunEnds
        Both.

    Raises
    ------
    FloeError
        For a file that cannot be read.
    """
    return RunEnds(read_state(first), read_state(last))


def paths_of(run: RunEnds) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starts (n, 2), displacements (n, 2), areas (n,) of the elements that are there all the time.

    Metres and square metres, in the order of the ids.

    Parameters
    ----------
    run : RunEnds
        First and last state.
    """
    moved, step = displacement(run.first, run.last)
    end = np.stack([moved["x"].values, moved["y"].values], axis=1)
    return end - step, step, moved["area"].values


def drift_difference(base: RunEnds, other: RunEnds) -> float:
    """Root mean square distance of where elements end, m, weighted by area.

    Parameters
    ----------
    base, other : RunEnds
        Of one scene; the elements are those of `base`.
    """
    start, step, area = paths_of(base)
    there, moved, _ = paths_of(other)
    if start.shape != there.shape or not np.allclose(start, there, rtol=0, atol=1e-3):
        moved = _interpolated(there, moved, start)
    distance2 = ((moved - step) ** 2).sum(axis=1)
    return float(np.sqrt(mean(distance2, area)))


def _interpolated(there: np.ndarray, moved: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Displacements between elements: linear, of the nearest element outside of their hull."""
    values = LinearNDInterpolator(there, moved)(start)
    outside = ~np.isfinite(values).all(axis=1)
    values[outside] = NearestNDInterpolator(there, moved)(start[outside])
    return np.asarray(values)


def mean_drift(run: RunEnds) -> float:
    """Mean distance between start and end, m.

    Parameters
    ----------
    run : RunEnds
        First and last state.
    """
    _, step, area = paths_of(run)
    return mean(np.hypot(step[:, 0], step[:, 1]), area)


def totals(state: xr.Dataset) -> dict[str, float]:
    """Ice volume per area of sea (m) and share of the sea under ice of a state.

    Parameters
    ----------
    state : xarray.Dataset
        With ice by element and category.
    """
    ocean = float(state.attrs["ocean_area"])
    names = {"volume": "ice_volume", "area": "ice_fraction"}
    return {
        name: float(state["area"].values @ state[variable].values.sum(axis=1)) / ocean
        for name, variable in names.items()
    }


def broken(run: RunEnds) -> np.ndarray:
    """Pairs of ids whose bond broke in the run, (n, 2); none without bonds.

    Parameters
    ----------
    run : RunEnds
        First and last state.
    """
    if "bond_id_lo" not in run.first:
        return np.zeros((0, 2), dtype=np.int64)
    return lost_pairs(intact(run.first), intact(run.last))


def broken_share_elsewhere(base: RunEnds, other: RunEnds) -> float:
    """Share of the bonds broken in either run that broke in one of them only (Jaccard distance).

    Parameters
    ----------
    base : RunEnds
        Runs from the same bonds.
    other : RunEnds
        Runs from the same bonds.

    Returns
    -------
    float
        0 to 1; 0 where neither broke any.
    """
    one, two = ({tuple(pair) for pair in broken(run).tolist()} for run in (base, other))
    return 1.0 - len(one & two) / len(one | two) if one | two else 0.0


def deformation(run: RunEnds) -> float:
    """Mean total deformation over neighbours, 1: |relative displacement| over distance.

    Over the six nearest neighbours of each element at the start.

    Parameters
    ----------
    run : RunEnds
        First and last state.
    """
    start, step, area = paths_of(run)
    if len(start) < 8:
        return 0.0
    distance, near = cKDTree(start).query(start, k=7)
    relative = np.linalg.norm(step[near[:, 1:]] - step[:, None, :], axis=2) / distance[:, 1:]
    return mean(relative.mean(axis=1), area)


def differences(base: RunEnds, other: RunEnds) -> dict[str, float]:
    """All measures of how far a run lies from another.

    Parameters
    ----------
    base : RunEnds
        Start and end of each run.
    other : RunEnds
        Start and end of each run.

    Returns
    -------
    dict
        drift (m), volume (m of ice over the sea), area (share of the sea), bonds (relative
        difference of the number broken), bonds_elsewhere (share), deformation (relative).
    """
    one, two = totals(base.last), totals(other.last)
    found = {name: two[name] - one[name] for name in one}
    found["drift"] = drift_difference(base, other)
    found["deformation"] = _relative(deformation(other), deformation(base))
    if "bond_id_lo" in base.first and "bond_id_lo" in other.first:
        found["bonds"] = _relative(len(broken(other)), len(broken(base)))
        found["bonds_elsewhere"] = broken_share_elsewhere(base, other)
    return found


def _relative(value: float, reference: float) -> float:
    return (value - reference) / reference if reference else float(value != 0.0)


def work(record: Mapping[str, Any]) -> float:
    """CPU seconds of element model and column of a run's record.

    Parameters
    ----------
    record : mapping
        Seconds of the run's parts.
    """
    return sum(float(record["cpu"].get(part, 0.0)) for part in WORK)


def scales(run: RunEnds) -> Mapping[str, float]:
    """What happens in a run at all, as the estimates have it: drift (m), volume (m), area (1).

    Parameters
    ----------
    run : RunEnds
        First and last state.
    """
    start, end = totals(run.first), totals(run.last)
    found = {name: max(abs(end[name] - start[name]), ICE_FLOOR * start[name]) for name in start}
    return {"drift": max(mean_drift(run), DRIFT_FLOOR), **found}
