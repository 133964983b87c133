# SPDX-License-Identifier: GPL-2.0-or-later
"""GRIB 1 and 2 through cfgrib (optional: `cfgrib`, with ecCodes from PyPI).

cfgrib makes one dataset of what shares its levels and times, and refuses the rest. Here each such
group is opened, and the groups are put side by side; dimensions of one name and other values get
the group's number behind their name.
"""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from floeflow.core.errors import FloeError

SUFFIXES = (".grib", ".grib1", ".grib2", ".grb", ".grb1", ".grb2")


def opens(path: Path) -> bool:
    """A file that begins as GRIB does, or has its suffix.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    bool
        True if this reader takes the file.
    """
    if not path.is_file():
        return False
    if path.suffix.lower() in SUFFIXES:
        return True
    with path.open("rb") as file:
        return file.read(4) == b"GRIB"


def open_raw(path: Path) -> xr.Dataset:
    """Open lazily; values are unpacked by ecCodes, missing ones NaN.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    xarray.Dataset
        Numbers as stored, with CF attributes that say what they mean.

    Raises
    ------
    FloeError
        Where cfgrib is not installed or the file cannot be read.
    """
    try:
        import cfgrib
    except (ImportError, RuntimeError):  # without ecCodes, cfgrib raises the latter
        raise FloeError(
            f"{path}: is a GRIB file, which needs the package cfgrib: "
            ".venv/bin/pip install 'floeflow[formats]'"
        ) from None
    try:
        # No index file is left beside the user's data.
        groups = cfgrib.open_datasets(
            str(path), backend_kwargs={"indexpath": ""}, decode_times=False
        )
    except Exception as error:  # a damaged file raises whatever its bytes lead to
        raise FloeError(f"{path}: cannot be read as GRIB ({type(error).__name__})") from None
    if not groups:
        raise FloeError(f"{path}: holds no GRIB message that can be read")
    return _beside(groups)


def _beside(groups: list[xr.Dataset]) -> xr.Dataset:
    """Put groups into one dataset, renaming what differs under one name."""
    merged = _with_coordinates(groups[0])
    for number, group in enumerate(groups[1:], start=2):
        plain = _with_coordinates(group)
        same = {
            name
            for name in plain.variables
            if name in merged.variables and merged[name].identical(plain[name])
        }
        clash = {
            str(name): f"{name}_{number}"
            for name in {*plain.variables, *plain.dims}
            if name not in same
            and (name in merged.variables or name in merged.dims)
        }  # fmt: skip
        for item in plain.variables.values():
            if "coordinates" in item.attrs:
                said = item.attrs["coordinates"].split()
                item.attrs["coordinates"] = " ".join(clash.get(name, name) for name in said)
        merged = xr.merge([merged, plain.rename(clash)], compat="override", join="override")
    return merged


def _with_coordinates(group: xr.Dataset) -> xr.Dataset:
    """Write to the variables' attributes which level and time they have."""
    plain = group.drop_indexes(list(group.indexes)).copy()
    for item in plain.data_vars.values():
        item.attrs["coordinates"] = " ".join(str(n) for n in item.coords if n not in item.dims)
    return plain
