# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of elements, bonds and contacts between NumPy and the plugin, gathered over the ranks."""

from __future__ import annotations

import ctypes

import numpy as np
from mpi4py import MPI

from floeflow.state.bonds import (
    BOND_COLUMNS,
    CONTACT_COLUMNS,
    RIDGE_COLUMNS,
    Arrays,
    line_length,
    pair_keys,
)

# What wind and ocean have given an element since it was loaded, N s.
IMPULSES = ("wind_impulse_x", "wind_impulse_y", "ocean_impulse_x", "ocean_impulse_y")
# Columns of an element in the plugin's order (liggghts_models/capi/capi.h).
COLUMNS = (
    *("x", "y", "theta", "u", "v", "omega", "radius", "mass", "thickness", "ice_area", "cover"),
    "ridged_area",
    *IMPULSES,
)
# What neighbours and walls do to an element now: force, N, and the sum of arms times forces, N m.
INTERNAL = ("force_x", "force_y", "moment_xx", "moment_yy", "moment_xy")
_CONTACT = (*CONTACT_COLUMNS, *RIDGE_COLUMNS)
_NOT_FINITE, _BOND_REACH = 1, 3


def stack_columns(table: Arrays, names: tuple[str, ...]) -> np.ndarray:
    """Columns of a table side by side, shape (rows, columns).

    Parameters
    ----------
    table : Arrays
        Columns by name, (rows,) each.
    names : tuple of str
        Columns in their order.

    Returns
    -------
    ndarray
        C-contiguous float64.
    """
    # Only ridging has the columns that may be missing; without it, and at its start, they are 0.
    none = np.zeros(len(next(iter(table.values()))))
    optional = dict.fromkeys(("ridged_area", *IMPULSES, *RIDGE_COLUMNS), none)
    optional["cover"] = none + 1.0
    columns = [
        np.asarray(table.get(name, optional[name]) if name in optional else table[name], float)
        for name in names
    ]
    return np.ascontiguousarray(np.column_stack(columns))


def gather(comm: MPI.Comm, local: np.ndarray) -> np.ndarray:
    """Rows of all ranks, by rank, on every rank.

    Parameters
    ----------
    comm : MPI.Comm
        Ranks that share the engine.
    local : ndarray
        Rows of this rank, (k, ...).

    Returns
    -------
    ndarray
        (sum of k, ...).
    """
    if comm.size == 1:
        return local
    counts = comm.allgather(local.nbytes)
    out = np.empty(sum(counts), np.uint8)
    comm.Allgatherv(
        [np.ascontiguousarray(local).reshape(-1).view(np.uint8), MPI.BYTE], [out, counts, MPI.BYTE]
    )
    return out.view(local.dtype).reshape(-1, *local.shape[1:])


def create_elements(library: ctypes.CDLL, instance: ctypes.c_void_p, elements: Arrays) -> int:
    """Make each rank's elements, in the order of the table; returns 1 if that failed.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    elements : Arrays
        Table of n elements, sorted by id.

    Returns
    -------
    int
        0 for success.
    """
    ids = np.ascontiguousarray(elements["id"], dtype=np.int64)
    kind = np.ascontiguousarray(elements["type"], dtype=np.int8)
    columns = stack_columns(elements, COLUMNS)
    return int(library.floe_create_elements(instance, len(ids), ids, kind, columns))


def get_elements(library: ctypes.CDLL, instance: ctypes.c_void_p, comm: MPI.Comm) -> Arrays:
    """All elements, sorted by id, on every rank.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    comm : MPI.Comm
        Ranks that share the engine.

    Returns
    -------
    Arrays
        Table of n elements.
    """
    n = int(library.floe_count_elements(instance))
    ids, kind = np.empty(n, np.int64), np.empty(n, np.int8)
    columns = np.empty((n, len(COLUMNS)))
    library.floe_get_elements(instance, ids, kind, columns)
    ids, kind, columns = (gather(comm, a) for a in (ids, kind, columns))
    order = np.argsort(ids)
    columns = columns[order]  # whole rows: a column at a time would fetch each of them again
    out: Arrays = {"id": ids[order], "type": kind[order]}
    for k, name in enumerate(COLUMNS):
        out[name] = columns[:, k].copy()
    return out


def get_internal(
    library: ctypes.CDLL, instance: ctypes.c_void_p, comm: MPI.Comm
) -> tuple[int, Arrays]:
    """Whether it failed (1), and the columns `INTERNAL` of all elements, sorted by id.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    comm : MPI.Comm
        Ranks that share the engine.

    Returns
    -------
    tuple of int and Arrays
        0 for success; internal forces and stresses by the names of `INTERNAL`, (n,) each.
    """
    n = int(library.floe_count_elements(instance))
    ids, kind = np.empty(n, np.int64), np.empty(n, np.int8)
    elements, columns = np.empty((n, len(COLUMNS))), np.empty((n, len(INTERNAL)))
    library.floe_get_elements(instance, ids, kind, elements)
    failed = int(library.floe_internal(instance, columns))
    ids, columns = gather(comm, ids), gather(comm, columns)
    columns = columns[np.argsort(ids)]
    return failed, {name: columns[:, k].copy() for k, name in enumerate(INTERNAL)}


