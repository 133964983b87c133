# SPDX-License-Identifier: GPL-2.0-or-later
"""The ice edge on a grid: extent, marginal zone, and how far two edges lie apart.

The integrated ice-edge error is the area on which two fields do not agree whether there is ice
(Goessling et al. 2016), split into what the first has too much and too little; divided by the
length of the other's edge it is a mean displacement of the edge (Melsom et al. 2019).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# From this share on a cell counts to the extent; below the second it is marginal.
EDGE, MARGIN = 0.15, 0.8
# Cells with less ice than this are marginal: what is open there are no leads.
PACK = 0.7


def extent(share: Array, area: Array, edge: float = EDGE) -> float:
    """Area of the cells with at least this share of ice (m2); NaN has none.

    Parameters
    ----------
    share : ndarray
        Of ice in each cell, (y, x).
    area : ndarray
        Of sea in each cell (m2), (y, x).
    edge : float, optional
        Least share that counts.

    Returns
    -------
    float
        m2.
    """
    return float(np.where(np.nan_to_num(share) >= edge, area, 0.0).sum())


def marginal(share: Array, area: Array) -> float:
    """Area of the cells with 15 to 80 % of ice (m2).

    Parameters
    ----------
    share : ndarray
        Of ice in each cell, (y, x).
    area : ndarray
        Of sea in each cell (m2), (y, x).

    Returns
    -------
    float
        m2.
    """
    filled = np.nan_to_num(share)
    return float(np.where((filled >= EDGE) & (filled < MARGIN), area, 0.0).sum())


def edge_length(share: Array, sea: Flags, spacing: float, edge: float = EDGE) -> float:
    """Length of the edge between ice and open sea (m). Coasts are no edge.

    Between the centres of four cells it cuts one corner off, runs straight through, or cuts two
    corners off: lines along the axes and diagonals come out as long as they are, others up to 8 %
    longer.

    Parameters
    ----------
    share : ndarray
        Ice, (y, x); NaN where unknown, which makes no edge.
    sea : ndarray
        Where there is sea.
    spacing : float
        Of the cells (m).
    edge : float
        Share from which on a cell counts as ice.

    Returns
    -------
    float
        m.
    """
    ice, known = np.nan_to_num(share) >= edge, sea & np.isfinite(share)
    corners = [np.s_[1:, 1:], np.s_[1:, :-1], np.s_[:-1, 1:], np.s_[:-1, :-1]]
    a, b, c, d = (ice[corner] for corner in corners)
    whole = np.logical_and.reduce([known[corner] for corner in corners])
    count = a.astype(int) + b + c + d
    single = (whole & ((count == 1) | (count == 3))).sum()
    across = whole & (count == 2) & (a == d)
    through = (whole & (count == 2)).sum() - across.sum()
    root = np.sqrt(2.0)
    return float(spacing * (single / root + through + root * across.sum()))


@dataclass(frozen=True)
class EdgeError:
    """How two ice edges differ.

    Attributes
    ----------
    over, under : float
        Area that only the first, or only the second covers (m2).
    length : float
        Of the second's edge (m).
    """

    over: float
    under: float
    length: float

    @property
    def integrated(self) -> float:
        """Integrated ice-edge error (m2)."""
        return self.over + self.under

    @property
    def displacement(self) -> float:
        """Mean distance of the edges (m); NaN where the second has no edge."""
        return self.integrated / self.length if self.length > 0.0 else np.nan


def edge_error(
    ours: Array, observed: Array, area: Array, spacing: float, edge: float = EDGE
) -> EdgeError:
    """Compare the edges of two fields where both are known.

    Parameters
    ----------
    ours, observed : ndarray
        Shares of ice, (y, x), NaN where unknown.
    area : ndarray
        Of the sea in the cells (m2).
    spacing : float
        Of the cells (m).
    edge : float
        Share from which on a cell counts as ice.

    Returns
    -------
    EdgeError
        Areas (m2) of ice too much and too little, and length (m) of the observed edge.
    """
    known = np.isfinite(ours) & np.isfinite(observed) & (area > 0.0)
    here, there = np.nan_to_num(ours) >= edge, np.nan_to_num(observed) >= edge
    return EdgeError(
        over=float(area[known & here & ~there].sum()),
        under=float(area[known & ~here & there].sum()),
        length=edge_length(np.where(known, observed, np.nan), area > 0.0, spacing, edge),
    )
