# SPDX-License-Identifier: GPL-2.0-or-later
"""The process that reads a scene's input files for `reading_process`.

A scene on its standard input; its seconds of processor time as the argument.
"""

from __future__ import annotations

import resource
import sys

from floeflow.analysis.file_checks import check_files
from floeflow.core.errors import FloeError, answer
from floeflow.scene import Scene

MOST_BYTES = 12 * 2**30


def _check() -> str:
    limits = ((resource.RLIMIT_AS, MOST_BYTES), (resource.RLIMIT_CPU, int(sys.argv[1])))
    for kind, most in limits:
        _, hard = resource.getrlimit(kind)
        resource.setrlimit(kind, (most if hard < 0 else min(most, hard), hard))
    scene = Scene.model_validate_json(sys.stdin.read())
    try:
        check_files(scene)
    except MemoryError:
        raise FloeError(
            f"{scene.mask.file}, or the forcing, asks for more than {MOST_BYTES >> 30} GiB"
        ) from None
    return ""


if __name__ == "__main__":
    sys.exit(answer(_check))
