# SPDX-License-Identifier: GPL-2.0-or-later
"""CF-1.11 description of gridded output: names, units, axes, bounds, projection, cell areas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from floeflow import __version__
from floeflow.column.thickness.categories import category_bounds
from floeflow.core.atomic_write import write_atomically
from floeflow.core.errors import FloeError
from floeflow.core.grids import scene_crs, scene_grid, to_lonlat
from floeflow.scene import Scene
from floeflow.transfer.stencil import Array

# Dimensions, values and attributes of variables by their names.
Variables = dict[str, tuple[Any, Any, dict[str, Any]]]

MISSING = 1.0e20


@dataclass(frozen=True)
class Described:
    """What CF says of a field; names, units and cell methods are those of CMIP6's table SImon.

    Parameters
    ----------
    standard_name : str
        Empty where CF has none.
    units, long_name : str
        As in the file.
    mean : str
        What it is a mean over, as in ``cell_methods``; empty for a sum over the cell.
    scale : float
        From the field as it is computed to the file's unit.
    area_type : str
        Name and value of a scalar coordinate that says of which area it is a fraction.
    bands : bool
        It has the dimension ``iceband``, the categories of thickness.
    single : bool
        Written in single precision: it follows from other fields and is in no budget.
    """

    standard_name: str
    units: str
    long_name: str
    mean: str
    scale: float = 1.0
    area_type: tuple[str, str] | None = None
    bands: bool = False
    single: bool = False


OF_SEA, OF_ICE = "area: mean where sea", "area: mean where sea_ice (comment: mask=siconc)"
SHEAR = "maximum_over_coordinate_rotation_of_sea_ice_horizontal_shear_strain_rate"
RIDGES, PONDS = ("typesirdg", "sea_ice_ridges"), ("typemp", "sea_ice_melt_pond")
DESCRIPTIONS = {
    "siconc": Described(
        "sea_ice_area_fraction",
        "%",
        "share of the cell's sea that is covered by ice",
        OF_SEA,
        100.0,
    ),
    "sithick": Described(
        "sea_ice_thickness", "m", "thickness of the ice, averaged over the ice", OF_ICE
    ),
    "sivol": Described("sea_ice_thickness", "m", "ice volume per area of sea", OF_SEA),
    "simass": Described("sea_ice_amount", "kg m-2", "mass of ice per area of sea", OF_SEA),
    "sisnthick": Described(
        "surface_snow_thickness", "m", "thickness of the snow, averaged over the ice", OF_ICE
    ),
    "sitemptop": Described(
        "sea_ice_surface_temperature", "K", "temperature of the surface of ice or snow", OF_ICE
    ),
    "siitdconc": Described(
        "sea_ice_area_fraction",
        "%",
        "share of the cell's sea that is covered by ice of a thickness category",
        OF_SEA,
        100.0,
        bands=True,
    ),
    "siitdthick": Described(
        "sea_ice_thickness",
        "m",
        "thickness of the ice of a category, averaged over it",
        "area: mean where sea_ice (comment: mask=siitdconc)",
        bands=True,
    ),
    "sirdgconc": Described(
        "area_fraction", "1", "share of the ice's area that is ridged", OF_ICE, area_type=RIDGES
    ),
    "sirdgthick": Described(
        "sea_ice_thickness",
        "m",
        "thickness of the ridged ice, averaged over it",
        "area: mean where sea_ice_ridges (comment: mask=sirdgconc)",
    ),
    "simpconc": Described(
        "area_fraction", "%", "share of the ice's area under melt ponds", OF_ICE, 100.0, PONDS
    ),
    "lead_fraction": Described(
        "", "1", "share of the cell's sea that is open, in cells with at least 70 % ice", OF_SEA
    ),
    "damage": Described(
        "", "1", "share of the elements' outline, taken as of hexagons, that no bond holds", OF_ICE
    ),
    "siage": Described(
        "age_of_sea_ice",
        "s",
        "time since the ice froze on open water, at most since the start of the run",
        OF_ICE,
    ),
    "sistresave": Described(
        "sea_ice_average_normal_horizontal_stress",
        "N m-1",
        "half the trace of the stress in the ice, above 0 in tension",
        OF_ICE,
    ),
    "sistremax": Described(
        "maximum_over_coordinate_rotation_of_sea_ice_horizontal_shear_stress",
        "N m-1",
        "largest shear stress in the ice",
        OF_ICE,
    ),
    "siu": Described(
        "sea_ice_x_velocity", "m s-1", "velocity of the ice along x, averaged over its mass", OF_ICE
    ),
    "siv": Described(
        "sea_ice_y_velocity", "m s-1", "velocity of the ice along y, averaged over its mass", OF_ICE
    ),
    "sispeed": Described(
        "sea_ice_speed", "m s-1", "speed of the ice's mean velocity at the instant", OF_ICE
    ),
    "sidmasstranx": Described(
        "sea_ice_x_transport", "kg s-1", "mass of ice and snow that passes the cell along x", ""
    ),
    "sidmasstrany": Described(
        "sea_ice_y_transport", "kg s-1", "mass of ice and snow that passes the cell along y", ""
    ),
    "sidivvel": Described(
        "divergence_of_sea_ice_velocity",
        "s-1",
        "divergence of siu and siv, by differences between cells",
        OF_ICE,
    ),
    "sishevel": Described(
        SHEAR, "s-1", "largest shear of siu and siv, by differences between cells", OF_ICE
    ),
}
DESCRIPTIONS |= {
    name.format(axis): Described(
        standard_name.format(axis), "N m-2", f"{text} along {axis}", OF_ICE, single=True
    )
    for axis in "xy"
    for name, standard_name, text in (
        ("sistr{}dtop", "surface_downward_{}_stress", "stress of the wind on the ice"),
        ("sistr{}ubot", "upward_{}_stress_at_sea_ice_base", "stress of the water on the ice"),
        (
            "siforcecoriol{}",
            "sea_ice_{}_force_per_unit_area_due_to_coriolis_effect",
            "Coriolis force",
        ),
        (
            "siforcetilt{}",
            "sea_ice_{}_force_per_unit_area_due_to_sea_surface_tilt",
            "force of the sea surface's tilt",
        ),
        ("siforceintstr{}", "sea_ice_{}_internal_stress", "force of contacts, bonds and walls"),
    )
}

HISTORY = {
    "conservative": "conservative remapping from elements to the grid",
    "mls": "moving least squares from elements to the grid, totals not kept",
    "shepard": "Shepard's average from elements to the grid, totals not kept",
    "nearest": "nearest element to the grid, totals not kept",
}


def describe(
    scene: Scene, state: xr.Dataset, fields: dict[str, Array], areas: tuple[Array, Array]
) -> xr.Dataset:
    """Dress gridded fields of a state for CF.

    Parameters
    ----------
    scene : Scene
        Its domain and effects are read.
    state : xarray.Dataset
        The state; its attributes give time and window.
    fields : dict of ndarray
        As `floeflow.diagnostics.gridded.gridded_fields` returns them.
    areas : tuple of ndarray
        Area of the cells and of the sea in them (m2), (ny, nx).

    Returns
    -------
    xarray.Dataset
        Fields (time, y, x) with attributes and encodings.
    """
    cells, crs = scene_grid(scene.domain), scene_crs(scene.domain)
    time = np.array([float(state.attrs["time"])])
    lon, lat = to_lonlat(crs, *cells.mesh())

    coords: Variables = {
        "time": ("time", time, _time_attributes(str(state.attrs["start"]))),
        "y": ("y", cells.y, _axis_attributes("y")),
        "x": ("x", cells.x, _axis_attributes("x")),
        "lat": (("y", "x"), lat, {"standard_name": "latitude", "units": "degrees_north"}),
        "lon": (("y", "x"), lon, {"standard_name": "longitude", "units": "degrees_east"}),
    }
    # Joined at once: each change of a dataset costs milliseconds. An instant has bounds of no
    # length.
    found: Variables = {"time_bnds": (("time", "bnds"), np.stack([time, time], axis=1), {})}
    for name, edges in (("y_bnds", cells.y_edges), ("x_bnds", cells.x_edges)):
        found[name] = ((name[0], "bnds"), np.stack([edges[:-1], edges[1:]], axis=1), {})
    found["crs"] = ((), np.int32(0), crs.to_cf())
    number = np.array([int(state.attrs["window"])], dtype=np.int32)
    counted = {"long_name": "number of the coupling window", "units": "1"}
    found["window"] = (("time",), number, counted)
    for name in DESCRIPTIONS:
        if name in fields:
            found |= _field(name, fields[name])
    if "siitdconc" in found:
        found |= _bands(found["siitdconc"][1].shape[1])
    data = xr.Dataset(found | _areas(*areas) | _method(fields), coords)
    history = f"{HISTORY[scene.grid.transfer]} (floeflow.diagnostics.gridded)"
    data.attrs = file_attributes(scene, f"Sea ice of scene {scene.name}", history)
    for name in map(str, data.variables):
        filled = name in DESCRIPTIONS
        data[name].encoding = {"_FillValue": MISSING if filled else None}
        if filled and DESCRIPTIONS[name].single:
            data[name].encoding |= {"dtype": "float32", "_FillValue": np.float32(MISSING)}
        if data[name].ndim >= 2:
            data[name].encoding |= {"zlib": True, "complevel": 4}
        if data[name].dims[-2:] == ("y", "x") and name not in ("lat", "lon"):
            kind = DESCRIPTIONS[name].area_type if filled else None
            data[name].encoding["coordinates"] = f"lat lon {kind[0]}" if kind else "lat lon"
    return data


def file_attributes(scene: Scene, title: str, history: str) -> dict[str, str]:
    """Global attributes of a file of fields.

    Parameters
    ----------
    scene : Scene
        Its effects are named.
    title, history : str
        What the file holds, and how that was made.

    Returns
    -------
    dict of str
        By CF's names.
    """
    return {
        "Conventions": "CF-1.11",
        "title": title,
        "source": f"FloeFlow {__version__}, sea-ice discrete element model",
        "effects": " ".join(scene.effects),
        "history": history,
    }


def field_attributes(long_name: str, units: str, cell_methods: str) -> dict[str, str]:
    """Attributes of a field on the grid, but for its standard name.

    Parameters
    ----------
    long_name, units, cell_methods : str
        As in the file.

    Returns
    -------
    dict of str
        By CF's names.
    """
    return {
        "long_name": long_name,
        "units": units,
        "cell_methods": cell_methods,
        "cell_measures": "area: sea_area",
        "grid_mapping": "crs",
    }


def _time_attributes(start: str) -> dict[str, str]:
    return {
        "standard_name": "time",
        "long_name": "time",
        "units": f"seconds since {start.replace('T', ' ')}",
        "calendar": "standard",
        "axis": "T",
        "bounds": "time_bnds",
    }


def _axis_attributes(axis: str) -> dict[str, str]:
    return {
        "standard_name": f"projection_{axis}_coordinate",
        "long_name": f"{axis} of the cell's centre",
        "units": "m",
        "axis": axis.upper(),
        "bounds": f"{axis}_bnds",
    }


def _field(name: str, values: Array) -> Variables:
    """A field at the dataset's time, with its attributes and the coordinates that it needs."""
    said = DESCRIPTIONS[name]
    dims = ("time", "iceband", "y", "x") if said.bands else ("time", "y", "x")
    attrs = {"standard_name": said.standard_name} if said.standard_name else {}
    method = f"{said.mean} time: point".strip()
    attrs |= field_attributes(said.long_name, said.units, method)
    found: Variables = {name: (dims, said.scale * values[None], attrs)}
    if said.area_type:
        kind, word = said.area_type
        found[kind] = ((), np.array(word, dtype=object), {"standard_name": "area_type"})
    return found


