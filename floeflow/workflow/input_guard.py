# SPDX-License-Identifier: GPL-2.0-or-later
"""Input files are checked in a process of their own, once for each scene and state of its files.

The libraries that read them are large, and a damaged file may bring them down, or make them ask for
all memory: then the run ends with a sentence, not with them. A check that passed is remembered by
what it depends on: keys of the scene, size and age of the files, the code that reads them. This
side imports no reader: it stands in the way of every start of the workflow.
"""

from __future__ import annotations

import hashlib
import json
import math
import signal
import subprocess
import sys
from pathlib import Path

from floeflow.core.atomic_write import write_text
from floeflow.core.errors import FloeError
from floeflow.forcings.files import users_files
from floeflow.scene import Scene
from floeflow.workflow.library import library_digest

PASSED = Path("results/inputs/passed")
# Processor time of a check: of any, and for each megabyte of its files.
LEAST_SECONDS, SECONDS_A_MB = 60, 0.2
KEYS: dict[str, bool | set[str]] = {
    **dict.fromkeys(("domain", "mask", "forcing", "time", "effects", "sea"), True),
    "packing": {"generator"},
}


def check_inputs(scene: Scene, passed: set[str], remember: bool = True) -> None:
    """Refuse a scene whose mask or forcing files its stages could not use.

    Parameters
    ----------
    scene : Scene
        With concrete effects.
    passed : set of str
        Digests of what passed in this process; one is added. Scenes of an ensemble share their
        files, so that one check does for all.
    remember : bool
        Whether to write down that the check passed.

    Raises
    ------
    FloeError
        As the checks of mask and forcing, or where one of the files brings the reader down.
    """
    digest, size = _digest(scene)
    mark = PASSED / digest
    if digest in passed or mark.is_file():
        return
    seconds = math.ceil(LEAST_SECONDS + SECONDS_A_MB * size / 1e6)
    done = subprocess.run(
        [sys.executable, "-m", "floeflow.workflow.input_reader", str(seconds)],
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
    passed.add(digest)
    if remember:
        write_text("", mark)


def _digest(scene: Scene) -> tuple[str, int]:
    """Digest of what a check depends on, and the bytes of its files."""
    keys = scene.model_dump(mode="json", include=KEYS)
    files: list[tuple[str, int, int]] = []
    try:
        given = [
            scene.mask.file,
            *users_files(scene),
            *(name for name in (scene.sea.file, scene.mask.labels.file) if name),
        ]
    except FloeError:
        given = [scene.mask.file]
    for name in given:
        path = Path(name)
        for each in [path] if not path.is_dir() else sorted(path.rglob("*")):
            if each.is_file():
                stat = each.stat()
                files.append((str(each), stat.st_size, stat.st_mtime_ns))
    code = [library_digest("mask"), library_digest("windows")]
    text = json.dumps([keys, files, code], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:24], sum(size for _, size, _ in files)
