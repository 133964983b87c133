# SPDX-License-Identifier: GPL-2.0-or-later
"""What froze and melted where in a window: of this gridded tendencies are made.

Columns of a window stand at places: the elements where the dynamics have left them and, with a
mixed layer, the open water in the cells of the grid. Each place has the terms of the ice's volume
as the column counts them. What of them melted into the sea at the window's end, new ice that found
no element or an element of which hardly anything is left, is taken from its place again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.coupling.sea.birth import OpenIce
from floeflow.coupling.sea.ice import Returned
from floeflow.coupling.sea.places import SeaPlaces
from floeflow.scene import Scene
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]

# Dimension of the places in the snapshots of the elements.
DIM = "grown"
COVER = "ice_area_grown"
PLACE = ("grown_x", "grown_y", "grown_area")
# Terms in which melting of new ice and of elements' last ice is counted: it froze in open water,
# or melts from below.
FRESH, OLD = "growth_new_ice", "growth_melt_base"


def wanted(scene: Scene) -> bool:
    """Whether a scene makes gridded tendencies.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    bool
        True with the effects ``grid_output`` and ``thermodynamics``.
    """
    return {"grid_output", "thermodynamics"} <= set(scene.effects)


def growth_places(
    state: xr.Dataset,
    parts: Sequence[Mapping[str, Array]],
    open_water: Sequence[OpenIce],
    places: SeaPlaces | None,
) -> dict[str, Array]:
    """Columns of a window and what they made of ice.

    Parameters
    ----------
    state : xarray.Dataset
        After the dynamics and the columns, before elements come or go.
    parts : sequence of mapping
        Terms of the mobile elements, over their areas (m3, m2), each time that columns were
        advanced.
    open_water : sequence of OpenIce
        Open water, each time.
    places : SeaPlaces or None
        The sea of a scene with a mixed layer.

    Returns
    -------
    dict of ndarray
        ``grown_x``, ``grown_y`` (m), ``grown_area`` (m2), terms ``growth_...`` (m3) and
        ``ice_area_grown`` (m2), (n,) each.
    """
    mobile = state["type"].values == MOBILE
    made = {name: state[name.removeprefix("grown_")].values[mobile] for name in PLACE}
    terms = sorted({name for part in parts for name in part if is_growth(name)})
    count = int(mobile.sum())
    for name in terms:
        made[name] = sum((part[name] for part in parts if name in part), np.zeros(count))
    if places is None or not open_water:
        return made
    cells = np.unique(np.concatenate([each.cells for each in open_water]))
    water = dict(zip(PLACE[:2], (axis[cells] for axis in places.grid.places()), strict=True))
    area = np.zeros(len(cells))
    sums = {name: np.zeros(len(cells)) for name in terms}
    for each in open_water:
        rows = np.searchsorted(cells, each.cells)
        # Of the open water before and after the dynamics, the last counts.
        area[rows] = each.area
        for name in terms:
            if name in each.terms:
                np.add.at(sums[name], rows, each.terms[name])
    water |= {PLACE[2]: area, **sums}
    return {name: np.concatenate([values, water[name]]) for name, values in made.items()}


def is_growth(name: str) -> bool:
    """Whether a term of the columns is one of the ice's volume or area.

    Parameters
    ----------
    name : str
        Of the term.

    Returns
    -------
    bool
        True for the ``growth_`` terms and for the cover.
    """
    return name.startswith("growth_") or name == COVER


def without(made: Mapping[str, Array], back: Returned) -> dict[str, Array]:
    """Terms of the columns less what melted into the sea as a whole, each at its nearest place.

    Parameters
    ----------
    made : mapping
        Places and terms (m3, m2) of the columns, (n,) each.
    back : Returned
        Ice that went back to the sea, with its places.

    Returns
    -------
    dict of ndarray
        By name as in `made`, over the same places, in the same units.
    """
    if not len(back.x):
        return dict(made)
    tree = cKDTree(np.stack([made[name] for name in PLACE[:2]], axis=1))
    nearest = tree.query(np.stack([back.x, back.y], axis=1))[1]
    left = dict(made)
    for name, amount in (
        (FRESH, back.volume * back.fresh),
        (OLD, back.volume * ~back.fresh),
        (COVER, back.cover),
    ):
        lost = np.bincount(nearest, amount, len(made[PLACE[0]]))
        left[name] = np.asarray(made.get(name, 0.0) - lost)
    return left


def as_variables(made: Mapping[str, Array]) -> dict[str, tuple[str, Array]]:
    """The places as variables of a dataset.

    Parameters
    ----------
    made : mapping of ndarray
        Values by element, (n,) each.

    Returns
    -------
    dict of (str, ndarray)
        Dimension and values by name, as `xarray.Dataset` takes them.
    """
    return {name: (DIM, values) for name, values in made.items()}
