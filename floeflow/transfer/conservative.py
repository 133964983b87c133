# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields to a grid, accurately, with exact totals and within the bounds of their elements.

First the areas are dealt to the cells, then what sits on them: ice area on the elements' area, ice
volume on ice area, temperature on ice volume. At every level the accurate average is moved by as
little as it takes (`bounded`) so that the cells' total, counted with the parent's amounts that are
already there, is that of the elements.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from floeflow.core.errors import FloeError
from floeflow.transfer.bounded import Ranks, nearest_bounded
from floeflow.transfer.fields import ROOM, Field, Remapper, parent_weights, ratio
from floeflow.transfer.grid import Grid
from floeflow.transfer.stencil import Array, Stencil, Target
from floeflow.transfer.weights import EMPTY

# Below this coverage a cell takes no more than its share of a correction.
LEAST_COVERAGE = 1e-12


@dataclass(frozen=True)
class _Closure:
    """How totals are closed on the grid; as `conservative_transfer` takes them."""

    near: NDArray[np.bool_] | None
    ranks: Ranks
    exact: bool


@dataclass
class Carried:
    """Fields of one set of elements on a grid.

    Parameters
    ----------
    values : dict of ndarray
        By name, (target.shape): sums per cell of extensive fields, averages of intensive ones,
        NaN where there is nothing of the parent.
    missing : dict of float
        By name: the elements' total minus the grid's. Round-off, unless `infeasible` names it.
    outside : dict of float
        By name: total in elements that lie outside of the grid or have no sea in reach; the
        grid's total leaves it out.
    infeasible : list of str
        Fields whose total the bounds do not allow.
    """

    values: dict[str, Array] = field(default_factory=dict)
    missing: dict[str, float] = field(default_factory=dict)
    outside: dict[str, float] = field(default_factory=dict)
    infeasible: list[str] = field(default_factory=list)


def conservative_transfer(
    fields: Sequence[Field],
    values: Mapping[str, Array],
    remapper: Remapper,
    *,
    known: Mapping[str, Array] | None = None,
    near: NDArray[np.bool_] | None = None,
    ranks: Ranks | None = None,
    exact: bool = True,
) -> Carried:
    """Bring a hierarchy of fields to the grid.

    Parameters
    ----------
    fields : sequence of Field
        Parents before what sits on them.
    values : mapping
        By name, (n,): amounts if extensive, per unit of the parent if intensive (NaN where there
        is no parent).
    remapper : Remapper
        Bins, and weights of all parents, built with these amounts.
    known : mapping, optional
        Amounts on the grid of parents that are known already, (target.shape), by name.
    near : ndarray of bool, optional
        Cells that may hold something, (target.shape); all in reach without it. See `near_cells`.
    ranks : Ranks, optional
        Where the elements are a slice. Every rank calls and gets the whole grid.
    exact : bool
        False: averages stay as they are, within their bounds, whatever that makes of the totals.

    Returns
    -------
    Carried
        The fields, and what could not be placed.

    Raises
    ------
    FloeError
        In a sentence that names field and element: a parent that comes later or not at all, a
        length that differs, values that are not finite where they count, an amount with nothing
        to sit on.
    """
    closure = _Closure(near, ranks or Ranks(), exact)
    carried = Carried()
    amounts = dict(known or {})
    placed = remapper.bins.placed()
    for item in fields:
        if item.parent not in ("", ROOM) and item.parent not in amounts:
            raise FloeError(
                f"remap: '{item.name}' sits on '{item.parent}', which is no extensive field that "
                "comes before it"
            )
        if item.name not in values:
            raise FloeError(f"remap: '{item.name}' has no values")
        try:
            _transfer_one(item, values, amounts, remapper, placed, closure, carried)
        except FloeError as error:
            raise FloeError(f"{item.name}: {error}") from None
        if item.kind == "extensive":
            amounts[item.name] = carried.values[item.name]
    return carried


