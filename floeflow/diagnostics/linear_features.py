# SPDX-License-Identifier: GPL-2.0-or-later
"""Linear features of deformation: narrow bands that carry most of it.

Each element has the mean rate of the triangles around it. Those that deform faster than twice the
mean of the ice are chosen, so that no rate has to be set. Those that are neighbours are a piece; a
piece that is long and narrow is a linear feature. Satellites' features are found by other rules
(Linow & Dierking 2017; Hutter et al. 2019), so numbers of both are to be compared with care.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floeflow.diagnostics.deformation import Strain
from floeflow.diagnostics.floe_sizes import fragments

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Elements deform fast above so many times the mean rate.
FAST = 2.0
# A feature is at least so many spacings of the elements long, and so many times as long as wide.
LONG, NARROW = 5.0, 3.0


@dataclass(frozen=True)
class Features:
    """Linear features of one interval.

    Attributes
    ----------
    share : float
        Of the ice's area that carries half of the deformation (1); NaN where none deforms.
    area : float
        Of all triangles (m2).
    length, width : ndarray
        Of the features (m), (feature,).
    angle : ndarray
        Of their long axis from the x axis to the left (rad), 0 to pi, (feature,).
    """

    share: float
    area: float
    length: Array
    width: Array
    angle: Array


def linear_features(strain: Strain, corners: Index, places: tuple[Array, Array]) -> Features:
    """Find the linear features of a field of deformation.

    Parameters
    ----------
    strain : Strain
        Of triangles, in the order of their corners.
    corners : ndarray
        Elements of the triangles, (triangle, 3).
    places : tuple of ndarray
        x and y of the elements (m), (element,).

    Returns
    -------
    Features
        None of them where the ice does not deform.
    """
    n = len(places[0])
    each = np.repeat(strain.area / 3.0, 3)
    area: Array = np.bincount(corners.ravel(), each, n).astype(np.float64)
    carried = np.bincount(corners.ravel(), each * np.repeat(strain.total, 3), n)
    whole, none = float(area.sum()), np.zeros(0)
    if not carried.sum() > 0.0:
        return Features(np.nan, whole, none, none, none)
    rate = np.divide(carried, area, out=np.zeros(n), where=area > 0.0)
    share = float(np.interp(0.5, *_localised(rate, area)))
    chosen = np.flatnonzero(rate > FAST * carried.sum() / whole)
    if not chosen.size:
        return Features(share, whole, none, none, none)
    x, y = (place[chosen] for place in places)
    sides = np.concatenate([corners[:, k] for k in ([0, 1], [1, 2], [2, 0])])
    length, width, angle = _shapes(x, y, area[chosen], fragments(chosen, sides))
    spacing = np.sqrt(whole / np.count_nonzero(area))
    kept = (length >= LONG * spacing) & (length >= NARROW * width)
    return Features(share, whole, length[kept], width[kept], angle[kept])


def _localised(rate: Array, area: Array) -> tuple[Array, Array]:
    """Share of the deformation that the fastest elements carry, and their share of the area."""
    order = np.argsort(-rate, kind="stable")
    carried, area = np.cumsum((rate * area)[order]), np.cumsum(area[order])
    start = np.zeros(1)
    return (
        np.concatenate([start, carried / carried[-1]]),
        np.concatenate([start, area / area[-1]]),
    )


def _shapes(x: Array, y: Array, area: Array, piece: Index) -> tuple[Array, Array, Array]:
    """Length, width (m) and angle (rad) of pieces, those of bars with their second moments."""
    whole = np.bincount(piece, area)
    # From the middle, where squares keep their digits.
    x, y = x - x.mean(), y - y.mean()
    dx, dy = (v - (np.bincount(piece, area * v) / whole)[piece] for v in (x, y))
    # An element has second moments of its own about its centre, as a square.
    own = np.bincount(piece, area**2) / whole / 12.0
    xx, yy, xy = (np.bincount(piece, area * each) / whole for each in (dx * dx, dy * dy, dx * dy))
    half = np.hypot(0.5 * (xx - yy), xy)
    length = np.sqrt(12.0 * (0.5 * (xx + yy) + half + own))
    angle = np.mod(0.5 * np.arctan2(2.0 * xy, xx - yy), np.pi)
    return length, whole / length, angle
