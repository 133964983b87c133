# SPDX-License-Identifier: GPL-2.0-or-later
"""The column schemes by the name under which a scene asks for them.

A scheme advances columns that are a dict of arrays over elements, by the names and in the SI units
of the state's schema, and tells the terms of its budgets by the names of the series. What a run
does not ask for is neither in the one nor in the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from floeflow.column import layered_run, zero_layer_run
from floeflow.column.params import Settings
from floeflow.column.state import Array
from floeflow.column.thickness.ridging_closure import before_closing, close_columns
from floeflow.core.errors import FloeError

Columns = dict[str, Array]
Sample = Callable[[float], dict[str, Array]]


@dataclass(frozen=True)
class Scheme:
    """What a scheme offers.

    Parameters
    ----------
    advance : callable
        ``advance(columns, sample, window, settings) -> (columns, terms)``: columns at the end of
        the window (s, s); ``sample(t)`` gives the forcing variables of `forcing_names` at the
        elements. Terms per square metre of the elements: ``growth_*`` (m of ice), ``snow_*`` (m of
        snow), ``energy_*`` (J/m2), ``water_*`` and ``salt_*`` (kg/m2), each (n,); and counts,
        ``temperature_*``, of schemes with layers.
    stored : callable
        ``stored(columns, settings)``: what the terms change, by ``energy``, ``water``, ``salt``.
    """

    advance: Callable[
        [Columns, Sample, tuple[float, float], Settings], tuple[Columns, dict[str, Array]]
    ]
    stored: Callable[[Columns, Settings], dict[str, Array]]


SCHEMES: dict[str, Scheme] = {
    "zero_layer": Scheme(zero_layer_run.advance, zero_layer_run.stored),
    "bl99": Scheme(layered_run.advance, layered_run.stored),
    "mushy": Scheme(layered_run.advance, layered_run.stored),
}


def scheme_of(settings: Settings) -> Scheme:
    """The scheme that a run asks for.

    Parameters
    ----------
    settings : Settings
        What the column is asked for.

    Returns
    -------
    Scheme
        Entry of `SCHEMES`.

    Raises
    ------
    FloeError
        For an unknown one.
    """
    if settings.scheme not in SCHEMES:
        known = ", ".join(SCHEMES)
        raise FloeError(f"column.scheme: unknown scheme '{settings.scheme}'; known are {known}")
    return SCHEMES[settings.scheme]


def advance_columns(
    columns: Columns,
    sample: Sample,
    window: tuple[float, float],
    settings: Settings,
    closed: Array | None = None,
) -> tuple[Columns, dict[str, Array]]:
    """Advance columns over a window; with the terms, ``*_stored`` for what is kept.

    ``ice_area_grown`` (1) is how much more of the area is under ice by growth and melt alone.

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state's schema, over elements.
    sample : callable
        Forcing at the elements at a time (s), by the names of the forcing.
    window : tuple of float
        Start and end (s).
    settings : Settings
        What is asked of the columns.
    closed : ndarray, optional
        Share of each element's area that ridging has just closed, with redistribution, (n,).

    Returns
    -------
    columns : dict of ndarray
        After the window, by the same names and of the same shapes.
        terms : dict of ndarray
        Budget terms by name, in the unit of what they change, over the element's area, (n,) each.

    Raises
    ------
    FloeError
        For an unknown scheme, a window that is not positive, ice without area, or forcing that is
        not finite.
    """
    scheme = scheme_of(settings)
    first = ridged = columns
    closing: dict[str, Array] = {}
    if closed is not None:
        first = before_closing(columns, closed)
        ridged, closing = close_columns(columns, closed, settings)
    after, terms = scheme.advance(ridged, sample, window, settings)
    start, end = (scheme.stored(each, settings) for each in (first, after))
    stored = {f"{name}_stored": end[name] - start[name] for name in end}
    # Without what ridging closed.
    covered, cover = (each["ice_fraction"].sum(axis=1) for each in (ridged, after))
    named = {**terms, **closing, **stored, "ice_area_grown": cover - covered}
    return after, named_terms(named, settings)


# Terms that come with a process.
_PROCESS_TERMS = {
    "frazil": ("growth_new_ice",),
    "lateral_melt": ("growth_melt_lateral",),
    "snow": (
        "snow_snowfall",
        "snow_melt",
        "snow_sublimation",
        "snow_flooded",
        "growth_snow_ice",
        "energy_snowfall",
        "water_snowfall",
    ),
}


def named_terms(terms: dict[str, Array], settings: Settings) -> dict[str, Array]:
    """Terms without those of processes that are not simulated, which are zero.

    Parameters
    ----------
    terms : dict of ndarray
        By the names of the series, (n,).
    settings : Settings
        Which processes are simulated.

    Returns
    -------
    dict of ndarray
        The rest, unchanged.
    """
    absent = {
        term for process, its in _PROCESS_TERMS.items() if not settings.has(process) for term in its
    }
    return {name: value for name, value in terms.items() if name not in absent}
