# SPDX-License-Identifier: GPL-2.0-or-later
"""Forcing of a single column from a CF or ERA5-named file: a point, or the nearest of a grid.

The tables of names and units, the turning of sums into rates, and the refusals are those of the
scenes' forcing (docs/forcing.md). Only the wind's speed matters to a column, so its components need
no turning.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from floeflow.column.params import Settings
from floeflow.column.state import Array
from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError
from floeflow.core.sun import day_of_year, sun_height
from floeflow.core.times import say, seconds_since
from floeflow.forcings import cf_variables as names
from floeflow.forcings.accumulate import rates
from floeflow.forcings.moisture import dew_point_humidity, snow_of_precipitation
from floeflow.forcings.sources import SUBSTITUTES
from floeflow.forcings.tracks import GAP, era5_mean

ALWAYS = ("air_temperature", "specific_humidity", "air_pressure", "longwave_down")
WITH_PROCESS = {"snow": "snowfall", "shortwave": "shortwave_down"}


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
    """

    start: datetime
    length: float
    series: dict[str, tuple[Array, Array]]
    constant: dict[str, float]
    place: tuple[float, float] | None = None

    def __call__(self, t: float) -> dict[str, Array]:
        """Forcing at a time (s), as `floeflow.column.schemes` takes it; the record repeats."""
        t = t % self.length
        values = {n: np.array([np.interp(t, *each)]) for n, each in self.series.items()}
        values |= {name: np.array([value]) for name, value in self.constant.items()}
        speed = values.pop("wind_speed")
        if self.place is not None:
            lon, lat = self.place
            height = sun_height(day_of_year(self.start, t), lat, lon)
            values["sun_height"] = np.array([float(height)])
        return values | {"wind_u": speed, "wind_v": np.zeros(1)}


@dataclass(frozen=True)
class Reader:
    """A file, its variables and the place that is asked for (degrees; None: the only one)."""

    path: Path
    variables: dict[str, cf.Variable]
    start: datetime
    place: tuple[float, float] | None
    accumulation: str

    def time_name(self, variable: cf.Variable) -> str:
        """Name of a variable's time axis.

        Raises
        ------
        FloeError
            Where it has none.
        """
        for dim in variable.dims:
            axis = self.variables.get(dim)
            if axis is not None and " since " in axis.text("units"):
                return dim
        raise FloeError(f"{self.path}: '{variable.name}' has no time axis with units 'since'")

    def series(self, kind: str, variable: cf.Variable) -> tuple[Array, Array]:
        """Times (s) and SI values of a quantity, or of a component of the wind."""
        names.refuse_extremes(variable, self.path)
        quantity = names.QUANTITIES.get(kind)
        if quantity is None:
            factor, offset = names.conversion(variable, names.VECTOR_UNITS, self.path)
            low, high, summed = -150.0, 150.0, False
        else:
            low, high = quantity.low, quantity.high
            factor, offset, summed = names.scalar_conversion(variable, quantity, self.path)
        seconds, values = self._read(variable)
        if summed:
            span, where = (seconds[1], seconds[-1]), (self.path, variable.name)
            since = self.start
            midnight = -(3600.0 * since.hour + 60.0 * since.minute + since.second)
            plan = rates(seconds, span, self.accumulation, midnight, where)
            seconds, values = plan.seconds, plan.of(values[plan.index][:, None])[:, 0]
        elif era5_mean(variable):
            hourly = np.abs(np.diff(seconds) - 3600.0).max(initial=0.0) < 1.0
            if variable.text("GRIB_stepType") == "avg" and not hourly and not self.accumulation:
                raise FloeError(
                    f"{self.path}: '{variable.name}' is a mean over time and its records are not "
                    "hourly: say in --accumulation over what"
                )
            step = (
                3600.0 if self.accumulation in ("", "hour") else float(np.median(np.diff(seconds)))
            )
            seconds = seconds - 0.5 * step
        values = factor * values + offset
        slack = (3e-4 if summed else 1e-6) * (high - low)
        bad = ~((values >= low - slack) & (values <= high + slack))
        if bad.any():
            k = int(np.argmax(bad))
            raise FloeError(
                f"{self.path}: '{variable.name}' is {values[k]:g} at "
                f"{say(self.start, float(seconds[k]))}{self.said()}, outside {low:g} to {high:g}: "
                "check its units"
            )
        return seconds, np.clip(values, low, high)

    def said(self) -> str:
        """The place, in words."""
        return "" if self.place is None else f" near {self.place[1]:g} N, {self.place[0]:g} E"

    def _read(self, variable: cf.Variable) -> tuple[Array, Array]:
        time = self.time_name(variable)
        with netCDF4.Dataset(self.path) as file:
            seconds = seconds_since(file[time][:], self.variables[time], self.start, self.path)
            picks = [slice(None) if d == time else self._pick(file, d) for d in variable.dims]
            found: Any = np.ma.asarray(file[variable.name][tuple(picks)], float)
            values: Array = np.ma.filled(found, np.nan)
        steps = np.diff(seconds)
        if steps.size == 0 or (steps <= 0).any():
            raise FloeError(f"{self.path}: time variable '{time}' does not ascend")
        if (wide := steps > GAP * np.median(steps)).any():
            k = int(np.argmax(wide))
            ends = [say(self.start, float(item)) for item in seconds[k : k + 2]]
            raise FloeError(f"{self.path}: '{time}' has a gap from {ends[0]} to {ends[1]}")
        if not np.isfinite(values).all():
            when = say(self.start, float(seconds[int(np.argmax(~np.isfinite(values)))]))
            raise FloeError(
                f"{self.path}: '{variable.name}' is missing or not finite at {when}{self.said()}"
            )
        return seconds, np.asarray(values, dtype=float)

    def _pick(self, file: netCDF4.Dataset, dim: str) -> int:
        if file.dimensions[dim].size == 1:
            return 0
        axis = self.variables.get(dim)
        units = "" if axis is None else axis.text("units").lower()
        if self.place is None or not units.startswith("degree"):
            raise FloeError(
                f"{self.path}: '{dim}' has {file.dimensions[dim].size} values: name the place by "
                "--lon and --lat on a grid of longitude and latitude"
            )
        values = np.asarray(file[dim][:], dtype=float)
        if "n" in units.removeprefix("degree"):
            return int(np.argmin(np.abs(values - self.place[1])))
        return int(np.argmin(np.abs((values - self.place[0] + 180.0) % 360.0 - 180.0)))


