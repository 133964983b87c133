# SPDX-License-Identifier: GPL-2.0-or-later
"""Forcing of one window on the scene grid, from any CF files, in SI units.

Bilinear in space, or area means where a file is much the finer; the files' own times cut to the
window. Each component of a vector is turned into the scene's axes where it stands in the file,
before it is interpolated, so that nothing breaks at the pole and staggered grids need no care. Only
the ocean's values may be missing, on land. See docs/forcing.md.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyproj
import xarray as xr
from numpy.typing import NDArray

from floeflow.core import area_means as areas
from floeflow.core import interpolate, vectors
from floeflow.core.errors import FloeError
from floeflow.core.fields import AnySource
from floeflow.core.grids import Grid, scene_crs, scene_grid, to_lonlat
from floeflow.core.times import say, window_span
from floeflow.forcings import cf_variables, fallback
from floeflow.forcings.accumulate import Rates
from floeflow.forcings.climatology import window_forcing
from floeflow.forcings.fixed_fields import FIXED
from floeflow.forcings.moisture import dew_point_humidity, snow_of_precipitation
from floeflow.forcings.sources import Sources, find_sources, forcing_hints
from floeflow.forcings.tracks import InputFile, Track, open_files, same_grid
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import forcing_variables

Array = NDArray[np.float64]
Index = NDArray[np.int64]

log = logging.getLogger(__name__)

# Ocean values missing on land take the nearest one up to this far (m); beyond it there is none.
OCEAN_REACH = 5.0e5
# Area means where so many points of a file lie along the side of a cell: the analytic forcing has
# two, and its values are of points.
FINER = 2.2
UNITS = {
    "wind": "m s-1",
    "ocean": "m s-1",
    "air_temperature": "K",
    "specific_humidity": "kg kg-1",
    "air_pressure": "Pa",
    "shortwave_down": "W m-2",
    "longwave_down": "W m-2",
    "snowfall": "kg m-2 s-1",
    "ocean_heat_flux": "W m-2",
    "sea_surface_temperature": "K",
}


@dataclass
class Places:
    """A scene's grid, and the weights from the files' grids to it."""

    scene: Scene
    grid: Grid
    crs: pyproj.CRS
    lon: Array
    lat: Array
    span: tuple[float, float]
    known: list[tuple[AnySource, interpolate.Transfer]] = field(default_factory=list)

    def transfer(self, track: Track) -> interpolate.Transfer:
        """Weights from a variable's grid to the scene's; refuses a file too small.

        Parameters
        ----------
        track : Track
            Variable of the files.

        Returns
        -------
        Transfer
            The same for variables on the same grid.
        """
        source = track.source()
        for old, found in self.known:
            if old is source:
                return self._covering(found, track)
        found = areas.transfer(source, self.grid, self.crs, self.lon, self.lat, FINER)
        self.known.append((source, found))
        return self._covering(found, track)

    def _covering(self, found: interpolate.Transfer, track: Track) -> interpolate.Transfer:
        inside = found.inside
        distance = getattr(found, "distance", None)
        if track.ocean and distance is not None:
            # Grids of the ocean may leave out blocks of land.
            inside = inside | (distance <= OCEAN_REACH)
        if not inside.all():
            worst = int(np.argmin(inside))
            raise FloeError(
                f"{track.path}: '{track.name}' does not cover the scene, such as "
                f"{self.place(worst)}"
            )
        return found

    def place(self, point: int) -> str:
        """A point of the grid in words.

        Parameters
        ----------
        point : int
            Index of the flattened grid.

        Returns
        -------
        str
            Latitude and longitude in degrees.
        """
        lat, lon = self.lat.ravel()[point], (self.lon.ravel()[point] + 180.0) % 360.0 - 180.0
        north, east = "N" if lat >= 0 else "S", "E" if lon >= 0 else "W"
        return f"{abs(lat):.1f} {north}, {abs(lon):.1f} {east}"

    def values(self, track: Track, plan: Rates) -> Array:
        """Values of a plan's records on the file's grid, nothing missing where it is needed.

        Parameters
        ----------
        track : Track
            Variable of the files.
        plan : Rates
            Which records.

        Returns
        -------
        ndarray
            On the scene's grid, (records, ny, nx), in the unit of the forcing.

        Raises
        ------
        FloeError
            For a variable without values where they are needed.
        """
        found = self.transfer(track)
        values = track.values(plan.index)
        missing = np.isnan(values)
        if track.ocean and missing.any():
            always = missing.all(axis=0)
            if always.all():
                raise FloeError(f"{track.path}: '{track.name}' has no value in the window")
            filled = interpolate.fill_nearest(
                np.where(always, np.nan, np.where(missing, 0.0, values)),
                track.source(),
                OCEAN_REACH,
            )
            values = np.where(missing & ~always, np.nan, filled)
        at_scene = found.of(values)
        if not np.isfinite(at_scene).all():
            when, where = np.argwhere(~np.isfinite(at_scene))[0]
            time = ""
            if track.layout.time:
                seconds = track.seconds[plan.index[when]]
                time = f" at {say(self.scene.time.start, float(seconds))}"
            raise FloeError(
                f"{track.path}: '{track.name}' is missing or not finite{time} near "
                f"{self.place(int(where))}"
            )
        return values


def places_of(scene: Scene, span: tuple[float, float]) -> Places:
    """The places of a scene for a span of time (s since its start).

    Parameters
    ----------
    scene : Scene
        Its grid and projection.
    span : tuple of float
        Start and end (s since the scene's start).

    Returns
    -------
    Places
        Grid of the scene in projection and in degrees.
    """
    grid, crs = scene_grid(scene.domain), scene_crs(scene.domain)
    return Places(scene, grid, crs, *to_lonlat(crs, *grid.mesh()), span)


def _scalar(places: Places, name: str, track: Track) -> tuple[Array, Array]:
    """Times and SI values (time, place) of a scalar; refuses values that cannot be."""
    quantity = cf_variables.QUANTITIES[name]
    factor, offset, summed = cf_variables.scalar_conversion(track.variable, quantity, track.path)
    plan = track.records(places.span)
    values = factor * places.values(track, plan) + offset
    at_scene = plan.of(places.transfer(track).of(values))
    low, high = float(at_scene.min()), float(at_scene.max())
    # Packing leaves fluxes a shade below zero, and more so differences of sums.
    slack = (3e-4 if summed else 1e-6) * (quantity.high - quantity.low)
    if low < quantity.low - slack or high > quantity.high + slack:
        raise FloeError(
            f"{track.path}: '{track.name}' reaches from {low:g} to {high:g} {quantity.si}, "
            f"outside {quantity.low:g} to {quantity.high:g} {quantity.si}: check its units"
        )
    return plan.seconds, np.clip(at_scene, quantity.low, quantity.high)


def _vector(
    places: Places, name: str, pair: tuple[Track, Track], east_north: bool
) -> tuple[Array, Array, Array]:
    """Times and components along the scene's axes (time, place), m/s.

    Each component is a vector along its own direction on the scene's map at its own points.

    Raises
    ------
    FloeError
        For components of different times, that are too fast, whose stress cannot be known, or
        that cannot be turned to the scene's axes.
    """
    high = cf_variables.VECTORS[name].high
    one, other = pair
    said = f"{one.path}: '{one.name}' and '{other.name}'"
    plans = [track.records(places.span) for track in pair]
    if plans[0].seconds.size != plans[1].seconds.size or not np.allclose(
        plans[0].seconds, plans[1].seconds
    ):
        raise FloeError(f"{said} are not of the same times")
    sources = [track.source() for track in pair]
    raw = []
    for track, plan in zip(pair, plans, strict=True):
        factor, _ = cf_variables.conversion(track.variable, cf_variables.VECTOR_UNITS, track.path)
        raw.append(factor * places.values(track, plan))
    together = raw[0].shape == raw[1].shape
    fastest = np.hypot(*raw) if together else np.concatenate([part.ravel() for part in raw])
    speed = float(np.nanmax(np.abs(fastest), initial=0.0))
    if speed > high:
        raise FloeError(f"{said} reach {speed:g} m/s, above {high:g}: check their units")
    stress = name == "wind" and places.scene.forcing.wind_mean == "stress"
    if stress:
        if not together or not same_grid(*sources):
            raise FloeError(
                f"{said} do not stand at the same points, so that the wind's stress there is not "
                "known: set forcing.wind_mean to velocity"
            )
        raw = [np.hypot(*raw) * part for part in raw]
    u, v = np.zeros(1), np.zeros(1)
    for number, (track, plan, values) in enumerate(zip(pair, plans, raw, strict=True)):
        angle = vectors.component_angle(sources[number], places.crs, east_north, number == 1)
        found = places.transfer(track)
        parts = [plan.of(found.of(values * turn)) for turn in (np.cos(angle), np.sin(angle))]
        u, v = u + parts[0], v + parts[1]
    if not (np.isfinite(u).all() and np.isfinite(v).all()):
        raise FloeError(
            f"{said} cannot be turned to the axes of '{places.scene.domain.crs}' everywhere in "
            "the scene"
        )
    if stress:
        root = np.sqrt(np.hypot(u, v))
        u, v = (part / np.where(root > 0.0, root, 1.0) for part in (u, v))
    return plans[0].seconds, u, v


def field_units() -> dict[str, str]:
    """SI units of the forcing by variable, vectors without component; fixed fields have theirs."""
    return UNITS | {name: unit for name, (_, unit) in FIXED.items()}


def make_forcing(
    scene: Scene, source: str | Path | Sequence[str | Path], window: int
) -> xr.Dataset:
    """Forcing of a window.

    Parameters
    ----------
    scene : Scene
        Its domain, time, forcing and effects are read.
    source : str, Path or sequence of them
        CF files, in the order in which they count; not read where ``forcing.source`` is
        climatology.
    window : int
        From 1.

    Returns
    -------
    xarray.Dataset
        The variables of ``floeflow.scene.effects.forcing_variables`` on (time, y, x), coriolis on
        (y, x); time in seconds since the scene's start, both ends of the window included. The
        attribute ``sources`` says where each comes from.

    Raises
    ------
    FloeError
        For what is missing, does not cover scene or window, or cannot be.
    """
    if scene.forcing.source == "climatology":
        return window_forcing(scene, window, field_units())
    paths = [Path(source)] if isinstance(source, str | Path) else [Path(item) for item in source]
    span = window_span(window, scene.time.window)
    places = places_of(scene, span)
    grid = places.grid
    files = open_files(paths, forcing_hints(scene))
    try:
        found = find_sources(scene, files)
        series, said = _from_files(places, found)
    finally:
        _close(files)
    own = np.unique(np.concatenate([list(span), *(seconds for seconds, _ in series.values())]))
    time = own[(own >= span[0]) & (own <= span[1])]
    if "cyclone" in found.fallbacks.values():
        time = np.unique(np.append(time, np.arange(span[0], span[1], scene.forcing.step)))
    made = {name: interpolate.at_times(*item, time) for name, item in series.items()}
    for name, stand_in in found.fallbacks.items():
        made |= fallback.fields(scene, name, stand_in, time)
        said[name] = f"forcing.fallback: {stand_in}"
    made |= _derived(made)
    made |= {
        name: FIXED[name][0](scene) for name in forcing_variables(scene.effects) if name in FIXED
    }
    for name, text in said.items():
        log.info("%s: %s", name, text)
    return _dataset(scene, grid, time, made, window, said)


def _close(files: Sequence[InputFile]) -> None:
    for file in files:
        file.data.close()


def _from_files(
    places: Places, found: Sources
) -> tuple[dict[str, tuple[Array, Array]], dict[str, str]]:
    """Series of all that the files have, and where each comes from."""
    series: dict[str, tuple[Array, Array]] = {}
    said = {}
    for name, item in found.tracks.items():
        if isinstance(item, tuple):
            seconds, u, v = _vector(places, name, item, found.east_north[name])
            series |= {f"{name}_u": (seconds, u), f"{name}_v": (seconds, v)}
        else:
            series[name] = _scalar(places, name, item)
        said[name] = describe(item)
    return series, said


def describe(item: Track | tuple[Track, Track]) -> str:
    """Where a quantity comes from, for people.

    Parameters
    ----------
    item : Track or tuple of Track
        Variable, or two components.

    Returns
    -------
    str
        File, variable, and what is known of level, time and units.
    """
    first = item[0] if isinstance(item, tuple) else item
    whole = ", ".join(track.name for track in (item if isinstance(item, tuple) else (item,)))
    level = first.level()
    kinds = {"mean": "means over time", "sum": "sums over time"}
    extra = [kinds[first.kind]] if first.kind in kinds else []
    said = [each for each in (level, *extra, first.note()) if each]
    return "; ".join([f"{whole} of {first.path}", *said])


def _derived(made: dict[str, Array]) -> dict[str, Array]:
    found = {}
    if "dew_point" in made:
        humidity = dew_point_humidity(made["dew_point"], made["air_pressure"])
        found["specific_humidity"] = humidity
    if "precipitation" in made:
        found["snowfall"] = snow_of_precipitation(made["precipitation"], made["air_temperature"])
    return found


def _dataset(
    scene: Scene,
    grid: Grid,
    time: Array,
    made: dict[str, Array],
    window: int,
    said: dict[str, str],
) -> xr.Dataset:
    data_vars, units = {}, field_units()
    for name in forcing_variables(scene.effects):
        dims = ("y", "x") if name in FIXED else ("time", "y", "x")
        shape = grid.shape if name in FIXED else (time.size, *grid.shape)
        values = np.ascontiguousarray(made[name]).reshape(shape)
        unit = units[name.removesuffix("_u").removesuffix("_v")]
        data_vars[name] = (dims, values, {"units": unit})
    log.info("window %d: %d times, %d variables", window, time.size, len(data_vars))
    coords = {
        "time": ("time", time, {"units": "s", "long_name": "time since the scene's start"}),
        "x": ("x", grid.x, {"units": "m"}),
        "y": ("y", grid.y, {"units": "m"}),
    }
    sources = "\n".join(f"{name}: {text}" for name, text in said.items())
    return xr.Dataset(data_vars, coords, {"crs": scene.domain.crs, "sources": sources})
