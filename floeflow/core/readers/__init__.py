# SPDX-License-Identifier: GPL-2.0-or-later
"""Readers of file formats: each opens a file as a dataset with CF attributes, values as stored.

A reader is one small file with `opens(path)`, which tells by the name or the first bytes whether
the file is its own, and `open_raw(path)`, which opens it lazily. Numbers stay packed, fills and
flags stay numbers: `floeflow.core.unpack` decodes them, the same for all formats. Extensions add
readers with `add_reader`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.core.extensions import load_extensions
from floeflow.core.readers import geotiff, grib, netcdf, nsidc, png, zarr_store

# What every reader of attributes takes for text.
TEXTS = {"standard_name", "units", "long_name", "calendar", "positive", "axis", "cell_methods"}
# In the order in which they are asked; NetCDF is the last resort and says what is wrong.
READERS: tuple[ModuleType, ...] = (zarr_store, grib, geotiff, png, nsidc, netcdf)


@dataclass(frozen=True)
class Reader:
    """A reader from outside, asked before those of FloeFlow.

    Parameters
    ----------
    opens : callable
        Whether a path is a file of its format.
    open_raw : callable
        Opens it lazily, as a dataset with CF attributes, values as stored.
    """

    opens: Callable[[Path], bool]
    open_raw: Callable[[Path], xr.Dataset]


_ADDED: list[Reader] = []


def add_reader(opens: Callable[[Path], bool], open_raw: Callable[[Path], xr.Dataset]) -> None:
    """Register a reader of another format; see `Reader`.

    Parameters
    ----------
    opens : callable
        Whether the reader takes a file, by its path.
    open_raw : callable
        Opens it as a dataset that is not decoded.
    """
    _ADDED.append(Reader(opens, open_raw))


def open_raw(path: str | Path) -> xr.Dataset:
    """Open a file of any known format, values as stored.

    Parameters
    ----------
    path : str or Path
        File or folder (a Zarr store).

    Returns
    -------
    xarray.Dataset
        Numbers as stored, with CF attributes that say what they mean.

    Raises
    ------
    FloeError
        Where there is no such file, where its format needs a library that is not installed, or
        where it cannot be read.
    """
    path = Path(path)
    if not path.exists():
        raise FloeError(f"{path}: there is no such file")
    if not (path.is_file() or path.is_dir()):
        raise FloeError(f"{path}: is no file, but a pipe or a device")
    load_extensions()
    own = (Reader(reader.opens, reader.open_raw) for reader in READERS)
    try:
        for reader in (*_ADDED, *own):
            if reader.opens(path):
                return _with_texts(reader.open_raw(path))
    except OSError as error:
        raise FloeError(f"{path}: cannot be read: {error.strerror or error}") from None
    raise FloeError(f"{path}: is a folder, and no Zarr store")


def _with_texts(data: xr.Dataset) -> xr.Dataset:
    """Attributes that CF has as text, as text: a damaged file may hold numbers there."""
    for item in data.variables.values():
        for name in TEXTS & item.attrs.keys():
            item.attrs[name] = str(item.attrs[name])
    return data


__all__ = ["READERS", "add_reader", "open_raw"]
