# SPDX-License-Identifier: GPL-2.0-or-later
"""Drift of a run at buoys: errors against lead time, beside persistence and free drift.

From each window boundary on at which a buoy is known, a virtual buoy starts at its place and goes
with the run's ice, one with the displacement that the buoy had in the window before (persistence)
and one in free drift under the run's own wind and current. What lies between the buoy and each of
them after a lead time is its error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.core.errors import FloeError
from floeflow.diagnostics.followed import Frame, step_between

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Displacement of free ice in a window (m, complex) at places.
Free = Callable[[int, Complex], Complex]

METHODS = ("run", "persistence", "free_drift")
# Neighbours that carry a virtual buoy, and how many spacings the nearest may be away.
NEIGHBOURS, REACH = 4, 2.0
# A buoy is known at a boundary between fixes that are at most this far apart (s).
GAP = 12 * 3600.0


def at_boundaries(seconds: Array, x: Array, y: Array, boundaries: Array) -> Complex:
    """Places of a buoy at window boundaries, linear between its fixes; NaN in longer gaps.

    Parameters
    ----------
    seconds, x, y : ndarray
        Fixes in the order of time, (fix,).
    boundaries : ndarray
        Times (s), (boundary,).
    """
    keep = np.append(True, np.diff(seconds) > 0.0)
    seconds, places = seconds[keep], (x + 1j * y)[keep]
    after = np.searchsorted(seconds, boundaries)
    out = np.full(boundaries.shape, complex(np.nan, np.nan))
    for k, (at, place) in enumerate(zip(boundaries, after, strict=True)):
        near = seconds[place] if place < seconds.size else np.inf
        if near == at:
            out[k] = places[place]
        elif 0 < place < seconds.size and near - seconds[place - 1] <= GAP:
            share = (at - seconds[place - 1]) / (near - seconds[place - 1])
            out[k] = (1.0 - share) * places[place - 1] + share * places[place]
    return out


@dataclass(frozen=True)
class Carrier:
    """Displacements of the run's ice in a window, at places.

    Attributes
    ----------
    tree : cKDTree
        Of the elements' places at its start.
    moved : ndarray
        Their displacements (m), (element,).
    reach : float
        Of the nearest element (m).
    """

    tree: cKDTree
    moved: Complex
    reach: float

    def at(self, places: Complex) -> Complex:
        """Displacement at places (m): neighbours weighted by distance; NaN far from ice.

        Parameters
        ----------
        places : ndarray
            x + iy (m), (n,).
        """
        out = np.full(places.shape, complex(np.nan, np.nan))
        known = np.flatnonzero(np.isfinite(places))
        if not known.size or not self.moved.size:
            return out
        points = np.stack([places[known].real, places[known].imag], axis=1)
        count = min(NEIGHBOURS, self.moved.size)
        far, near = self.tree.query(points, k=count)
        far, near = far.reshape(-1, count), near.reshape(-1, count)
        weight = 1.0 / np.maximum(far, 1.0) ** 2
        mean = (weight * self.moved[near]).sum(axis=1) / weight.sum(axis=1)
        out[known] = np.where(far[:, 0] <= self.reach, mean, np.nan)
        return out


def carrier(one: Frame, two: Frame) -> Carrier:
    """Displacements between the two boundaries of a window.

    Parameters
    ----------
    one : Frame
        Elements at the start and at the end of the window.
    two : Frame
        Elements at the start and at the end of the window.

    Returns
    -------
    Carrier
        Displacement of the nearest element (m), within reach.
    """
    step = step_between(one, two)
    places = np.stack([one.x[step.before], one.y[step.before]], axis=1)
    reach = REACH * one.spacing if one.id.size else 0.0
    return Carrier(cKDTree(places.reshape(-1, 2)), step.dx + 1j * step.dy, reach)


def velocity_carrier(one: Frame, two: Frame) -> Carrier:
    """As `carrier` where nothing can be followed: by the mean velocity of start and end.

    Parameters
    ----------
    one : Frame
        Elements at the start and at the end of the window.
    two : Frame
        Elements at the start and at the end of the window.

    Returns
    -------
    Carrier
        Displacement of the nearest element (m), within reach.
    """
    places = np.stack([one.x, one.y], axis=1)
    near = cKDTree(np.stack([two.x, two.y], axis=1)).query(places)[1]
    moved = 0.5 * (two.time - one.time) * (one.velocity + two.velocity[near])
    return Carrier(cKDTree(places), moved, REACH * one.spacing)


@dataclass(frozen=True)
class LeadErrors:
    """Errors by lead time.

    Attributes
    ----------
    lead : ndarray
        Windows, from 1, (lead,).
    count : ndarray
        Starts of which all three are known, (lead,).
    rms : ndarray
        Root of the mean square of the distance to the buoy (m), (method, lead), as `METHODS`.
    along : ndarray
        Mean error along and across (to the left of) the buoy's way (m), (2, lead), of the run.
    """

    lead: Array
    count: Array
    rms: Array
    along: Array

    def skill(self, method: str) -> Array:
        """1 - MSE of the run / MSE of another method, (lead,).

        Parameters
        ----------
        method : str
            One of `METHODS`.
        """
        other = self.rms[METHODS.index(method)]
        ratio = np.divide(self.rms[0], other, out=np.full(other.shape, np.nan), where=other > 0)
        return np.asarray(1.0 - ratio**2)


def lead_errors(
    buoys: Sequence[Complex], carriers: Sequence[Carrier | None], free: Free | None, longest: int
) -> LeadErrors:
    """Start virtual buoys at all boundaries and gather their errors.

    Parameters
    ----------
    buoys : sequence of ndarray
        Places of each buoy at all boundaries (m, complex), NaN where unknown, (boundary,).
    carriers : sequence of Carrier or None
        Of each window; None where the run cannot tell.
    free : callable or None
        Free drift; None without wind.
    longest : int
        Largest lead (windows).

    Raises
    ------
    FloeError
        Where no buoy can be followed for a window.
    """
    windows = len(carriers)
    empty = np.zeros((0, windows + 1), dtype=np.complex128)
    observed = np.stack(buoys).astype(np.complex128) if buoys else empty
    most = min(longest, windows)
    squares, count = np.zeros((3, most)), np.zeros(most)
    along = np.zeros((2, most))
    for start in range(windows):
        first = observed[:, start]
        before = observed[:, start - 1] if start else np.full(first.shape, np.nan + 0j)
        chosen = np.flatnonzero(np.isfinite(first) & np.isfinite(before))
        if not chosen.size:
            continue
        step = first[chosen] - before[chosen]
        place = {method: first[chosen].copy() for method in METHODS}
        for lead in range(most):
            window = start + lead
            if window >= windows or carriers[window] is None:
                break
            ice = carriers[window]
            assert ice is not None
            place["run"] += ice.at(place["run"])
            place["persistence"] += step
            if free is not None:
                place["free_drift"] += free(window + 1, place["free_drift"])
            truth = observed[chosen, window + 1]
            good = np.isfinite(truth) & np.isfinite(place["run"]) & np.isfinite(place["free_drift"])
            if not good.any():
                continue
            for k, method in enumerate(METHODS):
                squares[k, lead] += (np.abs(place[method][good] - truth[good]) ** 2).sum()
            count[lead] += good.sum()
            way = truth[good] - first[chosen][good]
            length = np.abs(way)
            off = (place["run"][good] - truth[good]) * way.conj()
            off = np.divide(off, length, out=np.zeros_like(off), where=length > 0)
            along[:, lead] += (off.real.sum(), off.imag.sum())
    known = np.flatnonzero(count > 0)
    if not known.size:
        raise FloeError(
            "buoys: none has fixes over two windows in a row, within the run and within reach of "
            "its ice"
        )
    rms = np.sqrt(squares[:, known] / count[known])
    if free is None:
        rms[METHODS.index("free_drift")] = np.nan
    leads = np.asarray(known + 1.0, dtype=np.float64)
    return LeadErrors(leads, count[known], rms, along[:, known] / count[known])


@dataclass(frozen=True)
class Drifts:
    """Displacements in single windows, of buoys and of the run at their places (m, complex)."""

    observed: Complex
    run: Complex

    @property
    def correlation(self) -> complex:
        """Complex correlation of both."""
        a, b = (each - each.mean() for each in (self.observed, self.run))
        spread = np.sqrt((np.abs(a) ** 2).sum() * (np.abs(b) ** 2).sum())
        return complex((b * a.conj()).sum() / spread) if spread > 0 else complex(np.nan, np.nan)

    @property
    def ratio(self) -> float:
        """Mean distance of the run over that of the buoys."""
        observed = float(np.abs(self.observed).mean())
        return float(np.abs(self.run).mean()) / observed if observed > 0 else np.nan


def window_drifts(buoys: Sequence[Complex], carriers: Sequence[Carrier | None]) -> Drifts:
    """Displacements of all windows in which both are known.

    Parameters
    ----------
    buoys : sequence of Complex
        Places at the boundaries (m), x + i y, (boundaries,) each.
    carriers : sequence of Carrier or None
        Of each window; None where there is no ice.

    Returns
    -------
    Drifts
        Displacements of buoys and of the ice (m).
    """
    pairs: list[tuple[Complex, Complex]] = []
    for window, ice in enumerate(carriers):
        if ice is None:
            continue
        first = np.array([places[window] for places in buoys])
        moved = np.array([places[window + 1] for places in buoys]) - first
        ours = ice.at(first)
        good = np.isfinite(moved) & np.isfinite(ours)
        pairs.append((moved[good], ours[good]))
    joined = (
        [np.concatenate([pair[k] for pair in pairs]) for k in (0, 1)]
        if pairs
        else [np.zeros(0, complex)] * 2
    )
    return Drifts(joined[0], joined[1])
