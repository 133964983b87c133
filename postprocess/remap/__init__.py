# SPDX-License-Identifier: GPL-2.0-or-later
"""Transfer of fields from elements to grids: weights built once, applied to many fields.

`weights` averages (moving least squares), `bins` adds up (conservative), `fields` says which of
the two a quantity needs. docs/theory/remap.md has the equations.
"""

from floeflow.postprocess.remap.bins import Bins, Room, build_bins, build_room
from floeflow.postprocess.remap.fields import Field, Remapper, remap
from floeflow.postprocess.remap.grid import Grid
from floeflow.postprocess.remap.weights import (
    EMPTY,
    MLS,
    SHEPARD,
    Weights,
    build_weights,
    load_weights,
    save_weights,
)

__all__ = [
    "EMPTY",
    "MLS",
    "SHEPARD",
    "Bins",
    "Field",
    "Grid",
    "Remapper",
    "Room",
    "Weights",
    "build_bins",
    "build_room",
    "build_weights",
    "load_weights",
    "remap",
    "save_weights",
]
