# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene's input files checked in a process of their own.

The libraries that read them are large, and a damaged file may bring them down, let them read for
ever, or make them ask for all memory: then the program ends with a sentence, not with them. This
side imports no reader: it stands in the way of every start of the workflow.
"""

from __future__ import annotations

import math
import signal
import subprocess
import sys
from pathlib import Path

from floeflow.core.errors import FloeError
from floeflow.core.polygon_names import files_of_polygons
from floeflow.forcings.files import users_files
from floeflow.masks.polygon_inputs import polygon_inputs
from floeflow.scene import Scene

# Processor time of a check: of any, and for each megabyte of its files.
LEAST_SECONDS, SECONDS_A_MB = 60, 0.2
# Marks of a Zarr store, whose files are counted; any other folder is refused when it is read.
STORE_MARKS = (".zgroup", ".zmetadata", "zarr.json")


def files_behind(scene: Scene) -> list[tuple[str, int, int]]:
    """Files that a check reads: name, size (bytes) and time of the last change (ns).

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    try:
        given = [
            scene.mask.file,
            *users_files(scene),
            *(name for name in (scene.sea.file, scene.mask.labels.file) if name),
            *polygon_inputs(scene.mask),
            *files_of_polygons(scene.packing.size.polygons),
        ]
    except FloeError:
        given = [scene.mask.file]
    found: list[tuple[str, int, int]] = []
    for name in given:
        path = Path(name)
        store = any((path / mark).is_file() for mark in STORE_MARKS)
        for each in sorted(path.rglob("*")) if store else [path]:
            if each.is_file():
                stat = each.stat()
                found.append((str(each), stat.st_size, stat.st_mtime_ns))
    return found


def check_in_process(scene: Scene) -> None:
    """Refuse a scene whose mask or forcing files its stages could not use.

    Parameters
    ----------
    scene : Scene
        With concrete effects.

    Raises
    ------
    FloeError
        As the checks of mask and forcing, or where one of the files brings the reader down.
    """
    size = sum(size for _, size, _ in files_behind(scene))
    seconds = math.ceil(LEAST_SECONDS + SECONDS_A_MB * size / 1e6)
    done = subprocess.run(
        [sys.executable, "-m", "floeflow.analysis.input_reader", str(seconds)],
        input=scene.model_dump_json(),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode < 0 or done.returncode not in (0, 1):
        how = signal.Signals(-done.returncode).name if done.returncode < 0 else "a fault"
        what = f"reading {scene.mask.file or 'the mask'} or the forcing"
        if done.returncode == -signal.SIGXCPU:
            raise FloeError(
                f"{what} took more than {seconds} s of processor time: a file is damaged, such as "
                "by a loop in it"
            )
        raise FloeError(f"{what} ended the reader ({how}): a file is damaged or far too large")
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line.startswith("floeflow: ")]
        raise FloeError((lines or ["floeflow: the check of the input files failed"])[-1][10:])
