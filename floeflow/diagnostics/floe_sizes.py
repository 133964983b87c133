# SPDX-License-Identifier: GPL-2.0-or-later
"""Floes as fragments of bonded elements, and the distribution of their sizes.

A power law n(d) ~ d^-a above a smallest size is fitted by maximum likelihood (Clauset et al. 2009)
and laid beside a lognormal that is cut at the same size. How well the power law holds is told by
the share of samples drawn from it that lie further from it than the floes do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Fewer elements do not make a floe's size, and fewer floes not a distribution.
RESOLVED = 10
FLOES = 20
# Fragments of larger elements (m) are plates of pack ice: floes of the sea are some 10 km at most.
LARGEST_ELEMENT = 5.0e3
# Smallest sizes that are tried for the power law, and samples that are drawn from it.
TRIED, DRAWN = 40, 200


def fragments(ids: Index, pairs: Index) -> Index:
    """Number of the fragment of each element, from 0, (element,).

    Parameters
    ----------
    ids : ndarray
        Ids of the elements, ascending.
    pairs : ndarray
        Ids that bonds hold together, (bond, 2); pairs with an id that is not there are left out.

    Returns
    -------
    ndarray
        Integer, (element,).
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    pairs = pairs[np.isin(pairs, ids).all(axis=1)]
    places = np.searchsorted(ids, pairs)
    links = coo_matrix((np.ones(len(places)), (places[:, 0], places[:, 1])), (ids.size, ids.size))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def floe_diameters(state: xr.Dataset) -> tuple[Array, Index, float]:
    """Diameters of discs of the fragments' areas (m), and their numbers of elements, (floe,).

    The third is the typical size of the elements (m).

    Parameters
    ----------
    state : xarray.Dataset
        A state with bonds; mobile elements with ice count.

    Returns
    -------
    diameters : ndarray
        m, (floe,).
    counts : ndarray
        Elements of each, (floe,).
    typical : float
        m, NaN without elements.
    """
    # Here, so that the functions above need no state.
    from floeflow.diagnostics.collect import intact
    from floeflow.state.schema import MOBILE

    there = (state["type"].values == MOBILE) & (state["ice_fraction"].values.sum(axis=1) > 0.0)
    label = fragments(state["id"].values[there], intact(state))
    each = state["area"].values[there]
    area = np.bincount(label, each)
    typical = float(np.sqrt(np.median(each))) if each.size else np.nan
    return 2.0 * np.sqrt(area / np.pi), np.bincount(label), typical


@dataclass(frozen=True)
class SizeFit:
    """A power law beside a lognormal.

    Attributes
    ----------
    exponent, error : float
        Of n(d) ~ d^-exponent and its standard error.
    smallest : float
        Size from which on both hold (m).
    floes : int
        As many are at least that large.
    goodness : float
        Share of samples of the power law that fit it worse; below 0.1 it is ruled out.
    mean, spread : float
        Of ln(d / 1 m) of the lognormal.
    ratio : float
        Logarithm of the likelihoods' ratio over its standard deviation (Vuong 1989): above 2 for
        the power law, below -2 for the lognormal, else the floes cannot tell.
    """

    exponent: float
    error: float
    smallest: float
    floes: int
    goodness: float
    mean: float
    spread: float
    ratio: float


def fit_sizes(sizes: Array, smallest: float | None = None, seed: int = 1) -> SizeFit | None:
    """Fit both distributions to floe sizes.

    Parameters
    ----------
    sizes : ndarray
        Above 0 (m), (floe,).
    smallest : float, optional
        Size from which on (m); else the one that fits best (Kolmogorov-Smirnov).
    seed : int
        Of the samples that are drawn.

    Returns
    -------
    SizeFit or None
        None where fewer than `FLOES` floes are large enough, or all are of one size.
    """
    sizes = np.sort(sizes)
    found = _best(sizes, smallest)
    if found is None:
        return None
    start, exponent, distance = found
    tail = sizes[sizes >= start]
    rng = np.random.default_rng(seed)
    below = sizes[sizes < start]
    worse = 0
    for _ in range(DRAWN):
        # Below the power law sizes are those of the floes, above it they follow it.
        n = int(rng.binomial(sizes.size, tail.size / sizes.size)) if below.size else sizes.size
        drawn = start * rng.random(n) ** (-1.0 / (exponent - 1.0))
        small = rng.choice(below, sizes.size - n) if below.size else below
        again = _best(np.sort(np.concatenate([small, drawn])), smallest)
        worse += again is None or again[2] >= distance
    mean, spread = _lognormal(tail, start)
    law = np.log((exponent - 1.0) / start) - exponent * np.log(tail / start)
    difference = law - _lognormal_density(tail, start, mean, spread)
    deviation = float(difference.std() * np.sqrt(tail.size))
    ratio = float(difference.sum() / deviation) if deviation > 0 else 0.0
    error = (exponent - 1.0) / np.sqrt(tail.size)
    return SizeFit(exponent, float(error), start, tail.size, worse / DRAWN, mean, spread, ratio)


def _best(sizes: Array, smallest: float | None) -> tuple[float, float, float] | None:
    """Smallest size, exponent and distance of the best power law of ascending sizes."""
    if sizes.size < FLOES:
        return None
    starts = [smallest] if smallest is not None else list(_starts(sizes))
    best: tuple[float, float, float] | None = None
    for start in starts:
        tail = sizes[np.searchsorted(sizes, start) :]
        logs = float(np.log(tail / start).sum()) if tail.size else 0.0
        if tail.size < FLOES or logs <= 0.0:
            continue
        exponent = 1.0 + tail.size / logs
        cumulative = 1.0 - (tail / start) ** (1.0 - exponent)
        steps = np.arange(tail.size + 1) / tail.size
        distance = float(
            max(np.abs(steps[1:] - cumulative).max(), np.abs(steps[:-1] - cumulative).max())
        )
        if best is None or distance < best[2]:
            best = (float(start), float(exponent), distance)
    return best


def _starts(sizes: Array) -> Array:
    """Sizes that are tried as the smallest, leaving enough floes above each."""
    known = np.unique(sizes[: sizes.size - FLOES + 1])
    if known.size <= TRIED:
        return known
    return known[np.linspace(0, known.size - 1, TRIED).astype(int)]


def _lognormal(tail: Array, start: float) -> tuple[float, float]:
    """Mean and spread of the logarithm of a lognormal that is cut below, by maximum likelihood."""
    from scipy.optimize import minimize

    logs = np.log(tail)
    first = [logs.mean(), np.log(max(logs.std(), 1e-3))]

    def misfit(at: Array) -> float:
        return -float(_lognormal_density(tail, start, at[0], float(np.exp(at[1]))).sum())

    # Far from the floes a lognormal is a power law: the bounds keep it from running away.
    width = 10.0 * max(logs.std(), 1e-3)
    bounds = [(logs.min() - 5.0 * width, logs.max() + width), (np.log(1e-3), np.log(5.0 * width))]
    found = minimize(misfit, first, method="L-BFGS-B", bounds=bounds)
    return float(found.x[0]), float(np.exp(found.x[1]))


def _lognormal_density(tail: Array, start: float, mean: float, spread: float) -> Array:
    """Logarithms of the density of a lognormal that is cut below."""
    from scipy.special import log_ndtr

    z = (np.log(tail) - mean) / spread
    above = log_ndtr(-(np.log(start) - mean) / spread)
    return np.asarray(-0.5 * z**2 - np.log(tail * spread * np.sqrt(2.0 * np.pi)) - above)
