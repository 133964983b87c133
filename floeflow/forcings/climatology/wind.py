# SPDX-License-Identifier: GPL-2.0-or-later
"""Pressure and wind: monthly centres, and storms of a seeded process that travel through them.

The wind at 10 m is 0.7 times the geostrophic one, turned by 25 degrees towards low pressure
(Proshutinsky and Johnson 1997: 0.7 and 30 degrees below 15 m/s, 0.8 and 20 degrees above).
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from floeflow.core.constants import AIR_DENSITY, EARTH_RADIUS, EARTH_ROTATION
from floeflow.core.monthly import at_day, east_north, unit
from floeflow.forcings.climatology import tables

Array = NDArray[np.float64]

SURFACE_SHARE, TURN = 0.7, np.radians(25.0)
# Blocks of this length (days) have storms of their own, whose seed is the block's number.
BLOCK = 5.0
LONGEST_LIFE = 8.0  # days


@dataclass(frozen=True)
class Track:
    """Where storms are born and where they go.

    Parameters
    ----------
    place : tuple of float
        Longitude and latitude (degrees) around which they are born.
    heading : float
        Degrees from north, clockwise.
    rate : float
        Storms in five days of winter.
    """

    place: tuple[float, float]
    heading: float
    rate: float


# Highs and lows in five days that are born anywhere beyond 60 degrees and go anywhere, and the
# spread of their depths (Pa): in all seasons they give the 4 to 6 m/s of the central Arctic
# (Przybylak 2003; drifting stations: about 5 m/s the year round).
WANDERERS, WANDERER_DEPTH = 14.0, 2.2e3
# Regions after Serreze (1995): the North Atlantic, Norwegian, Kara and Laptev Seas, Baffin Bay, and
# from the Pacific; in the south a belt around the continent (Simmonds and Keay 2000).
TRACKS_NORTH = (
    Track((-35.0, 62.0), 55.0, 1.5),
    Track((3.0, 68.0), 65.0, 1.4),
    Track((60.0, 74.0), 60.0, 0.5),
    Track((130.0, 74.0), 20.0, 0.4),
    Track((-60.0, 66.0), 350.0, 0.3),
    Track((-178.0, 68.0), 20.0, 0.4),
)
TRACKS_SOUTH = tuple(Track((lon, -58.0), 110.0, 0.5) for lon in range(-180, 180, 60))


@dataclass(frozen=True)
class Storm:
    """One storm: birth and life (days since 1 January 2000), path, depth (Pa) and width (m).

    A high has a negative depth.
    """

    birth: float
    life: float
    start: Array
    way: Array
    speed: float
    depth: float
    width: float

    def strength(self, day: float) -> float:
        """Share of its depth that it has.

        Parameters
        ----------
        day : float
            Since 1 January 2000.

        Returns
        -------
        float
            0 to 1.
        """
        age = (day - self.birth) / self.life
        return float(np.sin(np.pi * age) ** 2) if 0.0 < age < 1.0 else 0.0

    def centre(self, day: float) -> Array:
        """Unit vector of its centre, which moves on a great circle.

        Parameters
        ----------
        day : float
            Since 1 January 2000.

        Returns
        -------
        ndarray
            (3,).
        """
        angle = self.speed * (day - self.birth) * 86400.0 / EARTH_RADIUS
        return np.asarray(np.cos(angle) * self.start + np.sin(angle) * self.way)


def storms(seed: int, first: float, last: float, northern: bool, storminess: float) -> list[Storm]:
    """Storms that live at some time between two days (since 1 January 2000).

    Parameters
    ----------
    seed : int
        Of the random numbers.
    first : float
        Days since 1 January 2000.
    last : float
        Days since 1 January 2000.
    northern : bool
        Whether those of the northern hemisphere are wanted, else of the southern.
    storminess : float
        Factor on their number (1).

    Returns
    -------
    list of Storm
        Each with its birth and life (days).
    """
    found = []
    begin = int(np.floor((first - LONGEST_LIFE) / BLOCK))
    for block in range(begin, int(np.floor(last / BLOCK)) + 1):
        # Negative numbers are no seeds: those of blocks long before 2000 come round from above.
        rng = np.random.Generator(np.random.PCG64([seed, (block + 100_000) % 2**32, int(northern)]))
        season = _winter(block * BLOCK, northern)
        for track in TRACKS_NORTH if northern else TRACKS_SOUTH:
            count = int(rng.poisson(storminess * track.rate * (0.7 + 0.3 * season)))
            found += [_storm(rng, track, block * BLOCK, season) for _ in range(count)]
        count = int(rng.poisson(storminess * WANDERERS))
        found += [_wanderer(rng, northern, block * BLOCK) for _ in range(count)]
    return [storm for storm in found if storm.birth < last and storm.birth + storm.life > first]


def _winter(day: float, northern: bool) -> float:
    """1 in the middle of winter, 0 in the middle of summer."""
    phase = np.cos(2.0 * np.pi * (day - 20.0) / 365.25)
    return float(0.5 + 0.5 * (phase if northern else -phase))


def _storm(rng: np.random.Generator, track: Track, day: float, season: float) -> Storm:
    lon = track.place[0] + rng.normal(0.0, 10.0)
    lat = float(np.clip(track.place[1] + rng.normal(0.0, 3.0), -75.0, 82.0))
    east, north = east_north(np.array(lon), np.array(lat))
    heading = np.radians(track.heading + rng.normal(0.0, 25.0))
    return Storm(
        birth=day + rng.uniform(0.0, BLOCK),
        life=rng.uniform(3.0, LONGEST_LIFE),
        start=unit(np.array(lon), np.array(lat)),
        way=np.sin(heading) * east + np.cos(heading) * north,
        speed=rng.uniform(4.0, 12.0),
        depth=1e2 * rng.uniform(10.0, 20.0 + 12.0 * season),
        width=rng.uniform(3.0e5, 5.5e5),
    )


def _wanderer(rng: np.random.Generator, northern: bool, day: float) -> Storm:
    """A high or low of no track: the weather between storms."""
    sine = rng.uniform(np.sin(np.radians(60.0)), 1.0)
    lon, lat = rng.uniform(-180.0, 180.0), np.degrees(np.arcsin(sine)) * (1 if northern else -1)
    east, north = east_north(np.array(lon), np.array(lat))
    heading = rng.uniform(0.0, 2.0 * np.pi)
    return Storm(
        birth=day + rng.uniform(0.0, BLOCK),
        life=rng.uniform(3.0, LONGEST_LIFE),
        start=unit(np.array(lon), np.array(lat)),
        way=np.sin(heading) * east + np.cos(heading) * north,
        speed=rng.uniform(1.0, 8.0),
        depth=rng.normal(0.0, WANDERER_DEPTH),
        width=rng.uniform(4.5e5, 7.0e5),
    )


def pressure_and_wind(
    lon: Array,
    lat: Array,
    start: datetime,
    seconds: Array,
    days: Array,
    seed: int,
    storminess: float,
) -> tuple[Array, Array, Array]:
    """Pressure at sea level (Pa) and wind towards east and north (m/s), (times, places) each.

    Parameters
    ----------
    lon, lat : ndarray
        Degrees, (places,), all of one hemisphere.
    start : datetime
        Time 0.
    seconds, days : ndarray
        Times since then, and their days of the year, (times,).
    seed : int
        Of the storms.
    storminess : float
        Factor of their number.

    Returns
    -------
    pressure : ndarray
        Pa, (times, places).
    east, north : ndarray
        m/s, (times, places) each.
    """
    northern = bool(lat.mean() > 0)
    here, (east, north) = unit(lon, lat), east_north(lon, lat)
    tabled = tables.PRESSURE_NORTH if northern else tables.PRESSURE_SOUTH
    pressure = np.repeat(1e2 * at_day(np.array(tabled, float), days)[:, None], lon.size, axis=1)
    slope_e, slope_n = np.zeros_like(pressure), np.zeros_like(pressure)

    def add(row: Array | slice, height: Array, centre: Array, width: float) -> None:
        steep = (EARTH_RADIUS / width) ** 2
        bell = np.atleast_1d(height)[:, None] * np.exp((here @ centre - 1.0) * steep)
        pressure[row] += bell
        slope_e[row] += bell * steep / EARTH_RADIUS * (east @ centre)
        slope_n[row] += bell * steep / EARTH_RADIUS * (north @ centre)

    centres = tables.CENTRES_NORTH if northern else tables.CENTRES_SOUTH
    for (centre_lon, centre_lat), width, months in centres.values():
        centre = unit(np.array(float(centre_lon)), np.array(float(centre_lat)))
        add(slice(None), 1e2 * at_day(np.array(months, float), days), centre, width)
    if not northern:
        height, middle, width = tables.RIDGE_SOUTH
        ridge = 1e2 * height * np.exp(-0.5 * ((lat - middle) / width) ** 2)
        pressure += ridge - 1e2 * height * np.exp(-0.5 * ((66.0 + middle) / width) ** 2)
        slope_n += -ridge * (lat - middle) / width**2 / np.radians(EARTH_RADIUS)
    since = (start - datetime(2000, 1, 1)) / timedelta(days=1) + seconds / 86400.0
    living = storms(seed, float(since.min()), float(since.max()), northern, storminess)
    for row, day in enumerate(since.tolist()):
        for storm in living:
            if (strength := storm.strength(day)) > 0.0:
                depth = np.array(-storm.depth * strength)
                add(slice(row, row + 1), depth, storm.centre(day), storm.width)
    coriolis = 2.0 * EARTH_ROTATION * np.sin(np.radians(lat))
    scale = SURFACE_SHARE / (AIR_DENSITY * coriolis)
    u, v = -slope_n * scale, slope_e * scale
    turn = TURN if northern else -TURN
    return pressure, u * np.cos(turn) - v * np.sin(turn), u * np.sin(turn) + v * np.cos(turn)
