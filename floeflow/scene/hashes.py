# SPDX-License-Identifier: GPL-2.0-or-later
"""Which keys each stage reads, and their hash.

A rule's parameters hold the hash of its stage's keys, so that a changed plot key reruns no window,
and the state carries the hashes with which it was made.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

from floeflow.scene.blocks import Scene
from floeflow.scene.effects import forcing_variables

# A path names a key or a whole block, or asks with ``effects.<name>`` for one effect.
# ``time.windows`` is read by no stage but the estimate, which is one of the whole run: more windows
# are more jobs, never other ones.
FORCING_VARIABLES = "effects: forcing variables"
STAGE_KEYS: dict[str, tuple[str, ...]] = {
    "land": ("domain", "mask.refine", "mask.land", "mask.land_fraction"),
    "mask": (
        *("domain", "mask", "packing.generator", "time.start", "effects.mixed_layer"),
        *("sea.file", "sea.temperature", "sea.salinity", "effects.walls", "walls"),
        *("effects.periodic", "periodic"),
    ),
    "packing": ("seed", "packing", "effects.coast", "effects.walls", "walls"),
    "bonds": ("packing.bond_gap", "packing.bond_concentration", "packing.coast_bonds"),
    "forcing": (
        *("domain", "forcing", "time.start", "time.window", "grounding"),
        FORCING_VARIABLES,
    ),
    "initial": (
        "time.start",
        "effects",
        "column.ocean_salinity",
        "column.scheme",
        "column.categories",
        "column.layers",
        "column.initial_surface",
        "walls",
        "state.precision",
    ),
    "dynamics": (
        "effects",
        "dynamics",
        "grounding",
        "periodic",
        "time.window",
        "packing.coast_bonds",
        "state.precision",
        "exchange",
    ),
    "cells": ("seed",),
    "remesh": ("remap", "merge", "packing.bond_gap"),
    # What is kept changes no result, so it is in no window's own hash.
    "keep": ("state.keep",),
    "column": (
        *("effects", "column", "physics", "time.window", "rims", "gates"),
        *("sea.salinity_time", "sea.relaxation_time"),
    ),
    "grid": ("domain", "effects", "time.start", "time.window", "grid"),
    "diagnostics": ("effects", "domain"),
    "trajectory": ("domain.x_min", "domain.x_max", "domain.y_min", "domain.y_max"),
    "estimate": (
        *("effects", "domain", "mask", "packing", "forcing", "time", "dynamics", "column"),
        *("grounding", "walls"),
    ),
    # All that a mesh shows stands in packing and states.
    "mesh": (),
    "report": ("report", "name", "effects", "domain", "time.start", "time.window"),
}


# The stages whose results a stage builds on, nearest first.
BEFORE: dict[str, tuple[str, ...]] = {
    "land": (),
    "mask": ("land",),
    "packing": ("mask",),
    "bonds": ("packing",),
    "cells": ("packing",),
    "initial": ("packing", "bonds"),
}


def stage_values(scene: Scene, stage: str) -> dict[str, Any]:
    """Values of the keys that a stage reads, by path, in plain JSON types.

    Parameters
    ----------
    scene : Scene
        Whose keys are read.
    stage : str
        Of the workflow, a key of ``STAGE_KEYS``.

    Returns
    -------
    dict of object
        JSON values by path.
    """
    data = scene.model_dump(mode="json")
    if "thermodynamics" not in scene.effects:
        data.pop("column")
    if "grounding" not in scene.effects:
        data["grounding"] = {}
    if "walls" not in scene.effects:
        data["walls"] = {}
    if "periodic" not in scene.effects:
        data["periodic"] = {}
    values: dict[str, Any] = {}
    for path in STAGE_KEYS[stage]:
        if path == FORCING_VARIABLES:
            values[path] = list(forcing_variables(scene.effects))
            continue
        if path.startswith("effects."):
            values[path] = path.removeprefix("effects.") in scene.effects
            continue
        value: Any = data
        for part in path.split("."):
            value = value.get(part) if isinstance(value, dict) else None
        values[path] = value
    return values


def stage_hash(scene: Scene, stage: str) -> str:
    """Hash (16 hexadecimal digits) of the keys that a stage reads.

    Parameters
    ----------
    scene : Scene
        Whose keys are read.
    stage : str
        Of the workflow.

    Returns
    -------
    str
        Lower-case digits.
    """
    text = json.dumps(stage_values(scene, stage), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def chain_hash(scene: Scene, stage: str) -> str:
    """Hash of the keys of a stage of preprocessing and of all stages before it.

    Two scenes with the same hash have the same file of that stage.

    Parameters
    ----------
    scene : Scene
        Whose keys are read.
    stage : str
        Of preprocessing.

    Returns
    -------
    str
        16 lower-case digits.
    """
    parts = [stage_hash(scene, stage), *(chain_hash(scene, each) for each in BEFORE[stage])]
    return hashlib.sha256(" ".join(parts).encode()).hexdigest()[:16]
