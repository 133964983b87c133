# SPDX-License-Identifier: GPL-2.0-or-later
"""The seasonal cycle of a run: what observers of the Arctic's ice publish about it.

Each function takes what a run publishes (``grid.nc``, ``series/``, ``elements/``) and gives numbers
in SI units, so that they can be laid beside published ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import pyproj
import xarray as xr
from numpy.typing import NDArray

from floeflow.diagnostics.collect import with_shares

Array = NDArray[np.float64]

DAY = 86400.0
# The extent counts cells with at least this share of ice.
EDGE = 0.15


@dataclass(frozen=True)
class Cycle:
    """Monthly means, in the order of the run's months.

    Attributes
    ----------
    months : ndarray
        First days of the months, datetime64, (months,).
    area, extent : ndarray
        Area of the ice, and of the sea of cells with at least 15 % of ice (m2), (months,).
    volume : ndarray
        Of the ice (m3), (months,).
    thickness : ndarray
        Mean over the ice of the central basin (m), (months,).
    """

    months: NDArray[np.datetime64]
    area: Array
    extent: Array
    volume: Array
    thickness: Array


def central(lon: Array, lat: Array) -> NDArray[np.bool_]:
    """Whether places lie in the deep basin, away from its coasts and from the Atlantic's gates.

    North of 80 N; between 40 W and 70 E, where ice leaves for the Atlantic, north of 85 N.

    Parameters
    ----------
    lon : ndarray
        Degrees.
    lat : ndarray
        Degrees.

    Returns
    -------
    ndarray
        Of the shape of ``lon``.
    """
    gates = (lon > -40.0) & (lon < 70.0)
    return np.asarray(lat >= np.where(gates, 85.0, 80.0))


def cycle(grid: xr.Dataset) -> Cycle:
    """Monthly means of what ``grid.nc`` holds at its times.

    A month counts with the times of its own that the run has: the first and the last month of a
    run may be short.

    Parameters
    ----------
    grid : xarray.Dataset
        On ``time``, ``y`` and ``x``.

    Returns
    -------
    Cycle
        Area and extent (m2), volume (m3) and thickness (m) of each month that is there.
    """
    grid, sea = with_shares(grid), grid["sea_area"].values
    share, volume = (grid[name].fillna(0.0).values for name in ("siconc", "sivol"))
    area = (share * sea).sum(axis=(1, 2))
    extent = np.where(share >= EDGE, sea, 0.0).sum(axis=(1, 2))
    total = (volume * sea).sum(axis=(1, 2))
    inside = central(grid["lon"].values, grid["lat"].values)
    ice = (share * sea)[:, inside].sum(axis=1)
    mean = np.divide((volume * sea)[:, inside].sum(axis=1), ice, where=ice > 0.0, out=0.0 * ice)
    months = grid["time"].values.astype("datetime64[M]")
    known, index = np.unique(months, return_inverse=True)
    count = np.bincount(index)

    def means(values: Array) -> Array:
        return np.asarray(np.bincount(index, weights=values) / count)

    return Cycle(known, means(area), means(extent), means(total), means(mean))


def passed(series: Iterable[xr.Dataset], gate: str) -> tuple[float, float]:
    """Ice that passed a gate in all windows: area (m2) and volume (m3), out minus in.

    Parameters
    ----------
    series : iterable of xarray.Dataset
        Of each chunk of windows.
    gate : str
        Its name.

    Returns
    -------
    tuple of float
        m2 and m3.
    """
    area = volume = 0.0
    for chunk in series:
        area += float(chunk[f"gate_area_{gate}"].sum())
        volume += float(chunk[f"gate_volume_{gate}"].sum())
    return area, volume


def total(series: Iterable[xr.Dataset], name: str) -> float:
    """Sum over all windows of one of the series' terms.

    Parameters
    ----------
    series : iterable of xarray.Dataset
        Of each chunk of windows.
    name : str
        Of the term.

    Returns
    -------
    float
        In the unit of the term.
    """
    return sum(float(chunk[name].sum()) for chunk in series)


def month_sums(
    series: Iterable[xr.Dataset], names: Iterable[str], start: str, window: float
) -> dict[str, float]:
    """Sums of the series' terms over the windows of each month.

    Parameters
    ----------
    series : iterable of Dataset
        Files of ``series/``, one a chunk.
    names : iterable of str
        Terms; they are added to each other, and one that a run lacks is nothing.
    start : str
        Date of the run's start.
    window : float
        Length of a window (s).

    Returns
    -------
    dict
        By the months in which the windows' middles lie, such as ``1982-03``.
    """
    found: dict[str, float] = {}
    wanted = list(names)
    for chunk in series:
        ended = window * chunk["window"].values
        middles = np.datetime64(start, "s") + (ended - 0.5 * window).astype("timedelta64[s]")
        per = np.zeros(len(middles))
        for name in wanted:
            per = per + chunk[name].values if name in chunk else per
        for month, value in zip(middles.astype("datetime64[M]").astype(str), per, strict=True):
            found[month] = found.get(month, 0.0) + float(value)
    return found


@dataclass(frozen=True)
class Ridged:
    """Shares of the ice's area and of its volume that are ridged (1), by month."""

    months: NDArray[np.datetime64]
    area: Array
    volume: Array


