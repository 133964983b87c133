# SPDX-License-Identifier: GPL-2.0-or-later
"""The first screen in words: what was simulated, the five numbers that matter, what to know first.

Each number names the variable and the file that it comes from.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import xarray as xr

from floeflow.diagnostics.collect import SIDES
from floeflow.report.figures.series import AREA_UNITS, VOLUME_UNITS
from floeflow.report.report_text import DASH, duration, number, with_unit
from floeflow.scene import Scene

# A larger share of the sea without an element is worth a word.
UNCLAIMED = 0.02


@dataclass(frozen=True)
class Card:
    """A headline number: what it is, its value, a note, and where it comes from."""

    label: str
    value: str
    note: str
    source: str


@dataclass(frozen=True)
class Fact:
    """A number of a chapter's table."""

    label: str
    value: float | int | None
    unit: str
    source: str


def sentence(scene: Scene, numbers: Mapping[str, Any]) -> str:
    """What was simulated, in one sentence.

    Parameters
    ----------
    scene : Scene
        Its effects, start and forcing.
    numbers : mapping of object
        Of ``diagnostics.json``.

    Returns
    -------
    str
        With units.
    """
    count = int(numbers["elements"])
    size = math.sqrt(numbers["ice_area_end"] / count) / 1e3 if count else 0.0
    across = f" of about {number(size, 2)} km" if size else ""
    said = f"{number(count)} elements{across} {_verbs(scene)} for {duration(numbers['seconds'])}"
    return f"{said} from {_date(scene.time.start)}, {_driven(scene)}."


def _date(moment: datetime) -> str:
    """A day in words, with the hour where it is not midnight."""
    hour = f", {moment:%H:%M} UTC" if (moment.hour, moment.minute) != (0, 0) else ""
    return f"{moment.day} {moment:%B %Y}{hour}"


def _verbs(scene: Scene) -> str:
    """What the elements do, by the scene's effects."""
    effects = set(scene.effects)
    verbs = ["drift"]
    verbs += ["break"] if "bonds" in effects else []
    verbs += ["ridge"] if "ridging" in effects else []
    verbs += ["refreeze"] if "refreeze" in effects else []
    verbs += ["grow", "melt"] if "thermodynamics" in effects else []
    return verbs[0] if len(verbs) == 1 else f"{', '.join(verbs[:-1])} and {verbs[-1]}"


def _driven(scene: Scene) -> str:
    """What drives them."""
    words = {
        "analytic": "under a cyclone and a gyre by formula",
        "climatology": "under a synthetic climate with storms",
        "file": "under weather read from files",
    }
    return words[scene.forcing.source]


def cards(
    numbers: Mapping[str, Any], budgets: Sequence[Mapping[str, Any]], wall_seconds: float
) -> list[Card]:
    """The five numbers that matter; those of effects that are absent give way.

    Parameters
    ----------
    numbers : mapping of object
        Of ``diagnostics.json``.
    budgets : sequence of mapping of object
        Of ``diagnostics.json``.
    wall_seconds : float
        Wall time of the run (s).

    Returns
    -------
    list of Card
        Five.
    """
    found = [
        _stock("Ice area inside the scene", "ice_area", AREA_UNITS, numbers),
        _stock("Ice volume inside the scene", "ice_volume", VOLUME_UNITS, numbers),
        Card(
            "Mean net drift",
            f"{number(numbers['mean_drift_km'], 3)} km",
            f"mean speed {number(100 * numbers['mean_speed'], 3)} cm/s; the farthest element went "
            f"{number(numbers['largest_drift_km'], 3)} km",
            "mean_displacement, largest_displacement, drift_speed in diagnostics.nc",
        ),
    ]
    if "bonds_broken" in numbers:
        found.append(_bonds(numbers))
    found.append(_closing(budgets))
    if len(found) < 5:
        found.append(
            Card("Wall time", duration(wall_seconds), "all timed stages", "benchmarks/*.tsv")
        )
    return found


