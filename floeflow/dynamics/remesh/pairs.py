# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds and contacts of fresh elements, from those of the elements that they are made of.

Each fresh element is a mixture of old ones. A pair of fresh neighbours is bonded as the pairs of
their parts were on average: parts of one old element hold together wholly, parts of a bonded pair
by the share of the glue line that was whole, parts of elements side by side that were not bonded
not at all. Those that held best are bonded, as many as keep the pack's strength.
docs/theory/remesh.md has the rule.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from floeflow.core.constants import EDGE_SHARE
from floeflow.dynamics.ridging.ridging import contact_share
from floeflow.state.bonds import Arrays, element_rows, new_bonds
from floeflow.state.cells import Cells

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Index = NDArray[np.int64]

# Neighbours of which less than this share held together are not bonded in any case; with the coast
# those of which less than half did.
LEAST_BOND, LEAST_COAST_BOND = 0.2, 0.5
# Fresh neighbours of which less than this share was pressed together begin anew in any case.
LEAST_PRESSED = 0.2
# A sum larger by less than this share is the same.
ROUND_OFF = 1.0e-9


@dataclass(frozen=True)
class Ancestry:
    """Of which old elements fresh ones are made.

    Parameters
    ----------
    share : csr_matrix
        Share of each fresh element (column) that comes from each old one (row); columns of
        fresh elements that hold something add up to 1.
    old : dict of ndarray
        id (ascending), x, y, radius (m) and thickness (m, bearing) of the old elements.
    """

    share: sparse.csr_matrix
    old: Arrays


def mean_over_parts(
    table: sparse.csr_matrix, share: sparse.csr_matrix, lo: Index, hi: Index
) -> Array:
    """Mean of a table of old pairs over the parts of fresh pairs, (k,).

    Parameters
    ----------
    table : scipy.sparse.csr_matrix
        Of the old elements, (n, n).
    share : scipy.sparse.csr_matrix
        Share of each fresh element that comes from each old one, (n, fresh).
    lo : Index
        Rows of the k fresh pairs.
    hi : Index
        Rows of the k fresh pairs.

    Returns
    -------
    ndarray
        In the unit of the table.
    """
    if not len(lo):
        return np.zeros(0)
    column = share.tocsc()
    first, second = column[:, lo], column[:, hi]
    return np.asarray(first.multiply(table @ second).sum(axis=0)).ravel()


def _table(count: int, row: Index, column: Index, values: Array) -> sparse.csr_matrix:
    return sparse.csr_matrix((values, (row, column)), shape=(count, count))


def _near(old: Arrays, gap: float) -> tuple[Index, Index]:
    """Old pairs side by side: discs no further apart than a share of their radii's sum."""
    places = np.stack([old["x"], old["y"]], axis=1)
    most = 2.0 * float(old["radius"].max(initial=0.0)) * (1.0 + gap)
    pairs = cKDTree(places).query_pairs(most, output_type="ndarray")
    lo, hi = pairs[:, 0].astype(np.int64), pairs[:, 1].astype(np.int64)
    apart = np.hypot(*(places[hi] - places[lo]).T)
    keep = apart < (1.0 + max(gap, 1e-9)) * (old["radius"][lo] + old["radius"][hi])
    return lo[keep], hi[keep]


def _beside(old: Arrays, gap: float) -> sparse.csr_matrix:
    """Table of old pairs: 1 where they lie side by side, and of each element with itself."""
    count = len(old["id"])
    pairs = _near(old, gap)
    near = _table(count, *pairs, np.ones(len(pairs[0])))
    return sparse.csr_matrix((near + near.T).sign() + sparse.identity(count, format="csr"))


