# SPDX-License-Identifier: GPL-2.0-or-later
"""Places on a disc whose mean stands for the mean over it.

The element model meets forcing at the same places (`disc_places` in
``liggghts_models/laws/forcing.h``), and what elements give back to the grid is spread over them, so
that the way back is the transpose of the way in.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RINGS, SPOKES = 2, 8


def disc_places() -> tuple[Array, Array]:
    """Places on a disc of radius 1 around 0, x and y, (16,), all of the same weight.

    Two rings of Gauss-Legendre in the squared radius: exact for polynomials up to degree 7.
    """
    ring = np.repeat(np.arange(RINGS), SPOKES)
    radius = np.sqrt(0.5 * (1.0 + np.where(ring, 1.0, -1.0) / np.sqrt(3.0)))
    angle = 2.0 * np.pi * (np.tile(np.arange(SPOKES), RINGS) + 0.5 * ring) / SPOKES
    return radius * np.cos(angle), radius * np.sin(angle)
