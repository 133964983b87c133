# SPDX-License-Identifier: GPL-2.0-or-later
"""PNG pictures in grey, placed by a world file; what a grey means stands in `mask.scale`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.core.readers.geotiff import raster

GREY = {"1", "L", "I", "I;16", "I;16B"}


def opens(path: Path) -> bool:
    """A file with the suffix of PNG.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    bool
        True if this reader takes the file.
    """
    return path.is_file() and path.suffix.lower() == ".png"


def open_raw(path: Path) -> xr.Dataset:
    """Open whole: variable ``grey`` on x and y, whose projection the scene has to name.

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
        Where it is no picture in grey, or has no world file.
    """
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            mode, values = picture.mode, np.asarray(picture)
    except (OSError, UnidentifiedImageError, SyntaxError) as error:
        raise FloeError(f"{path}: cannot be read as PNG ({type(error).__name__})") from None
    if mode not in GREY:
        raise FloeError(
            f"{path}: is a picture in colours ({mode}), whose numbers cannot be known; give one in "
            "grey"
        )
    return raster({"grey": values.astype(np.int32)}, _world(path), "")


def _world(path: Path) -> tuple[float, float, float, float]:
    """Place of the pixels from the world file beside the picture."""
    for suffix in (".pgw", ".pngw", ".wld"):
        world = path.with_suffix(suffix)
        if not world.is_file():
            continue
        try:
            a, d, b, e, c, f = (float(line) for line in world.read_text().split())
        except (ValueError, OSError):
            raise FloeError(f"{world}: is no world file of six numbers") from None
        if b != 0 or d != 0 or a == 0 or e == 0:
            raise FloeError(f"{world}: its rows do not run along x")
        # A world file names the centre of the upper left pixel.
        return a, c - 0.5 * a, e, f - 0.5 * e
    raise FloeError(
        f"{path}: has no world file ({path.with_suffix('.pgw').name}) that says where it lies"
    )
