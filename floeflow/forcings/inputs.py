# SPDX-License-Identifier: GPL-2.0-or-later
"""Checks of a scene's input files, quick enough to make before any job.

The stages find their variables through the same functions, so what passes here is what they read.
Values are checked by the stages; but a file that cannot be read to its end is found here.
"""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np

from floeflow.core import cf_reading as cf
from floeflow.core import times
from floeflow.core.errors import FloeError
from floeflow.core.grids import scene_crs, scene_grid, to_lonlat
from floeflow.forcings import cf_variables as names
from floeflow.forcings.accumulate import rates
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import forcing_variables

CONCENTRATION = "sea_ice_area_fraction"

# What two quantities make up for a missing one.
SUBSTITUTES = {
    "specific_humidity": ("dew_point", "air_pressure"),
    "snowfall": ("precipitation", "air_temperature"),
}
# Records further apart than so many of their usual steps leave a gap.
GAP = 1.5


def find_concentration(
    variables: dict[str, cf.Variable], asked: str, path: str | Path
) -> cf.Variable:
    """The concentration variable: the one asked for, else the one with the standard name.

    Raises
    ------
    FloeError
        Where there is none or more than one.
    """
    if asked:
        return cf.named(variables, asked, path, "mask.concentration")
    found = cf.by_standard_name(variables, CONCENTRATION)
    if len(found) == 1:
        return found[0]
    listed = ", ".join(item.name for item in (found or variables.values()) if item.dims)
    said = "several variables have" if found else "no variable has"
    raise FloeError(
        f"{path}: {said} standard_name {CONCENTRATION}; name one of these in mask.concentration: "
        f"{listed}"
    )


def nearest_time(
    path: str | Path, variables: dict[str, cf.Variable], layout: cf.Layout, scene: Scene
) -> tuple[int, float]:
    """Index of the file's time nearest to the scene's start, and how far off it is (s)."""
    if not layout.time:
        return 0, 0.0
    with netCDF4.Dataset(path) as file:
        values = file[layout.time][:]
    if values.size == 1 and " since " not in variables[layout.time].text("units"):
        return 0, 0.0
    seconds = times.seconds_since(values, variables[layout.time], scene.time.start, path)
    index = int(np.argmin(np.abs(seconds)))
    return index, float(seconds[index])


def check_mask_file(scene: Scene) -> None:
    """Refuse a projection or mask file that the mask stage could not use.

    Raises
    ------
    FloeError
        One sentence that names the file and the variable: no file, no NetCDF, damaged, no such
        variable, dimensions that are no map, no value at all.
    """
    to_lonlat(scene_crs(scene.domain), *scene_grid(scene.domain).mesh())
    path = Path(scene.mask.file)
    if not scene.mask.file:
        raise FloeError("mask.file names no file")
    variables = cf.describe(path)
    concentration = find_concentration(variables, scene.mask.concentration, path)
    wanted = [concentration]
    for key in ("thickness", "water"):
        name = getattr(scene.mask, key)
        if name:
            wanted.append(cf.named(variables, name, path, f"mask.{key}"))
    first = cf.layout(variables, concentration, path)
    for variable in wanted:
        layout = cf.layout(variables, variable, path)
        if (layout.x, layout.y) != (first.x, first.y):
            raise FloeError(
                f"{path}: '{variable.name}' is not on the grid of '{concentration.name}'"
            )
        if not layout.lonlat:
            cf.projection(variables, variable, path)
        index, _ = nearest_time(path, variables, layout, scene)
        _check_values(path, variable, layout, index)


def _check_values(path: Path, variable: cf.Variable, layout: cf.Layout, index: int) -> None:
    key = tuple(index if dim == layout.time else slice(None) for dim in variable.dims)
    try:
        with netCDF4.Dataset(path) as file:
            values = np.ma.asarray(file[variable.name][key])
    except Exception as error:  # a damaged HDF5 file raises whatever its bytes lead to
        raise FloeError(
            f"{path}: variable '{variable.name}' cannot be read ({type(error).__name__})"
        ) from None
    if values.dtype.kind not in "iuf":
        raise FloeError(f"{path}: variable '{variable.name}' holds no numbers")
    if not np.isfinite(np.ma.filled(values.astype(float), np.nan)).any():
        raise FloeError(f"{path}: variable '{variable.name}' has no value that is not missing")


