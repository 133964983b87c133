# SPDX-License-Identifier: GPL-2.0-or-later
"""Input files of any known format, put into one order: one coordinate variable a dimension.

What differs between files that mean the same is evened out here, before anything is looked up:
ERA5's two experiment versions, forecasts' times and steps, dimensions whose coordinates have
another name, projected axes whose projection only the user knows. Values stay as stored.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyproj
import xarray as xr
from pyproj.exceptions import CRSError

from floeflow.core import coordinate_kinds as kinds
from floeflow.core.errors import FloeError
from floeflow.core.readers import open_raw

FORECAST = ("forecast_reference_time", "forecast_period")
SPATIAL = ("latitude", "longitude", "projected x", "projected y")


@dataclass(frozen=True)
class Hints:
    """What the user says of a file that does not say it itself.

    Parameters
    ----------
    key : str
        Block of the scene, for sentences: ``mask`` or ``forcing``.
    crs : str
        Projection of axes in metres without a grid mapping.
    flags : mapping of str to sequence of int
        Stored numbers that are no data, by what they mean.
    flagged : str
        The variable that they belong to; empty: all.
    scale : float
        What 1 in the file is as a share; 0: as its units say.
    """

    key: str = "mask"
    crs: str = ""
    flags: Mapping[str, Sequence[int]] = field(default_factory=dict)
    flagged: str = ""
    scale: float = 0.0


def open_input(path: str | Path, hints: Hints | None = None) -> xr.Dataset:
    """Open a file lazily; values as stored, coordinates in order.

    Parameters
    ----------
    path : str or Path
        File.
    hints : Hints, optional
        What the scene says of the file.

    Returns
    -------
    xarray.Dataset
        To be closed by the caller.

    Raises
    ------
    FloeError
        In one sentence: no file, not readable, a projection that names none.
    """
    raw = open_raw(path)
    data = raw.reset_coords([name for name in raw.coords if name not in raw.dims])
    data = _merge_versions(data)
    data = _valid_times(data)
    data = _own_coordinates(data)
    if hints:
        data = _with_hints(data, hints, path)
    data.set_close(raw.close)
    return data


def _merge_versions(data: xr.Dataset) -> xr.Dataset:
    """ERA5's ``expver``: final data (1), and preliminary (5) where there are none of these."""
    if "expver" not in data.dims or "expver" not in data.variables:
        return data
    versions = [str(item).strip().lstrip("0") for item in data["expver"].values]
    order = sorted(range(len(versions)), key=lambda k: (versions[k] != "1", k))
    merged = data.isel(expver=order[0]).drop_vars("expver")
    for name, item in data.data_vars.items():
        if "expver" not in item.dims:
            continue
        bare = item.drop_vars(list(item.coords))
        field = bare.isel(expver=order[0])
        for k in order[1:]:
            field = xr.where(_known(field), field, bare.isel(expver=k), keep_attrs=False)
        merged[name] = field.assign_attrs(item.attrs)
    return merged


def _known(field: xr.DataArray) -> xr.DataArray:
    known = xr.ones_like(field, dtype=bool)
    for key in ("_FillValue", "missing_value"):
        if key in field.attrs:
            known = known & (field != field.attrs[key])
    return known & field.notnull()


def _valid_times(data: xr.Dataset) -> xr.Dataset:
    """Forecasts: the time that a field is valid at, instead of the forecast's start and step."""
    found = [
        name
        for name, item in data.variables.items()
        if item.attrs.get("standard_name") == "time" or name == "valid_time"
        if " since " in str(item.attrs.get("units", ""))
    ]
    valid = next((name for name in found if data[name].ndim == 2), None)
    if valid is not None:
        return _stack(data, str(valid))
    for dim in list(data.dims):
        times = [str(n) for n in found if n in data.variables and data[n].dims == (dim,)]
        better = "valid_time" if "valid_time" in times else (times[0] if times else "")
        own = data.variables.get(dim)
        if better and better != dim and own is not None:
            start = own.attrs.get("standard_name") in FORECAST or "valid_time" == better
            if start:
                data = data.assign({str(dim): data[better].variable}).drop_vars(better)
    return _add_steps(data)


