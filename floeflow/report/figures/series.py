# SPDX-License-Identifier: GPL-2.0-or-later
"""Time series of the run: ice area and volume, energy, bonds, drift."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from floeflow.report.figures.style import BLUE, FAINT, GREEN, VERMILION, look, new_figure

SIZE = (6.0, 2.9)
# Lines of more points bear no markers.
MARKED = 60
AREA_UNITS = ((1e12, "10⁶ km²"), (1e9, "10³ km²"), (1e6, "km²"), (1.0, "m²"))
VOLUME_UNITS = ((1e12, "10³ km³"), (1e9, "km³"), (1e6, "10⁶ m³"), (1.0, "m³"))
ENERGY_UNITS = (
    (1e18, "EJ"),
    (1e15, "PJ"),
    (1e12, "TJ"),
    (1e9, "GJ"),
    (1e6, "MJ"),
    (1e3, "kJ"),
    (1.0, "J"),
)
FORCE_UNITS = ((1e12, "TN"), (1e9, "GN"), (1e6, "MN"), (1e3, "kN"), (1.0, "N"))
# Four sides in four colours; what comes after them starts anew with other dashes.
WALL_STYLES = tuple(
    (colour, dash) for dash in ("-", ":") for colour in (BLUE, VERMILION, GREEN, FAINT)
)


def pick_unit(units: tuple[tuple[float, str], ...], *values: np.ndarray) -> tuple[float, str]:
    """The largest unit of which the largest value holds at least one; else the smallest unit.

    Parameters
    ----------
    units : tuple of tuple of float and str
        Size of each unit and its name, the largest first.
    *values : ndarray
        In the smallest unit.

    Returns
    -------
    tuple of (float, str)
        Size of the unit in that of the values, and its name.
    """
    largest = max((float(np.nanmax(np.abs(v))) for v in values if np.isfinite(v).any()), default=0)
    return next((unit for unit in units if largest >= unit[0]), units[-1])


def time_axis(seconds: float) -> tuple[float, str]:
    """Seconds per unit, and the unit, in which a run of this length is best told.

    Parameters
    ----------
    seconds : float
        Length of the run.

    Returns
    -------
    tuple of (float, str)
        s, and the unit's name.
    """
    if seconds >= 2 * 86400.0:
        return 86400.0, "days"
    return (3600.0, "hours") if seconds >= 7200.0 else (60.0, "minutes")


def series_figures(
    data: xr.Dataset, start: str, effects: tuple[str, ...]
) -> Iterator[tuple[str, str, Figure]]:
    """Draw the series that the scene's effects bring.

    Parameters
    ----------
    data : xarray.Dataset
        ``diagnostics.nc``.
    start : str
        The scene's start, for the axis.
    effects : tuple of str
        The scene's effects.

    Yields
    ------
    tuple of str, str and Figure
        Name, caption, figure.
    """
    unit, word = time_axis(float(data["boundary_time"].values[-1]))
    axis = f"Time since {start} ({word})"
    at = data["boundary_time"].values / unit
    now = data["time"].values / unit

    stocks = [("area", "Ice area", "ice_area", AREA_UNITS, BLUE, "-o")]
    stocks.append(("volume", "Ice volume", "ice_volume", VOLUME_UNITS, BLUE, "-o"))
    if "snow" in effects:
        stocks.append(("snow", "Snow volume", "snow_volume", VOLUME_UNITS, VERMILION, "-s"))
    for short, words, variable, units, colour, dash in stocks:
        amount = data[variable].values
        scale, name = pick_unit(units, amount)
        line = (at, amount / scale, "", colour, dash)
        text = f"{words} inside the scene's rectangle at the window boundaries."
        yield f"series_{short}", text, _figure(axis, f"{words} ({name})", [line])

    kinetic, elastic = data["kinetic_energy"].values, data["elastic_energy"].values
    scale, name = pick_unit(ENERGY_UNITS, kinetic, elastic)
    yield (
        "series_energy",
        "Kinetic energy of the elements, and elastic energy of contacts"
        + (" and bonds." if "bonds" in effects else "."),
        _figure(
            axis,
            f"Energy ({name})",
            [
                (now, kinetic / scale, "kinetic", BLUE, "-"),
                (now, elastic / scale, "elastic", VERMILION, "--"),
            ],
        ),
    )
    yield (
        "series_speed",
        "Drift speed: area-weighted mean over the elements, and the fastest element.",
        _figure(
            axis,
            "Drift speed (m/s)",
            [
                (now, data["drift_speed"].values, "mean", BLUE, "-"),
                (now, data["largest_speed"].values, "largest", VERMILION, "--"),
            ],
        ),
    )
    displacement = data["mean_displacement"].values / 1e3
    farthest = data["largest_displacement"].values / 1e3
    yield (
        "series_displacement",
        "Net displacement since the start: area-weighted mean, and the farthest element.",
        _figure(
            axis,
            "Net displacement (km)",
            [
                (at, displacement, "mean", BLUE, "-o"),
                (at, farthest, "largest", VERMILION, "--s"),
            ],
        ),
    )
    if "bonds" in effects:
        yield (
            "series_bonds",
            "Bonds that hold.",
            _figure(axis, "Intact bonds (1)", [(now, data["intact_bonds"].values, "", GREEN, "-")]),
        )
    if "walls" in effects:
        yield _walls(data, axis, now)


Line = tuple[np.ndarray, np.ndarray, str, str, str]


def _walls(data: xr.Dataset, axis: str, now: np.ndarray) -> tuple[str, str, Figure]:
    names = dict.fromkeys(str(name)[:-2] for name in data if str(name).startswith("wall_force_"))
    push = [np.hypot(data[f"{name}_x"].values, data[f"{name}_y"].values) for name in names]
    scale, unit = pick_unit(FORCE_UNITS, *push)
    lines = [
        (now, force / scale, name.removeprefix("wall_force_"), colour, dash)
        for name, force, (colour, dash) in zip(names, push, cycle(WALL_STYLES), strict=False)
    ]
    text = "Force of the ice on each wall, its mean between two samples."
    return "series_walls", text, _figure(axis, f"Force on the wall ({unit})", lines)


def _figure(x_label: str, y_label: str, lines: list[Line]) -> Figure:
    with look():
        figure = new_figure(*SIZE)
        axes = figure.add_subplot()
        for x, y, label, colour, dash in lines:
            # Markers of many points run into one thick line.
            plain = dash.rstrip("os") if len(x) > MARKED else dash
            axes.plot(x, y, plain, color=colour, label=label, markersize=3.5)
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
        _style_axes(axes, [np.asarray(line[1], dtype=float) for line in lines])
        if len(lines) > 1:
            figure.legend(loc="outside upper right", ncols=2, fontsize=8.5)
    return figure


def _style_axes(axes: Axes, values: list[np.ndarray]) -> None:
    axes.grid(color=FAINT, alpha=0.25, linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.01)
    joined = np.concatenate(values)
    joined = joined[np.isfinite(joined)]
    if joined.size == 0:
        axes.text(0.5, 0.5, "no values", transform=axes.transAxes, ha="center")
        return
    low, high = float(joined.min()), float(joined.max())
    # From zero, unless the change would drown: then a margin of the change itself, and never an
    # axis so narrow that round-off looks like a signal.
    if low >= 0 and low <= 0.6 * high:
        axes.set_ylim(0, 1.08 * high or 1.0)
    else:
        pad = max(0.15 * (high - low), 1e-4 * abs(high), 1e-12)
        axes.set_ylim(low - pad, high + pad)
