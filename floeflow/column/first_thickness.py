# SPDX-License-Identifier: GPL-2.0-or-later
"""Thickness of the ice within an element at a start: all alike, or a gamma distribution.

Observed distributions have a maximum at some metres and a tail that falls exponentially, and theory
gives them the form h^q exp(-h/H) (Toppaladoddi and Wettlaufer 2015, doi
10.1103/PhysRevLett.115.148501). Here q is 2 and H a third of the mean thickness. Ridges are the
thickest ice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainc, gammaincinv

Array = NDArray[np.float64]

SHAPE = 3.0  # q + 1
# A category with less of the ice than this goes into the next thinner one.
LEAST_SHARE = 1e-3


@dataclass(frozen=True)
class FirstIce:
    """What the ice of a start is like, beside its concentration and volume.

    Parameters
    ----------
    distribution : {'single', 'gamma'}
        Of the thickness within an element.
    level_share : float
        Share of the ice's area that no ridge covers (1).
    lead_ice : float
        Thickness of bare ice on the open water of columns that are covered by 80 % or more (m).
    """

    distribution: str = "single"
    level_share: float = 1.0
    lead_ice: float = 0.0


@dataclass(frozen=True)
class Spread:
    """Shares of an element's ice in its categories (1), (n, ncat) each.

    Attributes
    ----------
    area, volume : ndarray
        Of the ice's area and volume; each row adds up to 1.
    level_area, level_volume : ndarray
        Of the category's own area and volume that is level.
    """

    area: Array
    volume: Array
    level_area: Array
    level_volume: Array


def single(thickness: Array, bounds: Array, level_share: float) -> Spread:
    """All ice of an element in the category that holds its thickness, ridges as thick as the rest.

    Parameters
    ----------
    thickness : ndarray
        Of the ice (m), (n,).
    bounds : ndarray
        Of the categories (m), (ncat + 1,).
    level_share : float
        As of `FirstIce`.

    Returns
    -------
    Spread
        Shares of area and volume by category and of both that is level (1), (n, ncat) each.
    """
    categories = len(bounds) - 1
    place = np.clip(np.searchsorted(bounds, thickness) - 1, 0, categories - 1)
    area = np.zeros((len(thickness), categories))
    area[np.arange(len(thickness)), place] = 1.0
    level = area * level_share
    return Spread(area, area.copy(), level, level.copy())


def gamma(thickness: Array, bounds: Array, level_share: float) -> Spread:
    """Gamma distribution about an element's mean thickness, its thickest part ridged.

    Parameters
    ----------
    thickness : ndarray
        Mean of the ice (m), (n,).
    bounds, level_share
        As of `single`.

    Returns
    -------
    Spread
        Shares of area and volume by category and of both that is level (1), (n, ncat) each.
    """
    edges = np.array([0.0, *bounds[1:-1], np.inf])
    scaled = SHAPE * edges / np.where(thickness > 0.0, thickness, 1.0)[:, None]
    level = np.minimum(scaled, gammaincinv(SHAPE, level_share) if level_share < 1.0 else np.inf)

    def shares(order: float, upto: Array) -> Array:
        return np.diff(gammainc(order, upto), axis=1)

    # The volume of a gamma distribution is distributed like one of the next order.
    parts = [shares(o, x) for x in (scaled, level) for o in (SHAPE, SHAPE + 1.0)]
    for n in range(len(edges) - 2, 0, -1):
        few = parts[0][:, n] < LEAST_SHARE
        for part in parts:
            part[few, n - 1] += part[few, n]
            part[few, n] = 0.0
    area, volume, level_area, level_volume = parts

    def of(part: Array, whole: Array) -> Array:
        return np.minimum(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0), 1.0)

    return Spread(area, volume, of(level_area, area), of(level_volume, volume))


DISTRIBUTIONS = {"single": single, "gamma": gamma}
