# SPDX-License-Identifier: GPL-2.0-or-later
"""NetCDF of every kind."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from floeflow.core.errors import FloeError


def opens(path: Path) -> bool:
    """Any file that no other reader takes.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    bool
        True if this reader takes the file.
    """
    return path.is_file()


def open_raw(path: Path) -> xr.Dataset:
    """Open lazily, undecoded.

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
        Where it cannot be read as NetCDF.
    """
    try:
        return xr.open_dataset(
            path, engine="netcdf4", decode_cf=False, create_default_indexes=False
        )
    except Exception as error:  # a damaged HDF5 file raises whatever its bytes lead to
        with path.open("rb") as file:
            if file.read(256).lstrip().startswith(b"<"):
                raise FloeError(
                    f"{path}: is a page of HTML or XML and no data: did its download need a login?"
                ) from None
        raise FloeError(f"{path}: cannot be read as NetCDF ({type(error).__name__})") from None
