# SPDX-License-Identifier: GPL-2.0-or-later
"""Weights of the nearest element alone: the crudest average, to compare with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floeflow.transfer.stencil import Array, Stencil, Target
from floeflow.transfer.weights import (
    EMPTY,
    LEAST_SHARE,
    NEAREST,
    Weights,
    build_weights,
    select_pairs,
)


def nearest_weights(x: Array, y: Array, area: Array, target: Target, pairs: Stencil) -> Weights:
    """Weights that give each node the value of the nearest element in reach that has any parent.

    Parameters
    ----------
    x, y, area, target
        As `build_weights` takes them.
    pairs : Stencil
        ``target.pairs(x, y, reach)``.

    Returns
    -------
    Weights
        One element to a node: its row is all of a Shepard average.
    """
    node = np.repeat(np.arange(len(pairs.start) - 1), np.diff(pairs.start))
    there = area[pairs.element] > LEAST_SHARE * area.max(initial=0.0)
    away = np.where(there, pairs.xi**2 + pairs.eta**2, np.inf)
    order = np.lexsort((pairs.element, away, node))
    first = np.zeros(len(node), dtype=bool)
    first[order[np.unique(node, return_index=True)[1]]] = True
    found = build_weights(x, y, area, target, pairs=select_pairs(pairs, first & there))
    status = np.where(found.status == EMPTY, EMPTY, NEAREST).astype(np.int8)
    return replace(found, status=status)
