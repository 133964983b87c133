# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of many daily windows of `smoke`, in chunks, under weather that knows the date."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import xarray as xr
import yaml

from floeflow.core.grids import from_lonlat, scene_crs, scene_grid, to_lonlat
from floeflow.core.plugin import plugin_path
from floeflow.core.vectors import map_to_east_north, north_angle
from floeflow.coupling import initial
from floeflow.coupling.chunk import Chunk, run_chunk
from floeflow.forcings import analytic, cf_variables
from floeflow.masks import land, mask
from floeflow.packings import bonds, packing
from floeflow.packings import fresh_cells as cells
from floeflow.scene import Scene, load_scene
from floeflow.scene.effects import forcing_variables
from floeflow.scene.windows import window_chunks
from floeflow.state import write_dataset, write_state

DAY = 86400.0
# Storms cross the scene one after the other, each so many days long.
STORM_DAYS = 5.0
# Of the forcing file's grid, m: coarser than the scene's.
SPACING = 4.0e5
EPOCH = datetime(1900, 1, 1)


def season(date: datetime) -> float:
    """From -1 on 20 January to 1 half a year later."""
    days = (date - datetime(date.year, 1, 20)).total_seconds() / DAY
    return float(-np.cos(2.0 * np.pi * days / 365.25))


def weather(date: datetime) -> dict[str, float]:
    """Weather of a date, SI units: 240 K in winter, thaw and a low sun all day in summer."""
    warm = season(date)
    temperature = 258.0 + 17.5 * warm
    vapour = 0.9 * float(analytic.saturation_over_ice(temperature))
    return {
        "air_temperature": temperature,
        "specific_humidity": 0.622 * vapour / (1.01e5 - 0.378 * vapour),
        "air_pressure": 1.01e5,
        "shortwave_down": max(0.0, 280.0 * warm),
        "longwave_down": 230.0 + 70.0 * warm,
        "snowfall": 3e-6 * (1.0 - 0.8 * warm),
        "ocean_heat_flux": 4.0 + 2.0 * warm,
    }


def forcing_file(scene: Scene, path: Path, days: int) -> None:
    """Write daily weather, storms and the gyre as one CF file, in days since 1900."""
    crs, grid = scene_crs(scene.domain), scene_grid(scene.domain)
    wide = [np.append(axis[0] - grid.spacing, [*axis, axis[-1] + grid.spacing]) for axis in
            (grid.x, grid.y)]  # fmt: skip
    lon, lat = analytic.lonlat_axes(*to_lonlat(crs, *np.meshgrid(*wide)), SPACING)
    mesh = np.meshgrid(lon, lat)
    (x, y), angle = from_lonlat(crs, *mesh), north_angle(crs, *mesh)
    dates = [scene.time.start + timedelta(days=k) for k in range(days + 1)]
    first = (scene.time.start - EPOCH).total_seconds() / DAY
    ages = np.mod(first + np.arange(days + 1), STORM_DAYS) * DAY
    storm = [analytic.cyclone_wind(scene.forcing.cyclone, x, y, age, True) for age in ages]
    vectors = {
        "wind": np.stack([np.stack(part) for part in zip(*storm, strict=True)]),
        "ocean": np.stack(analytic.gyre_current(scene.forcing.gyre, x, y))[:, None],
    }
    said = {"wind": ("u10", "v10", "ward_wind"), "ocean": ("uo", "vo", "ward_sea_water_velocity")}
    shape = (days + 1, len(lat), len(lon))
    data = {}
    for kind, (u, v) in vectors.items():
        turned = map_to_east_north(u, v, angle)
        for name, way, values in zip(said[kind], ("east", "north"), turned, strict=False):
            attrs = {"units": "m s-1", "standard_name": way + said[kind][2]}
            whole = np.broadcast_to(values, shape).astype(np.float32)
            data[name] = (("time", "lat", "lon"), whole, attrs)
    series = [weather(date) for date in dates]
    for name in forcing_variables(scene.effects):
        if name in series[0]:
            quantity = cf_variables.QUANTITIES[name]
            values = np.array([each[name] for each in series])[:, None, None]
            attrs = {"units": quantity.si, "standard_name": quantity.standard[0]}
            whole = np.broadcast_to(values, shape).astype(np.float32)
            data[quantity.common[0]] = (("time", "lat", "lon"), whole, attrs)
    clock = {"units": "days since 1900-01-01", "standard_name": "time", "calendar": "standard"}
    coords = {
        "time": ("time", first + np.arange(days + 1), clock),
        "lat": ("lat", lat, {"units": "degrees_north", "standard_name": "latitude"}),
        "lon": ("lon", lon, {"units": "degrees_east", "standard_name": "longitude"}),
    }
    analytic.write_cf(xr.Dataset(data, coords=coords, attrs={"Conventions": "CF-1.10"}), path)


@dataclass(frozen=True)
class Start:
    """A scene that is ready to run, and its folder."""

    project: Path
    folder: Path
    scene: Scene
    cells: Path | None


def make_scene(
    project: Path, place: Path, start: str, windows: int, per_job: int, more: tuple[str, ...] = ()
) -> Scene:
    """Make the scene and its forcing file.

    Parameters
    ----------
    project, place : Path
        Folder of the project, and the one to write to.
    start : str
        Date on which the scene starts.
    windows, per_job : int
        Daily windows, and how many of them one launch runs.
    more : tuple of str
        Effects besides those of `smoke`.
    """
    text = yaml.safe_load((project / "config/scenes/smoke.yaml").read_text())
    path = place / "year.nc"
    # The ice of another year's winter is as good a start as any.
    text["mask"] |= {"file": str(project / "data/oisst_arctic_1981-12-31.nc"), "days_off": 1000.0}
    text |= {
        "time": {"start": start, "windows": windows, "window": DAY},
        "forcing": {**text["forcing"], "step": DAY, "source": "file", "file": str(path)},
        "workflow": {"windows_per_job": per_job},
        "state": {"keep": "all"},
        "effects": [*Scene(name="any").effects, *more],
    }
    (place / "year.yaml").write_text(yaml.safe_dump(text))
    scene = load_scene(place / "year.yaml")
    forcing_file(scene, path, windows)
    return scene


def prepare(project: Path, place: Path, scene: Scene) -> Start:
    """Make state 0 of the scene, and fresh cells where it remaps."""
    ice = mask.make_mask(scene, land.make_land(scene)["land_fraction"].values)
    packed = packing.make_packing(ice, scene.packing, scene.seed)
    glued = bonds.make_bonds(packed, scene.packing.bond_gap, scene.packing.bond_concentration)
    folder = place / "results/year"
    write_state(initial.make_state(scene, packed, glued), folder / "state/0000.nc")
    fresh = None
    if "remap" in scene.effects:
        fresh = folder / "preprocess/cells.nc"
        write_dataset(cells.make_cells(ice, packed, scene.seed), fresh)
    return Start(project, folder, scene, fresh)


def run(at: Start, ranks: int) -> Iterator[list[str]]:
    """Run chunk after chunk, as the rule of windows does; yields the windows of each."""
    previous, time = "0000", at.scene.time
    for windows in window_chunks(time.windows, at.scene.workflow.windows_per_job).values():
        state = at.folder / f"state/{previous}.nc"
        plugin = plugin_path(at.project)
        chunk = Chunk(at.scene, at.folder, tuple(windows), state, plugin, ranks, at.cells)
        assert run_chunk(chunk) == len(windows)
        previous = chunk.name
        yield windows