def put_pairs(
    library: ctypes.CDLL, instance: ctypes.c_void_p, bonds: Arrays, contacts: Arrays
) -> int:
    """Put all pairs into the neighbour lists; returns 1 if that failed.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    contacts : Arrays
        Contact table.

    Returns
    -------
    int
        0 for success.
    """
    arguments: list[object] = []
    for table, names in ((bonds, BOND_COLUMNS), (contacts, _CONTACT)):
        ids = np.column_stack([table["id_lo"], table["id_hi"]]).astype(np.int64)
        arguments += [len(ids), np.ascontiguousarray(ids), stack_columns(table, names)]
    return int(library.floe_put_pairs(instance, *arguments))


def count_pairs(library: ctypes.CDLL, instance: ctypes.c_void_p) -> tuple[int, int]:
    """How many bonds and contacts this rank speaks for.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.

    Returns
    -------
    tuple of int
        Numbers of bonds and of contacts.
    """
    bonds, contacts = ctypes.c_longlong(), ctypes.c_longlong()
    library.floe_count_pairs(instance, ctypes.byref(bonds), ctypes.byref(contacts))
    return bonds.value, contacts.value


def get_pairs(
    library: ctypes.CDLL, instance: ctypes.c_void_p, comm: MPI.Comm, contact: tuple[str, ...]
) -> tuple[Arrays, Arrays]:
    """Bond table and contact table with these columns, sorted by (id_lo, id_hi), on every rank.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    comm : MPI.Comm
        Ranks that share the engine.
    contact : tuple of str
        Columns of the contact table that are wanted.

    Returns
    -------
    tuple of Arrays
        Bonds, and contacts.
    """
    counts = count_pairs(library, instance)
    ids = [np.empty((n, 2), np.int64) for n in counts]
    values = [np.empty((counts[0], len(BOND_COLUMNS))), np.empty((counts[1], len(_CONTACT)))]
    library.floe_get_pairs(instance, ids[0], values[0], ids[1], values[1])
    tables = []
    for k, (names, wanted) in enumerate(((BOND_COLUMNS, BOND_COLUMNS), (_CONTACT, contact))):
        pair, row = gather(comm, ids[k]), gather(comm, values[k])
        order = np.argsort((pair[:, 0] << 32) | pair[:, 1])
        pair, row = pair[order], row[order]
        table = {"id_lo": pair[:, 0].copy(), "id_hi": pair[:, 1].copy()}
        for column, name in enumerate(names):
            if name in wanted:
                table[name] = row[:, column].copy()
        tables.append(table)
    tables[0]["length"] = line_length(tables[0])
    return tables[0], tables[1]


def get_sums(
    library: ctypes.CDLL, instance: ctypes.c_void_p, comm: MPI.Comm
) -> tuple[int, dict[str, float]]:
    """Whether it failed (1), and the plugin's sums over all ranks by name.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    comm : MPI.Comm
        Ranks that share the engine.

    Returns
    -------
    tuple of int and dict of float
        0 for success; sums since the start in SI units, ``max_overlap`` the largest over all ranks.
    """
    names = library.floe_sum_names().decode().split()
    sums = np.zeros(len(names))
    failed = int(library.floe_sums(instance, sums, len(sums)))
    total, largest = np.empty_like(sums), np.empty_like(sums)
    comm.Allreduce(sums, total, op=MPI.SUM)
    comm.Allreduce(sums, largest, op=MPI.MAX)
    out = dict(zip(names, total.tolist(), strict=True))
    out["max_overlap"] = float(largest[names.index("max_overlap")])
    return failed, out


def missing_pairs(wanted: Arrays, present: Arrays) -> list[tuple[int, int]]:
    """Pairs of one table that another does not have.

    Parameters
    ----------
    wanted : Arrays
        Tables of pairs, with ``id_lo`` and ``id_hi``.
    present : Arrays
        Tables of pairs, with ``id_lo`` and ``id_hi``.

    Returns
    -------
    list of tuple of int
        Ids of the pairs that only ``wanted`` has.
    """
    rows = np.flatnonzero(~np.isin(pair_keys(wanted), pair_keys(present)))
    return [(int(wanted["id_lo"][k]), int(wanted["id_hi"][k])) for k in rows]


def first_fault(library: ctypes.CDLL, instance: ctypes.c_void_p, comm: MPI.Comm) -> str:
    """Sentence about the first element that failed on any rank; empty if none did.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Of LIGGGHTS.
    comm : MPI.Comm
        Ranks that share the engine.

    Returns
    -------
    str
        With element, place (m) and step.
    """
    whole, real = np.zeros(4, np.int64), np.zeros(6)
    library.floe_fault(instance, whole, real)
    found = [f for f in comm.allgather((whole.tolist(), real.tolist())) if f[0][0]]
    if not found:
        return ""
    (kind, step, ident, partner), (x, y, fx, fy, torque, speed) = min(
        found, key=lambda f: f[0][1:3]
    )
    place = f"at ({x:.6g}, {y:.6g}) m in step {step}"
    if kind == _BOND_REACH:
        return (
            f"The bond between elements {ident} and {partner}, {place}, became longer than the "
            "neighbour lists reach: set a longer reach."
        )
    what = "became non-finite" if kind == _NOT_FINITE else f"ran away with {speed:.3g} m/s"
    return (
        f"Element {ident} {what} {place}; last force ({fx:.6g}, {fy:.6g}) N, torque "
        f"{torque:.6g} N m: is the time step too long?"
    )
