# SPDX-License-Identifier: GPL-2.0-or-later
"""``results/<scene>/manifest.json``: all that a run was made from, so that it can be repeated.

Written by the workflow at the end of a run. The scene is in it with every key; versions, hashes and
ranks say with what; host and timings say where and how long.
"""

from __future__ import annotations

import csv
import hashlib
import importlib.metadata
import json
import os
import platform
import subprocess
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from floeflow.core.atomic_write import write_text
from floeflow.core.file_hash import file_hash
from floeflow.forcings.files import depth_files, forcing_files
from floeflow.masks.polygon_inputs import polygon_inputs
from floeflow.scene import Scene
from floeflow.workflow.library import PACKAGES, library_digest

MANIFEST = "manifest.json"
# Whose versions may change a number.
LIBRARIES = (
    *("floeflow", "snakemake", "numpy", "scipy", "numba"),
    *("xarray", "netCDF4", "pyproj", "shapely", "mpi4py"),
)


def input_files(scene: Scene) -> list[str]:
    """Files that the scene names: mask, shoreline, region, forcing, sea, walls.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    list of str
        Sorted, each once.
    """
    mask = scene.mask
    named = [
        mask.labels.file or ("" if mask.uniform else mask.file),
        *polygon_inputs(mask),
        *forcing_files(scene),
        *depth_files(scene),
        scene.sea.file,
        scene.walls.mesh if "walls" in scene.effects else "",
    ]
    return sorted({str(name) for name in named if name})


def hash_of(name: str) -> str:
    """SHA-256 of an input file; of a folder (a Zarr store), of its files' names and hashes.

    Parameters
    ----------
    name : str
        Of a file or folder.

    Returns
    -------
    str
        Hexadecimal, 64 digits.
    """
    path = Path(name)
    if not path.is_dir():
        return file_hash(path)
    digest = hashlib.sha256()
    for each in sorted(path.rglob("*")):
        if each.is_file():
            digest.update(f"{each.relative_to(path)} {file_hash(each)}\n".encode())
    return digest.hexdigest()


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that may change a number."""
    found = {"python": platform.python_version()}
    for name in LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


def timings(folder: Path) -> dict[str, dict[str, float]]:
    """Seconds, CPU seconds and memory (MB) of each job, as Snakemake measured them.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``.

    Returns
    -------
    dict of dict of float
        By job, then by name of the number.
    """
    found = {}
    for path in sorted((folder / "benchmarks").rglob("*.tsv")):
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file, delimiter="\t"))
        if rows:
            names = {"s": "seconds", "cpu_time": "cpu_seconds", "max_rss": "memory_mb"}
            found[path.relative_to(folder / "benchmarks").with_suffix("").as_posix()] = {
                name: float(rows[-1][column])
                for column, name in names.items()
                if _is_number(rows[-1].get(column))
            }
    return found


def write_manifest(scene: Scene, folder: Path, plugin: Path, last: str, workflow: Path) -> Path:
    """Write a run's manifest.

    Parameters
    ----------
    scene : Scene
        With concrete effects.
    folder : Path
        ``results/<scene>``.
    plugin : Path
        The LIGGGHTS plugin.
    last : str
        Name of the run's last window.
    workflow : Path
        Folder of the Snakefile.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    FloeError
        Where an input or the last state cannot be read any more.
    """
    # What reads states is large: at a workflow's start, which imports this, it is not needed.
    from floeflow.state import read_state

    provenance = json.loads(read_state(folder / "state" / f"{last}.nc").attrs["provenance"])
    manifest: dict[str, Any] = {
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
        "scene": scene.model_dump(mode="json"),
        "seed": scene.seed,
        "ranks": int(provenance["ranks"]),
        "versions": versions(),
        "commit": _commit(workflow),
        "code": {stage: library_digest(stage) for stage in PACKAGES},
        "plugin": file_hash(plugin),
        "inputs": {name: hash_of(name) for name in input_files(scene)},
        "last_state": {"window": last, "hash": str(provenance["window"])},
        "host": {
            "name": platform.node(),
            "system": platform.platform(),
            "processor": _processor(),
            "cores": os.cpu_count(),
        },
        "timings": timings(folder),
    }
    path = folder / MANIFEST
    write_text(json.dumps(manifest, indent=1) + "\n", path)
    return path


def _is_number(text: str | None) -> bool:
    try:
        float(text or "")
    except ValueError:
        return False
    return True


def _commit(folder: Path) -> str:
    """Commit of the checkout, with a plus where files differ from it; empty without git."""
    words = ["git", "-C", str(folder), "describe", "--always", "--abbrev=40", "--dirty=+"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.strip()


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    found = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(found, platform.processor())
