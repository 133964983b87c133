# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes with concrete effects: what ``effects: auto`` means for this ice and weather."""

from __future__ import annotations

from pathlib import Path

from floeflow.analysis.reading_process import check_in_process
from floeflow.scene import Scene
from floeflow.scene.load import load_scene


def resolve_scene(path: str | Path) -> Scene:
    """Read a scene file; ``effects: auto`` becomes the effects that the estimates recommend.

    Parameters
    ----------
    path : str or Path
        Of the scene file.

    Raises
    ------
    FloeError
        One sentence that names the file and the key.
    """
    return load_scene(path, _choose)


def checked_scene(path: str | Path) -> Scene:
    """As `resolve_scene`, its input files checked in a process of their own before they are read.

    Parameters
    ----------
    path : str or Path
        Of the scene file.

    Raises
    ------
    FloeError
        One sentence that names the file and the key, or the input file and what is wrong.
    """
    scene = resolve_scene(path)
    check_in_process(scene)
    return scene


def _choose(scene: Scene) -> tuple[str, ...]:
    check_in_process(scene)
    # Estimates read masks and weather, whose libraries take longer to import than a scene that
    # names its effects takes to load.
    from floeflow.analysis.estimate.choose import choose

    return choose(scene)
