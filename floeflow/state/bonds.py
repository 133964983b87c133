# SPDX-License-Identifier: GPL-2.0-or-later
"""The bond table: which pairs are bonded, where their glue lines lie and how far they are cracked.

The ends of a glue line are kept in the body frames of both elements, so that the stress in a bond
follows from the present positions alone. NumPy only: preprocessing, engine and tests share it.
"""

from __future__ import annotations

import numpy as np

from floeflow.core.errors import FloeError

Arrays = dict[str, np.ndarray]

# Columns that the plugin takes and gives, in its order (liggghts_models/capi/capi.h).
BOND_COLUMNS = (
    "span",
    "thickness",
    "crack_a",
    "crack_b",
    "lo_ax",
    "lo_ay",
    "lo_bx",
    "lo_by",
    "hi_ax",
    "hi_ay",
    "hi_bx",
    "hi_by",
)
CONTACT_COLUMNS = ("slip", "rest_overlap")
# What a contact carries besides, with ridging.
RIDGE_COLUMNS = ("ridge_closing", "ridge_thickness", "ridge_length")


def new_bonds(
    elements: Arrays,
    id_lo: np.ndarray,
    id_hi: np.ndarray,
    ax: np.ndarray,
    ay: np.ndarray,
    bx: np.ndarray,
    by: np.ndarray,
    thickness: np.ndarray,
) -> Arrays:
    """Unstressed bonds along given glue lines.

    Parameters
    ----------
    elements : dict of ndarray, shape (n,)
        At least id, x, y (m) and theta (rad); ids ascending.
    id_lo, id_hi : ndarray of int, shape (m,)
        The pairs, in any order; the table has the lower id first.
    ax, ay, bx, by : ndarray, shape (m,)
        Ends of each glue line, m. They are swapped where needed, so that the element with the
        lower id lies to the left when one looks from a to b.
    thickness : ndarray, shape (m,)
        Ice thickness of the bond, m.

    Returns
    -------
    dict of ndarray, shape (m,)
        Bond table sorted by (id_lo, id_hi): ids, length and span (m, of the glue line and between
        the centres), thickness (m), crack_a and crack_b (cracked share from either end, 0), and
        the ends in both body frames (m).

    Raises
    ------
    FloeError
        If a pair names an unknown element or one twice, or if a glue line has no length.
    """
    id_lo, id_hi = np.minimum(id_lo, id_hi), np.maximum(id_lo, id_hi)
    order = np.lexsort((id_hi, id_lo))
    pick = [np.asarray(a)[order] for a in (id_lo, id_hi, ax, ay, bx, by, thickness)]
    id_lo, id_hi, ax, ay, bx, by, thickness = pick
    lo, hi = element_rows(elements["id"], id_lo), element_rows(elements["id"], id_hi)
    if (id_lo == id_hi).any():
        raise FloeError(f"Element {id_lo[id_lo == id_hi][0]} cannot be bonded to itself.")
    dx = elements["x"][hi] - elements["x"][lo]
    dy = elements["y"][hi] - elements["y"][lo]
    length = np.hypot(bx - ax, by - ay)
    if not (length > 0).all():
        k = int(np.flatnonzero(~(length > 0))[0])
        raise FloeError(f"The bond between elements {id_lo[k]} and {id_hi[k]} has no length.")
    # The normal (t_y, -t_x) of the line must point from lo to hi.
    swap = (by - ay) * dx - (bx - ax) * dy < 0
    ax, bx = np.where(swap, bx, ax), np.where(swap, ax, bx)
    ay, by = np.where(swap, by, ay), np.where(swap, ay, by)
    table: Arrays = {
        "id_lo": id_lo.astype(np.int64),
        "id_hi": id_hi.astype(np.int64),
        "length": length,
        "span": np.hypot(dx, dy),
        "thickness": np.asarray(thickness, dtype=float),
        "crack_a": np.zeros(len(id_lo)),
        "crack_b": np.zeros(len(id_lo)),
    }
    for side, row in (("lo", lo), ("hi", hi)):
        cos, sin = np.cos(elements["theta"][row]), np.sin(elements["theta"][row])
        for end, px, py in (("a", ax, ay), ("b", bx, by)):
            rx, ry = px - elements["x"][row], py - elements["y"][row]
            table[f"{side}_{end}x"] = cos * rx + sin * ry
            table[f"{side}_{end}y"] = cos * ry - sin * rx
    return table


def element_rows(ids: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Rows of the `wanted` ids in the ascending `ids`; raises FloeError for an unknown id.

    Parameters
    ----------
    ids : ndarray
        Ascending, (n,).
    wanted : ndarray
        Ids, (k,).

    Returns
    -------
    ndarray
        (k,).

    Raises
    ------
    FloeError
        For an id that does not exist.
    """
    rows = np.minimum(np.searchsorted(ids, wanted), len(ids) - 1)
    unknown = ids[rows] != wanted
    if unknown.any():
        raise FloeError(f"Element {np.asarray(wanted)[unknown][0]} of a pair does not exist.")
    return rows


def pair_keys(table: Arrays) -> np.ndarray:
    """One number for each pair, in the order of (id_lo, id_hi); ids fit in 32 bits.

    Parameters
    ----------
    table : Arrays
        Pairs by id, (m,) each.

    Returns
    -------
    ndarray
        (m,).
    """
    lo, hi = (np.asarray(table[name], np.int64) for name in ("id_lo", "id_hi"))
    return (lo << 32) | hi


def line_length(table: Arrays) -> np.ndarray:
    """Length of each glue line, m, from its ends in the body frame of the lower id.

    Parameters
    ----------
    table : Arrays
        Bond table of m bonds.

    Returns
    -------
    ndarray
        m, (m,).
    """
    return np.hypot(table["lo_bx"] - table["lo_ax"], table["lo_by"] - table["lo_ay"])


def lines_in_space(table: Arrays, x: np.ndarray, y: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Ends of glue lines as the elements of the lower ids carry them (m), (bond, end, 2).

    Parameters
    ----------
    table : dict of ndarray
        Ends in the body frame of the lower id, ``lo_ax`` to ``lo_by`` (m), (bond,).
    x, y, theta : ndarray
        Place (m) and orientation (rad) of the element of the lower id, (bond,).

    Returns
    -------
    ndarray
        x and y (m), (bond, end, 2).
    """
    cos, sin = np.cos(theta), np.sin(theta)
    ends = []
    for end in "ab":
        bx, by = table[f"lo_{end}x"], table[f"lo_{end}y"]
        ends.append(np.stack([x + cos * bx - sin * by, y + sin * bx + cos * by], axis=1))
    return np.stack(ends, axis=1)


def empty_pairs(columns: tuple[str, ...]) -> Arrays:
    """Table without pairs.

    Parameters
    ----------
    columns : tuple of str
        Names of the columns.

    Returns
    -------
    dict of ndarray
        ids and columns by name, (0,) each.
    """
    table: Arrays = {"id_lo": np.zeros(0, np.int64), "id_hi": np.zeros(0, np.int64)}
    return table | {name: np.zeros(0) for name in columns}


def without(table: Arrays, ids: np.ndarray) -> Arrays:
    """Rows of a table of elements, pairs or wall contacts that name none of these elements.

    Parameters
    ----------
    table : Arrays
        Columns by name.
    ids : ndarray
        Ids of the elements, (k,).

    Returns
    -------
    Arrays
        A new table.
    """
    names = [name for name in ("id", "id_lo", "id_hi") if name in table]
    kept = ~np.any([np.isin(table[name], ids) for name in names], axis=0)
    return {name: values[kept] for name, values in table.items()}
