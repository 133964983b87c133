# SPDX-License-Identifier: GPL-2.0-or-later
"""The analytic forcing as a CF NetCDF file on longitude and latitude, like a user's own.

A travelling cyclone, a steady gyre and uniform weather, with east and north components. The
forcing stage reads this file as it reads any other, so nothing of it is a special case.
"""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core import vectors
from floeflow.core.atomic_write import write_atomically
from floeflow.core.grids import EARTH_RADIUS, from_lonlat, scene_crs, scene_grid, to_lonlat
from floeflow.core.times import window_span
from floeflow.forcings import cf_variables
from floeflow.scene.blocks import Cyclone, Gyre, Scene, Weather
from floeflow.scene.effects import forcing_variables

Array = NDArray[np.float64]

# Steps of the file's latitudes over a cell of the scene grid, and its coarsest step (degrees).
STEPS_PER_CELL, COARSEST = 2.0, 1.0


def cyclone_wind(
    cyclone: Cyclone, x: Array, y: Array, time: float, northern: bool
) -> tuple[Array, Array]:
    """Wind of a Rankine vortex whose centre travels.

    v = V r/R inside the radius R, V R/r outside (Rankine 1858), anticlockwise in the north, turned
    by the inflow angle towards the centre.

    Parameters
    ----------
    cyclone : Cyclone
        The scene's block.
    x, y : ndarray
        Places in the scene's projection (m).
    time : float
        Since the scene's start (s).
    northern : bool
        Hemisphere.

    Returns
    -------
    u, v : ndarray
        Along the scene's axes (m/s).
    """
    dx, dy = x - (cyclone.x + cyclone.u * time), y - (cyclone.y + cyclone.v * time)
    # r/R inside, R/r outside, over r: without a division by zero in the centre.
    scale = cyclone.wind_speed / np.maximum(cyclone.radius, (dx**2 + dy**2) / cyclone.radius)
    turn = np.radians(cyclone.inflow_angle)
    spin = 1.0 if northern else -1.0
    around, inward = spin * scale * np.cos(turn), scale * np.sin(turn)
    return -around * dy - inward * dx, around * dx - inward * dy


def gyre_current(gyre: Gyre, x: Array, y: Array) -> tuple[Array, Array]:
    """Current of a gyre without divergence, v = V (r/R) exp((1 - (r/R)^2) / 2).

    Largest at r = R. Parameters and result as in `cyclone_wind`.

    Parameters
    ----------
    gyre : Gyre
        Centre (m), radius (m), largest speed (m/s) and sense.
    x : ndarray
        Places (m).
    y : ndarray
        Places (m).

    Returns
    -------
    tuple of ndarray
        Components (m/s).
    """
    dx, dy = (x - gyre.x) / gyre.radius, (y - gyre.y) / gyre.radius
    speed = gyre.current_speed * np.exp(0.5 * (1.0 - dx**2 - dy**2))
    spin = -1.0 if gyre.clockwise else 1.0
    return -spin * speed * dy, spin * speed * dx


def saturation_over_ice(temperature: Array | float) -> Array | float:
    """Saturation vapour pressure over ice (Pa) at a temperature (K): Murray (1967).

    Parameters
    ----------
    temperature : ndarray or float
        K.

    Returns
    -------
    ndarray or float
        Pa, of the shape of the temperature.
    """
    return 610.78 * np.exp(21.8745584 * (temperature - 273.16) / (temperature - 7.66))


def humidity(weather: Weather) -> float:
    """Specific humidity (kg/kg) of the weather's relative humidity over ice.

    Parameters
    ----------
    weather : Weather
        Block ``forcing.weather`` of the scene.

    Returns
    -------
    float
        kg/kg.
    """
    vapour = weather.relative_humidity * float(saturation_over_ice(weather.air_temperature))
    return 0.622 * vapour / (weather.air_pressure - 0.378 * vapour)


def lonlat_axes(lon: Array, lat: Array, spacing: float) -> tuple[Array, Array]:
    """Longitudes and latitudes (degrees) of a grid that holds all places.

    Parameters
    ----------
    lon, lat : ndarray
        Places, (ny, nx), of a rectangle with a margin.
    spacing : float
        Cell size of the scene grid (m).

    Returns
    -------
    lon, lat : ndarray
        Axes, at least two steps to a cell of the scene grid; all the way round where a pole is
        inside or the places span half the circle.
    """
    step = min(COARSEST, np.degrees(spacing / EARTH_RADIUS) / STEPS_PER_CELL)
    bottom, top = float(lat.min()) - 2 * step, float(lat.max()) + 2 * step
    # A lap around the rectangle's rim winds around a pole that lies inside.
    rim = np.concatenate([lon[0], lon[1:, -1], lon[-1, -2::-1], lon[-2:0:-1, 0], lon[0, :1]])
    turns = np.mod(np.diff(rim) + 180.0, 360.0) - 180.0
    east = rim[0] + np.concatenate([[0.0], np.cumsum(turns)])
    pole = abs(turns.sum()) > 180.0
    if pole:
        top, bottom = (90.0, bottom) if lat.mean() > 0 else (top, -90.0)
    top, bottom = min(top, 90.0), max(bottom, -90.0)
    rows = int(np.ceil((top - bottom) / step)) + 1
    # Columns as wide as rows are high where meridians are farthest apart.
    flat = float(np.cos(np.radians(max(bottom, -top, 0.0))))
    if pole or np.ptp(east) > 180.0:
        columns = int(np.ceil(360.0 / (step / flat)))
        return 360.0 * np.arange(columns) / columns, np.linspace(bottom, top, rows)
    first, last = float(east.min()) - 2 * step / flat, float(east.max()) + 2 * step / flat
    columns = int(np.ceil((last - first) / (step / flat))) + 1
    return np.linspace(first, last, columns), np.linspace(bottom, top, rows)