def ridged(grid: xr.Dataset) -> Ridged:
    """Share of the ice that is ridged, of monthly means, from ``grid.nc`` with ridges.

    Parameters
    ----------
    grid : xarray.Dataset
        On ``time``, ``y`` and ``x``.

    Returns
    -------
    Ridged
        Shares of area and of volume (1) of each month.
    """
    grid, sea = with_shares(grid), grid["sea_area"].values
    share, of_ice, thick, volume = (
        grid[name].fillna(0.0).values for name in ("siconc", "sirdgconc", "sirdgthick", "sivol")
    )
    months = grid["time"].values.astype("datetime64[M]")
    known, index = np.unique(months, return_inverse=True)

    def sums(values: Array) -> Array:
        return np.asarray(np.bincount(index, weights=(values * sea).sum(axis=(1, 2))))

    area, amount = share * of_ice, share * of_ice * thick
    return Ridged(known, sums(area) / sums(share), sums(amount) / sums(volume))


@dataclass(frozen=True)
class Drift:
    """Net displacement of elements of the central basin over a day (m/s): quartiles, by month."""

    months: NDArray[np.datetime64]
    lower: Array
    median: Array
    upper: Array


def drift(
    elements: Iterable[xr.Dataset],
    remapped: Iterable[int],
    crs: str,
    window: float,
    skipped: int = 0,
) -> Drift:
    """Speed from displacements over one window, of elements of the central basin.

    Parameters
    ----------
    elements : iterable of Dataset
        Files of ``elements/``, one a chunk, in order.
    remapped : iterable of int
        Windows at whose end ice was remapped between elements: their displacements are left out.
    crs : str
        Of the coordinates.
    window : float
        Length of a window (s).
    skipped : int
        Windows at the run's start that do not count.

    Returns
    -------
    Drift
        Quartiles of the speed (m/s) of each month.
    """
    to_places = pyproj.Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
    left_out = set(remapped)
    found: dict[str, list[Array]] = {}
    before: xr.Dataset | None = None
    for now in _boundaries(elements, skipped):
        if before is not None and int(now.attrs["window"]) not in left_out:
            _, i, j = np.intersect1d(
                before["id"].values, now["id"].values, assume_unique=True, return_indices=True
            )
            lon, lat = to_places.transform(now["x"].values[j], now["y"].values[j])
            here = central(np.asarray(lon), np.asarray(lat)) & (now["type"].values[j] == 1)
            path = [(now[k].values[j] - before[k].values[i])[here] for k in ("drift_x", "drift_y")]
            month = str(now["time"].values)[:7]
            found.setdefault(month, []).append(np.hypot(*path) / window)
        before = now
    quartiles = np.array(
        [np.percentile(np.concatenate(found[month]), (25, 50, 75)) for month in sorted(found)]
    )
    months = np.array(sorted(found), "datetime64[M]")
    return Drift(months, quartiles[:, 0], quartiles[:, 1], quartiles[:, 2])


def _boundaries(elements: Iterable[xr.Dataset], skipped: int) -> Iterable[xr.Dataset]:
    """Elements at the end of each window but the skipped ones, from the chunks' files."""
    names = ["id", "type", "x", "y", "drift_x", "drift_y"]
    for chunk in elements:
        counts = chunk["element_count"].values
        for at, end in enumerate(np.cumsum(counts)):
            if int(chunk["window"][at]) <= skipped:
                continue
            rows = slice(int(end - counts[at]), int(end))
            one = chunk[names].isel(element=rows).load()
            one["time"] = chunk["time"][at]
            yield one.assign_attrs(window=int(chunk["window"][at]))


def swing(found: Cycle) -> float:
    """Largest minus smallest monthly thickness of the central basin (m).

    Parameters
    ----------
    found : Cycle
        Monthly means.

    Returns
    -------
    float
        m.
    """
    return float(found.thickness.max() - found.thickness.min())


def month_of(found: Cycle, values: Array, *, largest: bool) -> int:
    """Month of the year (1 to 12) of the largest or the smallest monthly mean.

    Parameters
    ----------
    found : Cycle
        Monthly means of the last year.
    values : ndarray
        One a month, (months,).
    largest : bool
        Whether the largest is asked for.

    Returns
    -------
    int
        1 to 12.
    """
    at = values.argmax() if largest else values.argmin()
    return int(found.months[at].astype(int) % 12) + 1


def by_month(found: Cycle, values: Array) -> Mapping[int, float]:
    """The last year's monthly means, keyed 1 to 12.

    Parameters
    ----------
    found : Cycle
        Monthly means of the last year.
    values : ndarray
        One a month, (months,).

    Returns
    -------
    mapping of float
        In the unit of the values.
    """
    numbers = found.months.astype(int) % 12 + 1
    return {int(n): float(v) for n, v in zip(numbers, values, strict=True)}
