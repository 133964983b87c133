# SPDX-License-Identifier: GPL-2.0-or-later
"""What the elements carry beside area and volume, as amounts on the grid, and what follows of them.

Only what a state holds comes out: no surface temperature without thermodynamics, no ridges without
an area of level ice, no thickness distribution of a single category, no age and no stress without
their effects.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.constants import ICE_DENSITY
from floeflow.diagnostics.ice_edge import PACK
from floeflow.state.snapshots import BONDED
from floeflow.transfer import Field

Array = NDArray[np.float64]

# Outline of a regular hexagon over the root of its area.
HEXAGON = float(np.sqrt(8.0 * np.sqrt(3.0)))

# Names on the grid of what the effect internal_stress keeps of the elements.
FORCES = ("siforceintstrx", "siforceintstry")
INTERNAL = (
    *zip(FORCES, ("internal_force_x", "internal_force_y"), strict=True),
    *((name, name) for name in ("stress_xx", "stress_yy", "stress_xy")),
)


def ice_amounts(mobile: xr.Dataset) -> tuple[list[Field], dict[str, Array]]:
    """Amounts that sit on the ice's area, and the properties of it, of each element.

    Parameters
    ----------
    mobile : xarray.Dataset
        Mobile elements of a state.

    Returns
    -------
    tuple of list and dict
        How each goes to a grid, and its values, (element,).
    """
    area = mobile["area"].values[:, None]
    share = mobile["ice_fraction"].values
    volume = np.where(share > 0.0, mobile["ice_volume"].values, 0.0)
    amounts: dict[str, Array] = {}
    if share.shape[1] > 1:
        for k in range(share.shape[1]):
            amounts[f"area_{k}"] = (area * share)[:, k]
            amounts[f"volume_{k}"] = (area * volume)[:, k]
    if "level_area" in mobile:
        level, thick = mobile["level_area"].values, mobile["level_volume"].values
        amounts["ridged_area"] = (area * share * (1.0 - level)).sum(axis=1)
        amounts["ridged_volume"] = (area * volume * (1.0 - thick)).sum(axis=1)
        if "pond_area" in mobile:
            ponds = area * share * level * mobile["pond_area"].values
            amounts["pond_area"] = ponds.sum(axis=1)
    if BONDED in mobile:
        # The outline of a regular hexagon; elements differ from it, their means hardly.
        amounts["outline"] = HEXAGON * np.sqrt(area[:, 0]) * (share.sum(axis=1) > 0)
        amounts["bonded"] = mobile[BONDED].values * (share.sum(axis=1) > 0)
    fields = [Field(name, "extensive", "ice_area") for name in amounts]
    means = _means_over_ice(mobile)
    fields += [Field(name, "intensive", "ice_area") for name in means]
    amounts |= means
    return fields, {name: np.asarray(values) for name, values in amounts.items()}


def _means_over_ice(mobile: xr.Dataset) -> dict[str, Array]:
    """Properties that are averaged over the ice's area, of each element."""
    share = mobile["ice_fraction"].values
    total = share.sum(axis=1)
    sums: dict[str, Array] = {}
    if "surface_temperature" in mobile:
        sums["sitemptop"] = (share * mobile["surface_temperature"].values).sum(axis=1)
    if "ice_age" in mobile:
        sums["siage"] = total * mobile["ice_age"].values
    # Of the whole effective area, borne by the ice in it.
    sums |= {name: mobile[variable].values for name, variable in INTERNAL if variable in mobile}
    means = {}
    for name, values in sums.items():
        # Elements without ice have no weight; a number there must only be finite.
        some = float(values[total > 0].sum() / total.sum()) if total.any() else 0.0
        means[name] = np.divide(values, total, out=np.full_like(total, some), where=total > 0)
    return means