def holding(
    old: Arrays, bonds: Arrays, gap: float
) -> tuple[sparse.csr_matrix, sparse.csr_matrix, sparse.csr_matrix]:
    """Tables of old pairs: how whole, how cracked at the right end, how thick where whole.

    Elements that do not lie side by side hold together as far as those between them do. Within an
    element bonds are as thick as those around it: its ice is thicker than young bonds, but the
    pack is no stronger than these.

    Parameters
    ----------
    old : Arrays
        Table of n old elements.
    bonds : Arrays
        Their bonds.
    gap : float
        Distance (m) up to which elements lie side by side.

    Returns
    -------
    tuple of scipy.sparse.csr_matrix
        Each (n, n); shares of the length, and thickness (m).
    """
    count = len(old["id"])
    lo, hi = (element_rows(old["id"], bonds[f"id_{end}"]) for end in ("lo", "hi"))
    whole = np.clip(1.0 - bonds["crack_a"] - bonds["crack_b"], 0.0, 1.0)
    both = _table(count, np.append(lo, hi), np.append(hi, lo), np.append(whole, whole))
    unit = sparse.identity(count, format="csr")
    step = both + unit
    far = ((step @ step).minimum(1.0) @ step).minimum(1.0)
    beside = _near(old, gap)
    first, second = np.concatenate([lo, beside[0]]), np.concatenate([hi, beside[1]])
    known = _table(count, first, second, np.ones(len(first)))
    known = (known + known.T).sign() + unit
    held = far - far.multiply(known) + step
    # Seen from lo, end a is on the right; seen from hi it is on the left.
    right = _table(
        count,
        np.append(lo, hi),
        np.append(hi, lo),
        np.append(bonds["crack_a"], bonds["crack_b"]),
    )
    around = np.bincount(np.append(lo, hi), np.append(whole, whole), minlength=count)
    bearing = np.bincount(
        np.append(lo, hi),
        np.append(whole * bonds["thickness"], whole * bonds["thickness"]),
        minlength=count,
    )
    mean = np.divide(bearing, around, out=np.array(old["thickness"], float), where=around > 0)
    thick = sparse.diags(mean)
    half = 0.5 * (thick @ (held - both) + (held - both) @ thick)
    bonded = np.append(whole, whole) * np.append(bonds["thickness"], bonds["thickness"])
    thickness = half + _table(count, np.append(lo, hi), np.append(hi, lo), bonded)
    return held.tocsr(), right, thickness.tocsr()


def best(share: Array, amount: Array, total: float, least: float) -> Flags:
    """Those with the largest shares, as many as have this total amount in sum, (k,).

    Parameters
    ----------
    share, amount : ndarray
        By which they are chosen, and of which the total is kept, (k,).
    total : float
        Of the amounts; one that would go beyond it is left out, and all that follow.
    least : float
        Smaller shares are not chosen.

    Returns
    -------
    ndarray
        Of bool, (k,).
    """
    order = np.argsort(-share, kind="stable")
    fits = np.cumsum(amount[order]) <= total * (1.0 + ROUND_OFF)
    out = np.zeros(len(share), dtype=bool)
    out[order] = fits & (share[order] >= least)
    return out


def fresh_bonds(
    ancestry: Ancestry, bonds: Arrays, fresh: Arrays, cells: Cells, gap: float
) -> Arrays:
    """Bond table of fresh elements, free of stress.

    Parameters
    ----------
    ancestry : Ancestry
        Columns in the order of the cells.
    bonds : dict of ndarray
        Bonds of the old elements.
    fresh : dict of ndarray, shape (m,)
        id, x, y, theta, radius, thickness of the fresh elements in the cells' order; thickness 0
        where there is no ice.
    cells : Cells
        Their sides are the glue lines.
    gap : float
        Widest gap between bonded discs, as a share of the sum of their radii.

    Returns
    -------
    dict of ndarray
        As `bondtable.new_bonds`, with cracks.
    """
    lo, hi = cells.lo, cells.hi
    apart = np.hypot(fresh["x"][hi] - fresh["x"][lo], fresh["y"][hi] - fresh["y"][lo])
    reach = fresh["radius"][lo] + fresh["radius"][hi]
    near = (apart < (1.0 + max(gap, 1e-9)) * reach) & (fresh["thickness"][lo] > 0)
    near &= fresh["thickness"][hi] > 0
    lo, hi, ends = lo[near], hi[near], cells.ends[near]
    # Elements that fill their cells in part have lines as much shorter, about their middles.
    part = np.minimum(
        fresh["radius"][lo] / cells.radius[lo], fresh["radius"][hi] / cells.radius[hi]
    )
    middle = ends.mean(axis=1, keepdims=True)
    ends = middle + part[:, None, None] * (ends - middle)
    held, right, thick = holding(ancestry.old, bonds, gap)
    whole = np.minimum(mean_over_parts(held, ancestry.share, lo, hi), 1.0)
    crack_a = mean_over_parts(right, ancestry.share, lo, hi)
    crack_b = mean_over_parts(right.T.tocsr(), ancestry.share, lo, hi)
    # What is not whole and no crack of a bond is taken from both ends alike.
    rest = np.maximum(1.0 - whole - crack_a - crack_b, 0.0)
    thickness = mean_over_parts(thick, ancestry.share, lo, hi) / np.maximum(whole, 1e-300)
    thickness = np.minimum(thickness, np.minimum(fresh["thickness"][lo], fresh["thickness"][hi]))
    # What was whole, in whole length: no more is whole now.
    before = bonds["length"] * (1.0 - bonds["crack_a"] - bonds["crack_b"])
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T) * whole
    keep = best(np.where(thickness > 0, whole, 0.0), length, float(before.sum()), LEAST_BOND)
    strength = float((length * thickness)[keep].sum())
    most = float((before * bonds["thickness"]).sum())
    thickness = thickness * min(1.0, most / strength) if strength > 0 else thickness
    lo, hi, ends = lo[keep], hi[keep], ends[keep]
    # Cells are sorted by id, so the lower row has the lower id, and a is on its right.
    table = new_bonds(
        fresh,
        *(fresh["id"][lo], fresh["id"][hi]),
        *(ends[:, 0, 0], ends[:, 0, 1], ends[:, 1, 0], ends[:, 1, 1]),
        thickness[keep],
    )
    order = np.lexsort((fresh["id"][hi], fresh["id"][lo]))
    table["crack_a"] = (crack_a + 0.5 * rest)[keep][order]
    table["crack_b"] = (crack_b + 0.5 * rest)[keep][order]
    return table


