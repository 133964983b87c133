# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether a thickness is of the ice where there is any, or ice volume over the area of the cell.

The two differ by the concentration. CF has one standard name for both, so that only cell methods,
the long name or a name in wide use tells them apart; where none does, the scene has to say.
"""

from __future__ import annotations

from pathlib import Path

from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError

IN_ICE, CELL_MEAN = "in_ice", "cell_mean"
# Names of CMIP6, CMEMS and NEMO (SI3) that mean one of the two.
NAMES = {
    "sithick": IN_ICE,
    "sithic": IN_ICE,
    "iicethic": IN_ICE,
    "sivol": CELL_MEAN,
    "sivolu": CELL_MEAN,
    "sivolume": CELL_MEAN,
    "hiff": CELL_MEAN,
}
STANDARD_NAMES = {
    "floating_ice_thickness": IN_ICE,
    "sea_ice_volume": CELL_MEAN,
}
# What long names say, in lower case; the first that is found counts.
WORDS = (
    ("in cell", CELL_MEAN),
    ("grid cell mean", CELL_MEAN),
    ("grid-cell mean", CELL_MEAN),
    ("cell average", CELL_MEAN),
    ("cell mean", CELL_MEAN),
    ("effective thickness", CELL_MEAN),
    ("effective sea ice thickness", CELL_MEAN),
    ("effective ice thickness", CELL_MEAN),
    ("volume per", CELL_MEAN),
    ("per unit area", CELL_MEAN),
    ("per grid cell area", CELL_MEAN),
    ("ice volume", CELL_MEAN),
    ("over ice", IN_ICE),
    ("in ice", IN_ICE),
    ("ice-covered", IN_ICE),
    ("ice covered", IN_ICE),
    ("floe thickness", IN_ICE),
    ("actual", IN_ICE),
)


def told(variable: cf.Variable) -> str:
    """``in_ice``, ``cell_mean``, or empty where the variable does not say.

    Parameters
    ----------
    variable : cf.Variable
        Thickness of a file.

    Returns
    -------
    str
        One of these three.
    """
    methods = " ".join(variable.text("cell_methods").lower().split())
    if "where sea_ice" in methods or "where ice" in methods:
        return IN_ICE
    if "area: mean where sea" in methods:
        return CELL_MEAN
    long_name = variable.text("long_name").lower()
    said = next((kind for word, kind in WORDS if word in long_name), "")
    return said or STANDARD_NAMES.get(variable.text("standard_name"), "") or NAMES.get(
        variable.name.lower(), ""
    )  # fmt: skip


def thickness_kind(asked: str, variable: cf.Variable, path: str | Path) -> str:
    """What a thickness is.

    Parameters
    ----------
    asked : str
        ``mask.thickness_is``; empty: as the variable tells.
    variable : Variable
        The thickness.
    path : str or Path
        Its file, for the sentence.

    Returns
    -------
    str
        ``in_ice`` or ``cell_mean``.

    Raises
    ------
    FloeError
        Where neither says.
    """
    kind = asked or told(variable)
    if kind:
        return kind
    raise FloeError(
        f"{path}: variable '{variable.name}' does not tell whether it is the thickness of the ice "
        "where there is any (in_ice), or ice volume over the cell's area (cell_mean): say which in "
        "mask.thickness_is"
    )
