# SPDX-License-Identifier: GPL-2.0-or-later
"""One quantity through all files that hold it: its records, their times, its grid, its values.

A year may lie in twelve files, and a quantity of two files with the same time comes from the first.
Records are instants, means over an interval, or sums over one; what they are is told by bounds,
cell methods, units, GRIB's step type and the names of ERA5's mean rates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core import cf_reading as cf
from floeflow.core import fields, levels, times, units
from floeflow.core.errors import FloeError
from floeflow.core.input_files import Hints
from floeflow.forcings import cf_variables
from floeflow.forcings.accumulate import (
    SLACK,
    Intervals,
    Rates,
    instants,
    intervals,
    plan,
)

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Records further apart than so many of their usual steps leave a gap.
GAP = 1.5
# ERA5's mean rates by their old names; the new ones begin with avg_. Each is of the hour before.
ERA5_MEANS = {
    "msdwswrf",
    "msdwlwrf",
    "msr",
    "mtpr",
    "mtsfr",
    "msnswrf",
    "msnlwrf",
    "mslhf",
    "msshf",
}


def era5_mean(variable: cf.Variable) -> bool:
    """Whether a variable is one of ERA5's mean rates, which are of the hour before their stamp.

    Parameters
    ----------
    variable : cf.Variable
        One of the file.

    Returns
    -------
    bool
        True by its name or GRIB's step type.
    """
    short = variable.text("GRIB_shortName") or variable.name
    named = short.startswith("avg_") or short in ERA5_MEANS
    return named or variable.text("GRIB_stepType") == "avg"


@dataclass
class InputFile:
    """An open file, its variables, and the grids that were read from it."""

    path: Path
    data: xr.Dataset
    variables: dict[str, cf.Variable]
    sources: dict[tuple[str, ...], fields.AnySource] = field(default_factory=dict)

    def layout(self, variable: cf.Variable) -> cf.Layout:
        """Roles of a variable's dimensions.

        Parameters
        ----------
        variable : cf.Variable
            One of the file.

        Returns
        -------
        Layout
            Names of the dimensions of x, y, time and level.
        """
        return cf.layout(self.variables, variable, self.path)

    def on_lonlat(self, variable: cf.Variable) -> bool:
        """Whether a variable lies on longitude and latitude.

        Parameters
        ----------
        variable : cf.Variable
            One of the file.

        Returns
        -------
        bool
            False on a projection and on a grid with places of its own.
        """
        return self.layout(variable).lonlat

    def source(self, variable: cf.Variable) -> fields.AnySource:
        """Grid of a variable; variables on the same one share it.

        Parameters
        ----------
        variable : cf.Variable
            One of the file.

        Returns
        -------
        Source or Curvilinear
            The same object for the same grid.
        """
        layout = self.layout(variable)
        key = (layout.x, layout.y, *(layout.places or ()), variable.text("grid_mapping"))
        if key not in self.sources:
            self.sources[key] = fields.source_grid(
                self.variables, variable, layout, self.data, self.path
            )
        return self.sources[key]


def open_files(paths: Sequence[Path], hints: Hints | None) -> list[InputFile]:
    """Open files, in the order in which they count.

    Parameters
    ----------
    paths : sequence of Path
        Files.
    hints : Hints or None
        What the scene says of them.

    Returns
    -------
    list of InputFile
        With their variables.

    Raises
    ------
    FloeError
        For a file that cannot be read.
    """
    found = []
    for path in paths:
        data = fields.open_file(path, hints)
        found.append(InputFile(Path(path), data, cf.variables_of(data)))
    return found


@dataclass(frozen=True)
class Clock:
    """What of a scene decides about times.

    Parameters
    ----------
    start : datetime
        The scene's start.
    midnight : float
        The midnight at or before it (s since it).
    accumulation : str
        Interval of sums and means without bounds, see ``forcing.accumulation``.
    days_off : float
        A field of one time may be so far from the scene's start.
    """

    start: datetime
    midnight: float
    accumulation: str
    days_off: float


class Track:
    """A variable in all files that hold it.

    Parameters
    ----------
    files : sequence of InputFile
        Those that may hold it, the first of them surely.
    name : str
        Of the variable.
    summed : bool
        Whether its units are those of a sum over time.
    ocean : bool
        Whether it belongs to the sea.
    clock : Clock
        Of the scene.
    height : float
        Above the ground (m), where it is wanted; see `levels.surface`.
    """

    def __init__(
        self,
        files: Sequence[InputFile],
        name: str,
        summed: bool,
        ocean: bool,
        clock: Clock,
        height: float = 0.0,
    ) -> None:
        self.first = files[0]
        self.variable = self.first.variables[name]
        self.path, self.name, self.ocean, self.clock = self.first.path, name, ocean, clock
        self.height = height
        self.layout = self.first.layout(self.variable)
        same = [file for file in files if name in file.variables]
        self.files = same if self.layout.time else same[:1]
        for file in self.files:
            cf_variables.refuse_extremes(file.variables[name], file.path)
            check_alike(self.variable, self.path, file.variables[name], file.path)
        self.seconds, self.bounds, self.piece, self.local = self._records()
        self.kind = self._kind(summed)

    def _records(self) -> tuple[Array, tuple[Array, Array] | None, Index, Index]:
        if not self.layout.time:
            none: Index = np.zeros(1, dtype=np.int64)
            return np.empty(0), None, none, none
        parts = [
            times.axis_seconds(
                file.data,
                file.variables,
                file.layout(file.variables[self.name]).time,
                self.clock.start,
                file.path,
            )
            for file in self.files
        ]
        seconds = np.concatenate([part for part, _ in parts])
        piece = np.repeat(np.arange(len(parts)), [part.size for part, _ in parts])
        local = np.concatenate([np.arange(part.size) for part, _ in parts])
        kept = np.arange(seconds.size)
        if len(parts) > 1:
            _, kept = np.unique(np.round(seconds), return_index=True)
        bounds = None
        if all(ends is not None for _, ends in parts):
            both = [ends for _, ends in parts if ends is not None]
            low, high = (np.concatenate([ends[side] for ends in both])[kept] for side in (0, 1))
            bounds = low, high
        return seconds[kept], bounds, piece[kept], local[kept]

    def _kind(self, summed: bool) -> str:
        """``instant``, ``mean`` or ``sum``."""
        if not self.layout.time:
            return "instant"
        if summed:
            return "sum"
        over_time = self._methods()
        step_type = self.variable.text("GRIB_stepType")
        if "point" in over_time or step_type == "instant":
            return "instant"
        if self.bounds is not None or era5_mean(self.variable) or step_type.startswith("avg"):
            return "mean"
        return "instant"

    def _methods(self) -> set[str]:
        """What the cell methods say of time."""
        methods = self.variable.text("cell_methods").replace(" ", "")
        return {
            part for part in ("point", "mean", "sum") for dim in ("time", self.layout.time)
            if f"{dim}:{part}" in methods
        }  # fmt: skip

    def note(self) -> str:
        """What is taken for granted of the records' times, for people; empty for nothing."""
        if not self.layout.time or self.bounds is not None:
            return ""
        if self.kind != "instant":
            how = self._how() or "hour"
            over = {"hour": "the hour before", "step": "the step before", "day": "the day so far"}
            return f"no bounds: taken as over {over[how]} of each record"
        daily = self.seconds.size > 1 and np.median(np.diff(self.seconds)) > times.DAY - SLACK
        if "mean" in self._methods() or (daily and "point" not in self._methods()):
            return "no bounds: taken as of its stamps, as if these were the middles of its times"
        return ""

    @property
    def where(self) -> tuple[Path, str]:
        """File and variable, for sentences."""
        return self.path, self.name

    def cover(self) -> tuple[float, float]:
        """First and last time that the records tell of (s)."""
        if self.kind == "instant":
            return float(self.seconds[0]), float(self.seconds[-1])
        found = self._intervals()
        return float(found.start[0]), float(found.end[-1])

    def records(self, span: tuple[float, float]) -> Rates:
        """The records that make values over a span (s), and when.

        Parameters
        ----------
        span : tuple of float
            Start and end (s since the scene's start).

        Returns
        -------
        Rates
            Records, in order, their times (s) and the seconds to divide sums by.

        Raises
        ------
        FloeError
            Where times do not ascend, have gaps, or do not cover the span.
        """
        if not self.layout.time:
            self._check_stamp()
            return Rates(np.zeros(1), np.zeros(1, np.int64), np.zeros(1, bool), np.ones(1))
        if self.kind == "instant":
            check_cover(self.seconds, *span, self.clock, self.path, self.layout.time)
            return instants(self.seconds, span)
        check_axis(self.seconds, *span, self.clock, self.path, self.layout.time)
        return plan(self._intervals(), span, self.where, summed=self.kind == "sum")

    def _check_stamp(self) -> None:
        """Refuse a steady field of quite another time."""
        if not self.layout.stamp:
            return
        seconds, _ = times.axis_seconds(
            self.first.data, self.first.variables, self.layout.stamp, self.clock.start, self.path
        )
        days = float(np.abs(seconds).min()) / times.DAY
        if days > self.clock.days_off:
            raise FloeError(
                f"{self.path}: '{self.name}' is of {times.say(self.clock.start, seconds[0])}, "
                f"{days:.0f} days from the scene's start; forcing.days_off allows "
                f"{self.clock.days_off:g} days"
            )

    def _how(self) -> str:
        """Over what sums and means without bounds are; empty: hourly records, each of its hour."""
        # ERA5's means are of the hour before, however far apart a file's records are.
        era5 = self.kind == "mean" and not self.variable.text("GRIB_stepType").startswith("avg")
        return self.clock.accumulation or ("hour" if era5 else "")

    def _intervals(self) -> Intervals:
        if self.kind == "sum" and self.variable.text("GRIB_stepType").startswith("avg"):
            raise FloeError(
                f"{self.path}: '{self.name}' is a mean of sums over time (GRIB step type "
                f"{self.variable.text('GRIB_stepType')}), such as ERA5's monthly means of a day's "
                "sums: give it as a rate"
            )
        if self.bounds is None:
            means = self.kind == "mean"
            return intervals(self.seconds, self._how(), self.clock.midnight, self.where, means)
        start, end = self.bounds
        goes_on = np.zeros(start.size, dtype=bool)
        if self.kind == "sum":
            # Sums since one start go on from record to record.
            goes_on[1:] = (np.abs(np.diff(start)) < SLACK) & (np.diff(end) > SLACK)
            start = np.where(goes_on, np.concatenate([start[:1], end[:-1]]), start)
        return Intervals(start, end, np.arange(start.size), goes_on)

    def values(self, index: Index) -> Array:
        """Unpacked values of some records on the file's grid, (records, ny, nx).

        Parameters
        ----------
        index : ndarray
            Of the records, (m,).

        Returns
        -------
        ndarray
            In the file's unit, NaN where there is none, (records, ny, nx).

        Raises
        ------
        FloeError
            Where the files of a variable are on different grids.
        """
        parts = np.empty((len(index), *fields.shape_of(self.source())))
        for piece in np.unique(self.piece[index]):
            file = self.files[piece]
            variable = file.variables[self.name]
            rows = np.flatnonzero(self.piece[index] == piece)
            source = file.source(variable)
            if piece and not same_grid(source, self.source()):
                raise FloeError(f"{file.path}: '{self.name}' is not on the grid of {self.path}")
            layout, level = file.layout(variable), self._level(file)
            parts[rows] = fields.read_values(
                *(file.data, self.name, layout, source, self.local[index][rows], file.path),
                None if level is None else level.index,
            )
        return parts

    def source(self) -> fields.AnySource:
        """The variable's grid."""
        return self.first.source(self.variable)

    def level(self) -> str:
        """The level that is read, for people; empty where the variable has none."""
        found = self._level(self.first)
        return found.said if found else ""

    def _level(self, file: InputFile) -> levels.Level | None:
        layout = file.layout(file.variables[self.name])
        return fields.surface_level(
            file.data, self.name, layout, self.ocean, file.path, self.height
        )


