# SPDX-License-Identifier: GPL-2.0-or-later
"""The map with a time slider: fields of all windows as 8-bit frames, and the lines over them.

A field of a year has hundreds of frames. Each value becomes one byte (0: no ice, 1 to 255: from the
low to the high end of the scale), all frames of a field are deflated together and written in
base64. The page inflates them with the browser's own DecompressionStream and draws them on a
canvas, so that nothing is loaded from elsewhere.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, cast

import contourpy
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.constants import ICE_DENSITY
from floeflow.report.box_drift import box_drift
from floeflow.report.figures.frame import Frame, graticule_lines
from floeflow.report.figures.style import Quantity, common_limits, nice_step

SECONDS_PER_DAY = 86400.0
# Values of a byte: 0 says that there is no ice.
LEVELS = 255
# Steps of the scale of fields that change from window to window: all 254 would be noise that does
# not deflate, and a year's report would have 10 MB.
COARSE = 62
# More frames than this add nothing that an eye can follow, and cost a reader's memory.
MOST_FRAMES = 1500

Bytes = NDArray[np.uint8]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class MapField:
    """A field that the map can show.

    Parameters
    ----------
    title : str
        On its button.
    unit : str
        Of the numbers that a reader sees.
    scale : float
        From the file's unit to that one.
    quantity : Quantity
        Colours and ends of the scale, in the reader's unit.
    needs : tuple of str
        Variables of the file without which it is absent; they are its source.
    text : str
        What it is, in a sentence.
    file : str
        Which file of the run holds them.
    steps : int
        Of the scale, that the page can tell apart; even.
    """

    title: str
    unit: str
    scale: float
    quantity: Quantity
    needs: tuple[str, ...]
    text: str
    file: str = "grid.nc"
    steps: int = LEVELS - 1


TENDENCIES = "tendencies.nc"
# From kg m-2 s-1 to centimetres of ice a day.
CENTIMETRES = 100.0 * SECONDS_PER_DAY / ICE_DENSITY

FIELDS: dict[str, MapField] = {
    "thickness": MapField(
        "Thickness",
        "m",
        1.0,
        Quantity("thickness", "", "dense", share=0.995),
        ("sithick",),
        "Ice thickness, mean over the ice in each cell.",
    ),
    "concentration": MapField(
        "Concentration",
        "%",
        100.0,
        Quantity("concentration", "", "ice", 0.0, 100.0),
        ("siconc",),
        "Ice concentration, share of each cell's sea under ice.",
    ),
    "drift": MapField(
        "Drift",
        "cm/s",
        100.0,
        Quantity("drift", "", "amp", share=0.99),
        ("siu", "siv"),
        "Drift speed; arrows show where the ice goes.",
        steps=COARSE,
    ),
    "deformation": MapField(
        "Deformation",
        "% per day",
        100.0 * SECONDS_PER_DAY,
        Quantity("deformation", "", "matter", share=0.98),
        ("sidivvel", "sishevel"),
        "Total deformation rate: the root of divergence squared plus shear squared.",
        steps=COARSE,
    ),
    "damage": MapField(
        "Damage",
        "%",
        100.0,
        Quantity("damage", "", "turbid", 0.0, 100.0),
        ("damage",),
        "Share of the outline of the elements that no bond holds.",
    ),
    "ridged": MapField(
        "Ridged ice",
        "%",
        100.0,
        Quantity("ridged", "", "speed", 0.0, share=0.995),
        ("sirdgconc",),
        "Share of the ice's area that is ridged.",
    ),
    "leads": MapField(
        "Leads",
        "%",
        100.0,
        Quantity("leads", "", "deep", 0.0, 30.0),
        ("lead_fraction",),
        "Open water inside of the pack: cells with at least 70 % ice.",
    ),
    "snow": MapField(
        "Snow",
        "cm",
        100.0,
        Quantity("snow", "", "tempo", share=0.995),
        ("sisnthick",),
        "Snow thickness, mean over the ice in each cell.",
    ),
    "pressure": MapField(
        "Pressure",
        "kN/m",
        -1e-3,
        Quantity("pressure", "", "rain", None, share=0.98),
        ("sistresave",),
        "Mean compression in the ice over its thickness; below 0 in tension.",
        steps=COARSE,
    ),
    "shear_stress": MapField(
        "Shear stress",
        "kN/m",
        1e-3,
        Quantity("shear_stress", "", "amp", share=0.98),
        ("sistremax",),
        "Largest shear stress in the ice over its thickness.",
        steps=COARSE,
    ),
    "age": MapField(
        "Age",
        "days",
        1.0 / SECONDS_PER_DAY,
        Quantity("age", "", "algae", share=0.995),
        ("siage",),
        "Time since the ice froze on open water, at most since the start of the run.",
    ),
    "growth": MapField(
        "Growth and melt",
        "cm/day",
        CENTIMETRES,
        Quantity("growth", "", "balance_r", share=0.98, signed=True),
        ("sidmassth",),
        "Ice that froze (above 0) or melted, per area of sea, mean of the window that ends here.",
        TENDENCIES,
        COARSE,
    ),
    "moved": MapField(
        "Moved in",
        "cm/day",
        CENTIMETRES,
        Quantity("moved", "", "balance_r", share=0.98, signed=True),
        ("sidmassdyn",),
        "Ice that drifted in (above 0) or away, per area of sea, mean of the window that ends "
        "here.",
        TENDENCIES,
        COARSE,
    ),
}


@dataclass(frozen=True)
class Layer:
    """A field of the map as the page takes it.

    Parameters
    ----------
    name : str
        Key in ``FIELDS``.
    low, high : float
        Ends of the colour scale in the reader's unit.
    beyond, below : bool
        Values lie beyond the high end, or below the low one.
    data : str
        Frames, deflated, in base64.
    palette : str
        255 colours of three bytes, in base64.
    """

    name: str
    low: float
    high: float
    beyond: bool
    below: bool
    data: str
    palette: str


def field_frames(grid: xr.Dataset, name: str) -> Array | None:
    """A field at all times in the reader's unit, NaN where there is none, (time, y, x).

    Parameters
    ----------
    grid : xarray.Dataset
        Gridded output, concentration as a share.
    name : str
        Key in ``FIELDS``.

    Returns
    -------
    ndarray or None
        None where the scene's effects do not bring the field.
    """
    field = FIELDS[name]
    if any(need not in grid for need in field.needs):
        return None
    parts = [np.asarray(grid[need].values, dtype=float) for need in field.needs]
    values = np.hypot(*parts) if len(parts) == 2 else parts[0]
    there = np.asarray(grid["siconc"].values) > 0
    if field.file == TENDENCIES:
        # Ice that has left or melted away changed the cell as well.
        there = there | (np.abs(values) > 0.0)
    return np.where(there, values * field.scale, np.nan)


def with_tendencies(grid: xr.Dataset, tendencies: xr.Dataset | None) -> xr.Dataset:
    """Fields of the grid with those tendencies that the map shows.

    Parameters
    ----------
    grid : xarray.Dataset
        Gridded output at window boundaries, with ``window`` numbers.
    tendencies : xarray.Dataset or None
        Means over windows, (time, y, x), with the numbers of the windows; None: there are none.

    Returns
    -------
    xarray.Dataset
        The mean over a window stands at its end, and is missing at the start of the run.
    """
    if tendencies is None:
        return grid
    wanted = [need for each in FIELDS.values() if each.file == TENDENCIES for need in each.needs]
    ends = np.searchsorted(tendencies["window"].values, grid["window"].values)
    known = np.isin(grid["window"].values, tendencies["window"].values)
    added = {}
    for name in wanted:
        values = np.full((grid.sizes["time"], grid.sizes["y"], grid.sizes["x"]), np.nan)
        values[known] = tendencies[name].values[ends[known]]
        added[name] = (("time", "y", "x"), values)
    return grid.assign(added)


def encode_frames(values: Array, low: float, high: float, steps: int = LEVELS - 1) -> Bytes:
    """Values as bytes: 0 where not finite, 1 at the low end, 255 at the high end and beyond.

    Parameters
    ----------
    values : ndarray
        In any unit and shape.
    low : float
        Ends of the scale, in the same unit.
    high : float
        Ends of the scale, in the same unit.
    steps : int, optional
        Of the scale; an even number has a byte for its middle.

    Returns
    -------
    Bytes
        Of the shape of the values.
    """
    share = np.clip((values - low) / (high - low), 0.0, 1.0)
    known = np.isfinite(values)
    step = np.rint(np.where(known, share, 0.0) * steps)
    return np.where(known, 1 + np.rint(step * ((LEVELS - 1) / steps)), 0).astype(np.uint8)


def packed(data: Bytes | NDArray[np.int8]) -> str:
    """Bytes deflated (zlib) and in base64.

    Parameters
    ----------
    data : Bytes or ndarray
        Of any shape.

    Returns
    -------
    str
        ASCII.
    """
    return base64.b64encode(zlib.compress(data.tobytes(), 9)).decode()


def palette_of(quantity: Quantity) -> str:
    """The colours of levels 1 to 255 as bytes in base64.

    Parameters
    ----------
    quantity : Quantity
        With its colours and scale.

    Returns
    -------
    str
        Red, green and blue of each level, in base64.
    """
    colours = quantity.cmap(np.linspace(0.0, 1.0, LEVELS))[:, :3]
    return base64.b64encode(np.rint(255 * colours).astype(np.uint8).tobytes()).decode()


def make_layers(grid: xr.Dataset) -> Iterator[Layer]:
    """The fields that the gridded output holds, rows from the top of the map down.

    Parameters
    ----------
    grid : xarray.Dataset
        On ``time``, ``y`` and ``x``.

    Yields
    ------
    Layer
        Frames and colours of one field.
    """
    for name, field in FIELDS.items():
        values = field_frames(grid, name)
        if values is None:
            continue
        low, high = scale_ends(field.quantity, values)
        frames = encode_frames(values[:, ::-1], low, high, field.steps)
        beyond = bool(np.nanmax(values, initial=high) > high)
        below = bool(np.nanmin(values, initial=low) < low)
        yield Layer(name, low, high, beyond, below, packed(frames), palette_of(field.quantity))


def scale_ends(quantity: Quantity, values: Array) -> tuple[float, float]:
    """Ends of the colour scale of a field at all times, the high one a number that reads well.

    Parameters
    ----------
    quantity : Quantity
        Whose scale may be fixed.
    values : ndarray
        At all times.

    Returns
    -------
    tuple of float
        In the unit of the values.
    """
    if quantity.signed:
        _, high = common_limits(quantity, np.abs(values))
        return -round_up(high), round_up(high)
    low, high = common_limits(quantity, values)
    low = -round_up(-low) if quantity.low is None and low < 0.0 else low
    return low, round_up(high) if quantity.high is None else high


def round_up(value: float) -> float:
    """The next number of one digit and a half, so that a colour bar ends well.

    Parameters
    ----------
    value : float
        Above 0, in any unit.

    Returns
    -------
    float
        Not below the value.
    """
    step = nice_step(value, 6)
    return float(np.ceil(value / step - 1e-9) * step)


def drift_arrows(grid: xr.Dataset) -> dict[str, Any] | None:
    """Drift of boxes of cells at all times, as bytes of a common scale.

    Parameters
    ----------
    grid : xarray.Dataset
        On ``time``, ``y`` and ``x``.

    Returns
    -------
    dict or None
        ``columns`` and ``rows`` of boxes, each of ``cells`` cells a side; ``data``: u, then v, of
        all times, each (time, row, column) from the top down, 127 being ``top`` (cm/s). None
        without drift.
    """
    boxes = box_drift(grid)
    if boxes is None:
        return None
    top = boxes.top
    data = np.stack([np.clip(np.rint(127 * box / top), -127, 127) for box in (boxes.u, boxes.v)])
    _, rows, columns = boxes.u.shape
    return {
        "rows": rows,
        "columns": columns,
        "cells": boxes.cells,
        "above": boxes.above,
        "top": 100.0 * top,
        "data": packed(data.astype(np.int8)),
    }


def land_path(land: xr.DataArray) -> str:
    """Land of the mask as an SVG path in kilometres, y downward.

    Parameters
    ----------
    land : xarray.DataArray
        Share of land, (y, x).

    Returns
    -------
    str
        The attribute ``d`` of a path.
    """
    values = np.pad(np.asarray(land.values, dtype=float), 1, mode="edge")
    x, y = (padded_axis(land[axis].values / 1e3) for axis in ("x", "y"))
    if values.max() < 0.5:
        return ""
    generator = contourpy.contour_generator(x, y, values, fill_type=contourpy.FillType.OuterOffset)
    polygons, codes = cast(tuple[list[Array], list[Array]], generator.filled(0.5, np.inf))
    parts = []
    for points, offsets in zip(polygons, codes, strict=True):
        for start, end in zip(offsets[:-1], offsets[1:], strict=True):
            parts.append(svg_line(points[start:end]) + "Z")
    return "".join(parts)


def padded_axis(axis: Array) -> Array:
    """Cell centres with one more at each end.

    Parameters
    ----------
    axis : ndarray
        Ascending, (n,).

    Returns
    -------
    ndarray
        (n + 2,).
    """
    step = axis[1] - axis[0] if axis.size > 1 else 1.0
    return np.concatenate([[axis[0] - step], axis, [axis[-1] + step]])


def svg_line(points: Array) -> str:
    """Points (km) as moves of an SVG path, to the tenth of a kilometre.

    Parameters
    ----------
    points : ndarray
        (n, 2).

    Returns
    -------
    str
        Part of the attribute ``d`` of a path; y is turned downward.
    """
    first, rest = points[0], points[1:]
    head = f"M{first[0]:.1f} {-first[1]:.1f}"
    return head + ("L" + " ".join(f"{x:.1f} {-y:.1f}" for x, y in rest) if len(rest) else "")


def graticule_path(frame: Frame) -> tuple[str, list[tuple[float, float, str]]]:
    """Parallels and meridians as one SVG path, and their labels with places (km, y downward).

    Parameters
    ----------
    frame : Frame
        Projection and extent of the map.

    Returns
    -------
    path : str
        The attribute ``d`` of a path.
    labels : list of tuple
        x and y (km) and text of each.
    """
    lines, labels = graticule_lines(frame)
    parts = []
    for x, y in lines:
        known = np.isfinite(x) & np.isfinite(y)
        cuts = np.flatnonzero(np.diff(known.astype(int))) + 1
        for piece in np.split(np.arange(x.size), cuts):
            if known[piece[0]] and piece.size > 1:
                kept = piece[::6] if piece[-1] in piece[::6] else np.append(piece[::6], piece[-1])
                parts.append(svg_line(np.stack([x[kept], y[kept]], axis=1)))
    return "".join(parts), [(x, -y, text) for x, y, text in labels]


def chosen_frames(count: int) -> NDArray[np.int64]:
    """Which times the map shows: all, or evenly spread ones where there are thousands.

    Parameters
    ----------
    count : int
        Number of times.

    Returns
    -------
    ndarray
        Indices, ascending.
    """
    step = max(1, int(np.ceil(count / MOST_FRAMES)))
    chosen = np.arange(0, count, step)
    return chosen if chosen[-1] == count - 1 else np.append(chosen, count - 1)


def time_labels(start: datetime, seconds: Iterable[float]) -> list[str]:
    """Times as a reader takes them: dates alone where all are midnights.

    Parameters
    ----------
    start : datetime
        Of the scene.
    seconds : iterable of float
        Since the start (s).

    Returns
    -------
    list of str
        Such as ``31 Dec 1981``.
    """
    moments = [start + timedelta(seconds=float(each)) for each in seconds]
    whole = all((at.hour, at.minute, at.second) == (0, 0, 0) for at in moments)
    return [f"{at:%d %b %Y}" if whole else f"{at:%d %b %Y %H:%M}" for at in moments]


def make_player(
    grid: xr.Dataset, frame: Frame, start: datetime, window: float
) -> dict[str, Any] | None:
    """All that the page needs for its map.

    Parameters
    ----------
    grid : xarray.Dataset
        Gridded output at all times, concentration as a share, with ``window`` numbers.
    frame : Frame
        Land, projection, extent.
    start : datetime
        The scene's start.
    window : float
        Length of a window (s).

    Returns
    -------
    dict or None
        ``layers`` (each with data, palette, words and ends of its scale), ``arrows``, ``times``,
        ``rows``, ``columns``, ``extent`` (km), ``land``, ``graticule``, ``labels``, ``bar``. None
        where the grid holds no time.
    """
    if not grid.sizes.get("time", 0):
        return None
    shown = grid.isel(time=chosen_frames(grid.sizes["time"]))
    left, right, bottom, top = frame.extent
    path, labels = graticule_path(frame)
    layers = []
    for layer in make_layers(shown):
        field = FIELDS[layer.name]
        words = {"title": field.title, "unit": field.unit, "text": field.text}
        layers.append(
            {
                **words,
                "name": layer.name,
                "low": layer.low,
                "high": layer.high,
                "beyond": layer.beyond,
                "below": layer.below,
                "none": "no value" if field.file == TENDENCIES else "no ice",
                "data": layer.data,
                "palette": layer.palette,
                "source": f"{field.file}: " + ", ".join(field.needs),
            }
        )
    return {
        "layers": layers,
        "arrows": drift_arrows(shown),
        "times": time_labels(start, shown["window"].values * window),
        "rows": shown.sizes["y"],
        "columns": shown.sizes["x"],
        "extent": (left, right, bottom, top),
        "land": land_path(frame.land),
        "graticule": path,
        "labels": labels,
        "bar": nice_step(right - left, 5),
    }
