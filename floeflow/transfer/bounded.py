# SPDX-License-Identifier: GPL-2.0-or-later
"""The nearest values with an exact total and within bounds: the correction of every transfer.

An accurate transfer need not conserve, and a conservative one need not stay within the values of
its sources. Both are put right afterwards at the least cost (optimization-based remap; Turner,
Peterson and Bolintineanu, GMD 15, 2022; Bochev, Ridzal and Peterson, J. Comput. Phys. 257, 2014):

    minimize sum q (x - target)^2  with  sum w x = total  and  low <= x <= high.

The solution is x = clip(target + shift w / q, low, high) with one number, the shift, and the total
grows with it. Newton's method on that piecewise linear function finds it in a few passes over the
values; bisection in between guards it. Each pass only adds up, so ranks can share the values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floeflow.core.errors import FloeError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# A total is met when it differs by less than this share of the largest that the bounds allow.
TOLERANCE = 1e-15
PASSES = 300
# Up to so many groups are added up one by one (pairwise, with less round-off), more in one pass.
FEW_GROUPS = 32


def _alone(part: Array) -> Array:
    return part


@dataclass(frozen=True)
class Ranks:
    """How ranks put their parts together; a rank that has all values needs nothing.

    Parameters
    ----------
    add, largest : callable
        Take an array of this rank, return the sum or the largest of all ranks' (``Allreduce``).
    """

    add: Callable[[Array], Array] = _alone
    largest: Callable[[Array], Array] = _alone


@dataclass(frozen=True)
class Bounded:
    """What `nearest_bounded` found.

    Parameters
    ----------
    values : ndarray
        (n,), within their bounds.
    shift : ndarray
        Shift of each group, (groups,); infinite where the bounds do not allow the total.
    missing : ndarray
        Total asked for minus total reached, (groups,): round-off where the bounds allow it,
        otherwise what they keep out (above 0) or in (below 0).
    feasible : ndarray of bool
        Whether the bounds allow the total, (groups,).
    """

    values: Array
    shift: Array
    missing: Array
    feasible: NDArray[np.bool_]


def nearest_bounded(
    target: Array,
    low: Array,
    high: Array,
    weight: Array,
    total: Array | float,
    *,
    group: Index | None = None,
    penalty: Array | None = None,
    ranks: Ranks | None = None,
) -> Bounded:
    """Find the nearest values within bounds that have a given weighted sum.

    Parameters
    ----------
    target : ndarray
        Accurate values, (n,).
    low, high : ndarray
        Bounds of each, (n,).
    weight : ndarray
        Amount that each value counts for in the total (area of a cell, amount of the parent),
        (n,), not negative. Values without weight are only cut at their bounds.
    total : ndarray or float
        Sum of weight times value that each group must have, (groups,); of all ranks.
    group : ndarray of int, optional
        Group of each value, (n,), from 0; without it there is one group.
    penalty : ndarray, optional
        Cost q of a change of each value, (n,), above 0; the weight, if not given: all values
        that are free to move are then shifted alike, and nearest is meant in the L2 norm of the
        weight.
    ranks : Ranks, optional
        Where the values are a slice: how to add up over ranks. Every rank calls.

    Returns
    -------
    Bounded
        The values; where the bounds do not allow a group's total, they are all at the bound that
        is nearest to it, and `Bounded.missing` says what is missing.

    Raises
    ------
    FloeError
        For lengths that differ, values that are not finite, or bounds that cross.
    """
    ranks = ranks or Ranks()
    totals = np.atleast_1d(np.asarray(total, dtype=np.float64))
    _check(target, low, high, weight, penalty, totals)
    add = _adder(group, len(target), len(totals), ranks)
    member = np.zeros(len(target), np.int64) if group is None else group
    held = weight > 0.0
    pull = held.astype(np.float64) if penalty is None else weight / penalty

    def at(shift: Array) -> Array:
        return np.minimum(np.maximum(target + shift[member] * pull, low), high)

    least, most = add(weight * low), add(weight * high)
    scale = add(weight * np.maximum(np.abs(low), np.abs(high)))
    tolerance = TOLERANCE * np.maximum(scale, np.abs(totals))
    inside = (totals > least) & (totals < most)
    below, above = _bracket(target, low, high, pull, member, len(totals), ranks)
    shift = np.zeros(len(totals))
    best, best_miss = shift.copy(), np.full(len(totals), np.inf)
    for count in range(PASSES):
        values = at(shift)
        miss = totals - add(weight * values)
        better = np.abs(miss) < best_miss
        best, best_miss = np.where(better, shift, best), np.where(better, np.abs(miss), best_miss)
        if ((best_miss <= tolerance) | ~inside).all():
            break
        below, above = np.where(miss > 0, shift, below), np.where(miss < 0, shift, above)
        slope = add(weight * pull * ((values > low) & (values < high)))
        step = shift + np.divide(miss, slope, out=np.full_like(miss, np.inf), where=slope > 0)
        newton = (step > below) & (step < above) & (count % 4 != 3)
        shift = np.where(newton, step, below + 0.5 * (above - below))

    best = np.where(inside, best, 0.0)
    values = at(best)
    for outside, bound in ((totals <= least, low), (totals >= most, high)):
        values = np.where(outside[member] & held, bound, values)
    values = _spread(values, low, high, weight, totals, member, add)
    shift = np.select([inside, totals <= least], [best, -np.inf], np.inf)
    missing = totals - add(weight * values)
    return Bounded(values, shift, missing, np.abs(missing) <= 1e3 * tolerance)


def _spread(
    values: Array,
    low: Array,
    high: Array,
    weight: Array,
    totals: Array,
    member: Index,
    add: Callable[[Array], Array],
) -> Array:
    """Spread what round-off of the shift still misses, in proportion to the room for it.

    A target that lies far outside of narrow bounds leaves the shift too coarse for them.
    """
    miss = totals - add(weight * values)
    up, down = high - values, low - values
    room = np.where(miss[member] > 0.0, up, down)
    all_room = add(weight * room)
    part = np.divide(miss, all_room, out=np.zeros_like(miss), where=all_room != 0.0)
    moved = values + np.clip(part, 0.0, 1.0)[member] * room
    better = np.abs(totals - add(weight * moved)) < np.abs(miss)
    return np.where(better[member], np.minimum(np.maximum(moved, low), high), values)


def _adder(group: Index | None, size: int, groups: int, ranks: Ranks) -> Callable[[Array], Array]:
    """How to add up terms, (n,), in each group, (groups,)."""
    if group is None:
        if groups != 1:
            raise FloeError(f"bounded: {groups} totals, but no groups to have them")
        return lambda term: ranks.add(np.array([term.sum()]))
    if group.shape != (size,) or (size and not (0 <= group.min() and group.max() < groups)):
        raise FloeError(f"bounded: each of {size} values needs a group from 0 to {groups - 1}")
    if groups > FEW_GROUPS:
        return lambda term: ranks.add(np.bincount(group, term, groups).astype(np.float64))
    rows = [np.flatnonzero(group == g) for g in range(groups)]
    return lambda term: ranks.add(np.array([term[row].sum() for row in rows]))


def _bracket(
    target: Array, low: Array, high: Array, pull: Array, member: Index, groups: int, ranks: Ranks
) -> tuple[Array, Array]:
    """Shifts at which every value of a group is at its lower, at its upper bound, (groups,)."""
    free = np.flatnonzero(pull > 0.0)
    ends = np.zeros((2, groups))
    for end, gap in zip(ends, (target - low, high - target), strict=True):
        np.maximum.at(end, member[free], gap[free] / pull[free])
    down, up = ranks.largest(ends)
    return -down, up


def _check(
    target: Array, low: Array, high: Array, weight: Array, penalty: Array | None, totals: Array
) -> None:
    """Refuse what has no answer, with the place."""
    given = {"target": target, "low": low, "high": high, "weight": weight}
    if penalty is not None:
        given["penalty"] = penalty
    for name, values in given.items():
        if values.ndim != 1 or values.shape != target.shape:
            raise FloeError(f"bounded: '{name}' has shape {values.shape}, not {target.shape}")
        if not np.isfinite(values).all():
            place = int(np.argmin(np.isfinite(values)))
            raise FloeError(f"bounded: '{name}' is {values[place]} at value {place}")
    if not np.isfinite(totals).all():
        raise FloeError(f"bounded: a total is {totals[~np.isfinite(totals)][0]}")
    wrong = {
        "its low bound is above its high one": low > high,
        "its weight is negative": weight < 0.0,
        "its penalty is not above 0": np.zeros(0) if penalty is None else penalty <= 0.0,
    }
    for what, where in wrong.items():
        if where.any():
            raise FloeError(f"bounded: value {int(np.argmax(where))}: {what}")
