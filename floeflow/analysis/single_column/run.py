# SPDX-License-Identifier: GPL-2.0-or-later
"""``floeflow column forcing.nc``: one column of sea ice.

Reads the forcing of a place, advances a column through it, writes its record as NetCDF and draws
it: for people who want the column and no elements.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import yaml

from floeflow.analysis.single_column.forcing_file import PointForcing, read_point
from floeflow.analysis.single_column.year import run_column, start_columns
from floeflow.column.params import Settings
from floeflow.column.schemes import SCHEMES
from floeflow.core.atomic_write import spare_inputs
from floeflow.core.errors import FloeError, answer
from floeflow.forcings.files import all_files
from floeflow.report.figures.column import column_figure
from floeflow.report.figures.style import write_png
from floeflow.scene.checks import LEAST_SALINITY
from floeflow.scene.effects import EFFECTS
from floeflow.scene.load import build_scene
from floeflow.scene.physics import ColumnPhysics
from floeflow.state import write_dataset

# Processes that need no neighbours.
PROCESSES = tuple(
    name
    for name, effect in EFFECTS.items()
    if effect.column and effect.needs == ("thermodynamics",)
)
DAY = 86400.0

# Largest sizes of what the options give; of those that scenes have, as theirs.
MOST = {
    "thickness": 20.0,
    "snow": 5.0,
    "salinity": 45.0,
    "mixed_layer_depth": 500.0,
    "new_ice_thickness": 1.0,
    "ocean_heat_flux": 1000.0,
    "pressure": 110_000.0,
    "friction_velocity": 1.0,
    "layers": 50,
    "categories": 20,
    "step": 3.2e7,
    "every": 3.2e9,
    "days": 1e6,
    "repeat": 10_000,
    "lon": 360.0,
    "lat": 90.0,
}
LEAST_STEP = 1.0  # s, as in scenes
MOST_RECORDS = 1_000_000


def arguments() -> argparse.ArgumentParser:
    """The command line."""
    parser = argparse.ArgumentParser(
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
        prog="floeflow column",
        description="One column of sea ice and its year.",
    )
    add = parser.add_argument
    add("forcing", nargs="+", help="files or patterns, at a point or on a map: docs/forcing.md")
    add("--scheme", choices=tuple(SCHEMES), default="bl99", help="vertical thermodynamics")
    add("--categories", type=int, default=1, help="thickness categories")
    add("--layers", type=int, default=7, help="layers of ice (bl99, mushy)")
    add(
        "--light",
        choices=("ccsm3", "delta_eddington"),
        default="ccsm3",
        help="radiation scheme for snow and ice",
    )
    add(
        "--variant",
        choices=("convergent", "icepack"),
        default="convergent",
        help="ponds, flushing and light in melting layers (docs/theory/column_ponds.md)",
    )
    add("--ponds", action="store_true", help="melt ponds (bl99, mushy)")
    add("--without", nargs="+", choices=PROCESSES, default=[], help="processes to leave out")
    add("--thickness", type=float, default=1.5, help="initial ice thickness (m)")
    add("--fraction", type=float, default=1.0, help="initial ice concentration (0 to 1)")
    add("--snow", type=float, default=0.2, help="initial snow depth (m)")
    add("--step", type=float, default=3600.0, help="longest time step (s)")
    add("--every", type=float, default=DAY, help="time between records (s)")
    add("--days", type=float, default=0.0, help="length of the run (days); 0: that of the forcing")
    add("--repeat", type=int, default=1, help="number of times to run through the forcing")
    add("--lon", type=float, help="longitude, for a file on a grid (degrees east)")
    add("--lat", type=float, help="latitude, for a file on a grid (degrees north)")
    add(
        "--accumulation",
        choices=("hour", "step", "day"),
        default="",
        help="interval over which the file sums radiation and precipitation",
    )
    add("--salinity", type=float, default=34.0, help="salinity of the sea (1e-3)")
    add("--mixed-layer-depth", type=float, default=20.0, help="depth of the mixed layer (m)")
    add("--new-ice-thickness", type=float, default=0.05, help="thickness of new ice (m)")
    add(
        "--ocean-heat-flux",
        type=float,
        default=2.0,
        help="heat flux from the ocean, if the file has none (W/m2)",
    )
    add(
        "--friction-velocity",
        type=float,
        default=0.005,
        help="friction velocity under the ice (m/s)",
    )
    add("--pressure", type=float, default=101325.0, help="air pressure, if the file has none (Pa)")
    add(
        "--start",
        help="begin at this time of the forcing, as 2015-03-01T12:00; without: at its first record",
    )
    add(
        "--physics",
        nargs="+",
        default=[],
        metavar="KEY=VALUE",
        help="keys of a scene's block 'physics', as albedo_ice_visible=0.75 (config/README.md)",
    )
    add("--output", type=Path, default=Path("column.nc"), help="output file (NetCDF)")
    add("--figure", type=Path, default=Path("column.png"), help="figure file (PNG)")
    return parser


def check(given: argparse.Namespace) -> None:
    """Refuse numbers that make no column.

    Parameters
    ----------
    given : argparse.Namespace
        Options of the command line.

    Raises
    ------
    FloeError
        Names the option.
    """
    positive = ("layers", "categories", "step", "every", "repeat", "mixed_layer_depth")
    for name in (*positive, "new_ice_thickness", "pressure"):
        if not getattr(given, name) > 0:
            raise FloeError(f"--{name.replace('_', '-')} must be above zero")
    if given.layers < 2:
        raise FloeError("--layers must be 2 or more")
    for name in ("thickness", "snow", "days", "salinity", "friction_velocity"):
        if not getattr(given, name) >= 0:
            raise FloeError(f"--{name.replace('_', '-')} must not be below zero")
    for name, most in MOST.items():
        if not abs(getattr(given, name) or 0.0) <= most:
            raise FloeError(f"--{name.replace('_', '-')} must be at most {most:g}")
    if given.step < LEAST_STEP:
        raise FloeError(f"--step must be {LEAST_STEP:g} s or more")
    if not 0 <= given.fraction <= 1:
        raise FloeError("--fraction must lie between 0 and 1")
    if given.scheme == "mushy" and given.salinity < LEAST_SALINITY:
        raise FloeError(
            f"--salinity must be {LEAST_SALINITY:g} (1e-3) or more with --scheme mushy: fresh "
            "water makes no mush"
        )
    if given.ponds and given.scheme == "zero_layer":
        raise FloeError("--ponds needs --scheme bl99 or mushy")
    if given.ponds and "shortwave" in given.without:
        raise FloeError("--ponds needs shortwave")
    if (given.lon is None) != (given.lat is None):
        raise FloeError("--lon and --lat come together")


def settings_of(given: argparse.Namespace) -> Settings:
    """Settings of the column that the command line asks for.

    Parameters
    ----------
    given : argparse.Namespace
        Options of the command line.
    """
    processes = tuple(name for name in PROCESSES if name not in given.without)
    return Settings(
        scheme=given.scheme,
        processes=(*processes, "ponds") if given.ponds else processes,
        light=given.light,
        variant=given.variant,
        categories=given.categories,
        layers=given.layers,
        step=given.step,
        new_ice_thickness=given.new_ice_thickness,
        ocean_salinity=given.salinity,
        mixed_layer_depth=given.mixed_layer_depth,
        physics=physics_of(given),
    )


def physics_of(given: argparse.Namespace) -> ColumnPhysics:
    """Constants of the command line, checked as those of a scene with the same column.

    Parameters
    ----------
    given : argparse.Namespace
        Options of the command line.

    Raises
    ------
    FloeError
        Names the key.
    """
    values = {}
    for word in given.physics:
        name, equals, value = word.partition("=")
        if not equals:
            raise FloeError(f"--physics {word}: give a key and its value, as emissivity=0.97")
        try:
            values[name] = yaml.safe_load(value)
        except yaml.YAMLError:
            raise FloeError(f"--physics {word}: {value!r} is no value") from None
    column = {"scheme": given.scheme, "light": given.light}
    effects = ["thermodynamics", *(("shortwave", "ponds") if given.ponds else ())]
    keys = {"name": "column", "effects": effects, "column": column, "physics": values}
    return build_scene(keys).physics


def forcing_of(given: argparse.Namespace, settings: Settings) -> PointForcing:
    """Forcing of the place that the command line names.

    Parameters
    ----------
    given : argparse.Namespace
        Parsed command line.
    settings : Settings
        What the columns read.

    Returns
    -------
    PointForcing
        SI units.

    Raises
    ------
    FloeError
        For a file that cannot be read, or lacks a variable.
    """
    constant = {
        "ocean_heat_flux": given.ocean_heat_flux,
        "friction_velocity": given.friction_velocity,
        "air_pressure": given.pressure,
    }
    place = None if given.lon is None else (given.lon, given.lat)
    files = all_files(map(str, given.forcing), "floeflow column")
    spare_inputs("--output", given.output, files)
    spare_inputs("--figure", given.figure, files)
    forcing = read_point(files, settings, constant, place, given.accumulation)
    return forcing if given.start is None else forcing.beginning(start_of(given.start))


def start_of(text: str) -> datetime:
    """Time of `--start`, in UTC.

    Parameters
    ----------
    text : str
        ISO 8601; UTC where it names no zone.

    Raises
    ------
    FloeError
        Where it is none.
    """
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        raise FloeError(f"--start {text}: give a time such as 2015-03-01T12:00") from None
    return moment.astimezone(UTC).replace(tzinfo=None) if moment.tzinfo else moment


def run(given: argparse.Namespace) -> str:
    """Run what the command line asks for; what to tell of it.

    Parameters
    ----------
    given : argparse.Namespace
        Options of the command line.

    Raises
    ------
    FloeError
        For bad options or forcing.
    """
    check(given)
    settings = settings_of(given)
    forcing = forcing_of(given, settings)
    length = given.repeat * (given.days * DAY or forcing.length)
    length -= 0.0 if given.days else forcing.begin
    if length / given.every > MOST_RECORDS:
        raise FloeError(
            f"--every {given.every:g} asks for {length / given.every:.3g} records; at most "
            f"{MOST_RECORDS} are allowed"
        )
    surface = float(forcing(0.0)["air_temperature"][0])
    columns = start_columns(settings, given.thickness, given.fraction, given.snow, surface)
    began = time.perf_counter()
    data, worst = run_column(columns, forcing, length, given.every, settings)
    seconds = time.perf_counter() - began
    data["time"].attrs = {"units": f"seconds since {forcing.first}", "calendar": "standard"}
    files = ", ".join(Path(item).name for item in given.forcing)
    data.attrs = {
        "Conventions": "CF-1.10",
        "title": f"Column of sea ice: {given.scheme}",
        "scheme": given.scheme,
        "processes": " ".join(settings.processes),
        "forcing": files,
    }
    write_dataset(data, given.output)
    title = f"{given.scheme}, {settings.categories} categor"
    title += "y" if settings.categories == 1 else "ies"
    figure = column_figure(data, forcing.first, f"{title}: {files}")
    write_png(figure, given.figure, 150)
    thickness = data["ice_volume"].values
    balance = ", ".join(f"{kind} {left:.1e}" for kind, left in worst.items())
    return "\n".join(forcing.said) + (
        f"\nice {thickness[0]:.2f} m, at most {thickness.max():.2f} m, at least "
        f"{thickness.min():.2f} m, at the end {thickness[-1]:.2f} m ({seconds:.1f} s)\n"
        f"largest residual of a record (W/m2, kg/m2): {balance}\n"
        f"written: {given.output}, {given.figure}"
    )


def main(words: Sequence[str] | None = None) -> int:
    """Command line; a fault is one sentence.

    Parameters
    ----------
    words : sequence of str or None, optional
        Of the command line; None for those of the process.

    Returns
    -------
    int
        Exit code.
    """
    return answer(partial(run, arguments().parse_args(words)))