def check_alike(one: cf.Variable, path: Path, other: cf.Variable, other_path: Path) -> None:
    """Refuse parts of one series whose numbers do not mean the same: other units, other axes.

    Parameters
    ----------
    one : cf.Variable
        Variables of the two files.
    path : Path
        Of the files, for messages.
    other : cf.Variable
        Variables of the two files.
    other_path : Path
        Of the files, for messages.

    Raises
    ------
    FloeError
        Names both files.
    """
    for attribute in ("units", "standard_name"):
        both = one.text(attribute), other.text(attribute)
        if both[0] == both[1]:
            continue
        if attribute == "units":
            same = (1.0, 0.0) in (units.conversion(*both), units.conversion(*both[::-1]))
        else:
            # ERA5 leaves names out, or calls them unknown, in some years and not in others.
            same = not all(both) or "unknown" in both
        if not same:
            raise FloeError(
                f"{other_path}: '{one.name}' has {attribute} '{both[1]}', but '{both[0]}' in "
                f"{path}: parts of one series must mean the same"
            )


def same_grid(one: fields.AnySource, other: fields.AnySource) -> bool:
    """Whether two grids have the same places, to a tenth of a second of arc, or a metre.

    Parameters
    ----------
    one : fields.AnySource
        Grids of two variables.
    other : fields.AnySource
        Grids of two variables.

    Returns
    -------
    bool
        False for grids of different kinds.
    """
    if one is other:
        return True
    if type(one) is not type(other) or fields.shape_of(one) != fields.shape_of(other):
        return False
    if isinstance(one, fields.Curvilinear) or isinstance(other, fields.Curvilinear):
        pairs = list(zip(one.lonlat(), other.lonlat(), strict=True))
        return all(np.allclose(a, b, rtol=0, atol=3e-5, equal_nan=True) for a, b in pairs)
    near = 3e-5 if one.crs is None else 1.0
    return all(
        np.allclose(a, b, rtol=0, atol=near) for a, b in ((one.x, other.x), (one.y, other.y))
    )


