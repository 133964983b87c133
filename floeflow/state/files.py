# SPDX-License-Identifier: GPL-2.0-or-later
"""Checksummed NetCDF-4 files, written whole or not at all.

A file is written under a unique temporary name beside its place, synced and renamed, so that a
reader sees the old file or the new one, never a half. It ends with the checksum of its bytes
(`floeflow.state.file_checksum`), which the reader verifies first. The attribute `checksum` names
the content, whatever library wrote it: it covers names, types, shapes, bytes and attributes.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr

from floeflow.core.atomic_write import write_atomically
from floeflow.core.errors import FloeError
from floeflow.state.file_checksum import append_file_checksum, check_file_checksum
from floeflow.state.migrations import migrate
from floeflow.state.schema import ROUNDED, VARIABLES, check_state

CHECKSUM = "checksum"


def checksum(data: xr.Dataset) -> str:
    """SHA-256 of a dataset's names, types, shapes, bytes and attributes (but of itself).

    Parameters
    ----------
    data : xarray.Dataset
        Any dataset.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    digest = hashlib.sha256()
    attrs = {name: _plain(value) for name, value in data.attrs.items() if name != CHECKSUM}
    digest.update(json.dumps(attrs, sort_keys=True).encode())
    for name in sorted(str(name) for name in data.variables):
        values = np.ascontiguousarray(data[name].values)
        if values.dtype.kind in "UO":
            values = np.char.encode(values.astype(str), "utf-8")
        head = f"{name} {data[name].dims} {values.shape} {values.dtype.newbyteorder('=').str}"
        digest.update(head.encode())
        digest.update(values.tobytes())
    return digest.hexdigest()


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value


def write_dataset(data: xr.Dataset, path: str | Path) -> str:
    """Write a dataset atomically, with its checksum, and return its checksum.

    Parameters
    ----------
    data : xarray.Dataset
        Data without encoded times or missing values.
    path : str or Path
        Its place; folders are made.

    Returns
    -------
    str
        SHA-256 of the content, in hexadecimal.

    Raises
    ------
    FloeError
        Where the file cannot be written; nothing of it is left then, and an older one stays.
    """
    path = Path(path)
    data = data.copy()
    data.attrs[CHECKSUM] = checksum(data)
    with write_atomically(path) as temporary:
        encoding = {str(name): {"_FillValue": None} for name in data.variables}
        data.to_netcdf(temporary, engine="netcdf4", format="NETCDF4", encoding=encoding)
        append_file_checksum(temporary)
        with open(temporary, "rb+") as file:
            os.fsync(file.fileno())
    return str(data.attrs[CHECKSUM])


def read_dataset(path: str | Path) -> xr.Dataset:
    """Verify the checksum of a file of `write_dataset` and read it into memory.

    Parameters
    ----------
    path : str or Path
        Of the file.

    Returns
    -------
    xarray.Dataset
        In memory; the file is closed.

    Raises
    ------
    FloeError
        Where it is missing, damaged or not written by FloeFlow.
    """
    path = Path(path)
    if not path.is_file():
        raise FloeError(f"{path}: there is no such file")
    try:
        check_file_checksum(path)
        with xr.open_dataset(
            path, engine="netcdf4", decode_cf=False, mask_and_scale=False
        ) as opened:
            data = opened.load()
    except OSError as error:
        raise FloeError(f"{path}: cannot be read: {error.strerror or error}") from None
    for name, value in data.attrs.items():
        data.attrs[name] = _plain(value)
    return data


def write_state(
    state: xr.Dataset, path: str | Path, precision: Literal["double", "single"] = "double"
) -> str:
    """Check a state, describe its variables, write it atomically; return its checksum.

    Parameters
    ----------
    state : xarray.Dataset
        All floating variables in double precision.
    path : str or Path
        Its place.
    precision : str
        In which the file keeps the variables that `schema.ROUNDED` names; ids, counts and the
        variables of `schema.EXACT` stay as they are.

    Returns
    -------
    str
        SHA-256 of the content, in hexadecimal.

    Raises
    ------
    FloeError
        Where it breaks the schema or cannot be written.
    """
    state = state.copy()
    try:
        check_state(state)
    except FloeError as error:
        raise FloeError(f"{path}: not written: {error}") from None
    for name in state.variables:
        rule = VARIABLES[str(name)]
        if precision == "single" and name in ROUNDED:
            # Bounds of the schema are single precision numbers, so that rounding keeps them.
            state[name] = state[name].astype(np.float32)
        state[name].attrs = {"units": rule.units, "long_name": rule.long_name}
    return write_dataset(state, path)


def read_state(path: str | Path) -> xr.Dataset:
    """Read a state, verify its checksum and schema; all floating variables in double precision.

    A state of an older schema version is brought to the present one (`floeflow.state.migrations`).

    Parameters
    ----------
    path : str or Path
        Of the file.

    Returns
    -------
    xarray.Dataset
        Of the present schema version, in memory.

    Raises
    ------
    FloeError
        In one sentence that names the file.
    """
    state = read_dataset(path)
    for name in ROUNDED:
        if name in state and state[name].dtype == np.float32:
            state[name] = state[name].astype(np.float64)
    try:
        state = migrate(state)
        check_state(state)
    except FloeError as error:
        raise FloeError(f"{path}: {error}") from None
    return state
