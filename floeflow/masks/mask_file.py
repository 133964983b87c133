# SPDX-License-Identifier: GPL-2.0-or-later
"""What a mask file holds: concentration, thickness, water, land and pole hole on its own grid.

The check before any job and the stage find their variables through the same functions, so what
passes the one is what the other reads.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core import cf_reading as cf
from floeflow.core import fields, levels, times, units
from floeflow.core.errors import FloeError
from floeflow.core.grids import scene_crs, scene_grid, to_lonlat
from floeflow.core.input_files import Hints
from floeflow.core.unpack import HOLE, LAND, Flags, Values, flag_variable
from floeflow.masks.labels import read_labels
from floeflow.masks.thickness import thickness_kind
from floeflow.scene.blocks import Scene

Array = NDArray[np.float64]

log = logging.getLogger(__name__)

CONCENTRATION = "sea_ice_area_fraction"
# Floats overshoot by what models leave; packed numbers by their rounding alone.
TOLERANCE = 0.01
MOST_THICKNESS = 50.0
# Units of per cent and no value above this: such a map may be either.
LEAST_SHARE = 0.5


def mask_hints(scene: Scene) -> Hints:
    """What the scene says of its mask file.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    Hints
        Projection, codes of flags, name and scale of the concentration.
    """
    mask = scene.mask
    flags = {name: codes for name, codes in mask.flags.model_dump().items() if codes}
    return Hints("mask", mask.crs, flags, mask.concentration, mask.scale)


def find_concentration(
    variables: dict[str, cf.Variable], asked: str, path: str | Path
) -> cf.Variable:
    """The concentration variable: the one asked for, else the one with the standard name.

    A file of one map alone, as a picture, has no other.

    Parameters
    ----------
    variables : dict of cf.Variable
        Of the file, by name.
    asked : str
        Name of the variable; empty to look for its standard name.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    Variable
        Of the file.

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
    maps = [item for item in variables.values() if len(item.dims) >= 2]
    if not found and len(maps) == 1 and maps[0].name in ("grey", "band_1"):
        return maps[0]
    listed = ", ".join(item.name for item in (found or variables.values()) if item.dims)
    said = "several variables have" if found else "no variable has"
    raise FloeError(
        f"{path}: {said} standard_name {CONCENTRATION}; name one of these in mask.concentration: "
        f"{listed}"
    )


@dataclass(frozen=True)
class Wanted:
    """A variable of the file that the mask needs, how it lies, and at which of its times.

    Parameters
    ----------
    variable, layout
        See `floeflow.core.cf_reading`.
    index : int
        Of its times.
    days_off : float
        Days between that time and the scene's start; NaN where the file has none.
    """

    variable: cf.Variable
    layout: cf.Layout
    index: int
    days_off: float


def nearest_time(
    data: xr.Dataset,
    variables: dict[str, cf.Variable],
    layout: cf.Layout,
    scene: Scene,
    path: str | Path,
) -> tuple[int, float]:
    """Index of the file's time nearest to the scene's start, and how many days it is off.

    A mean over time is off by nothing inside of its bounds. NaN where the file has no time.

    Parameters
    ----------
    data : xarray.Dataset
        Of the file, not decoded.
    variables : dict of cf.Variable
        Of the file, by name.
    layout : cf.Layout
        Dimensions of the variable.
    scene : Scene
        Its start, and ``mask.days_off``.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    index : int
        Along the time axis; 0 where there is none.
    days : float
        Distance from the scene's start, not negative.

    Raises
    ------
    FloeError
        Where it is further off than ``mask.days_off``.
    """
    name = layout.time or layout.stamp
    if not name:
        return 0, float("nan")
    if data[name].size == 1 and " since " not in variables[name].text("units"):
        return 0, float("nan")
    start = scene.time.start
    seconds, bounds = times.axis_seconds(data, variables, name, start, path)
    off = np.abs(seconds)
    index = int(np.argmin(off))
    if bounds is not None:
        low, high = bounds
        off = np.maximum(0.0, np.maximum(low, -high))
        # Where one mean ends the next begins, and holds from now on.
        index = off.size - 1 - int(np.argmin(off[::-1]))
    days = float(off[index]) / times.DAY
    if days > scene.mask.days_off:
        raise FloeError(
            f"{path}: its nearest time is {times.say(start, float(seconds[index]))}, {days:.0f} "
            f"days from the scene's start; mask.days_off allows {scene.mask.days_off:g} days"
        )
    return (index if layout.time else 0), days