def follow(
    found: Mapping[str, Array], sea: Array, per_ice: Array, fields: dict[str, Array]
) -> None:
    """Add to the gridded fields what follows from the amounts on the grid.

    Parameters
    ----------
    found : mapping
        Amounts on the grid, (ny, nx), as `ice_amounts` names them.
    sea, per_ice : ndarray
        Area of sea in each cell, and of ice (NaN where there is none) (m2), (ny, nx).
    fields : dict
        siconc, sivol and velocities are read; what follows is added.
    """
    fields["simass"] = ICE_DENSITY * fields["sivol"]
    fields["lead_fraction"] = np.where(fields["siconc"] >= PACK, 1.0 - fields["siconc"], np.nan)
    bands = [name.removeprefix("area_") for name in found if name.startswith("area_")]
    if bands:
        areas, volumes = (
            np.stack([found[f"{what}_{k}"] for k in bands]) for what in ("area", "volume")
        )
        fields["siitdconc"] = np.where(np.isfinite(fields["siconc"]), areas / sea, np.nan)
        # Round-off of an empty category has no thickness.
        there = areas > 1e-9 * sea
        fields["siitdthick"] = np.divide(
            volumes, areas, out=np.full(areas.shape, np.nan), where=there
        )
    if "ridged_area" in found:
        ridged = np.clip(found["ridged_area"] / per_ice, 0.0, 1.0)
        fields["sirdgconc"] = ridged
        there = np.nan_to_num(ridged) > 1e-6
        fields["sirdgthick"] = np.divide(
            found["ridged_volume"],
            found["ridged_area"],
            out=np.full(sea.shape, np.nan),
            where=there,
        )
    if "outline" in found:
        there = np.isfinite(per_ice) & (found["outline"] > 0.0)
        held = np.divide(
            found["bonded"], found["outline"], out=np.full(sea.shape, np.nan), where=there
        )
        fields["damage"] = np.clip(1.0 - held, 0.0, 1.0)
    if "pond_area" in found:
        fields["simpconc"] = np.clip(found["pond_area"] / per_ice, 0.0, 1.0)
    for name in ("sitemptop", "siage", *FORCES):
        if name in found:
            fields[name] = np.where(np.isfinite(per_ice), found[name], np.nan)
    if "stress_xx" in found:
        xx, yy, xy = (
            np.where(np.isfinite(per_ice), found[f"stress_{pair}"], np.nan)
            for pair in ("xx", "yy", "xy")
        )
        fields["sistresave"] = 0.5 * (xx + yy)
        fields["sistremax"] = np.hypot(0.5 * (xx - yy), xy)


def strain_rates(u: Array, v: Array, spacing: tuple[float, float]) -> tuple[Array, Array]:
    """Divergence and largest shear of a velocity field on a grid.

    Central differences, one-sided where a neighbour has no ice, NaN where both have none.

    Parameters
    ----------
    u, v : ndarray
        Velocities (m/s), NaN where there is no ice, (ny, nx).
    spacing : tuple of float
        Of the columns and of the rows (m).

    Returns
    -------
    tuple of ndarray
        Divergence and shear (1/s), each (ny, nx); Leppäranta 2011, section 5.1.
    """
    dx, dy = spacing
    ux, uy = slope(u, 1) / dx, slope(u, 0) / dy
    vx, vy = slope(v, 1) / dx, slope(v, 0) / dy
    return ux + vy, np.hypot(ux - vy, uy + vx)


def slope(values: Array, axis: int) -> Array:
    """Change from cell to cell along an axis, by central differences as far as there are values.

    Parameters
    ----------
    values : ndarray
        On a grid; NaN where unknown.
    axis : int
        Number of the axis.

    Returns
    -------
    ndarray
        Per cell; one-sided beside NaN, NaN without any neighbour.
    """
    moved = np.moveaxis(values, axis, -1)
    wide = np.full((*moved.shape[:-1], moved.shape[-1] + 2), np.nan)
    wide[..., 1:-1] = moved
    before, after = wide[..., 1:-1] - wide[..., :-2], wide[..., 2:] - wide[..., 1:-1]
    one = np.where(np.isfinite(before), before, after)
    both = np.isfinite(before) & np.isfinite(after)
    return np.moveaxis(np.where(both, 0.5 * (before + after), one), -1, axis)
