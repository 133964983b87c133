# SPDX-License-Identifier: GPL-2.0-or-later
"""Deformation of the ice from triangles of elements, and how it depends on the scale.

As it is done with buoys and with RGPS (Marsan et al. 2004; Hutchings et al. 2012): gradients of the
displacements of three elements, averaged over boxes of growing size, and moments of the total
deformation. Hutchings et al. (2024) show that the exponents depend on how triangles are chosen and
filtered and on the noise, so they are to be compared only with what was made in the same way, and
not below 10 km; signed gradients cancel in boxes (Beaudry & Tremblay 2026).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Orders of the moments.
ORDERS = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0])
# Triangles with a longer side than this many spacings span leads or bays, and thin ones are noise.
LONGEST = 2.5
SMALLEST_ANGLE = np.radians(15.0)
# A box counts where triangles cover at least this share of it.
COVERED = 0.5
# Fits use boxes of at least this many spacings of the elements, with at least this many samples.
FIT_FROM = 2.5
FIT_SAMPLES = 30


@dataclass(frozen=True)
class Strain:
    """Velocity gradients of pieces of ice.

    Attributes
    ----------
    x, y : ndarray
        Centres (m), (piece,).
    area : ndarray
        Areas (m2), (piece,).
    gradients : ndarray
        du/dx, du/dy, dv/dx, dv/dy (1/s), (piece, 4).
    """

    x: Array
    y: Array
    area: Array
    gradients: Array

    @property
    def divergence(self) -> Array:
        """Rate of divergence (1/s), (piece,)."""
        return np.asarray(self.gradients[:, 0] + self.gradients[:, 3])

    @property
    def shear(self) -> Array:
        """Largest rate of shear (1/s), (piece,)."""
        ux, uy, vx, vy = self.gradients.T
        return np.asarray(np.hypot(ux - vy, uy + vx))

    @property
    def total(self) -> Array:
        """Total deformation, the root of the sum of both squares (1/s), (piece,)."""
        return np.asarray(np.hypot(self.divergence, self.shear))


def triangles(x: Array, y: Array, spacing: float) -> Index:
    """Delaunay triangles of elements that are neighbours, (triangle, 3).

    Parameters
    ----------
    x, y : ndarray
        Positions (m), (element,).
    spacing : float
        Typical distance of neighbours (m): triangles with a side longer than `LONGEST` of it, or
        with an angle below `SMALLEST_ANGLE`, are left out.

    Returns
    -------
    ndarray
        Rows of the corners, (triangle, 3).
    """
    # A third of a second to import, and most of the diagnostics have no need of it.
    from scipy.spatial import Delaunay, QhullError

    if len(x) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    try:
        found = Delaunay(np.stack([x, y], axis=1)).simplices.astype(np.int64)
    except QhullError:  # all in one line
        return np.zeros((0, 3), dtype=np.int64)
    sides = np.stack(
        [
            np.hypot(x[found[:, a]] - x[found[:, b]], y[found[:, a]] - y[found[:, b]])
            for a, b in ((1, 2), (2, 0), (0, 1))
        ],
        axis=1,
    )
    a, b, c = np.sort(sides, axis=1).T
    # The smallest angle is the one against the shortest side.
    cosine = (b**2 + c**2 - a**2) / (2.0 * b * c)
    return found[(c <= LONGEST * spacing) & (cosine <= np.cos(SMALLEST_ANGLE))]


def triangle_strain(x: Array, y: Array, u: Array, v: Array, corners: Index) -> Strain:
    """Gradients of velocities that are linear in each triangle.

    Parameters
    ----------
    x, y : ndarray
        Positions (m), (element,).
    u, v : ndarray
        Velocities (m/s), (element,).
    corners : ndarray
        From `triangles`.

    Returns
    -------
    Strain
        Centres (m), areas (m2) and velocity gradients (1/s), one for each triangle.
    """
    x0, y0 = x[corners[:, 0]], y[corners[:, 0]]
    ax, ay = x[corners[:, 1]] - x0, y[corners[:, 1]] - y0
    bx, by = x[corners[:, 2]] - x0, y[corners[:, 2]] - y0
    twice = ax * by - ay * bx
    parts = []
    for w in (u, v):
        one, two = (w[corners[:, k]] - w[corners[:, 0]] for k in (1, 2))
        parts += [(one * by - two * ay) / twice, (two * ax - one * bx) / twice]
    return Strain(
        x[corners].mean(axis=1),
        y[corners].mean(axis=1),
        0.5 * np.abs(twice),
        np.stack(parts, axis=1),
    )


def box_strain(fine: Strain, size: float) -> Strain:
    """Means over square boxes of a side (m), weighted by area, of boxes that are `COVERED`.

    Parameters
    ----------
    fine : Strain
        Pieces of the ice with their velocity gradients (1/s).
    size : float
        Side of the boxes (m).

    Returns
    -------
    Strain
        One piece a box.
    """
    column, row = (np.floor(place / size).astype(np.int64) for place in (fine.x, fine.y))
    if not len(column):
        return fine
    key = (row - row.min()) * (column.max() - column.min() + 1) + (column - column.min())
    _, group = np.unique(key, return_inverse=True)
    area = np.asarray(np.bincount(group, fine.area), dtype=np.float64)
    sums = [np.bincount(group, fine.area * part) / area for part in fine.gradients.T]
    x, y = (np.bincount(group, fine.area * place) / area for place in (fine.x, fine.y))
    full = area >= COVERED * size**2
    return Strain(x[full], y[full], area[full], np.stack(sums, axis=1)[full])


def box_sizes(spacing: float, extent: float) -> Array:
    """Sides of the boxes (m): from twice the spacing by factors of root 2 to a third of the ice.

    Parameters
    ----------
    spacing : float
        Of the elements (m).
    extent : float
        Of the ice (m).

    Returns
    -------
    ndarray
        m; none for ice that is too small.
    """
    most = extent / 3.0
    if most < 2.0 * spacing:
        return np.zeros(0)
    steps = int(np.floor(2.0 * np.log2(most / (2.0 * spacing)) + 1e-9)) + 1
    return 2.0 * spacing * np.sqrt(2.0) ** np.arange(steps)


def moment_sums(strain: Strain, orders: Array = ORDERS) -> tuple[int, float, Array]:
    """Number of pieces, sum of their scales (m), sums of total deformation to each order.

    Parameters
    ----------
    strain : Strain
        Pieces of the ice.
    orders : ndarray, optional
        Exponents, (orders,).

    Returns
    -------
    tuple of int, float and ndarray
        Count, m, and sums in 1/s to the power of each order, (orders,).
    """
    scale = float(np.sqrt(strain.area).sum())
    return len(strain.area), scale, np.asarray((strain.total[:, None] ** orders).sum(axis=0))


@dataclass(frozen=True)
class Scaling:
    """Exponents of the moments: ⟨ε^q⟩ ~ L^-β(q).

    Attributes
    ----------
    exponent, error : ndarray
        β and its standard error, of the fit's scatter and of the spread between intervals of
        time, whichever is larger, (order,); NaN where there are too few scales.
    low, high : float
        Range of scales of the fit (m); NaN where there is none.
    """

    exponent: Array
    error: Array
    low: float
    high: float


def fit_scaling(count: Array, scale: Array, moments: Array, spacing: float) -> Scaling:
    """Fit power laws to moments at several scales.

    Parameters
    ----------
    count : ndarray
        Pieces, (interval, scale).
    scale : ndarray
        Sums of their scales (m), (interval, scale).
    moments : ndarray
        Sums of total deformation to each order, (interval, scale, order).
    spacing : float
        Of the elements (m); see `FIT_FROM`.

    Returns
    -------
    Scaling
        Exponents (1), their errors (1), and the scales (m) from and to which they were fitted.
    """
    orders = moments.shape[2]
    none = np.full(orders, np.nan)
    total = count.sum(axis=0)
    length = np.divide(scale.sum(axis=0), total, out=np.full(total.shape, np.nan), where=total > 0)
    used = np.flatnonzero((total >= FIT_SAMPLES) & (length >= FIT_FROM * spacing))
    if used.size < 3 or not (moments.sum(axis=0)[used] > 0.0).all():
        return Scaling(none, none, np.nan, np.nan)
    slopes, scatter = _slopes(count, scale, moments, used)
    # Blocks of intervals are left out one by one (jackknife).
    blocks = np.array_split(np.arange(len(count)), min(10, len(count)))
    spread = np.zeros(orders)
    if len(blocks) > 2:
        parts = []
        for block in blocks:
            kept = np.setdiff1d(np.arange(len(count)), block)
            if (count[kept][:, used].sum(axis=0) > 0).all():
                parts.append(_slopes(count[kept], scale[kept], moments[kept], used)[0])
        if len(parts) > 2:
            n = len(parts)
            spread = np.sqrt((n - 1) / n * ((np.array(parts) - np.mean(parts, 0)) ** 2).sum(0))
    return Scaling(
        -slopes, np.maximum(scatter, spread), float(length[used[0]]), float(length[used[-1]])
    )


def curvature(order: Array, exponent: Array) -> tuple[float, float]:
    """Coefficients a and b of β(q) = a q² + b q by least squares.

    A single fractal has a = 0; Marsan et al. (2004) found a = 0.13, b = 0.07 in winter.

    Parameters
    ----------
    order : ndarray
        Orders q of the moments, (order,).
    exponent : ndarray
        Exponents β of `Scaling`, (order,).

    Returns
    -------
    tuple of float
        a and b; NaN where an exponent is not known.
    """
    if not np.isfinite(exponent).all():
        return np.nan, np.nan
    found = np.linalg.lstsq(np.stack([order**2, order], axis=1), exponent, rcond=None)[0]
    return float(found[0]), float(found[1])


def _slopes(count: Array, scale: Array, moments: Array, used: Index) -> tuple[Array, Array]:
    """Slopes of the logarithms and their standard errors, (order,)."""
    n = count[:, used].sum(axis=0)
    x = np.log(scale[:, used].sum(axis=0) / n)
    y = np.log(moments[:, used].sum(axis=0) / n[:, None])
    dx = x - x.mean()
    slope = dx @ (y - y.mean(axis=0)) / (dx @ dx)
    rest = y - y.mean(axis=0) - dx[:, None] * slope
    freedom = max(len(x) - 2, 1)
    return np.asarray(slope), np.sqrt((rest**2).sum(axis=0) / freedom / (dx @ dx))
