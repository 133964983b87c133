# SPDX-License-Identifier: GPL-2.0-or-later
"""Forcing of a single column from the files that scenes read: a point, or the nearest of a map.

Tables of names and units, levels, times, means and sums, and the refusals are those of the scenes'
forcing (docs/forcing.md). Only the wind's speed matters to a column, so its components need no
turning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from floeflow.column.params import Settings
from floeflow.column.state import Array
from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError
from floeflow.core.input_files import Hints
from floeflow.core.sun import day_of_year, sun_height
from floeflow.core.times import first_date, say
from floeflow.forcings import cf_variables
from floeflow.forcings.forcing import describe
from floeflow.forcings.moisture import dew_point_humidity, snow_of_precipitation
from floeflow.forcings.points import at_place
from floeflow.forcings.sources import Sources, find_sources
from floeflow.forcings.tracks import InputFile, Track, open_files
from floeflow.scene.blocks import Scene

# Processes of a column that read forcing of their own; the others need what the column does.
READING = ("snow", "shortwave")


@dataclass(frozen=True)
class PointForcing:
    """Time series at a place.

    Parameters
    ----------
    start : datetime
        Time of the first record, to which seconds refer.
    length : float
        Time that all variables cover from there (s).
    series : dict of tuple
        Times (s) and SI values of each variable, ``wind_speed`` among them.
    constant : dict of float
        What does not change.
    place : tuple of float or None
        Longitude and latitude (degrees), for the height of the sun.
    begin : float
        Time of the record at which a run begins (s).
    said : tuple of str
        Where each quantity comes from, for people.
    """

    start: datetime
    length: float
    series: dict[str, tuple[Array, Array]]
    constant: dict[str, float]
    place: tuple[float, float] | None = None
    begin: float = 0.0
    said: tuple[str, ...] = ()

    @property
    def first(self) -> datetime:
        """Time at which a run begins."""
        return self.start + timedelta(seconds=self.begin)

    def beginning(self, moment: datetime) -> PointForcing:
        """The same forcing for a run that begins at a moment.

        Parameters
        ----------
        moment : datetime
            In UTC.

        Raises
        ------
        FloeError
            Where the moment is not within the record.
        """
        begin = (moment - self.start).total_seconds()
        if not 0.0 <= begin < self.length:
            last = self.start + timedelta(seconds=self.length)
            raise FloeError(f"--start {moment}: the forcing goes from {self.start} to {last}")
        return replace(self, begin=begin)

    def __call__(self, t: float) -> dict[str, Array]:
        """Forcing at a time of the run (s), as `floeflow.column.schemes` takes it.

        The record repeats from its first time on.
        """
        t = (self.begin + t) % self.length
        values = {n: np.array([np.interp(t, *each)]) for n, each in self.series.items()}
        values |= {name: np.array([value]) for name, value in self.constant.items()}
        speed = values.pop("wind_speed")
        if self.place is not None:
            lon, lat = self.place
            height = sun_height(day_of_year(self.start, t), lat, lon)
            values["sun_height"] = np.array([float(height)])
        return values | {"wind_u": speed, "wind_v": np.zeros(1)}


def read_point(
    paths: Sequence[Path],
    settings: Settings,
    constant: dict[str, float],
    place: tuple[float, float] | None,
    accumulation: str,
) -> PointForcing:
    """Read what a column needs.

    Parameters
    ----------
    paths : sequence of Path
        Files, at a point or on a map, in the order in which they count.
    settings : Settings
        Its processes say what is needed.
    constant : dict of float
        Values for what the files may lack: ``ocean_heat_flux``, ``friction_velocity``,
        ``air_pressure``.
    place : tuple of float or None
        Longitude and latitude (degrees), on a map.
    accumulation : str
        As `forcing.accumulation` of scenes.

    Raises
    ------
    FloeError
        For what is missing, has unknown units, gaps, or values that cannot be; names variable,
        time and place.
    """
    if settings.needs_sun and place is None:
        raise FloeError("delta-Eddington light needs the height of the sun: name --lon and --lat")
    files = open_files(paths, Hints("forcing"))
    try:
        points = [at_place(file, place) for file in files]
        start = _start(points)
        effects = ("thermodynamics", *(name for name in READING if settings.has(name)))
        keys = {"source": "file", "accumulation": accumulation}
        scene = Scene(name="column", effects=effects, time={"start": start}, forcing=keys)
        found = find_sources(scene, points, advise=False)
        series = _all_series(found, start, place)
    finally:
        for file in files:
            file.data.close()
    said = [f"{name}: {describe(item)}" for name, item in found.tracks.items()]
    said += [f"{name}: {constant[name]:g}, no file has it" for name in found.fallbacks]
    # Sums end their rates at their last record, like all others; intervals may begin before.
    length = min(float(seconds[-1]) for seconds, _ in series.values() if seconds.size > 1)
    left = {name: value for name, value in constant.items() if name not in series}
    _derive(series, left)
    return PointForcing(start, length, series, left, place, said=tuple(said))


def _start(files: Sequence[InputFile]) -> datetime:
    """Time of the first record."""
    found = []
    for file in files:
        for name, axis in file.variables.items():
            if axis.dims == (name,) and cf.dimension_kind(file.variables, name) == "time":
                first = float(np.asarray(file.data[name].values).reshape(-1)[0])
                found.append(first_date(axis, first, file.path))
    if not found:
        raise FloeError(f"{files[0].path}: has no time axis with units 'since'")
    return min(found)


def _all_series(
    found: Sources, start: datetime, place: tuple[float, float] | None
) -> dict[str, tuple[Array, Array]]:
    """Times (s) and SI values of all that the files have, ``wind_speed`` for the wind."""
    near = "" if place is None else f" near {place[1]:g} N, {place[0]:g} E"
    series = {}
    for name, item in found.tracks.items():
        if isinstance(item, Track):
            series[name] = _series(item, name, start, near)
            continue
        (seconds, u), (others, v) = (_series(part, "wind", start, near) for part in item)
        if seconds.size != others.size or not np.allclose(seconds, others):
            raise FloeError(
                f"{item[0].path}: '{item[0].name}' and '{item[1].name}' are not of the same times"
            )
        series["wind_speed"] = seconds, np.hypot(u, v)
    return series


def _series(track: Track, name: str, start: datetime, near: str) -> tuple[Array, Array]:
    """Times (s) and SI values of a quantity, or of a component of the wind."""
    quantity = cf_variables.QUANTITIES.get(name)
    if quantity is None:
        high = cf_variables.VECTORS[name].high
        factor, offset = cf_variables.conversion(
            track.variable, cf_variables.VECTOR_UNITS, track.path
        )
        low, summed, unit = -high, False, cf_variables.VECTOR_UNITS
    else:
        low, high, unit = quantity.low, quantity.high, quantity.si
        factor, offset, summed = cf_variables.scalar_conversion(
            track.variable, quantity, track.path
        )
    plan = track.records(track.cover() if track.layout.time else (0.0, 0.0))
    stored = track.values(plan.index).reshape(len(plan.index), 1)
    if not np.isfinite(stored).all():
        record = int(plan.index[int(np.argmax(~np.isfinite(stored[:, 0])))])
        when = f" at {say(start, float(track.seconds[record]))}" if track.layout.time else ""
        raise FloeError(f"{track.path}: '{track.name}' is missing or not finite{when}{near}")
    values = plan.of(factor * stored + offset)[:, 0]
    # Packing leaves fluxes a shade below zero, and more so differences of sums.
    slack = (3e-4 if summed else 1e-6) * (high - low)
    bad = (values < low - slack) | (values > high + slack)
    if bad.any():
        k = int(np.argmax(bad))
        raise FloeError(
            f"{track.path}: '{track.name}' is {values[k]:g} {unit} at "
            f"{say(start, float(plan.seconds[k]))}{near}, outside {low:g} to {high:g} {unit}: "
            "check its units"
        )
    return plan.seconds, np.clip(values, low, high)


def _derive(series: dict[str, tuple[Array, Array]], constant: dict[str, float]) -> None:
    """Put humidity and snowfall together from what stands for them, which is dropped."""
    if "dew_point" in series:
        seconds, dew = series.pop("dew_point")
        pressure = series.get("air_pressure", (np.zeros(1), [constant.get("air_pressure", 0.0)]))
        humidity = dew_point_humidity(dew, np.interp(seconds, *pressure))
        series["specific_humidity"] = seconds, humidity
    if "precipitation" in series:
        seconds, rain = series.pop("precipitation")
        air = np.interp(seconds, *series["air_temperature"])
        series["snowfall"] = seconds, snow_of_precipitation(rain, air)
