# SPDX-License-Identifier: GPL-2.0-or-later
"""What all contacts that may come about an element can add up to, whoever they are with.

Contacts form within a window, so their network is not known beforehand. For any motion a, b of two
elements in touch and any weights d > 0

    (a - b)^2 <= (1 + d_b / d_a) a^2 + (1 + d_a / d_b) b^2,

so a network of contacts is never stiffer than one in which each element is held to the ground by
springs as stiff as these terms. An element has room for so many neighbours only: two discs that
touch a third and do not overlap are seen from its centre under an angle of at least
2 asin(sqrt(q_j q_k)), q = r_j / (r_i + r_j) (law of cosines), and the angles of all neighbours in a
row add up to a full turn. And each neighbour is there once: those that are not as many as there is
room for, do not fill the turn. See docs/theory/forces.md, "Time step".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floeflow.core.period import apart, in_tree, tree_of
from floeflow.dynamics.engine.params import FIXED, EngineParams
from floeflow.state.bonds import Arrays

Array = NDArray[np.float64]

# More kinds of elements than this are put together, in classes that widen by this share.
MOST, WIDTH = 1500, 0.01
# Share of a pair's relative velocity that damping may take in a step (laws/contact.h).
DAMPING_PER_STEP = 0.1
# The bound is never that of fewer contacts than a lattice has about an element, each as stiff as
# the stiffest may be: so collisions of free elements are resolved in as many steps as in a lattice.
FEWEST = 6.0


@dataclass(frozen=True)
class Room:
    """Most that contacts about each element add up to, over its mass; arrays of shape (n,).

    Parameters
    ----------
    stiffness, damping : ndarray
        Sum of all neighbours', normal to the contacts, 1/s2 and 1/s.
    stiffest, most_damped : ndarray
        Of a single one.
    damped_per_step, most_damped_per_step : ndarray
        Bounds of the damping times the step, 1, whatever the step: sum and of a single one.
    """

    stiffness: np.ndarray
    damping: np.ndarray
    damped_per_step: np.ndarray
    stiffest: np.ndarray
    most_damped: np.ndarray
    most_damped_per_step: np.ndarray


@dataclass(frozen=True)
class Kinds:
    """Kinds of elements, smallest first: what an element of the kind is at worst.

    Parameters
    ----------
    radius, largest : ndarray, shape (m,)
        Of the smallest and the largest disc, m: one finds room, the other has room about it.
    thickness, inverse : ndarray, shape (m,)
        Of the thickest, m, and one over the mass of the heaviest, 1/kg; 0 for fixed ones.
    of : ndarray, shape (n,)
        Kind of each element.
    """

    radius: np.ndarray
    largest: np.ndarray
    thickness: np.ndarray
    inverse: np.ndarray
    of: np.ndarray

    @property
    def weight(self) -> np.ndarray:
        """The weights d, m/kg. Any would give a bound; these give a close one."""
        return self.radius * self.inverse


class _Discs(NamedTuple):
    """Elements or kinds, as `Kinds` has them; arrays of shape (n,)."""

    largest: Array
    radius: Array
    thickness: Array
    inverse: Array


class _Neighbours(NamedTuple):
    """Who may come to touch whom: rows (k,), the first neighbour of each row and the end (n + 1,).

    ``neighbour`` and whether it is ``touching`` already: (pairs,). ``single``: each neighbour is
    one element; else it stands for any number of its kind.
    """

    rows: NDArray[np.int64]
    start: NDArray[np.int64]
    neighbour: NDArray[np.int64]
    touching: NDArray[np.bool_]
    single: bool


def contact_room(elements: Arrays, params: EngineParams, way: float = np.inf) -> Room:
    """Bounds of the contacts about each element, friction left out.

    The weights are radius over mass: the heavier of two stays still. That makes the bound exact for
    a full lattice of equal discs, whatever their thicknesses.

    Parameters
    ----------
    elements : dict of ndarray, shape (n,)
        As `Engine.load` takes them.
    params : EngineParams
        Law parameters.
    way : float
        By how much two elements may come nearer to each other, m: only those whose discs are no
        further apart can meet. Infinite: any may meet any.

    Returns
    -------
    Room
        Sums over the contacts of each element by its mass, (n,) each; 0 for fixed elements.
    """
    if np.isfinite(way):
        sums = _rooms_near(elements, params, way)
    else:
        kinds = element_kinds(elements)
        n = len(kinds.radius)
        every = _Neighbours(
            rows=np.arange(n),
            start=np.arange(n + 1) * n,
            neighbour=np.tile(np.arange(n), n),
            touching=np.zeros(n * n, dtype=np.bool_),
            single=False,
        )
        discs = _Discs(kinds.largest, kinds.radius, kinds.thickness, kinds.inverse)
        sums = _rooms(discs, every, params)[kinds.of]
    mobile = np.asarray(elements["type"]) != FIXED
    sums = sums * np.where(mobile, 1.0 / elements["mass"], 0.0)[:, None]
    return Room(*sums.T)


def _rooms_near(elements: Arrays, params: EngineParams, way: float) -> Array:
    """Sums for each element (n, 6), of those that can come to touch it."""
    inverse = np.where(np.asarray(elements["type"]) == FIXED, 0.0, 1.0 / elements["mass"])
    radius, thickness = (np.asarray(elements[name], float) for name in ("radius", "thickness"))
    order = np.argsort(radius, kind="stable")
    radius, thickness, inverse = radius[order], thickness[order], inverse[order]
    places = np.column_stack([elements["x"], elements["y"]])[order]
    # Sorted rows: neighbours of ascending radius, as `_rooms` needs them.
    reach, period = radius + radius.max() + way, params.period
    tree, centres = tree_of(places, period), in_tree(places, period)
    near = tree.query_ball_point(centres, reach, return_sorted=True)
    count = np.array([len(item) for item in near])
    first = np.repeat(np.arange(len(radius)), count)
    second = np.concatenate([np.asarray(item, np.int64) for item in near])
    distance = apart(places, first, second, period)
    keep = (first != second) & (distance - radius[first] - radius[second] <= way)
    if not params.fixed_contacts:
        keep &= inverse[second] > 0.0
    first, second = first[keep], second[keep]
    start = np.searchsorted(first, np.arange(len(radius) + 1))
    touching = (distance[keep] < radius[first] + radius[second]).astype(np.bool_)
    listed = _Neighbours(np.arange(len(radius)), start, second, touching, single=True)
    sums = np.empty((len(radius), 6))
    sums[order] = _rooms(_Discs(radius, radius, thickness, inverse), listed, params)
    return sums


def _rooms(discs: _Discs, listed: _Neighbours, params: EngineParams) -> Array:
    """Sums of the bounds about some elements or kinds (k, 6): see `Room`, before the mass.

    Those that overlap already (`touching`) may be more than find room side by side: each counts.
    """
    laws = params.contact_modulus, params.contact_damping
    caps = DAMPING_PER_STEP, params.walls
    return np.asarray(_full_turns(np.column_stack(discs), listed, laws, caps))


@njit(cache=True)
def _full_turns(
    discs: np.ndarray,
    listed: _Neighbours,
    laws: tuple[float, float],
    caps: tuple[float, float],
) -> np.ndarray:
    per_step, walled = caps
    rows, start, neighbour, touching, single = listed
    modulus, share_damped = laws
    out = np.zeros((len(rows), 6))
    room = 0
    for i in range(len(rows)):
        room = max(room, 1 + start[i + 1] - start[i])
    q, value, over = np.empty(room), np.empty((3, room)), np.zeros(room, dtype=np.bool_)
    front_q, front = np.empty(room), np.empty(room)
    for i in rows:
        largest, own, h, inverse = discs[i]
        if inverse == 0.0:
            continue
        count = start[i + 1] - start[i]
        for n in range(count):
            _, r, other, heavy = discs[neighbour[start[i] + n]]
            k = modulus * h * other / (h + other) if h + other > 0.0 else 0.0
            reduced = 1.0 / (heavy + inverse)
            over[n] = touching[start[i] + n]
            weight = 1.0 + r * heavy / (own * inverse)
            q[n] = r / (largest + r)
            value[0, n] = weight * k
            value[1, n] = weight * 2.0 * share_damped * np.sqrt(k * reduced)
            value[2, n] = weight * per_step * reduced
        wall = -1
        if walled:
            # A wall takes the room of a disc of the same size; all the spring is the ice's own.
            n = count
            count += 1
            while n > 0 and q[n - 1] > 0.5:
                q[n], value[:, n], over[n] = q[n - 1], value[:, n - 1], over[n - 1]
                n -= 1
            q[n], over[n], wall = 0.5, False, n
            value[0, n] = modulus * h
            value[1, n] = 2.0 * share_damped * np.sqrt(modulus * h / inverse)
            value[2, n] = per_step / inverse
        for kind in range(3):
            # Only those count that are worth more than all smaller ones.
            kept, best, there = 0, -1.0, 0.0
            for n in range(count):
                if over[n]:
                    there += value[kind, n]
                if value[kind, n] > best:
                    best = value[kind, n]
                    front_q[kept], front[kept] = q[n], best
                    kept += 1
            most = 0.0
            for a in range(kept):
                for b in range(a + 1):
                    angle = 2.0 * np.arcsin(np.sqrt(front_q[a] * front_q[b]))
                    most = max(most, np.pi * (front[a] + front[b]) / angle)
            if single and most > FEWEST * best:
                once = _once(q[:count], value[kind, :count], over[:count], wall)
                most = min(most, max(once, FEWEST * best))
            out[i, kind], out[i, 3 + kind] = max(most, there), max(best, 0.0)
    return out


@njit(cache=True)
def _once(q: np.ndarray, value: np.ndarray, over: np.ndarray, wall: float) -> float:
    """Most that neighbours add up to of which each is there once; walls as many as find room.

    Beside the next one in the row a neighbour takes no less of the full turn than beside the
    smallest, ``q[0]``. Those in touch already (`over`) are all there and leave the whole turn.
    """
    left, total = 2.0 * np.pi, 0.0
    angle = 2.0 * np.arcsin(np.sqrt(q * q[0]))
    for n in np.argsort(-value / angle):
        if over[n]:
            total += value[n]
            continue
        share = left / angle[n]
        if n != wall:
            share = min(share, 1.0)
        total += share * value[n]
        left = max(left - share * angle[n], 0.0)
    return total


def element_kinds(elements: Arrays) -> Kinds:
    """Each element on its own where there are few, else classes of like radius and thickness.

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.

    Returns
    -------
    Kinds
        Radii (m), thickness (m) and inverse mass (1/kg) of each class, sorted by radius, and the
        class of each element, (n,).
    """
    inverse = np.where(np.asarray(elements["type"]) == FIXED, 0.0, 1.0 / elements["mass"])
    radius, thickness = (np.asarray(elements[name], float) for name in ("radius", "thickness"))
    of, n = np.arange(len(radius)), len(radius)
    width = WIDTH
    while n > MOST:
        r, h = (
            np.floor(np.log(v) / np.log1p(width)) for v in (radius, np.maximum(thickness, 1e-12))
        )
        r, h = (1 + (v - v.min()).astype(np.int64) for v in (r, h))
        key = (r * (h.max() + 1) + h) * np.where(inverse > 0.0, 1, -1)
        _, of = np.unique(key, return_inverse=True)
        n = int(of.max()) + 1
        width *= 2.0
    smallest, inverses = np.full(n, np.inf), np.full(n, np.inf)
    largest, thickest = np.zeros(n), np.zeros(n)
    for out, values in ((smallest, radius), (inverses, inverse)):
        np.minimum.at(out, of, values)
    for out, values in ((largest, radius), (thickest, thickness)):
        np.maximum.at(out, of, values)
    order = np.argsort(smallest, kind="stable")
    rank = np.argsort(order, kind="stable")
    return Kinds(smallest[order], largest[order], thickest[order], inverses[order], rank[of])
