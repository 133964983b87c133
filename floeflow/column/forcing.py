# SPDX-License-Identifier: GPL-2.0-or-later
"""Gridded forcing at the elements: bilinear in space, linear in time; at centres or over discs.

The stencil of every element is found once for a window; a time then costs one gather for each
record that it lies between, and successive times share those.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.sparse import csr_array

from floeflow.column.state import Array
from floeflow.core.discs import disc_places
from floeflow.core.errors import FloeError

WIND = ("wind_u", "wind_v")


class Series:
    """Fields at fixed places as functions of time; made by `sample_series`.

    Keeps the two records gathered last, because successive times mostly lie between the same.
    """

    def __init__(
        self,
        data: xr.Dataset,
        names: tuple[str, ...],
        nodes: NDArray[np.intp],
        weights: Array,
        places: tuple[Array, Array],
        wind_stress: bool = False,
    ) -> None:
        self._data = data
        self._names = names
        self._nodes = nodes
        self._weights = weights
        self._places = places
        self._wind_stress = wind_stress and set(WIND) <= set(names)
        self._time = data["time"].values.astype(float)
        self._records: dict[int, dict[str, Array]] = {}

    def __call__(self, t: float) -> dict[str, Array]:
        """Fields at time t (s), each (n,).

        Raises
        ------
        FloeError
            Where t lies outside the forcing, or a value needed is not finite.
        """
        time = self._time
        slack = 1e-6  # s
        if not time[0] - slack <= t <= time[-1] + slack:
            raise FloeError(
                f"forcing: it covers {time[0]:g} s to {time[-1]:g} s, but {t:g} s is asked for"
            )
        last = max(len(time) - 2, 0)
        k = int(np.clip(np.searchsorted(time, t, side="right") - 1, 0, last))
        if len(time) == 1:
            return self._rooted(dict(self._record(0)))
        share = float(np.clip((t - time[k]) / (time[k + 1] - time[k]), 0.0, 1.0))
        low, high = self._record(k), self._record(k + 1)
        self._records = {k: low, k + 1: high}
        between = {name: low[name] + share * (high[name] - low[name]) for name in self._names}
        return self._rooted(between)

    def _rooted(self, values: dict[str, Array]) -> dict[str, Array]:
        """The wind of a stress |w| w, where that was interpolated."""
        if not self._wind_stress:
            return values
        root = np.sqrt(np.hypot(*(values[name] for name in WIND)))
        return values | {name: values[name] / np.where(root > 0.0, root, 1.0) for name in WIND}

    def _record(self, k: int) -> dict[str, Array]:
        if k not in self._records:
            self._records[k] = {name: self._gather(name, k) for name in self._names}
        return self._records[k]

    def _field(self, name: str, k: int) -> Array:
        field = self._data[name]
        if "time" in field.dims:
            field = field.isel(time=k)
        return np.asarray(field.transpose("y", "x").values.astype(float).ravel())

    def _gather(self, name: str, k: int) -> Array:
        field = self._field(name, k)
        if self._wind_stress and name in WIND:
            field = field * np.hypot(*(self._field(part, k) for part in WIND))
        values = field[self._nodes]
        # A node of no weight may hold anything; it is not looked at.
        used = np.where(self._weights > 0.0, values, 0.0)
        bad = ~np.isfinite(used).all(axis=1)
        if bad.any():
            e = int(np.argmax(bad))
            x, y = self._places[0][e], self._places[1][e]
            raise FloeError(
                f"forcing: {name} is not finite at {self._time[k]:g} s near x = {x:.0f} m, "
                f"y = {y:.0f} m"
            )
        return np.asarray((self._weights * used).sum(axis=1))


def sample_series(
    data: xr.Dataset,
    names: Sequence[str],
    x: Array,
    y: Array,
    *,
    radius: Array | None = None,
    wind_stress: bool = False,
) -> Series:
    """Prepare fields for sampling at places.

    Parameters
    ----------
    data : xarray.Dataset
        Variables (time, y, x) or (y, x) with axes time (s), y and x (m, ascending).
    names : sequence of str
        Variables to sample.
    x, y : ndarray
        Places (m), (n,). Outside the outermost nodes the edge's value holds, as in the dynamics.
    radius : ndarray, optional
        Radii (m), (n,): means over discs around the places, as in the dynamics.
    wind_stress : bool
        Whether means and interpolation keep the wind's stress |w| w, else its velocity.

    Returns
    -------
    Series
        Callable: time (s) to a dict of fields, each (n,).

    Raises
    ------
    FloeError
        For a variable or axis that is missing or not ascending.
    """
    for name in names:
        if name not in data:
            raise FloeError(f"forcing: variable '{name}' is missing")
    for axis in ("time", "y", "x"):
        values = data[axis].values if axis in data else np.array([])
        least = 1 if axis == "time" else 2
        if len(values) < least or values.dtype.kind not in "fi" or np.any(~(np.diff(values) > 0)):
            raise FloeError(f"forcing: axis '{axis}' is missing or its numbers do not ascend")
    x, y = np.asarray(x, float), np.asarray(y, float)
    axes = data["x"].values.astype(float), data["y"].values.astype(float)
    nodes, weights = _stencil(*axes, x, y) if radius is None else _over_discs(*axes, x, y, radius)
    return Series(data, tuple(names), nodes, weights, (x, y), wind_stress)


def _stencil(across: Array, along: Array, x: Array, y: Array) -> tuple[NDArray[np.intp], Array]:
    """The four nodes around each place and their weights, (n, 4)."""
    columns, share_x = _bracket(across, x)
    rows, share_y = _bracket(along, y)
    width = len(across)
    nodes = (rows * width + columns)[:, None] + np.array([0, 1, width, width + 1])
    weights = np.stack(
        [
            (1.0 - share_y) * (1.0 - share_x),
            (1.0 - share_y) * share_x,
            share_y * (1.0 - share_x),
            share_y * share_x,
        ],
        axis=1,
    )
    return nodes, weights


def _over_discs(
    across: Array, along: Array, x: Array, y: Array, radius: Array
) -> tuple[NDArray[np.intp], Array]:
    """Nodes that discs meet and their shares in the means over them, (n, most), 0 beyond."""
    dx, dy = disc_places()
    px, py = x[:, None] + radius[:, None] * dx, y[:, None] + radius[:, None] * dy
    nodes, weights = _stencil(across, along, px.ravel(), py.ravel())
    owner = np.repeat(np.arange(len(x)), nodes.size // max(len(x), 1))
    shape = len(x), len(across) * len(along)
    shares = csr_array((weights.ravel() / dx.size, (owner, nodes.ravel())), shape=shape)
    shares.sum_duplicates()
    count = np.diff(shares.indptr)
    place = np.arange(len(shares.data)) - np.repeat(shares.indptr[:-1], count)
    row = np.repeat(np.arange(len(x)), count)
    most = int(count.max(initial=1))
    met, share = np.zeros((len(x), most), np.intp), np.zeros((len(x), most))
    met[row, place], share[row, place] = shares.indices, shares.data
    return met, share


def _bracket(nodes: Array, places: Array) -> tuple[NDArray[np.intp], Array]:
    """Lower node of each place's interval and the place's share of the interval, 0 to 1."""
    low = np.clip(np.searchsorted(nodes, places, side="right") - 1, 0, len(nodes) - 2)
    share = np.clip((places - nodes[low]) / (nodes[low + 1] - nodes[low]), 0.0, 1.0)
    return low, share
