# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds at the start: neighbours in the tessellation whose discs touch or nearly so.

The glue line of a bond is the edge that the two cells share, clipped to the ice. Coast elements
bond with nothing.
"""

import logging

import numpy as np
import xarray as xr

from floeflow import stage
from floeflow.dynamics.bondtable import new_bonds
from floeflow.dynamics.elements import bearing_thickness
from floeflow.state import read_dataset, write_dataset
from floeflow.state.schema import VARIABLES

log = logging.getLogger(__name__)


def bonded_edges(packing: xr.Dataset, bond_gap: float, minimum: float) -> np.ndarray:
    """Which edges of the tessellation become bonds.

    Parameters
    ----------
    packing : xarray.Dataset
        Output of the packing stage.
    bond_gap : float
        Widest gap between the discs, as a share of the sum of their radii.
    minimum : float
        Least ice concentration of an element that is frozen to its neighbours.

    Returns
    -------
    ndarray of bool
        (edge,): both elements hold ice of at least that concentration, and the gap d - r_i - r_j
        is under ``bond_gap`` (r_i + r_j) or no more than round-off.
    """
    lo, hi = packing["edge_lo"].values - 1, packing["edge_hi"].values - 1
    x, y, radius = (packing[name].values for name in ("x", "y", "radius"))
    fraction = packing["ice_fraction"].values.sum(axis=1)
    reach = radius[lo] + radius[hi]
    gap = np.hypot(x[hi] - x[lo], y[hi] - y[lo]) - reach
    near = gap < np.maximum(bond_gap, 1e-9) * reach
    frozen = (fraction > 0) & (fraction >= minimum)
    return np.asarray(near & frozen[lo] & frozen[hi])


def make_bonds(packing: xr.Dataset, bond_gap: float, minimum: float) -> xr.Dataset:
    """Bond table of a packing.

    Parameters
    ----------
    packing, bond_gap, minimum
        As in `bonded_edges`.

    Returns
    -------
    xarray.Dataset
        The ``bond_`` variables of the state's schema. A bond is as thick as the thinner of its two
        elements' load-bearing ice (volume over effective area).
    """
    edges = np.flatnonzero(bonded_edges(packing, bond_gap, minimum))
    thickness = bearing_thickness(packing)
    lo, hi = packing["edge_lo"].values[edges], packing["edge_hi"].values[edges]
    elements = {name: packing[name].values for name in ("id", "x", "y")}
    elements["theta"] = np.zeros(len(elements["id"]))
    ax, ay, bx, by = (packing[f"edge_{end}"].values[edges] for end in ("ax", "ay", "bx", "by"))
    table = new_bonds(
        elements, lo, hi, ax, ay, bx, by, np.minimum(thickness[lo - 1], thickness[hi - 1])
    )
    names = {name: f"bond_{name}" for name in table}
    assert all(name in VARIABLES for name in names.values())
    log.info("%d bonds on %d shared edges", len(edges), packing.sizes["edge"])
    return xr.Dataset({names[name]: ("bond", values) for name, values in table.items()})


def main(snakemake: stage.Snakemake) -> None:
    """Rule ``bonds``."""
    scene = stage.scene(snakemake)
    packing = read_dataset(snakemake.input.packing)
    bonds = make_bonds(packing, scene.packing.bond_gap, scene.packing.bond_concentration)
    write_dataset(bonds, snakemake.output.bonds)


if "snakemake" in globals():
    stage.run(main, globals()["snakemake"])