def wanted_variables(
    scene: Scene, data: xr.Dataset, variables: dict[str, cf.Variable], path: Path
) -> dict[str, Wanted]:
    """The variables that the mask needs: ``concentration``, and those that the scene names.

    Parameters
    ----------
    scene : Scene
        Block ``mask``.
    data : xarray.Dataset
        Of the file, not decoded.
    variables : dict of cf.Variable
        Of the file, by name.
    path : Path
        Of the file, for messages.

    Returns
    -------
    dict of Wanted
        Variable, layout, index of its time and days off by key of ``mask``.

    Raises
    ------
    FloeError
        For a variable that is missing, on no map, or on another grid.
    """
    mask = scene.mask
    named = {"concentration": find_concentration(variables, mask.concentration, path)}
    for key in ("thickness", "water"):
        name = getattr(mask, key)
        if name:
            named[key] = cf.named(variables, name, path, f"mask.{key}")
    found: dict[str, Wanted] = {}
    for key, variable in named.items():
        if variable.kind and variable.kind not in "iufb":
            raise FloeError(f"{path}: variable '{variable.name}' holds no numbers")
        layout = cf.layout(variables, variable, path)
        first = found.get("concentration")
        if first and (layout.x, layout.y) != (first.layout.x, first.layout.y):
            raise FloeError(
                f"{path}: '{variable.name}' is not on the grid of '{first.variable.name}'"
            )
        if not layout.lonlat and not layout.places:
            cf.projection(variables, variable, path)
        if key == "thickness":
            thickness_kind(mask.thickness_is, variable, path)
        index, days = nearest_time(data, variables, layout, scene, path)
        found[key] = Wanted(variable, layout, index, days)
    share_factor(found["concentration"].variable, path)
    return found


def check_mask_file(scene: Scene) -> None:
    """Refuse a projection or mask file that the mask stage could not use; reads no values.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Raises
    ------
    FloeError
        One sentence that names the file and the variable: no file, not readable, no such
        variable, dimensions that are no map, a time too far off, a thickness of unclear meaning.
    """
    to_lonlat(scene_crs(scene.domain), *scene_grid(scene.domain).mesh())
    if scene.packing.generator == "floes":
        read_labels(scene.mask.labels, scene.domain)
    if scene.packing.generator == "floes" or scene.mask.uniform > 0.0:
        return
    path = Path(scene.mask.file)
    if not scene.mask.file:
        raise FloeError("mask.file names no file")
    with fields.open_file(path, mask_hints(scene)) as data:
        wanted_variables(scene, data, cf.variables_of(data), path)


def share_factor(variable: cf.Variable, path: str | Path) -> float:
    """Factor that brings a concentration to a share by its units: 1 or 0.01.

    Parameters
    ----------
    variable : cf.Variable
        One of them.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    float
        1.

    Raises
    ------
    FloeError
        Where they are neither a share nor per cent.
    """
    given = variable.text("units")
    found = units.conversion(given, "1")
    if found not in ((1.0, 0.0), (0.01, 0.0)):
        raise FloeError(
            f"{path}: variable '{variable.name}' has units '{given}', which are neither a share "
            "nor per cent"
        )
    return found[0]


def as_share(found: Values, variable: cf.Variable, path: str | Path) -> tuple[Array, str]:
    """Concentration as a share, and what was taken for granted, empty for nothing.

    Per cent is told by the units, but files are known whose units say per cent and whose values
    are shares: where no value is above 1 but some are above a half, they are taken as shares.

    Parameters
    ----------
    found : Values
        As in the file, NaN where missing.
    variable : Variable
        For its units.
    path : str or Path
        The file, for the message.

    Returns
    -------
    share : ndarray
        0 to 1, NaN where it is not known.
    said : str
        A sentence, or empty.

    Raises
    ------
    FloeError
        Where units are unknown or do not tell, or values lie outside 0..1 by more than a packing's
        rounding.
    """
    factor, values, given = share_factor(variable, path), found.values, variable.text("units")
    what, said = f"{path}: variable '{variable.name}'", ""
    known = values[np.isfinite(values)]
    low, high = float(known.min()), float(known.max())
    slack = found.rounding * (1.0 + 1e-9) if found.rounding else TOLERANCE
    if factor != 1.0 and 0.0 < high <= LEAST_SHARE:
        raise FloeError(
            f"{what} has units '{given}' but no value above {high:g}: say in mask.scale whether 1 "
            "is all ice (mask.scale: 1) or one per cent (mask.scale: 0.01)"
        )
    if factor != 1.0:
        if high > 1.0 + slack:
            values, low, high = values * factor, low * factor, high * factor
            slack = factor * slack if found.rounding else TOLERANCE
        elif high > 0.0:
            said = (
                f"the units of '{variable.name}' say '{given}' but no value is above 1: taken as "
                "shares, 1 for all ice; with mask.scale: 0.01 it would be one per cent"
            )
    if low < -slack or high > 1.0 + slack:
        raise FloeError(
            f"{what} (units '{given}') reaches from {low:g} to {high:g} as a share, outside 0..1: "
            "check its units and its missing values; numbers that are flags go to mask.flags"
        )
    return np.clip(values, 0.0, 1.0), said


