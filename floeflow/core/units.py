# SPDX-License-Identifier: GPL-2.0-or-later
"""Units as files spell them, brought to SI through pint and cf-xarray's table of UDUNITS.

Files spell units in ways that no table of units has: those are put right here first. What pint
would read as something else than files mean ("ms-1" is no 1/ms, "c" no speed of light) is too.
"""

from __future__ import annotations

import re
from functools import cache

# Spellings in lower case, single blanks, and what they mean in UDUNITS.
SPELLINGS = {
    name: "1"
    for name in (
        *("", "1", "unitless", "none", "ratio", "fraction", "share", "dimensionless", "nondim"),
        *("(0 - 1)", "(0-1)", "0-1", "0 - 1", "0..1", "[0, 1]", "[0-1]", "[0..1]", "kg kg-1"),
        *("fraction (0-1)", "proportion", "-", "[-]", "n/a", "no units", "1.0", "fractional"),
    )
}
SPELLINGS |= {
    name: "percent" for name in ("%", "percent", "per cent", "per_cent", "percentage", "pct")
}
SPELLINGS |= {name: "percent" for name in ("percent (0-100)", "% (0-100)", "0-100", "percent (%)")}
SPELLINGS |= {name: "kelvin" for name in ("k", "kelvin", "kelvins", "degk", "deg_k", "deg k")}
SPELLINGS |= {
    name: "degC"
    for name in (
        *("c", "degc", "deg_c", "deg c", "celsius", "degree_c", "degrees_c", "degree c"),
        *("degree_celsius", "degrees_celsius", "degrees celsius", "degree celsius", "celcius"),
        *("degrees c", "°c", "ºc", "deg celsius", "deg. c"),
    )
}
SPELLINGS |= {name: "m s-1" for name in ("ms-1", "m/s", "m.s-1", "mps", "meter/sec", "m/sec")}
SPELLINGS |= {"kt": "knot", "kts": "knot", "knots": "knot", "cms-1": "cm s-1", "cm/sec": "cm s-1"}
SPELLINGS |= {name: "W m-2" for name in ("wm-2", "w/m2", "watts/m2", "watt/m^2", "w m^-2")}
SPELLINGS |= {name: "J m-2" for name in ("jm-2", "j/m2")}
SPELLINGS |= {name: "kg m-2 s-1" for name in ("kg/m2/s", "kg/m^2/s", "kgm-2s-1")}
SPELLINGS |= {
    "kg/m2": "kg m-2",
    "kg/m2/day": "kg m-2 day-1",
    "mm/d": "mm day-1",
    "mm/day": "mm day-1",
}
SPELLINGS |= {"m of water equivalent": "m", "m of water": "m", "mm of water": "mm"}
SPELLINGS |= {
    "hpa": "hectopascal",
    "mbar": "millibar",
    "mb": "millibar",
    "millibars": "millibar",
    "pascals": "pascal",
}
# What pint says of the units of most masks and seas, which need not wait for it.
COMMON = {("percent", "1"): (0.01, 0.0), ("degC", "K"): (1.0, 273.15)}
_LEADING = re.compile(r"^([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*[*x]?\s+(\S.*)$")


@cache
def conversion(text: str, si: str) -> tuple[float, float] | None:
    """Factor and offset that bring a number in these units to SI.

    Parameters
    ----------
    text : str
        The units as the file spells them.
    si : str
        The units that are wanted, in UDUNITS' spelling.

    Returns
    -------
    tuple of float or None
        ``value * factor + offset``; None where the units are not known, or of another kind.
    """
    plain = " ".join(text.split())
    lower = plain.lower()
    if plain == si or SPELLINGS.get(lower) == si:
        return 1.0, 0.0
    leading = _LEADING.match(plain)
    if leading and lower not in SPELLINGS:
        rest = conversion(leading[2], si)
        # Times of ten degrees from another zero would mean nothing.
        return None if rest is None or rest[1] else (float(leading[1]) * rest[0], 0.0)
    if lower in SPELLINGS:
        meant = SPELLINGS[lower]
        return COMMON[meant, si] if (meant, si) in COMMON else _by_pint(meant, si)
    for spelled in (plain, lower, lower.removesuffix("s")):
        found = _by_pint(spelled, si)
        if found is not None:
            return found
    return None


def _by_pint(text: str, si: str) -> tuple[float, float] | None:
    # Seconds of imports and tables, which files in common units do not need.
    from cf_xarray.units import units as registry

    try:
        zero, one = (
            registry.Quantity(value, registry.parse_units(text)).to(registry.parse_units(si))
            for value in (0.0, 1.0)
        )
    except Exception:  # pint raises whatever the text leads its parser to
        return None
    offset = float(zero.magnitude)
    # Round-off of the subtraction would be seen in exact tests of scaled units.
    factor = float(one.magnitude) if offset == 0.0 else float(one.magnitude) - offset
    return (round(factor, 12) if offset else factor), offset


def is_length(text: str) -> float | None:
    """Metres in a unit of length, ``100 km`` among them; None for another kind.

    Parameters
    ----------
    text : str
        Unit as in a file.

    Returns
    -------
    float or None
        m.
    """
    found = conversion(text, "m")
    return None if found is None or found[1] else found[0]
