# SPDX-License-Identifier: GPL-2.0-or-later
"""What all contacts that may come about an element can add up to, whoever they are with.

Contacts form within a window, so their network is not known beforehand. For any motion a, b of two
elements in touch and any weights d > 0

    (a - b)^2 <= (1 + d_b / d_a) a^2 + (1 + d_a / d_b) b^2,

so a network of contacts is never stiffer than one in which each element is held to the ground by
springs as stiff as these terms. An element has room for so many neighbours only: two discs that
touch a third and do not overlap are seen from its centre under an angle of at least
2 asin(sqrt(q_j q_k)), q = r_j / (r_i + r_j) (law of cosines), and the angles of all neighbours in a
row add up to a full turn. See docs/theory/forces.md, "Time step".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floeflow.dynamics.engine.params import FIXED, EngineParams
from floeflow.state.bonds import Arrays

# More kinds of elements than this are put together, in classes that widen by this share.
MOST, WIDTH = 1500, 0.01


@dataclass(frozen=True)
class Room:
    """Most that contacts about each element add up to, over its mass; arrays of shape (n,).

    Parameters
    ----------
    stiffness, damping : ndarray
        Sum of all neighbours', normal to the contacts, 1/s2 and 1/s.
    stiffest, most_damped : ndarray
        Of a single one.
    """

    stiffness: np.ndarray
    damping: np.ndarray
    stiffest: np.ndarray
    most_damped: np.ndarray


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


def contact_room(elements: Arrays, params: EngineParams) -> Room:
    """Bounds of the contacts about each element, friction left out.

    The weights are radius over mass: the heavier of two stays still. That makes the bound exact for
    a full lattice of equal discs, whatever their thicknesses.

    Parameters
    ----------
    elements : dict of ndarray, shape (n,)
        As `Engine.load` takes them.
    params : EngineParams
        Law parameters.
    """
    kinds = element_kinds(elements)
    weight = kinds.weight
    rows = []
    for i in range(len(kinds.radius)):
        if kinds.inverse[i] == 0.0:
            rows.append((0.0,) * 4)
            continue
        series = kinds.thickness + kinds.thickness[i]
        with np.errstate(invalid="ignore"):
            h = np.where(series > 0.0, kinds.thickness * kinds.thickness[i] / series, 0.0)
        k = params.contact_modulus * h
        c = 2.0 * params.contact_damping * np.sqrt(k / (kinds.inverse + kinds.inverse[i]))
        share = 1.0 + weight / weight[i]
        q = kinds.radius / (kinds.largest[i] + kinds.radius)
        rows.append((_full_turn(q, k * share), _full_turn(q, c * share), *_most(k, c, share)))
    mobile = np.asarray(elements["type"]) != FIXED
    sums = np.array(rows)[kinds.of] * np.where(mobile, 1.0 / elements["mass"], 0.0)[:, None]
    return Room(*sums.T)


def _most(k: np.ndarray, c: np.ndarray, share: np.ndarray) -> tuple[float, float]:
    return float((k * share).max()), float((c * share).max())


def _full_turn(q: np.ndarray, value: np.ndarray) -> float:
    """Most that the values of neighbours in a full turn add up to; `q` ascending.

    Half of both values belongs to the angle between two neighbours. Only those count that are
    worth more than all smaller ones.
    """
    best = np.maximum.accumulate(value)
    front = np.flatnonzero(np.concatenate([[True], best[1:] > best[:-1]]))
    q, value = q[front], value[front]
    angle = 2.0 * np.arcsin(np.sqrt(q[:, None] * q))
    return float((np.pi * (value[:, None] + value) / angle).max())


def element_kinds(elements: Arrays) -> Kinds:
    """Each element on its own where there are few, else classes of like radius and thickness."""
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
