# SPDX-License-Identifier: GPL-2.0-or-later
"""The report in words and numbers: formats, tables of the scene and its provenance.

Everything here is plain text; the template escapes it. A number that is not finite never reaches
the page: it is told as a dash.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import xarray as xr
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from floeflow import __version__
from floeflow.scene import Scene
from floeflow.scene.effects import EFFECTS, Effect

DASH = "–"
LIBRARIES = ("numpy", "xarray", "netCDF4", "pyproj", "matplotlib", "mpi4py", "snakemake")


@dataclass(frozen=True)
class Key:
    """A key of the scene, in words."""

    path: str
    value: str
    default: str
    unit: str
    text: str

    @property
    def differs(self) -> bool:
        """Whether the scene sets it to something else than the default."""
        return self.value != self.default


def number(value: Any, digits: int = 4) -> str:
    """A number with thousands separated; a dash for what is missing or not finite.

    Parameters
    ----------
    value : object
        None for what is missing.
    digits : int, optional
        Significant digits.

    Returns
    -------
    str
        Such as ``12,345`` or ``1.2 × 10⁹``.
    """
    if value is None or not math.isfinite(value):
        return DASH
    if isinstance(value, int):
        return f"{value:,}".replace("-", "−")
    size = abs(value)
    if size and not 1e-3 <= size < 1e7:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        return f"{mantissa}e{int(exponent)}".replace("-", "−")
    decimals = max(0, digits - 1 - math.floor(math.log10(size))) if size else 0
    text = f"{value:,.{decimals}f}"
    return (text.rstrip("0").rstrip(".") if "." in text else text).replace("-", "−")


def with_unit(value: float | None, units: Sequence[tuple[float, str]]) -> str:
    """A number in the largest unit of which it holds one.

    Parameters
    ----------
    value : float or None
        In the base unit; None for what is missing.
    units : sequence of tuple of float and str
        Size in the base unit, and name, largest first.

    Returns
    -------
    str
        Number and unit.
    """
    if value is None or not math.isfinite(value):
        return DASH
    scale, unit = next((u for u in units if abs(value) >= u[0]), units[-1])
    times = " × " if unit.startswith("10") else " "
    return f"{number(value / scale)}{times}{unit}"


def pretty_unit(unit: str) -> str:
    """A unit with its exponents raised.

    Parameters
    ----------
    unit : str
        As in CF attributes.

    Returns
    -------
    str
        With ² and ³.
    """
    return unit.replace("m2", "m²").replace("m3", "m³")


def duration(seconds: float) -> str:
    """A time span in its best unit.

    Parameters
    ----------
    seconds : float
        Of a time.

    Returns
    -------
    str
        Number of at most three digits, and unit.
    """
    for unit, name in ((86400.0, "days"), (3600.0, "hours"), (60.0, "minutes")):
        if seconds >= 2 * unit or (seconds >= unit and seconds % unit == 0):
            word = name[:-1] if seconds == unit else name
            return f"{number(seconds / unit, 3)} {word}"
    return f"{number(seconds, 3)} s"


def scene_keys(scene: Scene) -> list[Key]:
    """Every key of the scene that its effects can read, in the order of the blocks.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    list of Key
        Path, value, unit and what it is.
    """
    keys = _keys(scene, "")
    if "thermodynamics" not in scene.effects:
        keys = [key for key in keys if not key.path.startswith("column.")]
    return keys


def _keys(block: BaseModel, prefix: str) -> list[Key]:
    found = []
    for name, field in type(block).model_fields.items():
        value = getattr(block, name)
        if isinstance(value, BaseModel):
            found += _keys(value, f"{prefix}{name}.")
            continue
        found.append(
            Key(
                f"{prefix}{name}",
                _value(value),
                _default(field),
                _unit(field),
                field.description or "",
            )
        )
    return found


def _default(field: FieldInfo) -> str:
    return DASH if field.default is PydanticUndefined else _value(field.default)


def _unit(field: FieldInfo) -> str:
    extra = field.json_schema_extra
    return str(extra.get("unit", "")) if isinstance(extra, dict) else ""


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float) and abs(value) < 1e4:
        return f"{value:.10g}".replace("-", "−")
    if isinstance(value, int | float):
        return f"{value:,.10g}".replace("-", "−") if value < 1e15 else f"{value:g}"
    if isinstance(value, tuple | list):
        return ", ".join(str(item) for item in value) or "none"
    return str(value) if str(value) else "(empty)"


def effect_lists(scene: Scene) -> tuple[list[Effect], list[Effect]]:
    """Effects that the scene simulates, and those that are absent.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    there, absent : list of Effect
        In the registry's order.
    """
    there = [EFFECTS[name] for name in scene.effects]
    return there, [effect for effect in EFFECTS.values() if effect.name not in scene.effects]


def provenance(
    scene: Scene, attrs: Mapping[str, Any], numbers: Mapping[str, Any]
) -> list[tuple[str, str]]:
    """What made the run: versions, machine, ranks, seed, time step.

    Parameters
    ----------
    scene : Scene
        Its seed and keys.
    attrs : mapping of object
        Attributes of the last state.
    numbers : mapping of object
        Of ``diagnostics.json``.

    Returns
    -------
    list of tuple of str
        Name and text.
    """
    rows = [("FloeFlow", __version__)]
    rows += _flat(str(attrs.get("provenance", "")))
    rows += [
        ("Commit", str(numbers.get("git") or DASH)),
        ("Machine", str(numbers.get("machine") or DASH)),
        ("MPI ranks", number(numbers.get("ranks"))),
        ("Seed", str(scene.seed)),
        ("DEM steps", number(numbers.get("steps"))),
        ("DEM time step", f"{number(numbers.get('time_step'))} s"),
        ("Time step limited by", str(numbers.get("limited_by") or DASH)),
        ("Projection", scene.domain.crs),
        ("Libraries of the report", ", ".join(f"{name} {version(name)}" for name in LIBRARIES)),
    ]
    return rows


def _flat(text: str) -> list[tuple[str, str]]:
    """A state's provenance as rows: JSON objects by key, anything else as it stands."""
    try:
        data = json.loads(text)
    except ValueError:
        data = None
    if isinstance(data, dict):
        return [(f"State: {key}", str(value)) for key, value in data.items()]
    return [("State", text)] if text else []


def packing_figures(packing: xr.Dataset) -> list[tuple[str, float, str]]:
    """What the packing says of its own quality: meaning, value and unit.

    Parameters
    ----------
    packing : xarray.Dataset
        With quality as attributes.

    Returns
    -------
    list of tuple of (str, float, str)
        In the order of the packing's variables.
    """
    return [
        (str(item.attrs["long_name"]), float(item), str(item.attrs["units"]))
        for name, item in packing.data_vars.items()
        if str(name).startswith("quality_")
    ]
