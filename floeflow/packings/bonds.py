# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds at the start: neighbours in the tessellation whose discs touch or nearly so.

The glue line of a bond is the edge that the two cells share, clipped to the ice. Coast elements
bond with nothing, or, for fast ice, with the ice beside them: the tessellation of all elements,
coast included, says along which line.
"""

import logging
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.core.period import Period, period_of, shortest
from floeflow.packings.lines import diagram_around, disc_lines
from floeflow.state.bonds import Arrays, new_bonds
from floeflow.state.elements import joint_thickness
from floeflow.state.schema import COAST, VARIABLES
from floeflow.state.walls import clearance, rings

Array = NDArray[np.float64]
Index = NDArray[np.int64]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Edges:
    """Edges between neighbours, each a line where they may be frozen together.

    Parameters
    ----------
    lo, hi : ndarray
        Rows of the elements, (m,).
    ends : ndarray
        End points ax, ay, bx, by (m), (m, 4).
    """

    lo: Index
    hi: Index
    ends: Array

    def pick(self, chosen: NDArray[np.bool_]) -> "Edges":
        """Those that are chosen, (m,).

        Parameters
        ----------
        chosen : ndarray
            (n,).

        Returns
        -------
        Edges
            In their order.
        """
        return Edges(self.lo[chosen], self.hi[chosen], self.ends[chosen])


def ice_edges(packing: xr.Dataset) -> Edges:
    """Edges that mobile elements share, as the packing has them.

    Parameters
    ----------
    packing : xarray.Dataset
        Elements and edges of the tessellation.

    Returns
    -------
    Edges
        Rows of the two elements, and ends (m), (edges, 4).
    """
    ends = np.column_stack([packing[f"edge_{end}"].values for end in ("ax", "ay", "bx", "by")])
    return Edges(packing["edge_lo"].values - 1, packing["edge_hi"].values - 1, ends)


def coast_edges(packing: xr.Dataset) -> Edges:
    """Edges between mobile and coast elements in the tessellation of both.

    They pass between the discs. Each is cut to the width of its smaller disc, about the line of
    centres: at the end of a coast the tessellation alone would draw it far out to sea. The
    tessellation takes discs of the coast no larger than do not overlap each other, so that each
    has its part of the coast.

    Parameters
    ----------
    packing : xarray.Dataset
        Elements and edges of the tessellation.

    Returns
    -------
    Edges
        Rows of the two elements, and ends (m), (edges, 4).
    """
    radius = packing["radius"].values
    coast = packing["type"].values == COAST
    if not coast.any() or coast.all():
        none = np.empty(0, dtype=np.int64)
        return Edges(none, none, np.empty((0, 4)))
    places = np.stack([packing["x"].values, packing["y"].values], axis=1)
    smaller = radius.copy()
    if coast.sum() > 1:
        beside = cKDTree(places[coast]).query(places[coast], k=2)[0][:, 1]
        smaller[coast] = np.minimum(radius[coast], 0.5 * beside)
    diagram = diagram_around(places, smaller)
    both = coast[diagram.lo] != coast[diagram.hi]
    lo, hi, ends = disc_lines(diagram, places, radius, both)
    return Edges(lo, hi, ends.reshape(-1, 4))


def frozen(packing: xr.Dataset, edges: Edges, bond_gap: float, minimum: float) -> Edges:
    """Edges that become bonds.

    Parameters
    ----------
    packing : xarray.Dataset
        Output of the packing stage.
    edges : Edges
        Where elements meet.
    bond_gap : float
        Widest gap between the discs, as a share of the sum of their radii.
    minimum : float
        Least ice concentration of an element that is frozen to its neighbours.

    Returns
    -------
    Edges
        Those whose mobile elements hold ice of at least that concentration, where the gap
        d - r_i - r_j is under ``bond_gap`` (r_i + r_j) or no more than round-off; at the coast the
        gap between the ice's disc and the coast's line, where that is less. Within a floe of
        a labelled image all elements that share a side are frozen together, and none across.
    """
    x, y, radius = (packing[name].values for name in ("x", "y", "radius"))
    fraction = packing["ice_fraction"].values.sum(axis=1)
    if "concentration" in packing:
        fraction = packing["concentration"].values
    reach = radius[edges.lo] + radius[edges.hi]
    between = x[edges.hi] - x[edges.lo], y[edges.hi] - y[edges.lo]
    gap = np.hypot(*shortest(between, period_of(packing.attrs))) - reach
    gap = np.minimum(gap, _shore_gap(packing, edges))
    near = gap < np.maximum(bond_gap, 1e-9) * reach
    if "floe" in packing:
        floe = packing["floe"].values
        near = (floe[edges.lo] == floe[edges.hi]) | (
            near & ((floe == 0)[edges.lo] | (floe == 0)[edges.hi])
        )
    holds = (fraction > 0) & (fraction >= minimum) | (packing["type"].values == COAST)
    return edges.pick(near & holds[edges.lo] & holds[edges.hi])


def _table(
    elements: Arrays, lo: Index, hi: Index, lines: tuple[Array, Array], period: Period | None
) -> Arrays:
    """Bonds of pairs of rows, lower first, along lines (m, 4) of a thickness (m,).

    A line across a side of a repeated rectangle lies at the place of the lower row: the bond is
    made with a copy of the other that stands there.
    """
    ends, thickness = lines
    copied, count = np.zeros(0, np.int64), len(elements["id"])
    if period is not None:
        x, y = elements["x"], elements["y"]
        between = x[hi] - x[lo], y[hi] - y[lo]
        here = shortest(between, period)
        across = np.flatnonzero((here[0] != between[0]) | (here[1] != between[1]))
        copied, hi = hi[across], hi.copy()
        hi[across] = count + np.arange(len(across))
        places = {axis: elements[axis][lo[across]] + here[k][across] for k, axis in enumerate("xy")}
        elements = {axis: np.append(elements[axis], places[axis]) for axis in "xy"}
    elements = elements | {"id": np.arange(1, count + len(copied) + 1)}
    elements["theta"] = np.zeros(count + len(copied))
    ax, ay, bx, by = ends.T
    table = new_bonds(elements, lo + 1, hi + 1, ax, ay, bx, by, thickness)
    # Copies have the highest ids: the lower one of a pair stays the lower.
    owner = np.append(np.arange(1, count + 1), copied + 1)
    table["id_hi"] = owner[table["id_hi"] - 1]
    order = np.lexsort((table["id_hi"], table["id_lo"]))
    return {name: values[order] for name, values in table.items()}


def _shore_gap(packing: xr.Dataset, edges: Edges) -> Array:
    """Gap (m) between disc and coast line of edges with a coast element, (m,); else infinite."""
    coast = packing["type"].values == COAST
    out = np.full(len(edges.lo), np.inf)
    at_coast = np.flatnonzero(coast[edges.lo] != coast[edges.hi])
    if not len(at_coast):
        return out
    mobile = np.where(coast[edges.lo], edges.hi, edges.lo)[at_coast]
    places = np.stack([packing["x"].values, packing["y"].values], axis=1)[mobile]
    corner = np.column_stack([packing["coast_x"].values, packing["coast_y"].values])
    faces = rings(packing["coast_start"].values, corner)
    out[at_coast] = clearance(faces, *places.T) - packing["radius"].values[mobile]
    return out


def make_bonds(
    packing: xr.Dataset, bond_gap: float, minimum: float, coast: bool = False
) -> xr.Dataset:
    """Bond table of a packing.

    Parameters
    ----------
    packing, bond_gap, minimum
        As in `frozen`.
    coast : bool
        Whether ice beside the coast is frozen to it.

    Returns
    -------
    xarray.Dataset
        The ``bond_`` variables of the state's schema. A bond is as thick as the thinner of its two
        elements' load-bearing ice (volume over effective area), one to the coast as the ice.
    """
    kinds = [ice_edges(packing), coast_edges(packing)] if coast else [ice_edges(packing)]
    bonded = [frozen(packing, edges, bond_gap, minimum) for edges in kinds]
    lo, hi = (np.concatenate([getattr(edges, end) for edges in bonded]) for end in ("lo", "hi"))
    ends = np.concatenate([edges.ends for edges in bonded])
    thickness = joint_thickness(packing)
    elements = {name: packing[name].values for name in ("id", "x", "y")}
    thinner = np.minimum(thickness[lo], thickness[hi])
    table = _table(elements, lo, hi, (ends, thinner), period_of(packing.attrs))
    names = {name: f"bond_{name}" for name in table}
    assert all(name in VARIABLES for name in names.values())
    log.info(
        "%d bonds on %d shared edges, %d of them to the coast",
        *(len(lo), sum(len(edges.lo) for edges in kinds), len(lo) - len(bonded[0].lo)),
    )
    return xr.Dataset({names[name]: ("bond", values) for name, values in table.items()})
