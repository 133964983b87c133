# SPDX-License-Identifier: GPL-2.0-or-later
"""The layered column for Python: state, forcing and one or more steps of all elements.

Thermodynamics of Bitz and Lipscomb (1999) or of mush (Turner et al. 2013), `Physics.mushy` says
which, in one or more thickness categories on a slab ocean. All
amounts are per square metre of the element's effective area, so that a slice of elements is a
problem of its own and gives the same bits as the whole.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray

from floeflow.column.kernel import advance
from floeflow.column.physics import Physics, as_records
from floeflow.column.records import (
    FORCING,
    FORCING_DEFAULTS,
    LEVEL,
    SUMS,
    SUN_HEIGHT,
    Array,
    Column,
    Sea,
)
from floeflow.column.thermodynamics.enthalpy import salinity_profile
from floeflow.column.unsolved import UnsolvedError
from floeflow.core.errors import FloeError

_LEFT_OUT = np.empty(0)


def _left_out() -> Array:
    return _LEFT_OUT


@dataclass(frozen=True)
class LayeredState:
    """Columns of n elements; temperatures in degrees Celsius.

    Parameters
    ----------
    ice_fraction : ndarray
        Share of the area under ice of each category, (n, ncat).
    ice_volume, snow_volume : ndarray
        Per area (m), (n, ncat).
    surface_temperature : ndarray
        Of ice or snow (degC), (n, ncat).
    ice_enthalpy, snow_enthalpy : ndarray
        Of equally thick layers, top first (J/m3), (n, ncat, layers).
    ice_salinity : ndarray
        Of the same layers (1e-3), (n, ncat, layers); Bitz-Lipscomb ice sets it to its profile.
    sea_temperature : ndarray
        Of the mixed layer (degC), (n,).
    pending_freeze : ndarray
        Energy that the mixed layer lacks, of which the next step makes ice (J/m2), (n,).
    level_area, level_volume : ndarray
        Share of each category's ice area and volume that is level; 1 where left out, (n, ncat).
    pond_area : ndarray
        Share of the level area that ponds cover; these and the rest 0 where left out, (n, ncat).
    pond_depth, pond_lid : ndarray
        Of the water of ponds, and of the ice on it (m), (n, ncat).
    lid_snow : ndarray
        Snow on the ice less snow on the lids, while lids gather snow (m), (n, ncat).
    lid_share : ndarray
        Share of the flux into the surface that melted lids in the last step, (n, ncat).
    """

    ice_fraction: Array
    ice_volume: Array
    snow_volume: Array
    surface_temperature: Array
    ice_enthalpy: Array
    snow_enthalpy: Array
    ice_salinity: Array
    sea_temperature: Array
    pending_freeze: Array
    level_area: Array = field(default_factory=_left_out)
    level_volume: Array = field(default_factory=_left_out)
    pond_area: Array = field(default_factory=_left_out)
    pond_depth: Array = field(default_factory=_left_out)
    pond_lid: Array = field(default_factory=_left_out)
    lid_snow: Array = field(default_factory=_left_out)
    lid_share: Array = field(default_factory=_left_out)

    def __post_init__(self) -> None:
        """Fill in what was left out: all ice level, no ponds."""
        for name in LEVEL:
            if getattr(self, name) is _LEFT_OUT:
                there = np.asarray(self.ice_fraction) > 0.0
                level = there if name in ("level_area", "level_volume") else np.zeros_like(there)
                object.__setattr__(self, name, level.astype(np.float64))


def take(state: LayeredState, part: slice | NDArray[np.intp]) -> LayeredState:
    """Columns of some elements: what a rank works on.

    Parameters
    ----------
    state : LayeredState
        Columns of n elements.
    part : slice or ndarray of int
        Rows of the elements.

    Returns
    -------
    LayeredState
        The same arrays, their rows alone.
    """
    return LayeredState(**{f.name: getattr(state, f.name)[part] for f in fields(state)})


def pack_forcing(values: Mapping[str, Array], steps: int, count: int) -> Array:
    """Bring forcing into the order that `step` takes.

    Parameters
    ----------
    values : mapping of str to ndarray
        Every name in ``FORCING`` (units there) but for those in ``FORCING_DEFAULTS``, which may
        be left out, each broadcast to (steps, count).
    steps, count : int
        Steps and elements.

    Returns
    -------
    ndarray
        (steps, count, len(FORCING)).

    Raises
    ------
    FloeError
        For a name that is missing, or a value that is not finite.
    """
    packed = np.empty((steps, count, len(FORCING)))
    for k, name in enumerate(FORCING):
        if name not in values:
            if name not in FORCING_DEFAULTS:
                raise FloeError(f"column forcing: '{name}' is missing")
            packed[:, :, k] = FORCING_DEFAULTS[name]
            continue
        packed[:, :, k] = values[name]
        bad = ~np.isfinite(packed[:, :, k])
        if bad.any():
            step, element = (int(i[0]) for i in np.nonzero(bad))
            raise FloeError(
                f"column forcing: {name} is not finite in step {step} of element {element}"
            )
    return packed


def step(
    state: LayeredState, forcing: Array, dt: float, bounds: Array, p: Physics
) -> tuple[LayeredState, dict[str, Array]]:
    """Advance columns by as many steps as there is forcing for.

    Parameters
    ----------
    state : LayeredState
        Not changed.
    forcing : ndarray
        From `pack_forcing`, (steps, n, len(FORCING)).
    dt : float
        Of each step (s).
    bounds : ndarray
        Of the thickness categories (m), (ncat + 1,), see `categories.category_bounds`.
    p : Physics
        Constants.

    Returns
    -------
    LayeredState
        After the last step.
    dict of str to ndarray
        Budget terms summed over the steps, by the names in ``SUMS`` (units there), each (n,).

    Raises
    ------
    FloeError
        Where shapes do not fit.
    UnsolvedError
        Where temperatures did not come near a solution.
    """
    after = LayeredState(**{f.name: _copy(getattr(state, f.name)) for f in fields(state)})
    count, categories = after.ice_fraction.shape
    if forcing.shape[1:] != (count, len(FORCING)) or bounds.shape != (categories + 1,):
        raise FloeError(
            f"column: forcing {forcing.shape} and bounds {bounds.shape} do not fit {count} "
            f"elements of {categories} categories"
        )
    if p.delta_eddington and not np.isfinite(forcing[:, :, SUN_HEIGHT]).all():
        raise FloeError("column forcing: 'sun_height' is missing, delta-Eddington light needs it")
    level = np.stack([getattr(after, name) for name in LEVEL], axis=2)
    sums = np.zeros((count, len(SUMS)))
    advance(
        Column(
            after.ice_fraction,
            after.ice_volume,
            after.snow_volume,
            after.surface_temperature,
            after.ice_enthalpy,
            after.snow_enthalpy,
            after.ice_salinity,
            level,
        ),
        Sea(after.sea_temperature, after.pending_freeze),
        np.ascontiguousarray(forcing),
        salinity_profile(after.ice_enthalpy.shape[2], p),
        bounds,
        sums,
        float(dt),
        as_records(p),
    )
    after = replace(after, **{name: level[:, :, k].copy() for k, name in enumerate(LEVEL)})
    named = {name: sums[:, k].copy() for k, name in enumerate(SUMS)}
    failed = np.flatnonzero(named["failed"])
    if len(failed):
        raise UnsolvedError(failed, count, p.largest_left)
    return after, named


def _copy(values: Array) -> Array:
    return np.array(values, dtype=np.float64, order="C")


def ice_energy(state: LayeredState) -> Array:
    """Energy of ice and snow against water at 0 degC (J/m2, negative), (n,).

    Parameters
    ----------
    state : LayeredState
        n elements with their categories.

    Returns
    -------
    ndarray
        Sum over categories and layers, J/m2 of the element's area, (n,).
    """
    ice = state.ice_enthalpy.mean(axis=2) * state.ice_volume
    snow = state.snow_enthalpy.mean(axis=2) * state.snow_volume
    return np.asarray((ice + snow).sum(axis=1))


def ice_residual(before: LayeredState, after: LayeredState, sums: dict[str, Array]) -> Array:
    """Change of the energy of ice and snow that the terms do not explain (J/m2), (n,).

    Parameters
    ----------
    before : LayeredState
        Columns at the start and at the end of the steps.
    after : LayeredState
        Columns at the start and at the end of the steps.
    sums : dict of ndarray
        Budget terms of `step`, each (n,).

    Returns
    -------
    ndarray
        (n,); round-off where the budget closes.
    """
    named = sums["air_to_ice"] + sums["ocean_to_ice"]
    named = named + sums["snowfall_energy"] + sums["new_ice_energy"]
    return np.asarray(ice_energy(after) - ice_energy(before) - named)


def sea_residual(
    before: LayeredState,
    after: LayeredState,
    sums: dict[str, Array],
    mixed_depth: Array | float,
    p: Physics,
) -> Array:
    """Change of the mixed layer's heat that the terms do not explain (J/m2), (n,).

    For one step, or for steps with a mixed layer of constant depth (m).

    Parameters
    ----------
    before : LayeredState
        Columns at the start and at the end of the steps.
    after : LayeredState
        Columns at the start and at the end of the steps.
    sums : dict of ndarray
        Budget terms of `step`, each (n,).
    mixed_depth : ndarray or float
        Depth of the mixed layer (m), (n,) or one for all.
    p : Physics
        Constants.

    Returns
    -------
    ndarray
        (n,); round-off where the budget closes.
    """
    warmed = (after.sea_temperature - before.sea_temperature) * mixed_depth
    gain = p.heat_water * p.water_density * warmed
    gain = gain - (after.pending_freeze - before.pending_freeze)
    named = sums["air_to_sea"] + sums["light_to_sea"] + sums["deep_to_sea"]
    return np.asarray(gain - (named - sums["ocean_to_ice"] - sums["new_ice_energy"]))


def water_residual(
    before: LayeredState, after: LayeredState, sums: dict[str, Array]
) -> tuple[Array, Array]:
    """Change of ice and of snow volume that the terms do not explain (m), (n,) each.

    Parameters
    ----------
    before : LayeredState
        Columns at the start and at the end of the steps.
    after : LayeredState
        Columns at the start and at the end of the steps.
    sums : dict of ndarray
        Budget terms of `step`, each (n,).

    Returns
    -------
    tuple of ndarray
        Of ice (m of ice) and of snow (m of snow).
    """
    ice = after.ice_volume.sum(axis=1) - before.ice_volume.sum(axis=1)
    ice = ice - sums["growth"] - sums["snow_ice"] - sums["new_ice"]
    for name in ("melt_top", "melt_bottom", "melt_lateral", "cleared_ice", "sublimation_ice"):
        ice = ice + sums[name]
    snow = after.snow_volume.sum(axis=1) - before.snow_volume.sum(axis=1)
    snow = snow - sums["snowfall"] + sums["melt_snow"] + sums["sublimation_snow"]
    snow = snow + sums["flooded_snow"]
    return np.asarray(ice), np.asarray(snow)


def salt_residual(before: LayeredState, after: LayeredState, sums: dict[str, Array]) -> Array:
    """Change of the salt of mush that the terms do not explain (1e-3 m), (n,).

    Parameters
    ----------
    before : LayeredState
        Columns at the start and at the end of the steps.
    after : LayeredState
        Columns at the start and at the end of the steps.
    sums : dict of ndarray
        Budget terms of `step`, each (n,).

    Returns
    -------
    ndarray
        (n,); salinity times thickness.
    """
    content = [(s.ice_salinity.mean(axis=2) * s.ice_volume).sum(axis=1) for s in (before, after)]
    return np.asarray(content[1] - content[0] - sums["salt_to_ice"])


def pond_residual(before: LayeredState, after: LayeredState, sums: dict[str, Array]) -> Array:
    """Change of the water in ponds that the terms do not explain (m of water), (n,).

    Parameters
    ----------
    before : LayeredState
        Columns at the start and at the end of the steps.
    after : LayeredState
        Columns at the start and at the end of the steps.
    sums : dict of ndarray
        Budget terms of `step`, each (n,).

    Returns
    -------
    ndarray
        (n,); round-off where the budget closes.
    """
    water = []
    for s in (before, after):
        area = s.ice_fraction * s.level_area * s.pond_area
        water.append((area * s.pond_depth).sum(axis=1))
    named = sums["pond_gain"] - sums["pond_frozen"] - sums["pond_drained"] - sums["pond_lost"]
    return np.asarray(water[1] - water[0] - named)