def _bands(count: int) -> Variables:
    """Bounds of the thickness categories; the last has no end and stands at its start."""
    bounds = category_bounds(count)
    middle = 0.5 * (bounds[:-1] + bounds[1:])
    middle[-1] = bounds[-2]
    attrs = {"standard_name": "sea_ice_thickness", "units": "m", "bounds": "iceband_bnds"}
    ends = np.stack([bounds[:-1], bounds[1:]], axis=1)
    return {
        "iceband": ("iceband", middle, attrs | {"long_name": "category of ice thickness"}),
        "iceband_bnds": (("iceband", "bnds"), ends, {}),
    }


def _areas(area: Array, sea: Array) -> Variables:
    described = (
        ("cell_area", area, "m2", "cell_area", "area of the cell on the earth"),
        ("sea_area", sea, "m2", "cell_area", "area of the cell's sea on the earth"),
        ("sea_area_fraction", sea / area, "1", "sea_area_fraction", "share of sea in the cell"),
    )
    found: Variables = {}
    for name, values, units, standard_name, long_name in described:
        attrs = {"standard_name": standard_name, "long_name": long_name, "units": units}
        found[name] = (("y", "x"), values, attrs | {"grid_mapping": "crs"})
    return found


def _method(fields: dict[str, Array]) -> Variables:
    attrs = {
        "long_name": "how the ice's properties were averaged",
        "flag_values": np.array([0, 1, 2, 4], np.int8),
        "flag_meanings": "none shepard moving_least_squares nearest_element",
        "grid_mapping": "crs",
    }
    method = fields["remap_method"][None]
    found: Variables = {"remap_method": (("time", "y", "x"), method, attrs)}
    for name, units, what in (
        ("siarea", "m2", "ice area"),
        ("sivolume", "m3", "ice volume"),
        ("sisnvolume", "m3", "snow volume"),
    ):
        for part, meaning in (
            ("residual", f"total {what} of the grid minus that of the elements on it"),
            ("outside", f"{what} in elements outside of the grid"),
        ):
            if f"{name}_{part}" in fields:
                attrs = {"long_name": meaning, "units": units, "cell_methods": "time: point"}
                values = fields[f"{name}_{part}"][None]
                found[f"{name}_{part}"] = ("time", values, attrs)
    return found


