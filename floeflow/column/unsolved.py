# SPDX-License-Identifier: GPL-2.0-or-later
"""Temperatures of columns that no method found."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floeflow.core.errors import FloeError

LARGEST_LEFT = 1e-3
"""Temperatures that still change by more (K) when their iterations end are no solution."""


class UnsolvedError(FloeError):
    """Columns whose temperatures did not come near a solution; ``rows`` are their numbers.

    Parameters
    ----------
    rows : ndarray
        Numbers of the columns at fault, one at least.
    count : int
        How many columns there are.
    bound : float
        Change of the temperatures (K) that would have been near enough.
    place : str, optional
        Where the first one lies.
    """

    def __init__(self, rows: NDArray[np.int64], count: int, bound: float, place: str = "") -> None:
        self.rows, self.count, self.bound = rows, count, bound
        where = place or f"column {int(rows[0])}"
        super().__init__(
            f"column: no temperatures balance the fluxes in {len(rows)} of {count} columns, first "
            f"in {where}: they still change by more than {bound:g} K when the iterations end; "
            "check the forcing there, or take a shorter column.step"
        )

    def at(self, place: str) -> UnsolvedError:
        """The same with the place of the first column in words.

        Parameters
        ----------
        place : str
            The column's place, for people.

        Returns
        -------
        UnsolvedError
            With the same rows, count and bound.
        """
        return UnsolvedError(self.rows, self.count, self.bound, place)
