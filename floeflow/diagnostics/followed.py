# SPDX-License-Identifier: GPL-2.0-or-later
"""Elements that are followed from window to window: positions that mean the same ice.

A remap puts fresh elements on their cells, so nothing is followed across it. Where elements merged
the one that is left jumps to their common centre: it is left out of that step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Elements with less ice than this share are no ice to follow.
ICE = 0.15
# An element jumped where place and path of its ice part by more than this share of the spacing.
JUMP = 0.05


@dataclass(frozen=True)
class Frame:
    """Mobile elements with ice at a window boundary, ascending in id.

    Attributes
    ----------
    window : int
        Its number.
    time : float
        Since the scene's start (s).
    id : ndarray
        (element,).
    x, y : ndarray
        Places (m).
    path_x, path_y : ndarray
        Net displacement of their ice (m); the places themselves where no ice changes elements.
    area, share : ndarray
        Of the elements (m2), and of it under ice (1).
    velocity : ndarray
        Of the elements at the boundary (m/s), u + i v.
    """

    window: int
    time: float
    id: Index
    x: Array
    y: Array
    path_x: Array
    path_y: Array
    area: Array
    share: Array
    velocity: NDArray[np.complex128]

    @property
    def spacing(self) -> float:
        """Typical distance of neighbours (m)."""
        return float(np.sqrt(np.median(self.area))) if self.area.size else np.nan


def frame_of(state: xr.Dataset) -> Frame:
    """What is followed of a state or a snapshot.

    Parameters
    ----------
    state : xarray.Dataset
        State or snapshot.

    Returns
    -------
    Frame
        Of its mobile elements with ice, ascending in id.
    """
    share = state["ice_fraction"].values.sum(axis=1)
    kept = np.flatnonzero((state["type"].values == MOBILE) & (share >= ICE))
    kept = kept[np.argsort(state["id"].values[kept], kind="stable")]
    paths = ("drift_x", "drift_y") if "drift_x" in state else ("x", "y")
    x, y, path_x, path_y, area = (state[name].values[kept] for name in ("x", "y", *paths, "area"))
    return Frame(
        window=int(state.attrs["window"]),
        time=float(state.attrs["time"]),
        id=state["id"].values[kept],
        x=x,
        y=y,
        path_x=path_x,
        path_y=path_y,
        area=area,
        share=share[kept],
        velocity=state["u"].values[kept] + 1j * state["v"].values[kept],
    )


@dataclass(frozen=True)
class Step:
    """Elements that are in two frames and did not jump.

    Attributes
    ----------
    before, after : ndarray
        Their places in the frames, (element,).
    dx, dy : ndarray
        Displacements of their ice (m).
    seconds : float
        Between the frames.
    """

    before: Index
    after: Index
    dx: Array
    dy: Array
    seconds: float


def step_between(one: Frame, two: Frame) -> Step:
    """Displacements between two frames without a remap between them.

    Parameters
    ----------
    one : Frame
        Frames, in the order of time.
    two : Frame
        Frames, in the order of time.

    Returns
    -------
    Step
        Rows in both, displacements (m) and the time between (s).
    """
    _, i, j = np.intersect1d(one.id, two.id, assume_unique=True, return_indices=True)
    dx, dy = two.path_x[j] - one.path_x[i], two.path_y[j] - one.path_y[i]
    off = np.hypot(two.x[j] - one.x[i] - dx, two.y[j] - one.y[i] - dy)
    # A limit of no elements is not a number.
    kept = off <= (JUMP * one.spacing if one.id.size else 0.0)
    return Step(i[kept], j[kept], dx[kept], dy[kept], two.time - one.time)
