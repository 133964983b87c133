# SPDX-License-Identifier: GPL-2.0-or-later
"""Stored numbers to values: flags, fills and valid ranges first, scale and offset after.

What is no data is told apart before any scaling, as CF has it: a flag of 252 with a scale of 0.004
would else be ice of 1.008.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from floeflow.core import cf_reading as cf
from floeflow.core import units
from floeflow.core.errors import FloeError

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

LAND, HOLE, MISSING, WATER = "land", "pole_hole", "missing", "water"
# Words in a flag's meaning, in the order in which they count.
WORDS = (
    ("hole", HOLE),
    ("pole", HOLE),
    ("miss", MISSING),
    ("not_", MISSING),
    ("no_data", MISSING),
    ("invalid", MISSING),
    ("unused", MISSING),
    ("coast", LAND),
    ("shore", LAND),
    ("lake", LAND),
    ("land", LAND),
    ("open_water", WATER),
    ("open_ocean", WATER),
    ("ice_free", WATER),
    ("no_ice", WATER),
)
# Any float above this is a fill that no attribute tells of.
HUGE = 1.0e30
# Per cent in whole numbers without attributes, as AMSR2's files have them (NSIDC AU_SI12, AU_SI25).
PER_CENT_FLAGS = {110: MISSING, 120: LAND}


@dataclass(frozen=True)
class Values:
    """Unpacked numbers.

    Parameters
    ----------
    values : ndarray
        NaN where there is no data.
    flags : dict of ndarray
        Where there is none and why: ``land``, ``pole_hole``, ``missing``; only what is told.
    rounding : float
        Half a step of the packing, 0 where the file holds floats.
    """

    values: Array
    flags: dict[str, Flags]
    rounding: float


def kind_of_flag(meaning: str) -> str:
    """land, pole_hole, missing or water, by the words of a flag's meaning.

    Parameters
    ----------
    meaning : str
        A word of ``flag_meanings``.

    Returns
    -------
    str
        One of these four words.
    """
    lower = meaning.lower()
    return next((kind for word, kind in WORDS if word in lower), MISSING)


def unpack(raw: NDArray[Any], attrs: Mapping[str, Any]) -> Values:
    """Bring stored numbers to values.

    Parameters
    ----------
    raw : ndarray
        As stored.
    attrs : mapping
        The variable's CF attributes; ``floeflow_flags`` adds pairs of number and meaning.

    Returns
    -------
    Values
        Numbers with NaN where there is none, places of each flag, and half a step of the packing.

    Raises
    ------
    FloeError
        Where its packing is not by numbers.
    """
    stored = _unsigned(raw, attrs)
    packed = "scale_factor" in attrs or "add_offset" in attrs
    scale, offset = _number(attrs, "scale_factor", 1.0), _number(attrs, "add_offset", 0.0)
    if scale == 0.0:
        raise FloeError("its scale_factor is 0, so nothing is known of its values")
    whole = stored.dtype.kind in "iu"
    values = np.asarray(stored, dtype=np.float64)
    bad = ~np.isfinite(values)
    flags: dict[str, Flags] = {}
    for number, kind in _flagged(stored, attrs, packed):
        hit = np.asarray(values == number)
        if hit.any():
            flags[kind] = flags.get(kind, np.zeros(values.shape, bool)) | hit
    for number in _fills(stored.dtype, attrs):
        bad |= values == number
    if not whole:
        bad |= np.abs(values) > HUGE
    flagged = np.zeros(values.shape, bool)
    for hit in flags.values():
        flagged |= hit
    out = values * scale + offset if packed else values.copy()
    low, high, in_packed = _valid_range(attrs, stored.dtype, packed)
    # Float bounds of double-precision sums are met only to round-off.
    checked = values if in_packed else out
    bad |= ~flagged & ((checked < low) | (checked > high))
    if WATER in flags:
        out[flags[WATER]] = 0.0
    bad |= flagged & ~flags.get(WATER, np.zeros(values.shape, bool))
    out[bad] = np.nan
    rounding = 0.5 * abs(scale) if packed and whole else 0.0
    return Values(out, {k: v for k, v in flags.items() if k != WATER}, rounding)


def _number(attrs: Mapping[str, Any], name: str, default: float) -> float:
    """A number of the packing."""
    given = np.asarray(attrs.get(name, default)).reshape(-1)
    try:
        number = float(given[0]) if given.size == 1 else np.nan
    except (TypeError, ValueError):
        number = np.nan
    if not np.isfinite(number):
        raise FloeError(f"its {name} is {str(attrs[name])[:60]!r}, which is no number")
    return number


def flag_variable(
    variables: Mapping[str, cf.Variable], variable: cf.Variable
) -> cf.Variable | None:
    """The status flag beside a variable: named among its ancillaries, or as products name it.

    Parameters
    ----------
    variables : mapping of cf.Variable
        Of the file, by name.
    variable : cf.Variable
        One of them.

    Returns
    -------
    cf.Variable or None
        None where there is none.
    """
    listed = variable.text("ancillary_variables").split()
    for name in (*listed, "status_flag", "surface_type"):
        item = variables.get(name)
        if item is None or "flag_meanings" not in item.attrs:
            continue
        if name in listed or set(variable.dims) >= {d for d in item.dims}:
            if any(word in item.text("flag_meanings").lower() for word in ("land", "coast")):
                return item
    return None


def status_flags(raw: NDArray[Any], attrs: Mapping[str, Any]) -> dict[str, Flags]:
    """Where a status flag tells of land, lakes or coast, by its values or its bits.

    Parameters
    ----------
    raw : ndarray
        Stored values.
    attrs : mapping of object
        Of the variable, with ``flag_meanings``.

    Returns
    -------
    dict of Flags
        By kind of flag, of the shape of ``raw``.
    """
    stored = _unsigned(raw, attrs).astype(np.int64)
    words = str(attrs.get("flag_meanings", "")).replace(",", " ").split()
    found: dict[str, Flags] = {}
    masks = _numbers(attrs.get("flag_masks", ()), raw.dtype)
    values = _numbers(attrs.get("flag_values", ()), raw.dtype)
    for k, word in enumerate(words):
        if kind_of_flag(word) != LAND:
            continue
        # "land_spill_over" corrects ice beside land: it is no land itself.
        if any(part in word.lower() for part in ("spill", "spillover", "near", "adjacent")):
            continue
        if k < len(masks):
            bits = stored & int(masks[k])
            hit = bits == int(values[k]) if k < len(values) else bits != 0
        elif k < len(values):
            hit = stored == int(values[k])
        else:
            continue
        found[LAND] = found.get(LAND, np.zeros(stored.shape, bool)) | hit
    return found


def _unsigned(raw: NDArray[Any], attrs: Mapping[str, Any]) -> NDArray[Any]:
    """Classic NetCDF has signed bytes only: ``_Unsigned`` says what they mean."""
    said = str(attrs.get("_Unsigned", "")).lower() == "true"
    return raw.view(raw.dtype.str.replace("i", "u")) if said and raw.dtype.kind == "i" else raw


def _numbers(value: Any, dtype: np.dtype[Any]) -> list[float]:
    """Numbers of an attribute, brought to the signedness of the data."""
    if isinstance(value, str):
        parts = value.replace(",", " ").split()
        try:
            return [float(part.rstrip("bBsSlLfFdDuU")) for part in parts]
        except ValueError:
            return []
    found = [float(item) for item in np.atleast_1d(np.asarray(value)).reshape(-1)]
    if dtype.kind == "u":
        span = 2.0 ** (8 * dtype.itemsize)
        found = [item + span if item < 0 else item for item in found]
    return found


def _flagged(
    stored: NDArray[Any], attrs: Mapping[str, Any], packed: bool
) -> list[tuple[float, str]]:
    pairs = [(float(n), kind_of_flag(str(word))) for n, word in attrs.get("floeflow_flags", ())]
    if "flag_values" in attrs:
        numbers = _numbers(attrs["flag_values"], stored.dtype)
        words = str(attrs.get("flag_meanings", "")).replace(",", " ").split()
        words += ["missing"] * (len(numbers) - len(words))
        pairs += [(n, kind_of_flag(word)) for n, word in zip(numbers, words, strict=False)]
    elif not pairs and not packed and stored.dtype.kind in "iu" and _per_cent(attrs):
        beyond = set(np.unique(stored[stored > 100]).tolist())
        if beyond and beyond <= set(PER_CENT_FLAGS):
            pairs = [(float(n), kind) for n, kind in PER_CENT_FLAGS.items()]
    return pairs


def _per_cent(attrs: Mapping[str, Any]) -> bool:
    given = str(attrs.get("units", ""))
    return not given or units.conversion(given, "1") == (0.01, 0.0)


def _fills(dtype: np.dtype[Any], attrs: Mapping[str, Any]) -> list[float]:
    found: list[float] = []
    for key in ("_FillValue", "missing_value"):
        if key in attrs:
            found += _numbers(attrs[key], dtype)
    if not found and dtype.itemsize > 1:
        default = netCDF4.default_fillvals.get(dtype.str[1:])
        found = [] if default is None else [float(default)]
    return found


def _valid_range(
    attrs: Mapping[str, Any], dtype: np.dtype[Any], packed: bool
) -> tuple[float, float, bool]:
    """Bounds, and whether they are of stored numbers.

    They are of the stored ones unless they are floats beside packed integers.
    """
    low, high, in_packed = -np.inf, np.inf, True
    for key in ("valid_range", "valid_min", "valid_max"):
        if key not in attrs:
            continue
        numbers = _numbers(attrs[key], dtype)
        floating = not isinstance(attrs[key], str) and np.asarray(attrs[key]).dtype.kind == "f"
        in_packed = not (packed and dtype.kind in "iu" and floating)
        if key == "valid_range" and len(numbers) == 2:
            low, high = numbers
        elif key == "valid_min" and numbers:
            low = numbers[0]
        elif key == "valid_max" and numbers:
            high = numbers[0]
    return low, high, in_packed