def coast_bonds(
    ancestry: Ancestry, bonds: Arrays, fresh: Arrays, coast: Arrays, gap: float
) -> Arrays:
    """Bonds of fresh elements to the coast, where most of their parts were bonded to it.

    The line lies where both discs have the same power, across the line of centres, as long as
    those of the parts were on average, and no longer than the smaller disc is wide. It reaches no
    further, in radii, than the widest of the old ones: a packing freezes ice to a coast whose line
    is near, however far behind it the coast's discs stand.

    Parameters
    ----------
    ancestry, fresh, gap
        As for `fresh_bonds`.
    bonds : dict of ndarray
        Bonds of old elements to the coast.
    coast : dict of ndarray, shape (c,)
        id (ascending), x, y, theta and radius of the coast elements.

    Returns
    -------
    dict of ndarray
        Bond table, sorted by ids; cracked by the share of the parts' sides that was not bonded.
    """
    ashore = np.isin(bonds["id_lo"], coast["id"])
    land = element_rows(coast["id"], np.where(ashore, bonds["id_lo"], bonds["id_hi"]))
    ice = element_rows(ancestry.old["id"], np.where(ashore, bonds["id_hi"], bonds["id_lo"]))
    whole = np.clip(1.0 - bonds["crack_a"] - bonds["crack_b"], 0.0, 1.0)
    shape = (len(ancestry.old["id"]), len(coast["id"]))

    def over_parts(values: Array) -> sparse.csr_matrix:
        return ancestry.share.T @ sparse.csr_matrix((values, (ice, land)), shape=shape)

    held = sparse.coo_matrix(over_parts(whole))
    most = held.data >= LEAST_COAST_BOND
    one, two, share = held.row[most], held.col[most], np.minimum(held.data[most], 1.0)
    dx, dy = coast["x"][two] - fresh["x"][one], coast["y"][two] - fresh["y"][one]
    span, radii = np.hypot(dx, dy), (fresh["radius"][one], coast["radius"][two])
    old = ancestry.old
    spanned = np.hypot(coast["x"][land] - old["x"][ice], coast["y"][land] - old["y"][ice])
    spanned = spanned / (old["radius"][ice] + coast["radius"][land])
    reach = max(1.0 + max(gap, 1e-9), float(spanned.max(initial=0.0)))
    near = (span <= reach * (radii[0] + radii[1])) & (fresh["thickness"][one] > 0)

    def mean(name: str) -> Array:
        found = over_parts(whole * bonds[name])[one, two]
        return np.asarray(found).ravel() / share

    half = np.minimum(0.5 * mean("length"), np.minimum(*radii)) if len(one) else span
    thickness = np.minimum(mean("thickness"), fresh["thickness"][one]) if len(one) else span
    arm = 0.5 * (span + (radii[0] ** 2 - radii[1] ** 2) / span)
    nx, ny = dx / span, dy / span
    cx, cy = fresh["x"][one] + arm * nx, fresh["y"][one] + arm * ny
    ends = (cx + half * ny, cy - half * nx, cx - half * ny, cy + half * nx)
    both = {name: np.append(fresh[name], coast[name]) for name in ("id", "x", "y", "theta")}
    order = np.argsort(both["id"])
    both = {name: values[order] for name, values in both.items()}
    ids = fresh["id"][one[near]], coast["id"][two[near]]
    ax, ay, bx, by = (end[near] for end in ends)
    table = new_bonds(both, ids[0], ids[1], ax, ay, bx, by, thickness[near])
    sorting = np.lexsort((np.maximum(*ids), np.minimum(*ids)))
    for crack in ("crack_a", "crack_b"):
        table[crack] = (0.5 * (1.0 - share[near]))[sorting]
    return table