def make_analytic(scene: Scene, window: int) -> xr.Dataset:
    """Analytic forcing of one window.

    Parameters
    ----------
    scene : Scene
        Its domain, forcing, time and effects are read.
    window : int
        From 1.

    Returns
    -------
    xarray.Dataset
        CF variables on (time, lat, lon), east and north; only those that the effects need.
    """
    crs, grid = scene_crs(scene.domain), scene_grid(scene.domain)
    margin = grid.spacing
    x_rim = np.concatenate([[grid.x[0] - margin], grid.x, [grid.x[-1] + margin]])
    y_rim = np.concatenate([[grid.y[0] - margin], grid.y, [grid.y[-1] + margin]])
    places_lon, places_lat = to_lonlat(crs, *np.meshgrid(x_rim, y_rim))
    lon, lat = lonlat_axes(places_lon, places_lat, grid.spacing)
    mesh = np.meshgrid(lon, lat)
    x, y = from_lonlat(crs, *mesh)
    angle = vectors.north_angle(crs, *mesh)
    northern = bool(places_lat.mean() > 0)
    first, last = window_span(window, scene.time.window)
    count = round((last - first) / scene.forcing.step)
    time = first + scene.forcing.step * np.arange(count + 1)
    needed = forcing_variables(scene.effects)
    data: dict[str, Any] = {}

    def put(name: str, values: Array, units: str, standard_name: str) -> None:
        full = np.broadcast_to(values, (time.size, lat.size, lon.size)).astype(np.float32)
        attrs = {"units": units, "standard_name": standard_name}
        data[name] = (("time", "lat", "lon"), full, attrs)

    if "wind_u" in needed:
        wind = [cyclone_wind(scene.forcing.cyclone, x, y, float(t), northern) for t in time]
        east, north = vectors.map_to_east_north(
            np.stack([u for u, _ in wind]), np.stack([v for _, v in wind]), angle
        )
        put("u10", east, "m s-1", "eastward_wind")
        put("v10", north, "m s-1", "northward_wind")
    if "ocean_u" in needed:
        east, north = vectors.map_to_east_north(*gyre_current(scene.forcing.gyre, x, y), angle)
        put("uo", east, "m s-1", "eastward_sea_water_velocity")
        put("vo", north, "m s-1", "northward_sea_water_velocity")
    for name, value in _weather(scene.forcing.weather).items():
        if name in needed:
            quantity = cf_variables.QUANTITIES[name]
            put(quantity.common[0], np.array(value), quantity.si, quantity.standard[0])
    since = scene.time.start.isoformat(sep=" ")
    coords = {
        "time": ("time", time, {"units": f"seconds since {since}", "standard_name": "time"}),
        "lat": ("lat", lat, {"units": "degrees_north", "standard_name": "latitude"}),
        "lon": ("lon", lon, {"units": "degrees_east", "standard_name": "longitude"}),
    }
    coords["time"][2]["calendar"] = "standard"
    attrs = {"Conventions": "CF-1.10", "title": "Analytic cyclone, gyre and weather"}
    return xr.Dataset(data, coords=coords, attrs=attrs)


SEA_WEATHER = ("ocean_heat_flux", "sea_surface_temperature")


def _weather(weather: Weather) -> dict[str, float]:
    same = ("air_temperature", "air_pressure", "shortwave_down", "longwave_down", "snowfall")
    values = {name: float(getattr(weather, name)) for name in (*same, *SEA_WEATHER)}
    return values | {"specific_humidity": humidity(weather)}


def write_cf(data: xr.Dataset, path: Path) -> None:
    """Write a CF file whole or not at all, small because uniform fields pack well.

    Parameters
    ----------
    data : xarray.Dataset
        With CF attributes.
    path : Path
        NetCDF file, replaced in one step.

    Raises
    ------
    FloeError
        Where it cannot be written.
    """
    encoding: dict[str, dict[str, object]] = {
        str(name): {"_FillValue": None} for name in data.variables
    }
    for name in data.data_vars:
        encoding[str(name)] |= {"zlib": True, "complevel": 1}
    with write_atomically(path) as temporary:
        data.to_netcdf(temporary, engine="netcdf4", format="NETCDF4", encoding=encoding)