def _first_time(path: Path, variables: dict[str, cf.Variable]) -> datetime:
    for name, axis in variables.items():
        if axis.dims == (name,) and " since " in axis.text("units"):
            with netCDF4.Dataset(path) as file:
                calendar = axis.text("calendar") or "standard"
                date: Any = netCDF4.num2date(file[name][0], axis.text("units"), calendar)
            parts = (date.year, date.month, date.day, date.hour, date.minute, date.second)
            return datetime(*parts)
    raise FloeError(f"{path}: has no time axis with units 'since'")


def read_point(
    path: str | Path,
    settings: Settings,
    constant: dict[str, float],
    place: tuple[float, float] | None,
    accumulation: str,
) -> PointForcing:
    """Read what a column needs.

    Parameters
    ----------
    path : str or Path
        CF NetCDF file, at a point or on a grid of longitude and latitude.
    settings : Settings
        Its processes say what is needed.
    constant : dict of float
        Values for what the file may lack: ``ocean_heat_flux``, ``friction_velocity``,
        ``air_pressure``.
    place : tuple of float or None
        Longitude and latitude (degrees), on a grid.
    accumulation : str
        As `forcing.accumulation` of scenes.

    Raises
    ------
    FloeError
        For what is missing, has unknown units, gaps, or values that cannot be; names variable,
        time and place.
    """
    path = Path(path)
    if settings.needs_sun and place is None:
        raise FloeError("delta-Eddington light needs the height of the sun: name --lon and --lat")
    variables = cf.describe(path)
    reader = Reader(path, variables, _first_time(path, variables), place, accumulation)
    wanted = [*ALWAYS, *(name for process, name in WITH_PROCESS.items() if settings.has(process))]
    series, left = {"wind_speed": _wind(reader)}, dict(constant)
    for name in (*wanted, "ocean_heat_flux"):
        variable = names.find_scalar(variables, name, path)
        if variable is not None:
            series[name] = reader.series(name, variable)
            left.pop(name, None)
        elif name not in left:
            _substitute(reader, name, series, left)
    # Sums end their rates at their last record, like all others; intervals may begin before.
    length = min(float(seconds[-1]) for seconds, _ in series.values())
    kept = {name: series[name] for name in series if name in _READ}
    return PointForcing(reader.start, length, kept, left, place)


_READ = {"wind_speed", "ocean_heat_flux", *ALWAYS, *WITH_PROCESS.values()}


def _wind(reader: Reader) -> tuple[Array, Array]:
    pair = names.VECTORS["wind"]
    for u, v in (*pair.east_north, *pair.map_axes, *pair.common):
        found = []
        for name in (u, v):
            standard = cf.by_standard_name(reader.variables, name)
            found += standard[:1] or [reader.variables[n] for n in (name,) if n in reader.variables]
        if len(found) == 2:
            (seconds, east), (_, north) = (reader.series("wind", each) for each in found)
            return seconds, np.hypot(east, north)
    raise FloeError(
        f"{reader.path}: has no wind: no standard_names {' and '.join(pair.east_north[0])}"
    )


def _substitute(
    reader: Reader, name: str, series: dict[str, tuple[Array, Array]], constant: dict[str, float]
) -> None:
    """Put a quantity together from the two that stand for it."""
    others = SUBSTITUTES.get(name, ())
    found = [names.find_scalar(reader.variables, other, reader.path) for other in others]
    pair = []
    for other, variable in zip(others, found, strict=True):
        if variable is not None:
            pair.append(reader.series(other, variable))
        elif other in constant:
            pair.append((np.zeros(1), np.array([constant[other]])))
    if len(pair) < 2:
        standard = names.QUANTITIES[name].standard[0]
        raise FloeError(f"{reader.path}: has no {name}: no standard_name {standard}")
    seconds, first = pair[0]
    second = np.interp(seconds, *pair[1])
    make = dew_point_humidity if name == "specific_humidity" else snow_of_precipitation
    series[name] = seconds, make(first, second)
