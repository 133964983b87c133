# SPDX-License-Identifier: GPL-2.0-or-later
"""What a field is, so that nobody sums what should be averaged.

An intensive field is a property of its parent: thickness of ice area, velocity of ice mass. It is
averaged with the parent's amount as weight. An extensive field is an amount and is added up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from floeflow.errors import FloeError
from floeflow.postprocess.remap.bins import Bins
from floeflow.postprocess.remap.grid import Array
from floeflow.postprocess.remap.weights import Weights


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
        What an intensive field is a property of: a key of `Remapper.weights`. Empty for an
        extensive one.
    """

    name: str
    kind: Literal["intensive", "extensive"]
    parent: str = ""


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


def remap(field: Field, values: Array, remapper: Remapper, bounded: bool = True) -> Array:
    """Bring a field of the elements, (n,), to the grid, (ny, nx), in the way its kind asks for.

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
    if field.kind == "extensive":
        return remapper.bins.total(values)
    if field.parent not in remapper.weights:
        known = ", ".join(remapper.weights) or "none"
        raise FloeError(
            f"remap: '{field.name}' is averaged over '{field.parent}', for which there are no "
            f"weights; there are: {known}"
        )
    return remapper.weights[field.parent].apply(values, bounded)
