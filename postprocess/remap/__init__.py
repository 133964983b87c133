# SPDX-License-Identifier: GPL-2.0-or-later
"""Transfer of fields between elements and grids: weights built once, applied to many fields.

`weights` averages (moving least squares), `bins` adds up (conservative), `fields` says which of
the two a quantity needs, `carry` brings a hierarchy of fields over with exact totals and within
bounds, `samples` goes from grids to elements and back, `readers` reads other programs' meshes
(imported by name only: it brings meshio along). docs/theory/remap.md has the equations.
"""

from floeflow.postprocess.remap.bins import Bins, Room, build_bins, build_room, open_room
from floeflow.postprocess.remap.bounded import Bounded, Ranks, nearest_bounded
from floeflow.postprocess.remap.carry import Carried, carry, near_cells
from floeflow.postprocess.remap.fields import ROOM, Field, Remapper, build_remapper, remap
from floeflow.postprocess.remap.grid import Grid
from floeflow.postprocess.remap.mesh import Mesh, curvilinear
from floeflow.postprocess.remap.nearest import nearest_weights
from floeflow.postprocess.remap.quadrature import Points, disc_points, polygon_points
from floeflow.postprocess.remap.samples import (
    Sampler,
    build_sampler,
    mean_wind,
    vector_at,
    vector_back,
)
from floeflow.postprocess.remap.store import load_weights, save_weights
from floeflow.postprocess.remap.weights import (
    EMPTY,
    FILLED,
    MLS,
    NEAREST,
    SHEPARD,
    Weights,
    build_weights,
)

__all__ = [
    "EMPTY",
    "FILLED",
    "MLS",
    "NEAREST",
    "ROOM",
    "SHEPARD",
    "Bins",
    "Bounded",
    "Carried",
    "Field",
    "Grid",
    "Mesh",
    "Points",
    "Ranks",
    "Remapper",
    "Room",
    "Sampler",
    "Weights",
    "build_bins",
    "build_remapper",
    "build_room",
    "build_sampler",
    "build_weights",
    "carry",
    "curvilinear",
    "disc_points",
    "load_weights",
    "mean_wind",
    "near_cells",
    "nearest_bounded",
    "nearest_weights",
    "open_room",
    "polygon_points",
    "remap",
    "save_weights",
    "vector_at",
    "vector_back",
]
