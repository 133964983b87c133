# SPDX-License-Identifier: GPL-2.0-or-later
"""What a field is, so that nobody sums what should be averaged; and how fields go to a grid.

An intensive field is a property of its parent: thickness of ice area, temperature of ice volume.
It is averaged with the parent's amount as weight. An extensive field is an amount and is added up:
either dealt out as it is, or, if it sits on a parent (ice volume on ice area), carried as the
property "amount per amount of the parent".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from floeflow.core.errors import FloeError
from floeflow.transfer.bins import Bins, Room, build_bins
from floeflow.transfer.bounded import Ranks
from floeflow.transfer.nearest import nearest_weights
from floeflow.transfer.stencil import Array
from floeflow.transfer.weights import CONDITION_LIMIT, Weights, build_weights

# Parent of an area that fills the sea of the cells: at most all of it.
ROOM = "room"


@dataclass(frozen=True)
class Field:
    """A quantity of the elements.

    Parameters
    ----------
    name : str
        Its name.
    kind : str
        ``intensive`` or ``extensive``.
    parent : str
        What it is a property of or sits on: the name of an extensive field. `ROOM` for an
        extensive area that fills the cells' sea; empty for an amount that sits on nothing.

    Raises
    ------
    FloeError
        For an intensive field without a parent.
    """

    name: str
    kind: Literal["intensive", "extensive"]
    parent: str = ""

    def __post_init__(self) -> None:
        if self.kind == "intensive" and self.parent in ("", ROOM):
            raise FloeError(f"remap: '{self.name}' is intensive, but of which parent is not said")


@dataclass(frozen=True)
class Remapper:
    """Everything needed to bring the fields of one set of elements to one grid.

    Parameters
    ----------
    weights : mapping
        Weights by parent.
    bins : Bins
        For amounts.
    """

    weights: Mapping[str, Weights]
    bins: Bins


def build_remapper(
    x: Array,
    y: Array,
    parents: Mapping[str, Array],
    room: Room,
    *,
    radius: Array | None = None,
    condition_limit: float = CONDITION_LIMIT,
    ranks: Ranks | None = None,
    nearest: bool = False,
) -> Remapper:
    """Build weights and bins from one search for the pairs.

    Parameters
    ----------
    x, y : ndarray
        Element centres (m), (n,); a slice of the elements on ranks.
    parents : mapping
        Amounts by name, (n,), that fields are averaged over.
    room : Room
        The grid and the sea in its cells.
    radius : ndarray, optional
        As `build_bins` takes it.
    condition_limit, ranks
        As `build_weights` takes them.
    nearest : bool
        Weights of the nearest element alone instead; of all elements, not of slices.

    Returns
    -------
    Remapper
        Weights by parent, and bins, from the same elements.
    """
    pairs = room.target.pairs(x, y, room.reach)
    if nearest:
        near = {n: nearest_weights(x, y, a, room.target, pairs) for n, a in parents.items()}
        return Remapper(near, build_bins(x, y, room, radius, pairs))
    weights = {
        name: build_weights(
            *(x, y, amount, room.target),
            reach=room.reach,
            condition_limit=condition_limit,
            pairs=pairs,
            ranks=ranks,
        )
        for name, amount in parents.items()
    }
    return Remapper(weights, build_bins(x, y, room, radius, pairs))


def remap(field: Field, values: Array, remapper: Remapper, bounded: bool = True) -> Array:
    """Bring one field of the elements, (n,), to the grid in the way its kind asks for.

    Averages are accurate, but do not conserve: `floeflow.transfer.conservative` does both.

    Parameters
    ----------
    field : Field
        What it is.
    values : ndarray
        (n,): per unit of its parent if intensive, amounts if extensive.
    remapper : Remapper
        Weights and bins.
    bounded : bool
        Cut averages at the values of their elements (see `Weights.apply`).

    Returns
    -------
    ndarray
        Averages, NaN where no element is in reach, or sums per cell.

    Raises
    ------
    FloeError
        For a parent without weights.
    """
    try:
        if field.kind == "extensive":
            return remapper.bins.total(values)
        return parent_weights(field, remapper).apply(values, bounded)
    except FloeError as error:
        raise FloeError(f"{field.name}: {error}") from None


def parent_weights(field: Field, remapper: Remapper) -> Weights:
    """Weights of a field's parent.

    Parameters
    ----------
    field : Field
        With the name of its parent.
    remapper : Remapper
        Weights by the name of the parent.

    Returns
    -------
    Weights
        From the remapper.

    Raises
    ------
    FloeError
        Where there are none.
    """
    if field.parent not in remapper.weights:
        known = ", ".join(remapper.weights) or "none"
        raise FloeError(
            f"remap: '{field.name}' is averaged over '{field.parent}', for which there are no "
            f"weights; there are: {known}"
        )
    return remapper.weights[field.parent]


def ratio(field: Field, amount: Array, parent: Array) -> Array:
    """Amount per amount of the parent in each element, (n,); NaN where there is no parent.

    Parameters
    ----------
    field : Field
        For messages.
    amount : ndarray
        Of the field in each element, (n,).
    parent : ndarray
        Amount of the parent, (n,).

    Returns
    -------
    ndarray
        In the unit of the amount over that of the parent, (n,).

    Raises
    ------
    FloeError
        For an element that has some of the field and nothing that it sits on.
    """
    bare = (parent <= 0.0) & (amount != 0.0)
    if bare.any():
        e = int(np.argmax(bare))
        raise FloeError(
            f"remap: element {e} has {amount[e]:g} of '{field.name}', but no '{field.parent}' "
            "that it could sit on"
        )
    return np.divide(amount, parent, out=np.full_like(amount, np.nan), where=parent > 0.0)