def forcing_items(
    variables: dict[str, cf.Variable], effects: tuple[str, ...], path: str | Path
) -> dict[str, names.FoundVector | tuple[cf.Variable, ...]]:
    """Where a file holds what the effects need.

    Returns
    -------
    dict
        ``wind`` and ``ocean`` to vectors, scalars to their variables. Specific humidity may be
        the dew point and the pressure instead, snowfall the precipitation and the air temperature:
        two variables, see ``SUBSTITUTES``. The ocean heat flux may be missing.

    Raises
    ------
    FloeError
        Names what is missing and the standard name to give it.
    """
    wanted = dict.fromkeys(
        name.rsplit("_", 1)[0] if name.endswith(("_u", "_v")) else name
        for name in forcing_variables(effects)
        if name != "coriolis"
    )
    found: dict[str, names.FoundVector | tuple[cf.Variable, ...]] = {}
    for name in wanted:
        if name in names.VECTORS:
            vector = names.find_vector(variables, name, path)
            if vector is None:
                u, v = names.VECTORS[name].east_north[0]
                raise FloeError(f"{path}: has no {name}: no standard_names {u} and {v}")
            found[name] = vector
            continue
        scalar = names.find_scalar(variables, name, path)
        if scalar is not None:
            found[name] = (scalar,)
        elif name in SUBSTITUTES:
            pair = [names.find_scalar(variables, other, path) for other in SUBSTITUTES[name]]
            if pair[0] is None or pair[1] is None:
                standard = names.QUANTITIES[SUBSTITUTES[name][0]].standard[0]
                need = SUBSTITUTES[name][1].replace("_", " ")
                raise FloeError(
                    f"{path}: has no {name}: neither standard_name "
                    f"{names.QUANTITIES[name].standard[0]} nor {standard} with {need}"
                )
            found[name] = (pair[0], pair[1])
        elif name != "ocean_heat_flux":
            standard = names.QUANTITIES[name].standard[0]
            raise FloeError(f"{path}: has no {name}: no standard_name {standard}")
    return found


def components(item: names.FoundVector | tuple[cf.Variable, ...]) -> tuple[cf.Variable, ...]:
    """The file's variables behind an item of `forcing_items`."""
    return (item.u, item.v) if isinstance(item, names.FoundVector) else item


def kinds(name: str, item: names.FoundVector | tuple[cf.Variable, ...]) -> tuple[str, ...]:
    """What the variables of an item are: quantities of ``names.QUANTITIES``, or a vector twice."""
    if isinstance(item, names.FoundVector):
        return name, name
    return (name,) if len(item) == 1 else SUBSTITUTES[name]


def midnight(scene: Scene) -> float:
    """The midnight at or before the scene's start, in seconds since that."""
    start = scene.time.start
    return -(3600.0 * start.hour + 60.0 * start.minute + start.second + 1e-6 * start.microsecond)


def check_axis(
    seconds: np.ndarray, first: float, last: float, scene: Scene, path: str | Path, name: str
) -> None:
    """Refuse a time axis that does not ascend, or has a gap between first and last (s)."""
    steps = np.diff(seconds)
    if np.any(steps <= 0):
        raise FloeError(f"{path}: time variable '{name}' does not ascend")
    wide = steps > GAP * np.median(steps) if steps.size else np.zeros(0, dtype=bool)
    for k in np.flatnonzero(wide & (seconds[:-1] < last) & (seconds[1:] > first))[:1]:
        ends = [times.say(scene.time.start, float(item)) for item in seconds[k : k + 2]]
        raise FloeError(f"{path}: '{name}' has a gap from {ends[0]} to {ends[1]}")


def check_cover(
    seconds: np.ndarray, first: float, last: float, scene: Scene, path: str | Path, name: str
) -> None:
    """Refuse a time axis that does not ascend, or reach from first to last (s) without gaps."""
    check_axis(seconds, first, last, scene, path, name)
    if seconds[0] > first or seconds[-1] < last:
        span = [times.say(scene.time.start, float(item)) for item in (seconds[0], seconds[-1])]
        need = [times.say(scene.time.start, item) for item in (first, last)]
        raise FloeError(
            f"{path}: '{name}' covers {span[0]} to {span[1]}, but the scene needs {need[0]} to "
            f"{need[1]}"
        )


def check_forcing_file(scene: Scene) -> None:
    """Refuse a forcing file that the forcing stage could not use.

    Does nothing where the forcing is analytic.

    Raises
    ------
    FloeError
        One sentence: no file, no NetCDF, a quantity missing, units unknown, no map, or a time
        axis that does not cover the scene.
    """
    if scene.forcing.source != "file":
        return
    path = Path(scene.forcing.file)
    variables = cf.describe(path)
    for name, item in forcing_items(variables, scene.effects, path).items():
        for kind, variable in zip(kinds(name, item), components(item), strict=True):
            layout = cf.layout(variables, variable, path)
            if not layout.lonlat:
                cf.projection(variables, variable, path)
            summed = False
            if kind in names.QUANTITIES:
                _, _, summed = names.scalar_conversion(variable, names.QUANTITIES[kind], path)
            else:
                names.conversion(variable, names.VECTOR_UNITS, "m s-1", path)
            if not layout.time:
                continue
            with netCDF4.Dataset(path) as file:
                seconds = times.seconds_since(
                    file[layout.time][:], variables[layout.time], scene.time.start, path
                )
            end = scene.time.windows * scene.time.window
            if summed:
                check_axis(seconds, 0.0, end, scene, path, layout.time)
                how = scene.forcing.accumulation
                rates(seconds, (0.0, end), how, midnight(scene), (path, variable.name))
            else:
                check_cover(seconds, 0.0, end, scene, path, layout.time)