def write_grid(data: xr.Dataset, path: Path) -> None:
    """Write gridded output whole or not at all.

    Parameters
    ----------
    data : xarray.Dataset
        CF dataset.
    path : Path
        NetCDF file, replaced in one step.

    Raises
    ------
    FloeError
        Where the file cannot be written.
    """
    with write_atomically(path) as temporary:
        data.to_netcdf(temporary, engine="netcdf4", format="NETCDF4")


def join_times(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Fields of several times in one dataset; what has no time dimension stays as in the first.

    Parameters
    ----------
    parts : sequence of xarray.Dataset
        From `describe`, in order of time, on one grid.

    Returns
    -------
    xarray.Dataset
        In the order of the parts.
    """
    if len(parts) == 1:
        return parts[0]
    joined = xr.concat(
        parts, "time", data_vars="minimal", coords="minimal", compat="override", join="override",
        combine_attrs="override",
    )  # fmt: skip
    for name in joined.variables:
        # A window of an older program may lack a field.
        first = next(part for part in parts if name in part.variables)
        joined[name].encoding = dict(first[name].encoding)
    return joined


def join_files(paths: Sequence[Path], target: Path) -> None:
    """Append the times of CF files to each other, one file in memory at a time.

    Parameters
    ----------
    paths : sequence of Path
        Files on one grid, in order of time, as `write_grid` writes them.
    target : Path
        The joined file, written whole or not at all; ``time`` is its record dimension.

    Raises
    ------
    FloeError
        Where a file cannot be read or the target cannot be written.
    """
    with write_atomically(target) as temporary, netCDF4.Dataset(temporary, "w") as out:
        for path in paths:
            try:
                with netCDF4.Dataset(path) as part:
                    part.set_auto_maskandscale(False)
                    if not out.variables:
                        _define_like(part, out)
                    _append_times(part, out)
            except OSError as error:
                raise FloeError(f"{path}: cannot be read as NetCDF: {error.strerror}") from None


def _define_like(part: netCDF4.Dataset, out: netCDF4.Dataset) -> None:
    out.set_auto_maskandscale(False)
    out.setncatts({name: part.getncattr(name) for name in part.ncattrs()})
    for name, dimension in part.dimensions.items():
        out.createDimension(name, None if name == "time" else dimension.size)
    for name, variable in part.variables.items():
        attrs = {key: variable.getncattr(key) for key in variable.ncattrs()}
        made = out.createVariable(
            name,
            variable.dtype,
            variable.dimensions,
            fill_value=attrs.pop("_FillValue", None),
            compression="zlib" if variable.ndim >= 2 else None,
            complevel=4,
            chunksizes=_chunks(variable),
        )
        made.setncatts(attrs)
        if "time" not in variable.dimensions:
            made[...] = variable[...]


def _chunks(variable: netCDF4.Variable) -> tuple[int, ...] | None:
    """Chunks that suit maps as well as series: some tens of times of a piece of the map."""
    if variable.dimensions[:1] != ("time",) or variable.ndim < 3:
        return None
    return (30, *(1 for _ in variable.shape[1:-2]), *(min(n, 64) for n in variable.shape[-2:]))


def _append_times(part: netCDF4.Dataset, out: netCDF4.Dataset) -> None:
    first, count = out.dimensions["time"].size, part.dimensions["time"].size
    for name, variable in part.variables.items():
        if variable.dimensions[:1] == ("time",):
            out[name][first : first + count] = variable[...]
