# SPDX-License-Identifier: GPL-2.0-or-later
"""Transfer of fields between elements and grids: weights built once, applied to many fields.

`weights` averages (moving least squares), `bins` adds up (conservative), `fields` says which of
the two a quantity needs, `conservative_transfer` brings a hierarchy of fields over with exact
totals and within bounds, `samples` goes from grids to elements and back, `readers` reads other
programs' meshes (imported by name only: it brings meshio along). docs/theory/remap.md has the
equations.
"""

from floeflow.transfer.bins import Bins, Room, build_bins, build_room, open_room
from floeflow.transfer.bounded import Bounded, Ranks, nearest_bounded
from floeflow.transfer.conservative import Carried, conservative_transfer, near_cells
from floeflow.transfer.fields import ROOM, Field, Remapper, build_remapper, remap
from floeflow.transfer.grid import Grid
from floeflow.transfer.mesh import Mesh, curvilinear
from floeflow.transfer.nearest import nearest_weights
from floeflow.transfer.quadrature import Points, disc_points, polygon_points
from floeflow.transfer.samples import Sampler, build_sampler, mean_wind, vector_at, vector_back
from floeflow.transfer.store import load_weights, save_weights
from floeflow.transfer.weights import EMPTY, FILLED, MLS, NEAREST, SHEPARD, Weights, build_weights

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
    "conservative_transfer",
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
