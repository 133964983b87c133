# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes with concrete effects: what ``effects: auto`` means for this ice and weather."""

from __future__ import annotations

from pathlib import Path

from floeflow.scene import Scene
from floeflow.scene.load import load_scene


def resolve_scene(path: str | Path) -> Scene:
    """Read a scene file; ``effects: auto`` becomes the effects that the estimates recommend.

    Raises
    ------
    FloeError
        One sentence that names the file and the key.
    """
    return load_scene(path, _choose)


def _choose(scene: Scene) -> tuple[str, ...]:
    # Estimates read masks and weather, whose libraries take longer to import than a scene that
    # names its effects takes to load.
    from floeflow.analysis.estimate.choose import choose

    return choose(scene)
