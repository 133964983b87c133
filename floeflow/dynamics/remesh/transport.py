# SPDX-License-Identifier: GPL-2.0-or-later
"""Carry what elements hold along the pieces of an overlap: second order, conservative, bounded.

First the effective area, then what sits on it, as the state's schema says: ice on area, volume on
ice, temperature on volume, velocity on mass. Each property is a plane in its element, whose mean
over the element's pieces (weighted by what the property sits on) is the element's value. The
slopes are then limited so that no fresh cell leaves the range of its sources: flux-corrected
transport (Zalesak 1979), where the low-order flux is donor-cell, and what an element adds to one
of its pieces it takes from another. So totals are exact whatever the limits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floeflow.core.constants import ICE_DENSITY, SNOW_DENSITY
from floeflow.dynamics.remesh.overlap import Pieces
from floeflow.dynamics.remesh.slopes import Groups, Stencil, gradient, make_stencil
from floeflow.state.schema import MASS, VARIABLES, Variable

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Index = NDArray[np.int64]
Rules = Mapping[str, Variable]

# What an element's mass is the sum of, kg per unit of amount.
MASS_OF = {"ice_volume": ICE_DENSITY, "snow_volume": SNOW_DENSITY}


def sequence(names: set[str], rules: Rules) -> list[str]:
    """Variables in an order in which each comes after what it sits on; those of mass last.

    Parameters
    ----------
    names : set of str
        Variables of the elements.
    rules : Rules
        How each is carried.

    Returns
    -------
    list of str
        What has no place in the order comes last.
    """
    done: list[str] = []
    left = sorted(name for name in names if rules[name].kind)
    while left:
        ready = [
            name
            for name in left
            if rules[name].of != MASS
            and all(p in done for p in (rules[name].of, rules[name].per) if p)
        ]
        if not ready:
            return done + left
        done += ready
        left = [name for name in left if name not in ready]
    return done


def is_share(rule: Variable) -> bool:
    """Whether a variable's categories are shares of one area, which together stay under one.

    Parameters
    ----------
    rule : Variable
        Of the state's schema.

    Returns
    -------
    bool
        True for variables over categories that are a property of the area.
    """
    return rule.of == "area" and "category" in rule.dims


def _wide(amount: Array, like: Array) -> Array:
    """Amount of a parent in the shape of its property: one more axis for each that it lacks."""
    extra = like.ndim - amount.ndim
    return np.broadcast_to(amount.reshape(amount.shape + (1,) * extra), like.shape)


def amounts(values: Mapping[str, Array], rules: Rules = VARIABLES) -> dict[str, Array]:
    """Amounts of a state's variables, and the mass (kg).

    Parameters
    ----------
    values : mapping
        Element variables by name, (n, ...).
    rules : mapping
        The schema.

    Returns
    -------
    dict of ndarray
        By name, (n, ...): the variable times what it is a property of, in the product of both
        units; the mass (kg) under `MASS` where a variable is a property of it.
    """
    found: dict[str, Array] = {}
    for name in sequence(set(values), rules):
        rule = rules[name]
        if rule.of == MASS and MASS not in found:
            found[MASS] = mass(found)
        parent = rule.per or rule.of
        found[name] = values[name] * (_wide(found[parent], values[name]) if parent else 1.0)
    return found


def mass(found: Mapping[str, Array]) -> Array:
    """Mass (kg) from the amounts of ice and snow, (n,).

    Parameters
    ----------
    found : mapping of ndarray
        Ice and snow (m3) by element, (n, ncat) each.

    Returns
    -------
    ndarray
        kg, (n,).
    """
    parts = [
        density * found[name].sum(axis=1) for name, density in MASS_OF.items() if name in found
    ]
    return np.asarray(sum(parts))


def transport(
    values: Mapping[str, Array],
    centre: Array,
    pieces: Pieces,
    rules: Rules = VARIABLES,
    slopes: bool = True,
) -> dict[str, Array]:
    """Amounts that arrive in the fresh cells.

    Parameters
    ----------
    values : mapping
        Element variables of the old elements, (n, ...).
    centre : ndarray
        Centres of the old cells (m), (n, 2).
    pieces : Pieces
        Their overlap with m fresh cells.
    rules : mapping
        The schema.
    slopes : bool
        Second order; False: donor-cell, to compare with.

    Returns
    -------
    dict of ndarray
        Amounts by name, (m, ...), and the mass (kg).
    """
    slice_ = _Slice(
        pieces,
        Groups.of(pieces.source, pieces.sources),
        Groups.of(pieces.target, pieces.targets),
        make_stencil(centre) if slopes else None,
    )
    total = amounts(values, rules)
    share: dict[str, Array] = {"area": pieces.area}
    arrived = {"area": slice_.into.sum(pieces.area)}
    for name in sequence(set(values), rules):
        rule = rules[name]
        if name == "area":
            continue
        if rule.of == MASS and MASS not in share:
            share[MASS] = mass(share)
            arrived[MASS] = mass(arrived)
        weight = _wide(share[rule.of], np.empty((len(pieces.area), *values[name].shape[1:])))
        parent = _wide(total[rule.of], values[name])
        ratio = np.divide(total[name], parent, out=np.zeros_like(parent), where=parent > 0)
        flat = (pieces.sources, -1)
        found = slice_.carry(
            ratio.reshape(flat), parent.reshape(flat) > 0, weight.reshape(len(weight), -1), rule
        ).reshape(weight.shape)
        share[name], arrived[name] = found, slice_.into.sum(found)
    return arrived


@dataclass(frozen=True)
class _Slice:
    """Pieces with what is asked of them again and again."""

    pieces: Pieces
    out: Groups
    into: Groups
    stencil: Stencil | None

    def carry(self, ratio: Array, there: Flags, weight: Array, rule: Variable) -> Array:
        """Amounts of a property in the pieces, (k, c).

        Parameters
        ----------
        ratio, there : ndarray
            Value per parent in the sources, and whether the parent is there, (n, c).
        weight : ndarray
            Amount of the parent in the pieces, (k, c).
        rule : Variable
            What it is.
        """
        low = ratio[self.pieces.source]
        if self.stencil is None:
            return weight * low
        gx, gy = gradient(self.stencil, ratio, there)
        step = self._from_mean(gx, self.pieces.x, weight)
        step += self._from_mean(gy, self.pieces.y, weight)
        if is_share(rule):
            # Shares and their sum are limited alike, so that they still add up.
            every = [np.column_stack([a, a.sum(axis=1)]) for a in (ratio, step)]
            wide = np.column_stack([weight, weight[:, 0]])
            present = np.column_stack([there, there[:, 0]])
            part = self._limit(every[0], present, wide, every[1]).min(axis=1, keepdims=True)
        else:
            part = self._limit(ratio, there, weight, step)
        return weight * (low + part[self.pieces.source] * step)

    def _from_mean(self, slope: Array, at: Array, weight: Array) -> Array:
        """Slope times the way from the mean place of an element's weight, (k, c)."""
        source = self.pieces.source
        total = self.out.sum(weight)
        moment = self.out.sum(weight * at[:, None])
        mean = np.divide(moment, total, out=np.zeros_like(total), where=total > 0)
        return np.asarray(slope[source] * (at[:, None] - mean[source]))

    def _limit(self, ratio: Array, there: Flags, weight: Array, step: Array) -> Array:
        """Share of the slope of each source that breaks no bound, (n, c)."""
        source, target = self.pieces.source, self.pieces.target
        low = ratio[source]
        known = there[source] & (weight > 0)
        most = self.into.reduce(np.maximum, np.where(known, low, -np.inf), -np.inf)
        least = self.into.reduce(np.minimum, np.where(known, low, np.inf), np.inf)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            # In a piece no value beyond those of the sources around.
            around = self.out.reduce(np.maximum, most[target], -np.inf)[source]
            below = self.out.reduce(np.minimum, least[target], np.inf)[source]
            room = np.where(step > 0, (around - low) / step, (below - low) / step)
            room = np.where(known & (step != 0), np.clip(room, 0.0, 1.0), 1.0)
            part = np.minimum(self.out.reduce(np.minimum, room, 1.0), 1.0)
            # In a cell no mean beyond those of its own sources.
            change = np.where(known, weight * part[source] * step, 0.0)
            base = np.where(known, weight * low, 0.0)
            held = self.into.sum(np.where(known, weight, 0.0))
            mean = self.into.sum(base)
            gain = self.into.sum(np.maximum(change, 0.0))
            loss = self.into.sum(np.minimum(change, 0.0))
            up = np.where(gain > 0, np.clip((most * held - mean) / gain, 0.0, 1.0), 1.0)
            down = np.where(loss < 0, np.clip((least * held - mean) / loss, 0.0, 1.0), 1.0)
        allowed = np.where(change > 0, up[target], np.where(change < 0, down[target], 1.0))
        return np.asarray(part * np.minimum(self.out.reduce(np.minimum, allowed, 1.0), 1.0))


def values_of(
    arrived: Mapping[str, Array], area: Array, fill: Mapping[str, Array], rules: Rules = VARIABLES
) -> dict[str, Array]:
    """Values of the variables from their amounts.

    Parameters
    ----------
    arrived : mapping
        Amounts by name, (m, ...).
    area : ndarray
        Effective areas to refer to (m2), (m,); above ``arrived["area"]`` where a gap of open
        water was added, which holds no ice and is else like the element's own.
    fill : mapping
        Values where there is nothing to be a property of, (m, ...).
    rules : mapping
        The schema.

    Returns
    -------
    dict of ndarray
        By name, in the schema's units and within its bounds, (m, ...).
    """
    out = {"area": area}
    for name, amount in arrived.items():
        if name in ("area", MASS):
            continue
        rule = rules[name]
        parent = rule.per or rule.of
        # Gap water has no ice, and else is as the element's own: so a temperature stays.
        thins = rule.per == "area" or is_share(rule)
        per = _wide(area if thins else arrived[parent], amount)
        value = np.divide(amount, per, out=np.array(fill[name], dtype=float), where=per > 0)
        out[name] = np.clip(value, rules[name].low, rules[name].high)
    return out