def _stock(
    label: str, name: str, units: Sequence[tuple[float, str]], numbers: Mapping[str, Any]
) -> Card:
    start, end = numbers[f"{name}_start"], numbers[f"{name}_end"]
    note = _change(start, end)
    through = through_sides(numbers, name)
    if through and start:
        net = sum(through.values())
        way = "left through the sides" if net < 0 else "came in through the sides"
        note += f"; {with_unit(abs(net), units)} {way}"
    return Card(label, with_unit(end, units), note, f"{name} in diagnostics.nc")


def through_sides(numbers: Mapping[str, Any], name: str) -> dict[str, float]:
    """What came in (above 0) or left through each side that anything passed.

    Parameters
    ----------
    numbers : mapping of object
        Of ``diagnostics.json``.
    name : str
        ``ice_area``, ``ice_volume`` or ``snow_volume``.

    Returns
    -------
    dict of float
        m2 or m3, by side.
    """
    keys = {side: f"{name}_through_{side}_side" for side in SIDES}
    return {side: float(numbers[key]) for side, key in keys.items() if key in numbers}


def _change(start: float, end: float) -> str:
    if not start:
        return "none at the start" if end else "none"
    share = 100.0 * (end - start) / start
    sign = "+" if share > 0 else ""
    return "unchanged" if abs(share) < 5e-4 else f"{sign}{number(share, 2)} % since the start"


def _bonds(numbers: Mapping[str, Any]) -> Card:
    start, alive = numbers["bonds_start"], numbers["bonds_end"]
    note = f"of {number(start)} at the start; {number(numbers['bonds_broken'])} broke"
    if numbers.get("bonds_refrozen"):
        note += f", {number(numbers['bonds_refrozen'])} froze"
    if numbers.get("bonds_remade"):
        made = numbers["bonds_remade"]
        way = "came" if made > 0 else "went"
        note += f", {number(abs(made))} {way} with elements that came or went"
    return Card("Bonds alive", number(alive), note, "bonds, bonds_broken in diagnostics.nc")


def _closing(budgets: Sequence[Mapping[str, Any]]) -> Card:
    closed = sum(budget["verdict"] == "closed" for budget in budgets)
    rest = [str(budget["label"]) for budget in budgets if budget["verdict"] != "closed"]
    note = f"not closed: {', '.join(rest)}" if rest else "each relative to its turnover"
    return Card(
        "Budgets that close", f"{closed} of {len(budgets)}", note, "budgets in diagnostics.json"
    )


