# SPDX-License-Identifier: GPL-2.0-or-later
"""Mechanical redistribution: closing turned into open water lost and ridges built.

The contacts of an element report how much of its area they closed. Thin ice and open water take
part first (Thorndike et al. 1975, in the exponential form of Lipscomb et al. 2007), and what
ridges becomes fewer square metres of thicker ice (Hibler 1980; exponential thicknesses of Lipscomb
et al. 2007). Equations are numbered as in docs/theory/redistribution.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floeflow.column.physics import TINY
from floeflow.column.state import Array

Columns = dict[str, Array]

PARTICIPATION = 0.05  # a*, e-folding scale of the participation in G
RIDGE_SCALE = 3.0  # mu, m^(1/2): e-folding thickness of ridges is mu sqrt(h)
RAFTING = 1.0  # m: thicker ice makes ridges of at least h + 1 m instead of 2 h
SNOW_KEPT = 0.5  # share of the snow on ridging ice that stays on it
MOST_ROUNDS = 60
TOLERANCE = 1e-14  # of the element's area


@dataclass(frozen=True)
class Ridged:
    """Outcome of a redistribution.

    Parameters
    ----------
    columns : dict of ndarray
        Columns afterwards, per area that is left.
    snow_lost : ndarray
        Snow that fell into the sea (m per area that is left), (n,).
    snow_energy : ndarray
        Its energy (J/m2, negative), (n,); zero where snow has no layers.
    forced : ndarray
        Elements where nothing thin was left to ridge: the rest of the closing thickened all ice
        in place, (n,), bool.
    """

    columns: Columns
    snow_lost: Array
    snow_energy: Array
    forced: NDArray[np.bool_]


def participation(area: Array, whole: Array) -> Array:
    """Share of closing and ridging that open water and each category take (eq. 2).

    Parameters
    ----------
    area : ndarray
        Fractions of open water and of the categories, thinnest first, (n, 1 + ncat).
    whole : ndarray
        Their sum, (n,).

    Returns
    -------
    ndarray
        Adds up to 1 in each element, (n, 1 + ncat).
    """
    below = np.cumsum(area, axis=1) / whole[:, None]
    # Expm1 keeps the digits of small fractions: e^(-a/s) - e^(-b/s) = e^(-a/s) (1 - e^((a-b)/s)).
    width = area / whole[:, None]
    start = np.exp(-(below - width) / PARTICIPATION)
    return np.asarray(start * np.expm1(-width / PARTICIPATION) / np.expm1(-1.0 / PARTICIPATION))


def ridge_shape(thickness: Array) -> tuple[Array, Array]:
    """Least thickness of ridges and its e-folding scale (m) from ice of a thickness (eqs. 4, 5).

    Parameters
    ----------
    thickness : ndarray
        Of the ice that ridges (m), any shape.

    Returns
    -------
    tuple of ndarray
        m, of that shape each.
    """
    return np.minimum(2.0 * thickness, thickness + RAFTING), RIDGE_SCALE * np.sqrt(thickness)


def ridge_shares(thickness: Array, bounds: Array) -> tuple[Array, Array]:
    """Shares of new ridges' area and volume that each category gets (eqs. 6 and 7).

    Parameters
    ----------
    thickness : ndarray
        Of the ridging ice (m), positive, (n, ncat).
    bounds : ndarray
        Of the categories (m), (ncat + 1,).

    Returns
    -------
    tuple of ndarray
        (n, ncat from, ncat into); each adds up to 1 over the last axis.
    """
    least, scale = (each[..., None] for each in ridge_shape(thickness))
    edges = np.maximum(bounds, least)
    over = np.exp(-(edges - least) / scale)
    volume = (edges + scale) * over / (least + scale)
    # The last category has no end; ridges start in some category or above it.
    over[..., -1] = volume[..., -1] = 0.0
    over[..., 0] = volume[..., 0] = 1.0
    return over[..., :-1] - over[..., 1:], volume[..., :-1] - volume[..., 1:]


def redistribute(columns: Columns, closed: Array, bounds: Array) -> Ridged:
    """Take closed area from open water and ice.

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state, as they were per area *before* the closing; not changed.
    closed : ndarray
        Share of each element's area that was closed, 0 to below 1, (n,).
    bounds : ndarray
        Of the categories (m), (ncat + 1,), two categories or more.

    Returns
    -------
    Ridged
        Columns per area that is left. Ice volume, energy and salt are those before, snow too but
        for what fell into the sea.
    """
    amounts = _amounts(columns)
    lost: Columns = {
        name: np.zeros((len(closed), *amounts[name].shape[2:]))
        for name in ("snow", "snow_heat")
        if name in amounts
    }
    left = np.ones(len(closed))
    for _ in range(MOST_ROUNDS):
        rest = left - (1.0 - closed)
        rest = np.where(rest > TOLERANCE, rest, 0.0)
        if not rest.any():
            break
        left = left - _ridge(amounts, lost, left, rest, bounds)
    kept = 1.0 - closed
    forced = left - kept > 1e3 * TOLERANCE
    # Round-off, or ice that finds no room: all of it makes room alike.
    covered = amounts["area"].sum(axis=1)
    fits = np.minimum(kept / np.where(covered > kept, covered, kept), 1.0)[:, None]
    for name in {"area", "warmth", "level"} & set(amounts):
        amounts[name] = amounts[name] * fits
    snow = lost.get("snow", np.zeros_like(kept)) / kept
    energy = np.zeros_like(kept)
    if "snow_heat" in lost:
        energy = lost["snow_heat"].mean(axis=1) / kept
    return Ridged(_columns(amounts, columns, kept), snow, energy, forced)


def _ridge(amounts: Columns, lost: Columns, left: Array, rest: Array, bounds: Array) -> Array:
    """Close up to ``rest`` of the area, as far as no class runs out; the area closed, (n,).

    Changes ``amounts`` and ``lost``.
    """
    area = amounts["area"]
    water = np.maximum(left - area.sum(axis=1), 0.0)
    classes = np.concatenate([water[:, None], area], axis=1)
    part = participation(classes, classes.sum(axis=1))
    exists = area > 0.0
    thickness = np.where(exists, amounts["ice"] / np.where(exists, area, 1.0), 1.0)
    least, scale = ridge_shape(thickness)
    thicker = (least + scale) / thickness
    net = part[:, 0] + (part[:, 1:] * (1.0 - 1.0 / thicker)).sum(axis=1)
    there = part > 0.0
    most = np.where(there, classes / np.where(there, part, 1.0), np.inf).min(axis=1)
    gross = np.minimum(rest / np.where(net > 0.0, net, np.inf), most)
    taken = gross[:, None] * part
    share = np.where(classes > 0.0, taken / np.where(classes > 0.0, classes, 1.0), 0.0)
    # A class that is all used up leaves exact zeros.
    share = np.where(share > 1.0 - 1e-12, 1.0, share)[:, 1:]
    into_area, into_volume = ridge_shares(thickness, bounds)
    for name, values in amounts.items():
        moved = values * share.reshape(share.shape + (1,) * (values.ndim - 2))
        stays = moved
        if name in ("level", "level_ice"):
            # Ridges are not level; what ponds there were on the ice has run off.
            amounts[name] = values - moved
            continue
        if name in ("area", "warmth"):
            stays = moved / thicker
        elif name in lost:
            stays = SNOW_KEPT * moved
            lost[name] += (moved - stays).sum(axis=1)
        into = into_area if name in ("area", "warmth") else into_volume
        amounts[name] = values - moved + np.einsum("enm,en...->em...", into, stays)
    ridged = (area * share * (1.0 - 1.0 / thicker)).sum(axis=1)
    return np.asarray(np.minimum(taken[:, 0], water) + ridged)


def _amounts(columns: Columns) -> Columns:
    """What areas, volumes and layers add up to, (n, ncat) or (n, ncat, layers)."""
    area, ice = columns["ice_fraction"], columns["ice_volume"]
    amounts = {"area": area, "ice": ice, "warmth": area * columns["surface_temperature"]}
    for name, amount in _LAYERED.items():
        if name in columns:
            amounts[amount] = columns[name] * ice[..., None]
    if "level_area" in columns:
        amounts["level"] = area * columns["level_area"]
        amounts["level_ice"] = ice * columns["level_volume"]
    if "snow_volume" in columns:
        amounts["snow"] = columns["snow_volume"]
        if "snow_enthalpy" in columns:
            amounts["snow_heat"] = columns["snow_enthalpy"] * amounts["snow"][..., None]
    return amounts


_LAYERED = {"ice_enthalpy": "ice_heat", "ice_salinity": "salt"}


def _columns(amounts: Columns, like: Columns, kept: Array) -> Columns:
    """Columns of amounts per area before the closing, of which ``kept`` is left."""
    area, ice = amounts["area"], amounts["ice"]
    exists = (area > TINY) & (ice > 0.0)
    columns = dict(like)
    columns["ice_fraction"] = area / kept[:, None]
    columns["ice_volume"] = ice / kept[:, None]
    warmth = amounts["warmth"] / np.where(exists, area, 1.0)
    columns["surface_temperature"] = np.where(exists, warmth, like["surface_temperature"])
    for name, amount in _LAYERED.items():
        if name in like:
            columns[name] = _per(amounts[amount], ice)
    if "level" in amounts:
        columns["level_area"] = np.where(
            exists, amounts["level"] / np.where(exists, area, 1.0), 0.0
        )
        share = amounts["level_ice"] / np.where(exists, ice, 1.0)
        columns["level_volume"] = np.where(exists, share, 0.0)
    if "snow" in amounts:
        columns["snow_volume"] = amounts["snow"] / kept[:, None]
        if "snow_heat" in amounts:
            columns["snow_enthalpy"] = _per(amounts["snow_heat"], amounts["snow"])
    return columns


def _per(content: Array, volume: Array) -> Array:
    there = (volume > 0.0)[..., None]
    return np.where(there, content / np.where(there, volume[..., None], 1.0), 0.0)