def check_axis(
    seconds: Array, first: float, last: float, clock: Clock, path: Path, name: str
) -> None:
    """Refuse a time axis that does not ascend, or has a gap between first and last (s).

    Parameters
    ----------
    seconds : ndarray
        Of the records, since the scene's start (s), (records,).
    first : float
        Span that is needed (s).
    last : float
        Span that is needed (s).
    clock : Clock
        Of the scene, for messages.
    path : Path
        Of the file, for messages.
    name : str
        Of the time variable, for messages.

    Raises
    ------
    FloeError
        For an axis that does not ascend, or has a gap.
    """
    steps = np.diff(seconds)
    if np.any(steps <= 0):
        raise FloeError(f"{path}: time variable '{name}' does not ascend")
    wide = steps > GAP * np.median(steps) if steps.size else np.zeros(0, dtype=bool)
    for k in np.flatnonzero(wide & (seconds[:-1] < last) & (seconds[1:] > first))[:1]:
        ends = [times.say(clock.start, float(item)) for item in seconds[k : k + 2]]
        raise FloeError(f"{path}: '{name}' has a gap from {ends[0]} to {ends[1]}")


def check_cover(
    seconds: Array, first: float, last: float, clock: Clock, path: Path, name: str
) -> None:
    """Refuse a time axis that does not ascend, or reach from first to last (s) without gaps.

    Parameters
    ----------
    seconds : ndarray
        Of the records, since the scene's start (s), (records,).
    first : float
        Span that is needed (s).
    last : float
        Span that is needed (s).
    clock : Clock
        Of the scene, for messages.
    path : Path
        Of the file, for messages.
    name : str
        Of the variable, for messages.

    Raises
    ------
    FloeError
        For an axis that does not ascend, has a gap, or is too short.
    """
    check_axis(seconds, first, last, clock, path, name)
    if seconds[0] > first or seconds[-1] < last:
        span = [times.say(clock.start, float(item)) for item in (seconds[0], seconds[-1])]
        need = [times.say(clock.start, item) for item in (first, last)]
        raise FloeError(
            f"{path}: '{name}' covers {span[0]} to {span[1]}, but the scene needs {need[0]} to "
            f"{need[1]}"
        )