def _transfer_one(
    item: Field,
    values: Mapping[str, Array],
    amounts: Mapping[str, Array],
    remapper: Remapper,
    placed: NDArray[np.bool_],
    closure: _Closure,
    carried: Carried,
) -> None:
    """Add one field to those carried."""
    ranks = closure.ranks
    own = values[item.name]
    if own.shape != placed.shape:
        raise FloeError(f"remap: it has shape {own.shape}, but there are {len(placed)} elements")
    if item.parent in ("", ROOM):
        amount, result = own, remapper.bins.total(own, ranks)
        if item.parent == ROOM:
            own_total = amount[placed].sum()
            result, feasible = _fill_room(result, own_total, remapper, closure)
    else:
        parent = values[item.parent]
        extensive = item.kind == "extensive"
        if extensive and not np.isfinite(own).all():
            e = int(np.argmin(np.isfinite(own)))
            raise FloeError(f"remap: it is {own[e]} at element {e}")
        per = ratio(item, own, parent) if extensive else own
        amount = np.where(parent > 0.0, per, 0.0) * parent
        total = ranks.add(np.array([amount[placed].sum()]))[0]
        on = amounts[item.parent]
        result, feasible = _average(item, per, on, total, remapper, closure)
        if extensive:
            result = np.where(np.isfinite(result), result, 0.0) * on
    if item.parent and not feasible:
        carried.infeasible.append(item.name)
    sums, outside = ranks.add(np.array([amount[placed].sum(), amount[~placed].sum()]))
    on_grid = result if item.kind == "extensive" else np.nan_to_num(result) * on
    carried.values[item.name] = result
    carried.missing[item.name] = float(sums - on_grid.sum())
    carried.outside[item.name] = float(outside)


def _fill_room(
    dealt: Array, own: float, remapper: Remapper, closure: _Closure
) -> tuple[Array, bool]:
    """Areas in the cells, none above its sea; cells take of a correction as they are covered."""
    sea = remapper.bins.room.area.ravel()
    total = closure.ranks.add(np.array([own]))
    dealt = dealt.ravel()
    open_ = (sea > 0.0) & (dealt > 0.0)
    if closure.near is not None:
        open_ &= closure.near.ravel()
    share = np.divide(dealt, sea, out=np.zeros_like(sea), where=sea > 0.0)
    target = np.where(open_, share, 0.0)
    high = open_.astype(np.float64)
    if not closure.exact:
        return (np.minimum(target, high) * sea).reshape(remapper.bins.room.area.shape), True
    pull = np.clip(target, LEAST_COVERAGE, 1.0)
    # Land weighs nothing; its penalty is any number above 0.
    penalty = np.where(sea > 0.0, sea, 1.0) / pull
    found = nearest_bounded(target, np.zeros_like(sea), high, sea, total, penalty=penalty)
    return (found.values * sea).reshape(remapper.bins.room.area.shape), bool(found.feasible[0])


def _average(
    item: Field, per: Array, on: Array, total: float, remapper: Remapper, closure: _Closure
) -> tuple[Array, bool]:
    """Bounded averages, with an exact total if asked; NaN where there is nothing of the parent."""
    weights = parent_weights(item, remapper)
    accurate = weights.apply(per, ranks=closure.ranks).ravel()
    low, high = (bound.ravel() for bound in weights.bounds(per, closure.ranks))
    has = (on.ravel() > 0.0) & (weights.status.ravel() != EMPTY)
    values = np.full(on.size, np.nan)
    if not closure.exact:
        values[has] = np.clip(accurate[has], low[has], high[has])
        return values.reshape(on.shape), True
    found = nearest_bounded(accurate[has], low[has], high[has], on.ravel()[has], total)
    values[has] = found.values
    return values.reshape(on.shape), bool(found.feasible[0])


def near_cells(
    x: Array, y: Array, radius: Array, target: Target, pairs: Stencil
) -> NDArray[np.bool_]:
    """Cells at most one grid spacing from the disc of an element, (target.shape).

    Hats that reach farther, where elements are coarser than the grid, may not spread ice there.

    Parameters
    ----------
    x, y, radius : ndarray
        Centres and radii of the elements that have any (m), (n,).
    target : Target
        The grid; hats of a mesh reach no farther than to the neighbouring nodes anyway.
    pairs : Stencil
        Pairs of nodes and these elements.

    Returns
    -------
    ndarray
        Of bool, (target.shape).
    """
    node = np.repeat(np.arange(len(pairs.start) - 1), np.diff(pairs.start))
    near = np.zeros(len(pairs.start) - 1, bool)
    if isinstance(target, Grid):
        node_x, node_y = target.places()
        dx, dy = target.spacing
        away_x = np.abs(x[pairs.element] - node_x[node]) - radius[pairs.element]
        away_y = np.abs(y[pairs.element] - node_y[node]) - radius[pairs.element]
        node = node[(away_x <= dx) & (away_y <= dy)]
    near[node] = True
    return near.reshape(target.shape)
