# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls and their contacts between NumPy and the plugin, gathered over the ranks."""

from __future__ import annotations

import ctypes

import numpy as np
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.tables import gather, stack_columns
from floeflow.state.bonds import CONTACT_COLUMNS, RIDGE_COLUMNS, Arrays, element_rows
from floeflow.state.walls import FACE_COLUMNS, FACE_NUMBERS

# LIGGGHTS command that makes room for walls.
FIX = "fix walls all floe/walls"
_CONTACT = (*CONTACT_COLUMNS, *RIDGE_COLUMNS)


def check_wall_contacts(
    faces: Arrays, elements: Arrays, contacts: Arrays, columns: tuple[str, ...]
) -> None:
    """Refuse a table of wall contacts with impossible values; names the contact.

    Parameters
    ----------
    faces : Arrays
        Faces of walls, as in `floeflow.state.walls`.
    elements : Arrays
        Table of n elements, sorted by id.
    contacts : Arrays
        Table of contacts with walls.
    columns : tuple of str
        Columns that the table must have.

    Raises
    ------
    FloeError
        For an element or face that does not exist, a pair that appears twice, or a value that
        cannot be.
    """
    ids, face = np.asarray(contacts["id"]), np.asarray(contacts["face"])
    if len(ids) == 0:
        return
    element_rows(elements["id"], ids)
    if (face < 0).any() or (face >= len(faces["ax"])).any():
        raise FloeError("A wall contact names a face that does not exist.")
    if len(np.unique(np.column_stack([ids, face]), axis=0)) != len(ids):
        raise FloeError("An element and a face appear twice in the table of wall contacts.")
    ridging = "ridge_closing" in columns
    for name in columns:
        bad = ~np.isfinite(contacts[name])
        if name in RIDGE_COLUMNS or (name == "rest_overlap" and not ridging):
            bad |= contacts[name] < 0
        if bad.any():
            k = int(np.flatnonzero(bad)[0])
            raise FloeError(
                f"{name} of the contact of element {ids[k]} with face {face[k]} is "
                f"{contacts[name][k]}: it must be finite and must not be negative."
            )


def set_walls(library: ctypes.CDLL, instance: ctypes.c_void_p, faces: Arrays) -> int:
    """Hand the faces over; returns 1 if that failed.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    faces : Arrays
        Faces of walls, as in `floeflow.state.walls`.

    Returns
    -------
    int
        0 for success.
    """
    numbers = np.column_stack([faces[name] for name in FACE_NUMBERS]).astype(np.int64)
    columns = stack_columns(faces, FACE_COLUMNS)
    return int(
        library.floe_set_walls(
            instance, count_walls(faces), len(columns), np.ascontiguousarray(numbers), columns
        )
    )


def count_walls(faces: Arrays) -> int:
    """How many walls the faces belong to.

    Parameters
    ----------
    faces : Arrays
        Table of faces.

    Returns
    -------
    int
        0 without faces.
    """
    return int(faces["wall"].max(initial=-1)) + 1


def put_wall_contacts(library: ctypes.CDLL, instance: ctypes.c_void_p, contacts: Arrays) -> int:
    """Hand each rank the contacts of its elements; returns 1 if that failed.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    contacts : Arrays
        Table of contacts with walls.

    Returns
    -------
    int
        0 for success.
    """
    ids = np.column_stack([contacts["id"], contacts["face"]]).astype(np.int64)
    columns = stack_columns(contacts, _CONTACT)
    return int(
        library.floe_put_wall_contacts(instance, len(ids), np.ascontiguousarray(ids), columns)
    )


def get_wall_contacts(
    library: ctypes.CDLL, instance: ctypes.c_void_p, comm: MPI.Comm, columns: tuple[str, ...]
) -> Arrays:
    """Contacts with walls, sorted by (id, face), on every rank.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    comm : MPI.Comm
        Ranks that share the engine.
    columns : tuple of str
        Columns that are wanted.

    Returns
    -------
    Arrays
        With ``id`` and ``face``.
    """
    n = int(library.floe_count_wall_contacts(instance))
    ids, values = np.empty((n, 2), np.int64), np.empty((n, len(_CONTACT)))
    library.floe_get_wall_contacts(instance, ids, values)
    ids, values = gather(comm, ids), gather(comm, values)
    order = np.lexsort((ids[:, 1], ids[:, 0]))
    out: Arrays = {"id": ids[order, 0].copy(), "face": ids[order, 1].copy()}
    for k, name in enumerate(_CONTACT):
        if name in columns:
            out[name] = values[order, k].copy()
    return out


def wall_forces(
    library: ctypes.CDLL, instance: ctypes.c_void_p, comm: MPI.Comm, walls: int
) -> tuple[np.ndarray, np.ndarray]:
    """Impulse (N s) on the ice since `load` and force (N) now of each wall, shapes (walls, 2).

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    comm : MPI.Comm
        Ranks that share the engine.
    walls : int
        Number of walls.

    Returns
    -------
    tuple of ndarray
        Components x and y.
    """
    mine = np.zeros((2, walls, 2))
    library.floe_wall_forces(instance, mine[0], mine[1])
    total = np.empty_like(mine)
    comm.Allreduce(mine, total, op=MPI.SUM)
    return total[0], total[1]