def as_metres(values: Array, variable: cf.Variable, path: str | Path) -> Array:
    """Ice thickness in metres; see `as_share`.

    Parameters
    ----------
    values : ndarray
        In the unit of the variable.
    variable : cf.Variable
        With its attributes.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    ndarray
        m, not below 0.

    Raises
    ------
    FloeError
        For another unit, or for values that no ice has.
    """
    given = variable.text("units")
    metres = units.is_length(given) if given else None
    what = f"{path}: variable '{variable.name}'"
    if metres is None:
        raise FloeError(f"{what} has units '{given}', not m or cm")
    values = values * metres
    known = values[np.isfinite(values)]
    low, high = float(known.min()), float(known.max())
    if low < -TOLERANCE or high > MOST_THICKNESS:
        raise FloeError(
            f"{what} reaches from {low:g} to {high:g} m, outside 0..{MOST_THICKNESS:g} m: check "
            "its units and its missing values"
        )
    return np.maximum(values, 0.0)


@dataclass(frozen=True)
class MaskFile:
    """The fields of a mask file on its own grid.

    Parameters
    ----------
    path : Path
        The file.
    source : Source or Curvilinear
        Its grid.
    share : ndarray
        Concentration 0..1, NaN where the file has none, (ny, nx).
    thickness : ndarray or None
        Metres, of the kind that ``thickness_is`` names; NaN where the file has none.
    thickness_is : str
        ``in_ice`` or ``cell_mean``; empty without thickness.
    water : ndarray of bool or None
        Where ``mask.water`` has a value.
    land, hole : ndarray of bool or None
        Where flags tell of land and of the pole hole; None where there are no such flags.
    notes : tuple of str
        What was found, for log and report.
    """

    path: Path
    source: fields.AnySource
    share: Array
    thickness: Array | None
    thickness_is: str
    water: Flags | None
    land: Flags | None
    hole: Flags | None
    notes: tuple[str, ...]


def read_mask_file(scene: Scene) -> MaskFile:
    """Read what the mask needs.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    MaskFile
        Fields on the file's own grid: concentration (1), thickness (m), land, and notes for people.

    Raises
    ------
    FloeError
        For all that is wrong with the file.
    """
    path = Path(scene.mask.file)
    with fields.open_file(path, mask_hints(scene)) as data:
        variables = cf.variables_of(data)
        wanted = wanted_variables(scene, data, variables, path)
        first = wanted["concentration"]
        source = fields.source_grid(variables, first.variable, first.layout, data, path)
        found = {key: _values(data, item, source, path) for key, item in wanted.items()}
        land = _land(data, variables, wanted["concentration"], found, source, path)
        notes = tuple(_note(data, item, path) for item in wanted.values())
    raw, thickness, kind = found["concentration"], None, ""
    if "thickness" in wanted:
        variable = wanted["thickness"].variable
        thickness = as_metres(found["thickness"].values[0], variable, path)
        kind = thickness_kind(scene.mask.thickness_is, variable, path)
        notes += (f"'{variable.name}' is taken as {kind}",)
    share, said = as_share(raw, first.variable, path)
    notes += (said,) if said else ()
    return MaskFile(
        path,
        source,
        share[0],
        thickness,
        kind,
        np.isfinite(found["water"].values[0]) if "water" in found else None,
        land,
        raw.flags[HOLE][0] if HOLE in raw.flags else None,
        notes,
    )


def _values(data: xr.Dataset, item: Wanted, source: fields.AnySource, path: Path) -> Values:
    name = item.variable.name
    found = fields.read_unpacked(data, name, item.layout, source, np.array([item.index]), path)
    if found.values.shape[1:] != fields.shape_of(source):
        raise FloeError(f"{path}: '{name}' is not on the grid of the concentration")
    if not np.isfinite(found.values).any():
        raise FloeError(f"{path}: variable '{name}' has no value that is not missing")
    return found


def _land(
    data: xr.Dataset,
    variables: dict[str, cf.Variable],
    first: Wanted,
    found: dict[str, Values],
    source: fields.AnySource,
    path: Path,
) -> Flags | None:
    """Land by the concentration's own flags, or by a status flag beside it."""
    flags = found["concentration"].flags
    if LAND in flags:
        return flags[LAND][0]
    status = flag_variable(variables, first.variable)
    if status is None:
        return None
    # A status flag lies as what it tells of, and need not repeat the mapping.
    same = set(status.dims) <= set(first.variable.dims)
    layout = first.layout if same else cf.layout(variables, status, path)
    if layout.time and layout.time not in status.dims:
        layout = replace(layout, time="")
    index = np.array([first.index if layout.time else 0])
    told = fields.read_flags(data, status.name, layout, source, index, path)
    return told[LAND][0] if LAND in told else None


def _note(data: xr.Dataset, item: Wanted, path: Path) -> str:
    variable, layout = item.variable, item.layout
    level: levels.Level | None = fields.surface_level(data, variable.name, layout, True, path)
    parts = [f"'{variable.name}' of {path}"]
    if level is not None and data[layout.level or layout.height].size > 1:
        parts.append(f"at {level.said}")
    if np.isfinite(item.days_off):
        parts.append(f"{item.days_off:.1f} days from the start")
    else:
        parts.append("of no known time")
    return ", ".join(parts)
