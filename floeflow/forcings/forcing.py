# SPDX-License-Identifier: GPL-2.0-or-later
"""Forcing of one window on the scene grid, from any CF file, in SI units.

Bilinear in space, the file's own times cut to the window. Vectors are turned into the scene's axes
where they stand in the file, before they are interpolated, so that nothing breaks at the pole. Only
the ocean's values may be missing, on land. See docs/forcing.md.
"""

import logging
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyproj
import xarray as xr
from numpy.typing import NDArray

from floeflow.core import cf_reading as cf
from floeflow.core import fields, interpolate, vectors
from floeflow.core.constants import EARTH_ROTATION
from floeflow.core.errors import FloeError
from floeflow.core.grids import scene_crs, scene_grid, to_lonlat
from floeflow.core.times import say, seconds_since, window_span
from floeflow.forcings import cf_variables as names
from floeflow.forcings.accumulate import Rates, rates
from floeflow.forcings.inputs import SUBSTITUTES, check_axis, check_cover, forcing_items, midnight
from floeflow.forcings.moisture import dew_point_humidity, snow_of_precipitation
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import forcing_variables

Array = NDArray[np.float64]
Index = NDArray[np.int64]

log = logging.getLogger(__name__)

# Ocean values missing on land take the nearest one up to this far (m); beyond it there is none.
OCEAN_REACH = 5.0e5
UNITS = {
    "wind": "m s-1",
    "ocean": "m s-1",
    "coriolis": "s-1",
    "air_temperature": "K",
    "specific_humidity": "kg kg-1",
    "air_pressure": "Pa",
    "shortwave_down": "W m-2",
    "longwave_down": "W m-2",
    "snowfall": "kg m-2 s-1",
    "ocean_heat_flux": "W m-2",
}


@dataclass
class _File:
    """An open forcing file, a scene's places, and the weights between them."""

    path: Path
    scene: Scene
    data: xr.Dataset
    variables: dict[str, cf.Variable]
    crs: pyproj.CRS
    lon: Array
    lat: Array
    span: tuple[float, float]
    cache: dict[tuple[str, str, str], tuple[fields.Source, interpolate.Weights]] = field(
        default_factory=dict
    )

    def grid(self, variable: cf.Variable) -> tuple[fields.Source, interpolate.Weights]:
        """The variable's grid and its weights to the scene grid; refuses a file too small."""
        layout = cf.layout(self.variables, variable, self.path)
        key = (layout.x, layout.y, variable.text("grid_mapping"))
        if key not in self.cache:
            source = fields.source_grid(self.variables, variable, layout, self.data, self.path)
            found = interpolate.weights(source, self.lon, self.lat)
            if not found.inside.all():
                worst = int(np.argmin(found.inside))
                lat, lon = self.lat.ravel()[worst], self.lon.ravel()[worst]
                raise FloeError(
                    f"{self.path}: '{variable.name}' does not cover the scene, such as "
                    f"{_place(lat, lon)}"
                )
            self.cache[key] = source, found
        return self.cache[key]

    def times(self, variable: cf.Variable) -> tuple[Array, Index]:
        """Times (s) that bracket the window, and their indices; none for a steady variable."""
        layout = cf.layout(self.variables, variable, self.path)
        if not layout.time:
            return np.empty(0), np.zeros(1, dtype=np.int64)
        axis = self.variables[layout.time]
        seconds = seconds_since(
            self.data[layout.time].values, axis, self.scene.time.start, self.path
        )
        check_cover(seconds, *self.span, self.scene, self.path, layout.time)
        first = int(np.searchsorted(seconds, self.span[0], side="right")) - 1
        last = int(np.searchsorted(seconds, self.span[1], side="left"))
        index = np.arange(first, last + 1)
        return seconds[index], index

    def sums(self, variable: cf.Variable) -> Rates:
        """How the records of a variable that is summed over time make rates in the window."""
        layout = cf.layout(self.variables, variable, self.path)
        if not layout.time:
            raise FloeError(f"{self.path}: '{variable.name}' is a sum over no time: give its rate")
        axis = self.variables[layout.time]
        seconds = seconds_since(
            self.data[layout.time].values, axis, self.scene.time.start, self.path
        )
        check_axis(seconds, *self.span, self.scene, self.path, layout.time)
        how = self.scene.forcing.accumulation
        return rates(seconds, self.span, how, midnight(self.scene), (self.path, variable.name))

    def values(self, variable: cf.Variable, ocean: bool, index: Index) -> Array:
        """Raw values at these times on the file's grid, nothing missing where it is needed."""
        layout = cf.layout(self.variables, variable, self.path)
        source, found = self.grid(variable)
        values = fields.read_values(self.data, variable.name, layout, source, index, self.path)
        missing = np.isnan(values)
        if ocean and missing.any():
            always = missing.all(axis=0)
            if always.all():
                raise FloeError(f"{self.path}: '{variable.name}' has no value in the window")
            filled = interpolate.fill_nearest(
                np.where(always, np.nan, np.where(missing, 0.0, values)), source, OCEAN_REACH
            )
            values = np.where(missing & ~always, np.nan, filled)
        self._refuse_missing(variable, layout, source, found, values, index)
        return values

    def _refuse_missing(
        self,
        variable: cf.Variable,
        layout: cf.Layout,
        source: fields.Source,
        found: interpolate.Weights,
        values: Array,
        index: Index,
    ) -> None:
        at_scene = found.apply(source.padded(values))
        if np.isfinite(at_scene).all():
            return
        when, where = np.argwhere(~np.isfinite(at_scene))[0]
        time = ""
        if layout.time:
            axis = self.variables[layout.time]
            value = self.data[layout.time].values[index[when]]
            seconds = seconds_since(value, axis, self.scene.time.start, self.path)
            time = f" at {say(self.scene.time.start, float(seconds[0]))}"
        lat, lon = self.lat.ravel()[where], self.lon.ravel()[where]
        raise FloeError(
            f"{self.path}: '{variable.name}' is missing or not finite{time} near {_place(lat, lon)}"
        )