def fresh_contacts(
    ancestry: Ancestry, contacts: Arrays, fresh: Arrays, cells: Cells, bonded: Flags, gap: float
) -> Arrays:
    """Contacts of fresh elements whose parts were pressed or had ridged against each other.

    They reach across the gap between the fresh discs and go on from the mean force per contact
    length, closing, thickness and time in touch of their parts; slip is let go. A mean overlap
    would make other forces where thicknesses and sizes differ, above what the ridges hold. No more
    length is in touch than was, and all forces together are no larger.

    Parameters
    ----------
    ancestry, fresh, cells, gap
        As for `fresh_bonds`.
    contacts : dict of ndarray
        Contacts of the old elements, with ridging's columns.
    bonded : ndarray
        Sides (k,) of the cells whose elements are bonded.

    Returns
    -------
    dict of ndarray
        Contact table, sorted by ids, with ridging's columns and, where the old one has it, the time
        in touch (s).
    """
    old, share = ancestry.old, ancestry.share
    count = len(old["id"])
    a, b = (element_rows(old["id"], contacts[f"id_{end}"]) for end in ("lo", "hi"))
    apart = np.hypot(old["x"][b] - old["x"][a], old["y"][b] - old["y"][a])
    elastic = old["radius"][a] + old["radius"][b] - apart - contacts["rest_overlap"]
    length = np.where(contacts["ridge_length"] > 0, contacts["ridge_length"], 1.0)
    push = np.maximum(elastic, 0.0) * contact_share(old, a, b) / length
    pressed = (contacts["ridge_closing"] > 0) | (elastic > 0)
    a, b = a[pressed], b[pressed]
    partners = np.bincount(np.append(a, b), minlength=count)

    def table(values: Array) -> sparse.csr_matrix:
        # Within an element stands the mean of its own contacts.
        values = values[pressed]
        twice = np.append(values, values)
        own = np.bincount(np.append(a, b), weights=twice, minlength=count) / np.maximum(partners, 1)
        pair = _table(count, np.append(a, b), np.append(b, a), twice)
        return sparse.csr_matrix(pair + sparse.diags(own))

    lo, hi = cells.lo, cells.hi
    distance = np.hypot(fresh["x"][hi] - fresh["x"][lo], fresh["y"][hi] - fresh["y"][lo])
    reach = fresh["radius"][lo] + fresh["radius"][hi]
    near = ~bonded & (distance < (1.0 + gap) * reach)
    near &= (fresh["thickness"][lo] > 0) & (fresh["thickness"][hi] > 0)
    lo, hi, overlap = lo[near], hi[near], (reach - distance)[near]
    weight = mean_over_parts(table(np.ones(len(pressed))), share, lo, hi)
    # Parts that do not lie side by side say nothing.
    beside = mean_over_parts(_beside(old, gap), share, lo, hi)
    touching = np.divide(weight, beside, out=np.zeros(len(lo)), where=beside > 0)
    new = 2.0 * EDGE_SHARE * np.minimum(fresh["radius"][lo], fresh["radius"][hi])
    keep = best(touching, new, float(length[pressed].sum()), LEAST_PRESSED)
    lo, hi, overlap, weight = lo[keep], hi[keep], overlap[keep], weight[keep]

    def mean(values: Array) -> Array:
        return mean_over_parts(table(values), share, lo, hi) / weight

    force, most = mean(push) * new[keep], float((push * length)[pressed].sum())
    force *= min(1.0, most / max(float(force.sum()), 1e-300))
    carried = force / contact_share(fresh, lo, hi)
    made: Arrays = {
        "id_lo": fresh["id"][lo],
        "id_hi": fresh["id"][hi],
        "slip": np.zeros(len(lo)),
        "rest_overlap": overlap - carried,
        "ridge_closing": mean(contacts["ridge_closing"]),
        "ridge_thickness": mean(contacts["ridge_thickness"]),
        "ridge_length": new[keep],
    }
    if "touch_time" in contacts:
        made["touch_time"] = mean(contacts["touch_time"])
    order = np.lexsort((made["id_hi"], made["id_lo"]))
    return {name: values[order] for name, values in made.items()}
