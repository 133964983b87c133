# SPDX-License-Identifier: GPL-2.0-or-later
"""Whose state a file holds: a scene goes on from its own, and from no other.

A state says of which scene and window it is and from which keys it was made. Its checksum proves
that the file is whole, not that it lies in its place: a copied file is whole in any folder.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from floeflow.core.errors import FloeError
from floeflow.scene import Scene, stage_hash

# Stages on which the state at the start depends.
START_STAGES = ("land", "mask", "packing", "bonds", "initial")
# Stages whose keys make a window from the state before it.
WINDOW_STAGES = ("dynamics", "column", "remesh", "forcing")


def provenance(scene: Scene) -> str:
    """Hashes of the scene keys of each stage behind the state at the start, as JSON.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    str
        JSON object: hash by stage, sorted.
    """
    stages = [name for name in START_STAGES if name != "bonds" or "bonds" in scene.effects]
    return json.dumps({name: stage_hash(scene, name) for name in stages}, sort_keys=True)


def window_keys(scene: Scene) -> dict[str, str]:
    """Hashes of the scene keys that make a window.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    dict of str
        Hash by stage.
    """
    return {stage: stage_hash(scene, stage) for stage in WINDOW_STAGES}


def check_origin(
    attrs: Mapping[str, object], path: Path, scene: Scene, window: int, library: str = ""
) -> None:
    """Refuse a state that this scene did not make.

    Parameters
    ----------
    attrs : mapping
        Attributes of the state.
    path : Path
        Its file.
    scene : Scene
        With concrete effects; a variant ``<base>+...`` may start from its base scene's state.
    window : int
        At whose end the state must be.
    library : str
        Digest of the code of windows; empty: of any.

    Raises
    ------
    FloeError
        Names the file and what does not fit.
    """
    owner = str(attrs["scene"])
    if owner not in (scene.name, scene.name.partition("+")[0]):
        raise FloeError(
            f"{path}: is a state of the scene '{owner}', not of '{scene.name}': was it copied?"
        )
    if attrs["window"] != window:
        raise FloeError(
            f"{path}: is the state of window {attrs['window']}, not of {window}: was it copied?"
        )
    found = json.loads(str(attrs["provenance"]))
    wanted = json.loads(provenance(scene))
    if window:
        wanted |= window_keys(scene) | ({"library": library} if library else {})
    other = [name for name, value in wanted.items() if found.get(name) != value]
    if other:
        what = "other code" if other == ["library"] else f"other keys ({', '.join(other)})"
        raise FloeError(
            f"{path}: was made with {what} than this scene's: move results/{scene.name} away, or "
            "give the scene another name"
        )