def _stack(data: xr.Dataset, valid: str) -> xr.Dataset:
    """A forecast's start and step as one axis of times that ascend, each once."""
    both = data[valid].dims
    flat = data[valid].values.reshape(-1)
    _, first = np.unique(flat, return_index=True)
    attrs = dict(data[valid].attrs)
    steps = np.unravel_index(first, data[valid].shape)
    index = {dim: xr.DataArray(k, dims="valid time") for dim, k in zip(both, steps, strict=True)}
    out = data.drop_vars([valid, *(dim for dim in both if dim in data.variables)])
    out = out.isel(index).rename({"valid time": str(both[0])})
    out[str(both[0])] = ((both[0],), flat[first], {**attrs, "standard_name": "time"})
    return out


def _add_steps(data: xr.Dataset) -> xr.Dataset:
    """A forecast's start plus its one step, where the file gives no valid time."""
    for dim in list(data.dims):
        own = data.variables.get(dim)
        if own is None or own.attrs.get("standard_name") != "forecast_reference_time":
            continue
        for name, item in data.variables.items():
            if item.attrs.get("standard_name") != "forecast_period" or item.size != 1:
                continue
            unit = str(own.attrs.get("units", "")).split(" since ")[0]
            step = kinds.seconds_in(str(item.attrs.get("units", "")))
            start = kinds.seconds_in(unit)
            if step is None or start is None:
                continue
            shift = float(np.asarray(item.values).reshape(())) * step / start
            attrs = {**own.attrs, "standard_name": "time"}
            data = data.assign({str(dim): (own.dims, own.values + shift, attrs)})
            return data.drop_vars(str(name))
    return data


def _own_coordinates(data: xr.Dataset) -> xr.Dataset:
    """Give each dimension its coordinate variable under its own name.

    Files name axes otherwise, as ``xgrid(x)``, or ``tdim`` with a variable ``time(tdim)``.
    """
    for dim in list(data.dims):
        own = data.variables.get(dim)
        if own is not None and own.dims == (dim,) and kinds.kind_of(str(dim), own.attrs):
            continue
        others = [
            str(name)
            for name, item in data.variables.items()
            if name != dim and item.dims == (dim,) and kinds.kind_of(str(name), item.attrs)
        ]
        if len(others) > 1:
            others = [
                name
                for name in others
                if kinds.kind_of(name, data[name].attrs) in ("time", *SPATIAL)
                and data[name].attrs.get("standard_name") not in FORECAST
            ]
        if len(others) == 1:
            item = data[others[0]].variable
            attrs = {"long_name": others[0], **item.attrs}
            if kinds.kind_of(str(dim), attrs) == "":
                attrs["standard_name"] = kinds.standard_name(others[0], attrs)
            data = data.drop_vars([others[0]]).assign({str(dim): (item.dims, item.data, attrs)})
    return data


def _with_hints(data: xr.Dataset, hints: Hints, path: str | Path) -> xr.Dataset:
    if hints.crs:
        data = _with_crs(data, hints, path)
    for name, item in data.data_vars.items():
        if hints.flagged and name != hints.flagged:
            continue
        if hints.flags and item.ndim >= 2:
            pairs = [(code, word) for word, codes in hints.flags.items() for code in codes]
            item.attrs["floeflow_flags"] = pairs
        if hints.scale and item.ndim >= 2:
            # On top of a packing, whose values are the file's numbers.
            packing = {"scale_factor": 1.0, "add_offset": 0.0}
            scaled = {key: hints.scale * item.attrs.get(key, own) for key, own in packing.items()}
            item.attrs |= {**scaled, "units": "1"}
    return data


def _with_crs(data: xr.Dataset, hints: Hints, path: str | Path) -> xr.Dataset:
    try:
        crs = pyproj.CRS.from_user_input(hints.crs)
    except CRSError:
        raise FloeError(
            f"{hints.key}.crs: '{hints.crs}' names no coordinate system, for {path}"
        ) from None
    for axis in "xy":
        for dim in data.dims:
            own = data.variables.get(dim)
            if own is None or own.dims != (dim,) or not str(dim).lower().startswith(axis):
                continue
            if kinds.kind_of(str(dim), own.attrs) in ("", f"projected {axis}"):
                own.attrs["standard_name"] = f"projection_{axis}_coordinate"
    data["floeflow_crs"] = ((), 0, {"crs_wkt": crs.to_wkt()})
    for item in data.data_vars.values():
        if item.ndim >= 2 and "grid_mapping" not in item.attrs:
            item.attrs["grid_mapping"] = "floeflow_crs"
    return data
