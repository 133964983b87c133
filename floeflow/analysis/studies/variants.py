# SPDX-License-Identifier: GPL-2.0-or-later
"""Variants: scenes of their own that differ from a base scene in a few keys.

A study is a list of variants, the first of which is ``base``. A variant runs through the same
workflow as any scene, under ``results/<scene>+<study>-<variant>``.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from floeflow.core.errors import FloeError
from floeflow.scene import Scene
from floeflow.scene.load import build_scene

BASE = "base"


@dataclass(frozen=True)
class Variant:
    """One run of a study.

    Parameters
    ----------
    name : str
        Short name within the study.
    changes : dict
        New values by dotted key, such as ``{"packing.elements": 400}``.
    group : str
        What is varied: an effect or a setting.
    label : str
        How figures and tables call it.
    """

    name: str
    changes: dict[str, Any] = field(default_factory=dict)
    group: str = ""
    label: str = ""

    def as_text(self) -> str:
        """The variant as one line of JSON, for a rule's parameters."""
        return json.dumps(asdict(self), sort_keys=True)

    @classmethod
    def from_text(cls, text: str) -> Variant:
        """Read what `as_text` wrote.

        Parameters
        ----------
        text : str
            JSON.
        """
        return cls(**json.loads(text))


def run_name(scene: str, study: str, variant: str) -> str:
    """Name of a variant's scene.

    Parameters
    ----------
    scene : str
        Names.
    study : str
        Names.
    variant : str
        Names.

    Returns
    -------
    str
        ``<scene>+<study>-<variant>``.
    """
    return f"{scene}+{study}-{variant}"


def changed(keys: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Keys of a scene with some set anew.

    Parameters
    ----------
    keys : mapping
        As read from a scene file; left as it is.
    changes : mapping
        New values by dotted key.
    """
    data = copy.deepcopy(dict(keys))
    for path, value in changes.items():
        block = data
        *parents, last = path.split(".")
        for parent in parents:
            block = block.setdefault(parent, {})
        block[last] = value
    return data


def variant_scene(keys: Mapping[str, Any], scene: Scene, study: str, variant: Variant) -> Scene:
    """Scene of a variant: the base scene's keys, one chunk for all windows, and the changes.

    Effects are written out, so that ``effects: auto`` is decided once for the whole study.

    Parameters
    ----------
    keys : mapping
        As the base scene's file sets them.
    scene : Scene
        The base scene.
    study : str
        Name of the study.
    variant : Variant
        What the variant changes.

    Raises
    ------
    FloeError
        Where the changes make no valid scene.
    """
    common = {
        "effects": list(scene.effects),
        "name": scene.name,
        "workflow.windows_per_job": variant.changes.get("time.windows", scene.time.windows),
    }
    name = run_name(scene.name, study, variant.name)
    try:
        made = build_scene(changed(keys, {**common, **variant.changes}))
    except FloeError as error:
        raise FloeError(f"variant '{name}': {error}") from None
    # A plus sign is in no name that a user may give, so no scene can be taken for a variant.
    return made.model_copy(update={"name": name})
