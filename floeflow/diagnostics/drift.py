# SPDX-License-Identifier: GPL-2.0-or-later
"""Statistics of drift from positions at window boundaries.

What buoys are analysed for: how far the ice goes, how fast its displacement grows with the time
lag, how fast neighbours part. Positions between two boundaries are not known here, so distances
are those of the polygon through the boundaries.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floeflow.core.errors import FloeError

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def drift_distance(x: Array, y: Array) -> Array:
    """Distance that each element has gone since the first boundary.

    Parameters
    ----------
    x, y : ndarray
        Positions (m), (boundary, element).

    Returns
    -------
    ndarray
        m, (boundary, element): the sum of the straight ways between boundaries, 0 at the first.
    """
    gone = np.zeros_like(x)
    np.cumsum(np.hypot(np.diff(x, axis=0), np.diff(y, axis=0)), axis=0, out=gone[1:])
    return gone


def mean_squared_displacement(time: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Mean squared displacement of the elements over lags of whole windows.

    The mean runs over all elements and all pairs of boundaries that are this lag apart (Taylor
    1921; for ice, Martin & Thorndike 1985), by MDAnalysis' windowed algorithm. MDAnalysis keeps
    positions in single precision; it is given the displacements since the first boundary, which
    have the same differences and lose 1e-7 of themselves, not of the distance to the pole.

    Parameters
    ----------
    time : ndarray
        Times of the boundaries (s), equally spaced, at least two.
    x, y : ndarray
        Positions (m), (boundary, element), at least one element.

    Returns
    -------
    tuple of ndarray
        Lags (s), from 0, and mean squared displacement (m2), each (boundary,).

    Raises
    ------
    FloeError
        Where there are fewer than two boundaries, no element, or windows of unequal length.
    """
    # Half a second to import, and diagnostics has no need of it.
    import MDAnalysis
    from MDAnalysis.analysis.msd import EinsteinMSD

    frames, elements = x.shape
    if frames < 2 or elements == 0:
        raise FloeError(
            f"mean squared displacement: {frames} boundaries and {elements} elements are too few"
        )
    step = float(time[1] - time[0])
    if not np.allclose(np.diff(time), step, rtol=1e-9):
        raise FloeError("mean squared displacement: the windows are not of one length")
    places = np.zeros((frames, elements, 3), dtype=np.float32)
    places[..., 0] = x - x[0]
    places[..., 1] = y - y[0]
    universe = MDAnalysis.Universe.empty(elements, trajectory=False)
    universe.load_new(places, order="fac", dt=step)
    found = EinsteinMSD(universe, msd_type="xy", fft=False).run()
    return step * np.arange(frames, dtype=np.float64), np.asarray(found.results.timeseries)


def relative_dispersion(x: Array, y: Array, pairs: Index) -> Array:
    """Mean squared change of the vectors between paired elements since the first boundary.

    0 as long as all pairs move alike; it grows where the ice turns, shears or breaks apart
    (relative dispersion as in Martin & Thorndike 1985 and Rampal et al. 2008, there with pairs of
    buoys).

    Parameters
    ----------
    x, y : ndarray
        Positions (m), (boundary, element).
    pairs : ndarray
        Columns of the paired elements, (pair, 2).

    Returns
    -------
    ndarray
        m2, (boundary,).

    Raises
    ------
    FloeError
        Where there is no pair.
    """
    if not len(pairs):
        raise FloeError("relative dispersion: there is no pair of elements")
    squares = np.zeros((len(x), len(pairs)))
    for places in (x, y):
        between = places[:, pairs[:, 1]] - places[:, pairs[:, 0]]
        squares += (between - between[0]) ** 2
    return np.asarray(squares.mean(axis=1))
