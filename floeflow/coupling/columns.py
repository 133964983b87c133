# SPDX-License-Identifier: GPL-2.0-or-later
"""The column's share of a window: every rank takes a slice of the elements.

A column knows nothing of its neighbours, so slices give the same bits on any number of ranks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from mpi4py import MPI

from floeflow.column.forcing import sample_series
from floeflow.column.schemes import advance_columns as advance_slice
from floeflow.column.settings import column_settings
from floeflow.column.unsolved import UnsolvedError
from floeflow.core.collective import on_all
from floeflow.core.grids import scene_crs, to_lonlat
from floeflow.core.sun import day_of_year, sun_height
from floeflow.coupling.sea.birth import OpenIce, icy, melt_back, settle_ice
from floeflow.coupling.sea.columns import float_columns, give_back
from floeflow.coupling.sea.ice import Returned, add_terms
from floeflow.coupling.sea.places import SeaPlaces
from floeflow.coupling.sea.shares import build_shares
from floeflow.coupling.sea.water import Water, read_water, relax_heat, relax_salt, with_water
from floeflow.scene import Scene
from floeflow.scene.effects import SEA_VARIABLES, column_forcing_variables, column_variables
from floeflow.state.elements import Arrays
from floeflow.state.schema import MOBILE

SEA_SURFACE_TEMPERATURE = "sea_surface_temperature"

Budget = dict[str, float]


@dataclass(frozen=True)
class Columns:
    """Columns to advance: of the mobile elements and, on a mixed layer, of open water.

    Parameters
    ----------
    values : dict of ndarray
        By the names of the state's schema, (n, ...).
    x, y, u, v, area : ndarray
        Places (m), velocities (m/s) and effective areas (m2), (n,).
    closed : ndarray or None
        Share of the areas that ridging has just closed, with redistribution.
    salinity : ndarray or None
        Of the mixed layer below (1e-3).
    """

    values: Arrays
    x: np.ndarray
    y: np.ndarray
    u: np.ndarray
    v: np.ndarray
    area: np.ndarray
    closed: np.ndarray | None = None
    salinity: np.ndarray | None = None

    def some(self, rows: np.ndarray) -> Columns:
        """Some of them.

        Parameters
        ----------
        rows : ndarray
            Of the elements, (m,).

        Returns
        -------
        Columns
            In the order of the rows.
        """
        values = {name: value[rows] for name, value in self.values.items()}
        places = self.x[rows], self.y[rows], self.u[rows], self.v[rows], self.area[rows]
        closed = None if self.closed is None else self.closed[rows]
        return Columns(
            values, *places, closed, None if self.salinity is None else self.salinity[rows]
        )


def forcing_sampler(
    scene: Scene, columns: Columns, forcing: xr.Dataset
) -> Callable[[float], dict[str, np.ndarray]]:
    """Forcing of some columns as a function of time.

    With a mixed layer and ocean drag the ice's drift against the current gives the friction
    velocity under it, sqrt(C_w) |u_w - u|, with the velocity at the window's end.

    Parameters
    ----------
    scene : Scene
        Effects and forcing.
    columns : dict of ndarray
        Of n elements.
    forcing : xarray.Dataset
        Of the window, as `floeflow.forcings.window` makes it.

    Returns
    -------
    callable
        ``sample(t)``: values at the elements at a time (s since the scene's start) by the names of
        the forcing, SI units, (n,).
    """
    names = tuple(
        name for name in column_forcing_variables(scene.effects) if name != SEA_SURFACE_TEMPERATURE
    )
    rubs = "mixed_layer" in scene.effects and "ocean_drag" in scene.effects
    names = (*names, "ocean_u", "ocean_v") if rubs else names
    u, v, x, y = columns.u, columns.v, columns.x, columns.y
    over = np.sqrt(columns.area / np.pi) if scene.forcing.at == "cell" else None
    stress = scene.forcing.wind_mean == "stress"
    series = sample_series(forcing, names, x, y, radius=over, wind_stress=stress)
    lit = column_settings(scene).needs_sun
    lon, lat = to_lonlat(scene_crs(scene.domain), x, y) if lit else (x, y)

    def sample(t: float) -> dict[str, np.ndarray]:
        values = series(t)
        if rubs:
            slip = np.hypot(values.pop("ocean_u") - u, values.pop("ocean_v") - v)
            values["friction_velocity"] = np.sqrt(scene.dynamics.ocean_drag) * slip
        if lit:
            values["sun_height"] = sun_height(day_of_year(scene.time.start, t), lat, lon)
        if columns.salinity is not None:
            values["sea_salinity"] = columns.salinity
        return values

    return sample


def mobile_columns(scene: Scene, state: xr.Dataset, first_area: np.ndarray) -> Columns:
    """Columns of the mobile elements, without their sea.

    Parameters
    ----------
    scene : Scene
        Effects and scheme.
    state : xarray.Dataset
        At the window's end, after ridging.
    first_area : ndarray
        Area of all elements before the motion (m2), (elements,).

    Returns
    -------
    dict of ndarray
        Of the mobile elements, (n,).
    """
    rows = np.flatnonzero(state["type"].values == MOBILE)
    scheme = column_settings(scene).scheme
    names = [n for n in column_variables(scene.effects, scheme) if n not in SEA_VARIABLES]
    closed = None
    if "redistribution" in scene.effects:
        closed = 1.0 - state["area"].values[rows] / first_area[rows]
    x, y, u, v, area = (state[name].values[rows] for name in ("x", "y", "u", "v", "area"))
    values = {name: state[name].values[rows] for name in names}
    return Columns(values, x, y, u, v, area, closed)


def advance_all(
    comm: MPI.Comm,
    scene: Scene,
    columns: Columns,
    forcing: xr.Dataset,
    window: tuple[float, float],
) -> tuple[Arrays, Arrays]:
    """Advance columns over a window, a slice on each rank; all, and their terms, on each.

    Parameters
    ----------
    comm : MPI.Comm
        Ranks that share the columns.
    scene : Scene
        Settings of the columns.
    columns : dict of ndarray
        Of all n mobile elements, the same on each rank.
    forcing : xarray.Dataset
        Of the window.
    window : tuple of float
        Start and end (s).

    Returns
    -------
    tuple of Arrays
        Columns at the end, and the terms of the budgets, (n,) and more, of all elements.

    Raises
    ------
    FloeError
        For settings or forcing that the scheme refuses, on each rank.
    UnsolvedError
        Where no temperatures balance the fluxes; names the place.
    """
    settings = column_settings(scene)
    part = columns.some(np.array_split(np.arange(len(columns.x)), comm.size)[comm.rank])

    def advance() -> tuple[Arrays, Arrays]:
        sample = forcing_sampler(scene, part, forcing)
        try:
            return advance_slice(part.values, sample, window, settings, part.closed)
        except UnsolvedError as error:
            first = int(error.rows[0])
            raise error.at(f"the one at ({part.x[first]:.6g}, {part.y[first]:.6g}) m") from None

    after, terms = on_all(comm, advance)
    # Put together whole, so that sums are the same on any number of ranks.
    return tuple(
        {name: np.concatenate(comm.allgather(value)) for name, value in each.items()}
        for each in (after, terms)
    )  # type: ignore[return-value]


def advance_columns(
    comm: MPI.Comm,
    scene: Scene,
    state: xr.Dataset,
    forcing: xr.Dataset,
    window: tuple[float, float],
    first_area: np.ndarray,
    places: SeaPlaces | None = None,
) -> tuple[xr.Dataset, Arrays, Budget, OpenIce | None]:
    """Advance the columns of all mobile elements over a window, and the sea that they float on.

    Parameters
    ----------
    comm : MPI.Comm
        Collective; every rank has the whole state and gets the whole result.
    scene : Scene
        The scene.
    state : xarray.Dataset
        State after the dynamics of the window.
    forcing : xarray.Dataset
        The window's forcing on the scene's grid.
    window : tuple of float
        Start and end of the window, s since the scene's start.
    first_area : ndarray
        Areas of the elements before the window's ridging (m2), (n,).
    places : SeaPlaces, optional
        The sea, with a mixed layer.

    Returns
    -------
    tuple of xarray.Dataset, two dicts, and OpenIce or None
        State with new columns; terms of the budgets of each mobile element, over its area:
        ``growth_<term>`` (m3 of ice), ``snow_<term>`` (m3 of snow), ``energy_<term>`` (J),
        ``water_<term>`` and ``salt_<term>`` (kg), (n,), which `totals` adds up; sums of the same
        terms over open water, of the sea ``sea_heat_<term>`` (J) and ``sea_salt_<term>`` (kg), and
        how often temperatures were solved for, ``temperature_<how>``;
        and the ice that formed in open water, which has to be settled.
    """
    columns = mobile_columns(scene, state, first_area)
    count = len(columns.x)
    if places is None or "mixed_layer" not in scene.effects:
        after, terms = advance_all(comm, scene, columns, forcing, window)
        counts = take_counts(terms)
        each = {name: columns.area * values for name, values in terms.items()}
        return _with_columns(state, after), each, counts, None
    settings = column_settings(scene)
    water = read_water(state, places.area, settings)
    grid = places.grid
    shares = build_shares(columns.x, columns.y, columns.area, grid, places.area, places.pull)
    afloat = float_columns(
        water, shares, columns.values, (columns.x, columns.y, columns.area), grid.places()
    )
    still = np.zeros(len(afloat.cells))
    closed = None if columns.closed is None else np.concatenate([columns.closed, still])
    u, v = (np.concatenate([each, still]) for each in (columns.u, columns.v))
    every = Columns(afloat.columns, afloat.x, afloat.y, u, v, afloat.area, closed, afloat.salinity)
    after, terms = advance_all(comm, scene, every, forcing, window)
    counts = take_counts(terms)
    every_term = {name: afloat.area * values for name, values in terms.items()}
    each = {name: values[:count] for name, values in every_term.items()}
    open_terms = {name: values[count:] for name, values in every_term.items()}
    of_open = totals(open_terms)
    water, sea_terms = give_back(water, shares, afloat, after, terms)
    water, drawn = _relaxed(scene, water, forcing, window)
    own = {name: values[:count] for name, values in after.items() if name not in SEA_VARIABLES}
    ice = {name: values[count:] for name, values in after.items() if name not in SEA_VARIABLES}
    found = OpenIce(afloat.cells, afloat.area[count:], ice, shares, open_terms)
    state = with_water(_with_columns(state, own), water)
    return state, each, {**of_open, **add_terms(sea_terms, drawn), **counts}, found


def _relaxed(
    scene: Scene, water: Water, forcing: xr.Dataset, window: tuple[float, float]
) -> tuple[Water, Budget]:
    """The sea after relaxation to a temperature, and to the salinity of the water below."""
    seconds, terms = window[1] - window[0], {}
    if "sea_relaxation" in scene.effects:
        moments = forcing["time"].values
        field = forcing[SEA_SURFACE_TEMPERATURE].values.reshape(len(moments), -1)
        middle = 0.5 * (window[0] + window[1])
        target = np.array([np.interp(middle, moments, field[:, k]) for k in range(field.shape[1])])
        water, gained = relax_heat(water, target, seconds, scene.sea.relaxation_time)
        terms["sea_heat_relaxation"] = gained
    if scene.sea.salinity_time > 0.0:
        water, came = relax_salt(water, seconds, scene.sea.salinity_time)
        terms["sea_salt_deep"] = came
    return water, terms


def _with_columns(state: xr.Dataset, columns: Arrays) -> xr.Dataset:
    """State whose mobile elements have these columns."""
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    found = {}
    for name, values in columns.items():
        whole = state[name].values.copy()
        whole[mobile] = values
        found[name] = (state[name].dims, whole)
    return state.assign(found)


def take_counts(terms: Arrays) -> Budget:
    """Take the counts out of the columns' terms, which else are per area; their sums.

    Parameters
    ----------
    terms : Arrays
        Terms of the columns, (n,) each; the counts are taken out.

    Returns
    -------
    dict of float
        Sums over all elements by the count's name; `terms` has them no more.
    """
    names = [name for name in terms if name.startswith("temperature_")]
    return {name: float(terms.pop(name).sum()) for name in names}


def totals(each: Arrays) -> Budget:
    """Terms of the budgets over all elements.

    Added up on the whole arrays, so that the sums are the same on any number of ranks.

    Parameters
    ----------
    each : Arrays
        Terms, (n,) each.

    Returns
    -------
    dict of float
        Sums by the same names, in the unit of the terms.
    """
    return {name: float(values.sum()) for name, values in each.items()}


def settle_open_ice(
    scene: Scene, state: xr.Dataset, found: OpenIce, places: SeaPlaces, last: bool
) -> tuple[xr.Dataset, Budget, Returned]:
    """What becomes of ice that formed in open water; see `floeflow.coupling.sea.birth`.

    Parameters
    ----------
    scene : Scene
        The scene.
    state : xarray.Dataset
        After the columns.
    found : OpenIce
        From `advance_columns`.
    places : SeaPlaces
        The sea.
    last : bool
        At the window's end; before the dynamics no element may come or go, and all melts back.

    Returns
    -------
    tuple of xarray.Dataset, dict and Returned
        State, terms of the budgets, and what melted back, by places.
    """
    water = read_water(state, places.area, column_settings(scene))
    if last:
        state, water, terms, back = settle_ice(
            state, water, found, places, "ridging" in scene.effects
        )
    else:
        water, terms, back = melt_back(water, icy(found), places)
    return with_water(state, water), terms, back
