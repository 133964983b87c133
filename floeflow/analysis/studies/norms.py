# SPDX-License-Identifier: GPL-2.0-or-later
"""Error norms of a run against a reference run, each relative to what happens in the reference.

Positions of the elements, concentration and thickness on the scene's grid, ice volume and area,
number and place of broken bonds, deformation.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from floeflow.analysis.studies.compare import RunEnds, differences, scales
from floeflow.diagnostics.collect import with_shares
from floeflow.diagnostics.gridded import make_grid
from floeflow.scene import Scene


def on_grid(scene: Scene, ends: RunEnds, mask: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """Gridded concentration and thickness at start and end of a run.

    Parameters
    ----------
    scene : Scene
        Its keys.
    ends : RunEnds
        Start and end of the run.
    mask : xarray.Dataset
        With land.

    Returns
    -------
    tuple of xarray.Dataset
        At the start and at the end, (y, x); 1 and m.
    """
    names = ["siconc", "sithick"]
    first, last = (
        with_shares(make_grid(scene, state, mask)[names].isel(time=0))
        for state in (ends.first, ends.last)
    )
    return first, last


def errors(
    reference: RunEnds,
    ends: RunEnds,
    grids: tuple[tuple[xr.Dataset, xr.Dataset], tuple[xr.Dataset, xr.Dataset]],
) -> tuple[dict[str, float], dict[str, float]]:
    """Errors of a run, and the scales to which they are relative.

    Parameters
    ----------
    reference, ends : RunEnds
        Of one scene.
    grids : tuple of tuple of xarray.Dataset
        Start and end of the reference, then of the run, from `on_grid` with one scene and mask.

    Returns
    -------
    tuple of dict
        By norm; absolute errors, never negative.
    """
    found = {name: abs(value) for name, value in differences(reference, ends).items()}
    scale = {**scales(reference), "bonds": 1.0, "bonds_elsewhere": 1.0, "deformation": 1.0}
    (start, truth), (_, field) = grids
    for name in ("siconc", "sithick"):
        found[name] = _rms(field[name], truth[name])
        # What happens in the run, but a hundredth of the field at least.
        scale[name] = max(_rms(truth[name], start[name]), 0.01 * _rms(truth[name], 0.0))
    return found, scale


def _rms(one: xr.DataArray, other: xr.DataArray | float) -> float:
    difference = one.fillna(0.0) - (other.fillna(0.0) if isinstance(other, xr.DataArray) else other)
    return float(np.sqrt((difference**2).mean()))


def relative(found: Mapping[str, float], scale: Mapping[str, float]) -> dict[str, float]:
    """Errors over their scales.

    Parameters
    ----------
    found : mapping of float
        By norm, in one unit.
    scale : mapping of float
        By norm, in one unit.

    Returns
    -------
    dict of float
        1; 0 where the scale is 0.
    """
    return {name: value / scale[name] if scale[name] else 0.0 for name, value in found.items()}
