# SPDX-License-Identifier: GPL-2.0-or-later
"""Statistics of one run that are worth comparing where ice breaks chaotically.

Motion is that from the start of the run to its end, averaged over boxes of one size: drift and
deformation of the same scales can be compared between elements of different sizes and windows of
different lengths.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.analysis.studies.compare import totals
from floeflow.diagnostics.collect import broken_by_motion, displacement, intact
from floeflow.scene.blocks import Domain
from floeflow.state.snapshots import bonded_length

Array = NDArray[np.float64]

# Width of the boxes over which motion is averaged (m), and how many there are at least across the
# domain's shorter side.
BOX, LEAST_BOXES = 150e3, 6
# Elements must cover this share of a box for its mean to count.
COVERED = 0.3
DAY = 86400.0


@dataclass(frozen=True)
class Boxes:
    """Boxes of the domain: nx times ny of them, with a width of ``width`` m."""

    x_min: float
    y_min: float
    width: float
    nx: int
    ny: int


def make_boxes(domain: Domain) -> Boxes:
    """Square boxes that cover the domain.

    Parameters
    ----------
    domain : Domain
        Rectangle of the scene (m).
    """
    sides = domain.x_max - domain.x_min, domain.y_max - domain.y_min
    width = min(BOX, min(sides) / LEAST_BOXES)
    nx, ny = (max(1, int(np.ceil(side / width - 1e-9))) for side in sides)
    return Boxes(domain.x_min, domain.y_min, width, nx, ny)


def box_sums(boxes: Boxes, x: Array, y: Array, amount: Array) -> Array:
    """Sum of amounts at places x, y (m) over each box, (ny, nx); places outside do not count.

    Parameters
    ----------
    boxes : Boxes
        Squares (m).
    x : ndarray
        Places (m), (n,).
    y : ndarray
        Places (m), (n,).
    amount : ndarray
        (n,).

    Returns
    -------
    ndarray
        In the unit of the amount.
    """
    column = np.floor((x - boxes.x_min) / boxes.width).astype(np.int64)
    row = np.floor((y - boxes.y_min) / boxes.width).astype(np.int64)
    inside = (column >= 0) & (column < boxes.nx) & (row >= 0) & (row < boxes.ny)
    place = row[inside] * boxes.nx + column[inside]
    sums = np.bincount(place, amount[inside], boxes.nx * boxes.ny).astype(np.float64)
    return sums.reshape(boxes.ny, boxes.nx)


def box_drift(boxes: Boxes, first: xr.Dataset, last: xr.Dataset) -> Array:
    """Mean velocity of the ice that started in each box (m s-1), (2, ny, nx).

    NaN where elements that are there at the start and the end cover less than `COVERED` of the box.

    Parameters
    ----------
    boxes : Boxes
        Squares (m).
    first : xarray.Dataset
        Snapshots.
    last : xarray.Dataset
        Snapshots.

    Returns
    -------
    ndarray
        Components u and v.
    """
    moved, step = displacement(first, last)
    area, length = moved["area"].values, float(last.attrs["time"] - first.attrs["time"])
    x, y = (moved[axis].values - step[:, k] for k, axis in enumerate("xy"))
    held = box_sums(boxes, x, y, area)
    means = np.stack([box_sums(boxes, x, y, area * step[:, k]) for k in range(2)])
    counts = held >= COVERED * boxes.width**2
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(counts, means / held / length, np.nan)


def box_deformation(boxes: Boxes, drift: Array) -> Array:
    """Total deformation rate of box means, sqrt(divergence² + shear²) (s-1), (ny-2, nx-2).

    Central differences over two boxes; NaN where a neighbour is.

    Parameters
    ----------
    boxes : Boxes
        Squares (m).
    drift : ndarray
        m/s, (2, ny, nx).

    Returns
    -------
    ndarray
        1/s.
    """
    u, v = drift
    over = 2.0 * boxes.width
    u_x, v_x = ((f[1:-1, 2:] - f[1:-1, :-2]) / over for f in (u, v))
    u_y, v_y = ((f[2:, 1:-1] - f[:-2, 1:-1]) / over for f in (u, v))
    shear = np.hypot(u_x - v_y, u_y + v_x)
    return np.asarray(np.hypot(u_x + v_y, shear))


def run_statistics(
    domain: Domain, first: xr.Dataset, last: xr.Dataset, series: xr.Dataset
) -> tuple[dict[str, float], Array]:
    """Statistics of a run.

    Parameters
    ----------
    domain : Domain
        The scene's.
    first : xarray.Dataset
        State 0.
    last : xarray.Dataset
        Snapshot of the elements at the end.
    series : xarray.Dataset
        Series of all windows.

    Returns
    -------
    tuple of dict and ndarray
        Those of the following that the effects bring, by name; and the velocities of the boxes
        (m s-1), (2, ny, nx).

        - ``volume``: m of ice over the sea; ``area``: share of the sea
        - ``deformation``, ``strong_deformation``: mean and 90th percentile over boxes (per day)
        - ``ridged``: area that ridging used up, share of the sea
        - ``broken``: bonds that broke, of those at the start
        - ``bonded``: length that bonds hold, of that at the start
        - ``patchiness``: standard deviation over boxes of the share of outlines that bonds hold,
          over its mean
    """
    boxes = make_boxes(domain)
    drift = box_drift(boxes, first, last)
    rates = box_deformation(boxes, drift)
    found = dict(totals(last))
    known = rates[np.isfinite(rates)] * DAY
    if known.size:
        found["deformation"] = float(known.mean())
        found["strong_deformation"] = float(np.quantile(known, 0.9))
    if "ridged_area" in series:
        lost = float(np.sum(series["ridged_area"].values))
        found["ridged"] = lost / float(first.attrs["ocean_area"])
    if "bond_id_lo" in first and len(intact(first)):
        windows = np.unique(series["sample_window"].values)
        found["broken"] = float(broken_by_motion(series, windows)[-1]) / len(intact(first))
        found |= _held(boxes, first, last)
    return found, drift


def _held(boxes: Boxes, first: xr.Dataset, last: xr.Dataset) -> dict[str, float]:
    """Length that bonds hold, and how unevenly it is spread."""
    length, start = last["bonded_length"].values, bonded_length(first)
    x, y = last["x"].values, last["y"].values
    held = box_sums(boxes, x, y, length)
    # An outline is about as long as that of a disc of the element's area.
    whole = box_sums(boxes, x, y, 2.0 * np.sqrt(np.pi * last["area"].values))
    share = held[whole > 0.0] / whole[whole > 0.0]
    return {
        "bonded": float(length.sum() / start.sum()),
        "patchiness": float(share.std() / share.mean()) if share.mean() > 0.0 else 0.0,
    }