def warnings(
    scene: Scene,
    notes: Sequence[str],
    numbers: Mapping[str, Any],
    budgets: Sequence[Mapping[str, Any]],
) -> list[str]:
    """What a reader must know before any number: assumptions, and budgets that are open.

    Parameters
    ----------
    scene : Scene
        Its mask and forcing are read.
    notes : sequence of str
        What was found in the mask's file, one a line.
    numbers, budgets
        Of ``diagnostics.json``.

    Returns
    -------
    list of str
        Sentences, each once.
    """
    found = []
    mask = scene.mask
    if not mask.thickness:
        thick = f"{number(mask.ice_thickness)} m"
        rule = {
            "constant": thick,
            "concentration": f"{thick} times concentration",
            "climatology": "a table by place and month, times concentration",
        }[mask.thickness_rule]
        found.append(f"Ice thickness at the start is no observation but a rule: {rule}.")
    if mask.thickness_distribution == "gamma" and "thermodynamics" in scene.effects:
        found.append("Within each element thickness has a gamma distribution at the start.")
    if mask.lead_ice and "thermodynamics" in scene.effects:
        found.append(
            f"Leads of ice of 80 % and more bear {number(mask.lead_ice)} m of young ice at the "
            "start, where the mask has open water."
        )
    if mask.uniform:
        found.append(f"Ice at the start is no observation: {number(mask.uniform)} of all water.")
    for note in notes:
        # What is of the very day says nothing that a reader must know.
        if note.endswith("days from the start") and not note.endswith(" 0.0 days from the start"):
            file = note.partition(" of ")[2]
            found.append(f"Mask of another day: {file}.")
        elif "filled" in note or "covers" in note:
            found.append(f"Mask: {note}.")
    if scene.forcing.source != "file":
        found.append(f"Wind and weather are no observations: the scene runs {_driven(scene)}.")
    unclaimed, ocean = numbers.get("unclaimed_water_end", 0.0), numbers.get("ocean_area", 0.0)
    # On a mixed layer such water freezes, and a remap gives it to elements.
    lies_open = not {"remap", "mixed_layer"} & set(scene.effects)
    if ocean and unclaimed > UNCLAIMED * ocean and lies_open:
        share = number(100.0 * unclaimed / ocean, 2)
        found.append(f"{share} % of the sea at the end belongs to no element and makes no ice.")
    for budget in budgets:
        if budget["verdict"] == "open":
            ratio = budget["relative"]
            size = DASH if ratio is None else f"{number(100.0 * ratio, 2)} %"
            found.append(f"Budget open: {budget['label']}, {size} of its turnover unexplained.")
    if numbers.get("temperature_unconverged"):
        found.append(
            f"{number(numbers['temperature_unconverged'])} of "
            f"{number(numbers['temperature_solves'])} solves for the temperatures of the ice ended "
            "short of their tolerance (temperature_unconverged in diagnostics.nc)."
        )
    return list(dict.fromkeys(found))


def facts(numbers: Mapping[str, Any], scene: Scene) -> dict[str, list[Fact]]:
    """Numbers of the chapters ice, motion and bonds, each with its source.

    Parameters
    ----------
    numbers : mapping of object
        Of ``diagnostics.json``.
    scene : Scene
        Its effects.

    Returns
    -------
    dict of list of Fact
        By chapter.
    """
    made: dict[str, list[Fact]] = {"ice": [], "motion": [], "bonds": []}
    stocks = (("ice_area", "Ice area", "10³ km2", 1e9), ("ice_volume", "Ice volume", "km3", 1e9))
    for name, label, unit, size in (*stocks, ("snow_volume", "Snow volume", "km3", 1e9)):
        if f"{name}_start" not in numbers:
            continue
        source = f"diagnostics.nc: {name}"
        for word in ("start", "end"):
            value = numbers[f"{name}_{word}"] / size
            made["ice"].append(Fact(f"{label}, {word}", value, unit, source))
        where = "export_*, inflow_*" if "rims" in scene.effects else f"{name}_beyond_*"
        for side, value in through_sides(numbers, name).items():
            way = "left" if value < 0 else "came in"
            label_side = f"{label} that {way} through the {side} side"
            fact = Fact(label_side, abs(value) / size, unit, f"diagnostics.nc: {where}")
            made["ice"].append(fact)
    for key, value in numbers.items():
        if key.startswith("gate_"):
            what, name = key.removeprefix("gate_").split("_", 1)
            unit, size = ("10³ km2", 1e9) if what == "area" else ("km3", 1e9)
            label = f"Ice {what} through {name.replace('_', ' ').title()}, to the right of its line"
            made["ice"].append(Fact(label, value / size, unit, f"diagnostics.nc: {key}"))
    if numbers.get("temperature_rescued"):
        share = 100.0 * numbers["temperature_rescued"] / numbers["temperature_solves"]
        label = "Solves for temperatures that needed the second method"
        made["ice"].append(Fact(label, share, "%", "diagnostics.nc: temperature_rescued"))
    for label, key, unit, source in (
        ("Mean net drift", "mean_drift_km", "km", "mean_displacement"),
        ("Net drift of the farthest element", "largest_drift_km", "km", "largest_displacement"),
        ("Mean speed", "mean_speed", "m/s", "drift_speed"),
        ("Largest speed of an element", "largest_speed", "m/s", "largest_speed"),
    ):
        made["motion"].append(Fact(label, numbers[key], unit, f"diagnostics.nc: {source}"))
    for label, key, source in (
        ("Bonds alive at the start", "bonds_start", "bonds"),
        ("Broken by motion", "bonds_broken", "bonds_broken"),
        ("Frozen anew", "bonds_refrozen", "bonds_refrozen"),
        ("Came or went (below 0) with elements: remaps, merging, sides", "bonds_remade", "bonds"),
        ("Bonds alive at the end", "bonds_end", "bonds"),
    ):
        if key in numbers:
            made["bonds"].append(Fact(label, numbers[key], "", f"diagnostics.nc: {source}"))
    return made


