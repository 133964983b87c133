# SPDX-License-Identifier: GPL-2.0-or-later
"""Zarr stores, folders or zipped (optional: `zarr`)."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from floeflow.core.errors import FloeError

MARKS = (".zgroup", ".zmetadata", "zarr.json")


def opens(path: Path) -> bool:
    """A folder with Zarr's metadata, or a file named ``.zarr.zip``.

    Parameters
    ----------
    path : Path
        The folder or zip file.

    Returns
    -------
    bool
        True if this reader takes the file.
    """
    if path.is_dir():
        return any((path / mark).is_file() for mark in MARKS)
    return path.name.endswith(".zarr.zip")


def open_raw(path: Path) -> xr.Dataset:
    """Open lazily, undecoded.

    Parameters
    ----------
    path : Path
        The folder or zip file.

    Returns
    -------
    xarray.Dataset
        Numbers as stored, with CF attributes that say what they mean.

    Raises
    ------
    FloeError
        Where `zarr` is not installed or the store is damaged.
    """
    try:
        import zarr  # noqa: F401
    except ImportError:
        raise FloeError(
            f"{path}: is a Zarr store, which needs the package zarr: "
            ".venv/bin/pip install 'floeflow[formats]'"
        ) from None
    try:
        return xr.open_dataset(path, engine="zarr", decode_cf=False, create_default_indexes=False)
    except Exception as error:  # a damaged store raises whatever its bytes lead to
        raise FloeError(f"{path}: cannot be read as Zarr ({type(error).__name__})") from None
