# SPDX-License-Identifier: GPL-2.0-or-later
"""Map of the bonds: which hold, which are partly cracked, which broke in the run."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from floeflow.report.figures.frame import Frame, prepare_axes
from floeflow.report.figures.maps import WIDTH, Shapes, say_no_ice, shape_collections
from floeflow.report.figures.style import BLUE, COAST, SKY, VERMILION, look, new_figure
from floeflow.state.bonds import lines_in_space
from floeflow.state.elements import pair_arrays
from floeflow.state.schema import MOBILE


def glue_lines(bonds: xr.Dataset, state: xr.Dataset) -> np.ndarray:
    """End points (km) of glue lines, carried by their lower element, (bond, 2, 2).

    Parameters
    ----------
    bonds : xarray.Dataset
        With ``bond_id_lo`` and the ends in the body frame of that element.
    state : xarray.Dataset
        Where the elements are now; a bond whose element is gone is left out.

    Returns
    -------
    ndarray
        km, (bond, 2, 2); bonds whose element is gone are left out.
    """
    ids, lo = state["id"].values, bonds["bond_id_lo"].values
    place = np.searchsorted(ids, lo)
    there = place < ids.size
    there[there] = ids[place[there]] == lo[there]
    x, y, theta = (state[name].values[place[there]] for name in ("x", "y", "theta"))
    table = {name: values[there] for name, values in pair_arrays(bonds, "bond").items()}
    return lines_in_space(table, x, y, theta) / 1e3


def follows_start(last: xr.Dataset) -> bool:
    """Whether bonds of the start can be found in a last state: a remap makes all elements anew.

    Parameters
    ----------
    last : xarray.Dataset
        Last state or snapshot.

    Returns
    -------
    bool
        False with the effect ``remap``.
    """
    return "remap" not in str(last.attrs["effects"]).split()


def bond_map(
    frame: Frame, first: xr.Dataset, last: xr.Dataset, shapes: Shapes, title: str
) -> Figure:
    """Map the bonds of the first state as they are in the last: whole, cracked, broken.

    Parameters
    ----------
    frame : Frame
        Land, projection, extent.
    first, last : xarray.Dataset
        First and last state.
    shapes : Shapes
        Outlines of the last state's elements.
    title : str
        Title.

    Returns
    -------
    Figure
        Of Matplotlib, to be closed by the caller.
    """
    whole, cracked, broken = sort_bonds(first, last)
    with look():
        figure = new_figure(*frame.size(1.4 * WIDTH))
        axes = figure.add_subplot()
        prepare_axes(axes, frame, title)
        for collection, index in shape_collections(axes, last, shapes):
            ice = last["type"].values[index] == MOBILE
            faces = np.where(ice, "#ffffff", COAST)
            collection.set_facecolor([str(face) for face in faces])
            axes.add_collection(collection, autolim=False)
        styles = ((whole, SKY, 0.5), (cracked, BLUE, 1.2), (broken, VERMILION, 1.9))
        names = ("whole", "partly cracked", *(("broken",) if follows_start(last) else ()))
        for (bonds, colour, width), name in zip(styles, names, strict=False):
            lines = LineCollection(
                list(glue_lines(bonds, last)), colors=colour, linewidths=width, zorder=4
            )
            axes.add_collection(lines, autolim=False)
            label = f"{name}: {bonds.sizes['bond']:,}"
            axes.plot([], [], color=colour, linewidth=width, label=label)
        figure.legend(loc="outside lower center", ncols=3, fontsize=8.5)
        if not (last["type"].values == MOBILE).any():
            say_no_ice(axes)
    return figure


def sort_bonds(first: xr.Dataset, last: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset, xr.Dataset]:
    """Bonds of the first state by what became of them: whole, partly cracked, broken.

    Those of which both elements are still there. Where elements were remapped, the bonds of the
    last state, of which none is broken.

    Parameters
    ----------
    first : xarray.Dataset
        States at the start and at the end.
    last : xarray.Dataset
        States at the start and at the end.

    Returns
    -------
    tuple of xarray.Dataset
        States with those bonds alone.
    """
    if follows_start(last):
        ends = [np.isin(first[f"bond_id_{end}"], last["id"]) for end in ("lo", "hi")]
        first = first.isel(bond=np.flatnonzero(ends[0] & ends[1]))
    else:
        first = last
    then = _pair_keys(first)
    crack = {
        key: float(a + b)
        for key, a, b in zip(
            _pair_keys(last),
            last["bond_crack_a"].values,
            last["bond_crack_b"].values,
            strict=True,
        )
    }
    now = np.array([crack.get(key, 1.0) for key in then])
    parts = (now == 0, (now > 0) & (now < 1), now >= 1)
    whole, cracked, broken = (first.isel(bond=np.flatnonzero(part)) for part in parts)
    return whole, cracked, broken


def _pair_keys(state: xr.Dataset) -> list[tuple[int, int]]:
    lo, hi = state["bond_id_lo"].values.tolist(), state["bond_id_hi"].values.tolist()
    return list(zip(lo, hi, strict=True))
