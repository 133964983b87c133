# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of places and times that users have: tracks of buoys, series of thickness.

Three layouts of columns are known: ``id, time, lon, lat`` in any order; that of the International
Arctic Buoy Programme (``BuoyID Year ... POS_DOY Lat Lon``, the day of the year from 1); one file a
buoy with ``datetime, latitude, longitude`` as in the archive of the MOSAiC buoys (Bliss et al.
2023), whose name is the id. Columns are parted by commas, semicolons, tabs or blanks; lines that
begin with ``#`` are left out; times without a zone are UTC.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from floeflow.core.errors import FloeError

Array = NDArray[np.float64]

TIMES = ("time", "datetime", "date_time", "timestamp", "date", "date/time")
COLUMNS = {
    "id": ("id", "buoyid", "buoy_id", "buoy", "imei", "sensor_id"),
    "lon": ("lon", "longitude", "long"),
    "lat": ("lat", "latitude"),
    "thickness": ("thickness", "sithick", "ice_thickness", "sea_ice_thickness"),
    "year": ("year",),
    "day": ("pos_doy", "doy"),
}
# What products write for nothing.
MISSING = ("", "nan", "na", "null", "-999", "-999.0", "-999.00", "-9999", "999.99")


@dataclass(frozen=True)
class Points:
    """Places in the order of time.

    Attributes
    ----------
    path : Path
        The file.
    id : ndarray
        Names of the tracks, (point,).
    seconds : ndarray
        Since the scene's start, (point,).
    lon, lat : ndarray
        Degrees, (point,).
    thickness : ndarray or None
        Metres, (point,).
    """

    path: Path
    id: NDArray[np.str_]
    seconds: Array
    lon: Array
    lat: Array
    thickness: Array | None = None


def read_points(path: Path, start: datetime, thickness: bool = False) -> Points:
    """Read a table of places.

    Parameters
    ----------
    path : Path
        The file.
    start : datetime
        Of the scene, UTC.
    thickness : bool
        Whether there must be a column with the thickness of the ice (m).

    Raises
    ------
    FloeError
        Where the file is missing, has none of the layouts, or a line makes no sense.
    """
    rows = _lines(path)
    if not rows:
        raise FloeError(f"{path}: holds no line")
    number, head = rows[0]
    separator = next((sign for sign in ("\t", ";", ",") if sign in head), None)
    names = [_plain(name) for name in head.split(separator)]
    place = {
        key: next((names.index(name) for name in known if name in names), None)
        for key, known in (COLUMNS | {"time": TIMES}).items()
    }
    needed = ["lon", "lat", *(["thickness"] if thickness else [])]
    absent = [key for key in needed if place[key] is None]
    dated = place["time"] is not None or (place["year"] is not None and place["day"] is not None)
    if absent or not dated:
        lacking = [*absent, *([] if dated else ["time"])]
        raise FloeError(
            f"{path}: line {number} names no column for {', '.join(lacking)}; there are "
            f"{', '.join(names)}"
        )
    ids, values = [], []
    for number, line in rows[1:]:
        cells = [cell.strip().strip('"') for cell in line.split(separator)]
        if len(cells) < len(names):
            raise FloeError(f"{path}: line {number} has {len(cells)} columns, not {len(names)}")
        wanted = {key: cells[at] for key, at in place.items() if at is not None}
        if any(wanted[key].lower() in MISSING for key in needed):
            continue
        where = f"{path}: line {number}"
        seconds = _seconds(wanted, start, where)
        row = [seconds, *(_number(wanted[key], key, where) for key in needed)]
        if not (-360.0 <= row[1] <= 360.0 and -90.0 <= row[2] <= 90.0):
            raise FloeError(f"{where}: longitude {row[1]:g} and latitude {row[2]:g} are no place")
        ids.append(wanted.get("id") or path.stem)
        values.append(row)
    if not values:
        raise FloeError(f"{path}: no line below its names has a place")
    data = np.array(values)
    order = np.argsort(data[:, 0], kind="stable")
    data, names_of = data[order], np.array(ids)[order]
    depth = data[:, 3] if thickness else None
    if depth is not None and (depth.min() < 0.0 or depth.max() > 50.0):
        raise FloeError(
            f"{path}: thickness reaches from {depth.min():g} to {depth.max():g} m, outside 0 to "
            "50 m"
        )
    return Points(path, names_of, data[:, 0], data[:, 1], data[:, 2], depth)


def _lines(path: Path) -> list[tuple[int, str]]:
    """Numbers and texts of the lines that say something."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise FloeError(f"{path}: there is no such file") from None
    except (OSError, ValueError):
        raise FloeError(f"{path}: cannot be read as text") from None
    lines = enumerate(text.splitlines(), start=1)
    return [(number, line.strip()) for number, line in lines if line.strip()[:1] not in ("", "#")]


def _plain(name: str) -> str:
    """A column's name without its unit: 'Latitude (deg)' is latitude."""
    bare = re.sub(r"[\[(].*?[\])]", "", name.strip().strip('"')).strip().lower()
    return re.sub(r"\s+", "_", bare)


def _number(text: str, what: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise FloeError(f"{where}: {what} '{text}' is not a number") from None
    if not np.isfinite(value):
        raise FloeError(f"{where}: {what} '{text}' is not a number")
    return value


def _seconds(row: dict[str, str], start: datetime, where: str) -> float:
    """Time of a line since the scene's start (s)."""
    if "time" in row:
        try:
            moment = datetime.fromisoformat(row["time"].replace("/", "-").replace("Z", "+00:00"))
        except ValueError:
            raise FloeError(
                f"{where}: time '{row['time']}' is not a date like 2020-01-31 06:00:00"
            ) from None
    else:
        year, day = (_number(row[key], key, where) for key in ("year", "day"))
        if not (1900 <= year <= 2200 and 1.0 <= day < 368.0):
            raise FloeError(f"{where}: year {year:g} and day {day:g} are not a date")
        moment = datetime(int(year), 1, 1) + timedelta(days=day - 1.0)
    if moment.tzinfo is not None:
        moment = moment.astimezone(UTC).replace(tzinfo=None)
    return (moment - start.replace(tzinfo=None)).total_seconds()
