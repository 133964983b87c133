# SPDX-License-Identifier: GPL-2.0-or-later
"""Which files a scene's forcing is read from. Opens none, so that it is cheap to ask."""

from __future__ import annotations

import glob
import hashlib
import shutil
import zipfile
import zlib
from collections.abc import Iterable
from pathlib import Path

from floeflow.core.atomic_write import write_atomically
from floeflow.core.errors import FloeError
from floeflow.scene.blocks import Scene

UNPACKED = Path("results/inputs")


def users_files(scene: Scene) -> tuple[str, ...]:
    """Files of the user that a window's forcing is read from, the depth of the sea among them.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    tuple of str
        Empty for analytic forcing without a file of depths.
    """
    files = tuple(map(str, forcing_files(scene))) if scene.forcing.source == "file" else ()
    return (*files, *depth_files(scene))


def depth_files(scene: Scene) -> tuple[str, ...]:
    """The file of the depth of the sea, of a scene that reads one.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    tuple of str
        One name, or none.
    """
    asked = "grounding" in scene.effects and scene.grounding.file
    return (scene.grounding.file,) if asked else ()


def forcing_files(scene: Scene) -> list[Path]:
    """Files of a scene's forcing, patterns filled in and archives unpacked, in their order.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    list of Path
        Each once.

    Raises
    ------
    FloeError
        Where a pattern meets no file, or an archive holds none.
    """
    given = ([scene.forcing.file] if scene.forcing.file else []) + list(scene.forcing.files)
    return all_files(given, "forcing.files")


def all_files(given: Iterable[str], key: str) -> list[Path]:
    """Files that names and patterns mean, archives unpacked; ``key`` asked for them.

    Parameters
    ----------
    given : iterable of str
        Names and patterns.
    key : str
        Of the scene, for messages.

    Returns
    -------
    list of Path
        Each once.

    Raises
    ------
    FloeError
        Where a pattern meets no file, or an archive holds none.
    """
    found: list[Path] = []
    for entry in given:
        matches = [Path(item) for item in sorted(glob.glob(entry))]
        if not matches:
            if any(sign in entry for sign in "*?["):
                raise FloeError(f"{key}: no file is named as {entry}")
            matches = [Path(entry)]
        for path in matches:
            archive = path.suffix.lower() == ".zip" and not path.name.endswith(".zarr.zip")
            found += unzip(path) if archive else [path]
    return list(dict.fromkeys(found))


def unzip(path: Path, folder: Path = UNPACKED) -> list[Path]:
    """Unpack an archive's data files, once: ERA5 comes as one.

    Parameters
    ----------
    path : Path
        ZIP archive.
    folder : Path, optional
        In which the files are kept.

    Returns
    -------
    list of Path
        Of the unpacked data files, in the archive's order.

    Raises
    ------
    FloeError
        Where it cannot be read, or holds no data file.
    """
    if not path.is_file():
        raise FloeError(f"{path}: there is no such file")
    stat = path.stat()
    mark = f"{path.resolve()} {stat.st_size} {stat.st_mtime_ns}"
    into = folder / f"{path.stem}-{hashlib.sha256(mark.encode()).hexdigest()[:12]}"
    found = []
    try:
        with zipfile.ZipFile(path) as archive:
            for item in archive.infolist():
                # Only the last part of a member's name: none can point out of the folder.
                name = Path(item.filename).name
                if item.is_dir() or not name.lower().endswith((".nc", ".nc4", ".grib", ".grb")):
                    continue
                target = into / name
                if not target.is_file():
                    with archive.open(item) as packed, write_atomically(target) as temporary:
                        # Piece by piece: a record of years does not fit into the memory.
                        with temporary.open("wb") as data:
                            shutil.copyfileobj(packed, data)
                found.append(target)
    except (OSError, EOFError, zipfile.BadZipFile, RuntimeError, zlib.error) as error:
        raise FloeError(f"{path}: cannot be unpacked ({type(error).__name__})") from None
    if not found:
        raise FloeError(f"{path}: holds no NetCDF or GRIB file")
    return found
