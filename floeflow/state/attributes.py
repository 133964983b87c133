# SPDX-License-Identifier: GPL-2.0-or-later
"""Attributes that every state carries, and what they may say."""

from __future__ import annotations

import json
import math
from collections.abc import Hashable, Mapping
from datetime import datetime

from floeflow.core.errors import FloeError
from floeflow.core.period import ATTRIBUTE as PERIOD
from floeflow.scene.effects import SCHEME_STATE, known_effects

# The column scheme of a state with thermodynamics; where it is missing, zero_layer.
SCHEME_ATTRIBUTE, DEFAULT_SCHEME = "column_scheme", "zero_layer"
_SCHEMES = {DEFAULT_SCHEME}.union(*SCHEME_STATE.values())

# Attributes that every state carries, with their types.
ATTRIBUTES: dict[str, type] = {
    "schema_version": int,
    "scene": str,
    "effects": str,
    "window": int,
    "time": float,
    "start": str,
    "seed": int,
    "crs": str,
    "ocean_area": float,
    "unclaimed_water": float,
    "provenance": str,
}


def check_attributes(attrs: Mapping[Hashable, object]) -> tuple[tuple[str, ...], str]:
    """Effects and column scheme of a state whose attributes are as they must be.

    Parameters
    ----------
    attrs : mapping of object
        Of a state.

    Returns
    -------
    effects : tuple of str
        Of the state.
    scheme : str
        Of its columns.

    Raises
    ------
    FloeError
        In one sentence, which names the first attribute at fault.
    """
    for name, kind in ATTRIBUTES.items():
        value = attrs.get(name)
        if not isinstance(value, kind):
            raise FloeError(f"attribute '{name}' is missing or no {kind.__name__}")
        if isinstance(value, float) and not math.isfinite(value):
            raise FloeError(f"attribute '{name}' is {value}")
    effects = tuple(str(attrs["effects"]).split())
    for name in effects:
        if name not in known_effects():
            raise FloeError(f"attribute 'effects' names {name!r}, which is not an effect")
    scheme = attrs.get(SCHEME_ATTRIBUTE, DEFAULT_SCHEME)
    if not (isinstance(scheme, str) and scheme in _SCHEMES):
        raise FloeError(
            f"attribute '{SCHEME_ATTRIBUTE}' is {scheme!r}, which is not a column scheme"
        )
    try:
        datetime.fromisoformat(str(attrs["start"]))
    except ValueError:
        raise FloeError(f"attribute 'start' is {attrs['start']!r}, which is not a time") from None
    if "periodic" in effects and not _are_bounds(attrs.get(PERIOD)):
        raise FloeError(f"attribute '{PERIOD}' is missing or holds no bounds of a rectangle")
    if not _is_json_object(str(attrs["provenance"])):
        raise FloeError("attribute 'provenance' is not a JSON object")
    return effects, scheme


def _are_bounds(value: object) -> bool:
    """Whether these are west, south, east and north edge, infinite where an axis has ends."""
    if not (isinstance(value, list) and len(value) == 4):
        return False
    if not all(isinstance(edge, float) for edge in value):
        return False
    return bool(value[0] < value[2] and value[1] < value[3])


def _is_json_object(text: str) -> bool:
    try:
        return isinstance(json.loads(text), dict)
    except (ValueError, RecursionError):
        return False
