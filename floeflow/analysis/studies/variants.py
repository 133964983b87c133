# SPDX-License-Identifier: GPL-2.0-or-later
"""Variants: scenes of their own that differ from a base scene in a few keys.

A study is a list of variants, the first of which is ``base``. A variant runs through the same
workflow as any scene, under ``results/<scene>--<study>-<variant>``.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import yaml

from floeflow.core.errors import FloeError
from floeflow.scene import Scene
from floeflow.scene.load import build_scene, read_keys

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
        What is varied: an effect or a knob.
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
        """Read what `as_text` wrote."""
        return cls(**json.loads(text))


def run_name(scene: str, study: str, variant: str) -> str:
    """Name of a variant's scene."""
    return f"{scene}--{study}-{variant}"


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


def variant_keys(path: Path, scene: Scene, study: str, variant: Variant) -> dict[str, Any]:
    """Keys of a variant: the scene's file, with one job for all windows, and the changes.

    Effects are written out, so that ``effects: auto`` is decided once for the whole study.
    """
    common = {
        "effects": list(scene.effects),
        "name": run_name(scene.name, study, variant.name),
        "workflow.windows_per_job": variant.changes.get("time.windows", scene.time.windows),
    }
    return changed(read_keys(path), {**common, **variant.changes})


def write_variant(keys: Mapping[str, Any], path: Path) -> Scene:
    """Validate a variant and write its scene file; the file is left alone where it is the same.

    Raises
    ------
    FloeError
        Where the changes make no valid scene.
    """
    try:
        scene = build_scene(keys)
    except FloeError as error:
        raise FloeError(f"variant '{keys.get('name')}': {error}") from None
    text = yaml.safe_dump(dict(keys), sort_keys=False)
    if not path.is_file() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return scene