def _place(lat: float, lon: float) -> str:
    east = (lon + 180.0) % 360.0 - 180.0
    return f"{abs(lat):.1f} {'N' if lat >= 0 else 'S'}, {abs(east):.1f} {'E' if east >= 0 else 'W'}"


def _scalar(file: _File, name: str, variable: cf.Variable) -> tuple[Array, Array]:
    """Times and SI values (time, place) of a scalar; refuses values that cannot be."""
    quantity = names.QUANTITIES[name]
    factor, offset, summed = names.scalar_conversion(variable, quantity, file.path)
    source, found = file.grid(variable)
    if summed:
        plan = file.sums(variable)
        seconds, index = plan.seconds, plan.index
    else:
        seconds, index = file.times(variable)
    values = factor * file.values(variable, quantity.ocean, index) + offset
    at_scene = found.apply(source.padded(values))
    if summed:
        at_scene = plan.of(at_scene)
    low, high = float(at_scene.min()), float(at_scene.max())
    # Packing leaves fluxes a shade below zero, and more so differences of sums.
    slack = (3e-4 if summed else 1e-6) * (quantity.high - quantity.low)
    if low < quantity.low - slack or high > quantity.high + slack:
        raise FloeError(
            f"{file.path}: '{variable.name}' reaches from {low:g} to {high:g} {quantity.si}, "
            f"outside {quantity.low:g} to {quantity.high:g}: check its units"
        )
    return seconds, np.clip(at_scene, quantity.low, quantity.high)


