# SPDX-License-Identifier: GPL-2.0-or-later
"""Input files are checked once for each scene and state of its files.

A check that passed is remembered by what it depends on: keys of the scene, size and age of the
files, the code that reads them.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from floeflow.analysis.reading_process import check_in_process, files_behind
from floeflow.core.atomic_write import write_text
from floeflow.scene import Scene
from floeflow.workflow.library import library_digest

PASSED = Path("results/inputs/passed")
KEYS: dict[str, bool | set[str]] = {
    **dict.fromkeys(("domain", "mask", "forcing", "grounding", "time", "effects", "sea"), True),
    "packing": {"generator", "size"},
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
    digest = _digest(scene)
    mark = PASSED / digest
    if digest in passed or mark.is_file():
        return
    check_in_process(scene)
    passed.add(digest)
    if remember:
        write_text("", mark)


def _digest(scene: Scene) -> str:
    """Digest of what a check depends on."""
    keys = scene.model_dump(mode="json", include=KEYS)
    code = [library_digest(stage) for stage in ("mask", "packing", "windows")]
    text = json.dumps([keys, files_behind(scene), code], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:24]
