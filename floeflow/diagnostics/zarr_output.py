# SPDX-License-Identifier: GPL-2.0-or-later
"""Gridded output as a Zarr store, for reading in parts over a network."""

from __future__ import annotations

import shutil
from pathlib import Path

import xarray as xr

from floeflow.core.errors import FloeError

# What of a NetCDF file's encoding means the same in Zarr.
KEPT = ("dtype", "_FillValue", "units", "calendar", "coordinates")
TIMES = 30


def write_zarr(grid: Path, target: Path) -> None:
    """Write ``grid.nc`` as a Zarr store, with some tens of times of the whole map in a chunk.

    Parameters
    ----------
    grid : Path
        CF fields, as `floeflow.diagnostics.cf_output` writes them.
    target : Path
        The store, made anew; half a store is never left under this name.

    Raises
    ------
    FloeError
        Where the package zarr is missing, or a file cannot be read.
    """
    try:
        import zarr  # noqa: F401
    except ImportError:
        raise FloeError(
            f"{target}: the package zarr is not installed: pip install 'floeflow[formats]'"
        ) from None
    try:
        with xr.open_dataset(grid, engine="netcdf4") as opened:
            data = opened.load()
    except OSError as error:
        raise FloeError(f"{grid}: cannot be read: {error.strerror or error}") from None
    for variable in data.variables.values():
        variable.encoding = {
            key: variable.encoding[key] for key in KEPT if key in variable.encoding
        }
        if variable.dims[:1] == ("time",) and variable.ndim > 1:
            variable.encoding["chunks"] = (min(TIMES, variable.shape[0]), *variable.shape[1:])
    half = target.with_name(f".{target.name}.part")
    for folder in (half, target):
        shutil.rmtree(folder, ignore_errors=True)
    half.parent.mkdir(parents=True, exist_ok=True)
    # Version 2 of the format, which more programs read (GDAL among them).
    data.to_zarr(half, mode="w", zarr_format=2, consolidated=True)
    half.rename(target)