def _vector(file: _File, name: str, item: names.FoundVector) -> tuple[Array, Array, Array]:
    """Times and components along the scene's axes (time, place), m/s."""
    pair = names.VECTORS[name]
    parts = []
    for variable in (item.u, item.v):
        factor, _ = names.conversion(variable, names.VECTOR_UNITS, "m s-1", file.path)
        seconds, index = file.times(variable)
        parts.append(factor * file.values(variable, pair.ocean, index))
    source, found = file.grid(item.u)
    if source is not file.grid(item.v)[0] or parts[0].shape != parts[1].shape:
        raise FloeError(
            f"{file.path}: '{item.u.name}' and '{item.v.name}' are not on the same grid and times"
        )
    speed = float(np.nanmax(np.hypot(*parts)))
    if speed > pair.high:
        raise FloeError(
            f"{file.path}: '{item.u.name}' and '{item.v.name}' reach {speed:g} m/s, above "
            f"{pair.high:g}: check their units"
        )
    lon, lat = source.lonlat()
    east, north = parts
    if not item.east_north and source.crs is not None:
        # On longitude and latitude the grid's own axes are east and north.
        angle = vectors.north_angle(source.crs, lon, lat)
        east, north = vectors.map_to_east_north(east, north, angle)
    u, v = vectors.east_north_to_map(east, north, vectors.north_angle(file.crs, lon, lat))
    at_scene = found.apply(source.padded(u)), found.apply(source.padded(v))
    if not (np.isfinite(at_scene[0]).all() and np.isfinite(at_scene[1]).all()):
        raise FloeError(
            f"{file.path}: '{item.u.name}' and '{item.v.name}' cannot be turned to the axes of "
            f"'{file.scene.domain.crs}' everywhere in the scene"
        )
    return seconds, *at_scene


def make_forcing(scene: Scene, path: str | Path, window: int) -> xr.Dataset:
    """Forcing of a window.

    Parameters
    ----------
    scene : Scene
        Its domain, time and effects are read.
    path : str or Path
        A CF file.
    window : int
        From 1.

    Returns
    -------
    xarray.Dataset
        The variables of ``floeflow.scene.effects.forcing_variables`` on (time, y, x), coriolis on
        (y, x); time in seconds since the scene's start, both ends of the window included.

    Raises
    ------
    FloeError
        For what is missing, does not cover scene or window, or cannot be.
    """
    path = Path(path)
    grid, crs = scene_grid(scene.domain), scene_crs(scene.domain)
    lon, lat = to_lonlat(crs, *grid.mesh())
    span = window_span(window, scene.time.window)
    needed = forcing_variables(scene.effects)
    series: dict[str, tuple[Array, Array]] = {}
    variables = cf.describe(path)
    items = forcing_items(variables, scene.effects, path)
    with fields.open_file(path) as data:
        file = _File(path, scene, data, variables, crs, lon, lat, span)
        for name, item in items.items():
            if isinstance(item, names.FoundVector):
                seconds, u, v = _vector(file, name, item)
                series |= {f"{name}_u": (seconds, u), f"{name}_v": (seconds, v)}
            elif len(item) == 2:
                for other, variable in zip(SUBSTITUTES[name], item, strict=True):
                    series[other] = _scalar(file, other, variable)
            else:
                series[name] = _scalar(file, name, item[0])
    own = np.unique(np.concatenate([list(span), *(seconds for seconds, _ in series.values())]))
    time = own[(own >= span[0]) & (own <= span[1])]
    made = {name: interpolate.at_times(*item, time) for name, item in series.items()}
    if "dew_point" in made:
        made["specific_humidity"] = dew_point_humidity(made["dew_point"], made["air_pressure"])
    if "precipitation" in made:
        made["snowfall"] = snow_of_precipitation(made["precipitation"], made["air_temperature"])
    if "ocean_heat_flux" in needed and "ocean_heat_flux" not in made:
        steady = scene.forcing.weather.ocean_heat_flux
        log.info("the file has no ocean heat flux: %g W/m2 of forcing.weather", steady)
        made["ocean_heat_flux"] = np.full((time.size, lon.size), steady)
    if "coriolis" in needed:
        made["coriolis"] = 2.0 * EARTH_ROTATION * np.sin(np.radians(lat))
    data_vars = {}
    for name in needed:
        dims = ("y", "x") if name == "coriolis" else ("time", "y", "x")
        values = np.ascontiguousarray(made[name]).reshape(
            grid.shape if name == "coriolis" else (time.size, *grid.shape)
        )
        units = UNITS[name.removesuffix("_u").removesuffix("_v")]
        data_vars[name] = (dims, values, {"units": units})
    log.info("window %d: %d times, %d variables", window, time.size, len(data_vars))
    coords = {
        "time": ("time", time, {"units": "s", "long_name": "time since the scene's start"}),
        "x": ("x", grid.x, {"units": "m"}),
        "y": ("y", grid.y, {"units": "m"}),
    }
    return xr.Dataset(data_vars, coords=coords, attrs={"crs": scene.domain.crs})