def motion_facts(analyses: xr.Dataset) -> list[Fact]:
    """How the pack drifts with the wind, as far as the run tells.

    Parameters
    ----------
    analyses : xarray.Dataset
        Of the analyses of motion.

    Returns
    -------
    list of Fact
        Empty where the run was too short for them.
    """
    if "wind_factor" not in analyses:
        return []
    factor, turning = (
        float(analyses[f"wind_{name}"].values[0, 0]) for name in ("factor", "turning")
    )
    if not math.isfinite(factor):
        return []
    ice = "of pack ice (80 % and more)"
    return [
        Fact(f"Drift over wind at 10 m, {ice}", 100.0 * factor, "%", "analyses.nc: wind_factor"),
        Fact(
            f"Turning to the left of the wind, {ice}",
            math.degrees(turning),
            "°",
            "analyses.nc: wind_turning",
        ),
    ]


def break_facts(analyses: xr.Dataset) -> list[Fact]:
    """How the breaks of bonds cluster in time and space, as far as the run tells.

    Parameters
    ----------
    analyses : xarray.Dataset
        Of the analyses of breaks.

    Returns
    -------
    list of Fact
        Those of which the analyses have the variable, in the order of the page.
    """
    made: list[tuple[str, float, str, str]] = []
    if "break_busy_share" in analyses:
        share = 100.0 * float(analyses["break_busy_share"])
        label = "Least share of the time in which half of all bonds broke"
        made.append((label, share, "%", "break_busy_share"))
    if "break_soon_share" in analyses:
        soon = 100.0 * float(analyses["break_soon_share"])
        label = "Breaks in the first eighth of a window (12.5 %: they do not follow windows)"
        made.append((label, soon, "%", "break_soon_share"))
    if "break_fano" in analyses:
        steps = analyses["break_step"].values / 3600.0
        for at in (0, -1):
            label = f"Variance of breaks over their mean, in intervals of {number(steps[at], 3)} h"
            made.append((label, float(analyses["break_fano"].values[at]), "", "break_fano"))
    if "burst_size" in analyses and analyses["burst_size"].size:
        largest = int(analyses["burst_size"].values.argmax())
        hours = float(analyses["burst_duration"].values[largest]) / 3600.0
        label = f"Breaks of the largest burst, which lasted {number(hours, 3)} h"
        made.append((label, float(analyses["burst_size"].values[largest]), "", "burst_size"))
    if "break_event_elements" in analyses:
        largest = int(analyses["break_event_elements"].max())
        label = "Elements of the largest event: neighbours that lost bonds in one window"
        made.append((label, largest, "", "break_event_elements"))
        ratios = analyses["break_neighbour_ratio"].values
        known = sorted(ratio for ratio in ratios.tolist() if math.isfinite(ratio))
        if known:
            label = "Neighbours that both lost bonds, over chance, median window"
            made.append((label, known[len(known) // 2], "", "break_neighbour_ratio"))
    return [
        Fact(label, value, unit, f"analyses.nc: {source}") for label, value, unit, source in made
    ]
