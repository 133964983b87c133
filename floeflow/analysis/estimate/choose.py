# SPDX-License-Identifier: GPL-2.0-or-later
"""Which effects a scene should name: estimates of all of them, a recommendation, reasons.

``effects: auto`` takes what is recommended. Output of any kind changes no result: `auto` keeps
that of the default scene.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from floeflow.analysis.estimate.conditions import Conditions, conditions
from floeflow.analysis.estimate.cost import Coefficients, coefficients, cost_share
from floeflow.analysis.estimate.dimensionless_numbers import meaning, number_value
from floeflow.analysis.estimate.influence import Influence, influence
from floeflow.core.errors import FloeError
from floeflow.forcings.inputs import check_forcing_file
from floeflow.scene import Scene
from floeflow.scene.effects import EFFECTS, check_effects, compatible

# Relative influence above which an effect is needed, and below which it is waste.
NEEDED, WASTE = 0.05, 0.01
OUTPUT = ("grid_output", "trajectory_output", "internal_stress", "ice_age")
# Effects that make another scene of it: only who wants that scene can name them.
SETTING = ("walls",)


@dataclass(frozen=True)
class Estimate:
    """What an effect would do in a scene.

    Parameters
    ----------
    name : str
        The effect.
    named : bool
        Whether the run has it.
    number : float or None
        Its dimensionless number; None where it has none.
    meaning : str
        What the number is.
    drift, volume, area : float
        Influence on positions (m), ice volume per sea area (m), share of the sea under ice.
    share : float
        The largest of them relative to what happens in the run.
    cost : float
        Share of the run time.
    advice : str
        needed, minor, waste, output or setting.
    reason : str
        One sentence.
    """

    name: str
    named: bool
    number: float | None
    meaning: str
    drift: float
    volume: float
    area: float
    share: float
    cost: float
    advice: str
    reason: str

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return asdict(self)


def advise(name: str, found: Influence) -> tuple[str, str]:
    """Advice on an effect, and the reason in one sentence.

    Parameters
    ----------
    name : str
        Effect.
    found : Influence
        What it changes.

    Returns
    -------
    tuple of str
        ``output``, ``setting``, ``needed``, ``minor`` or ``waste``, and a sentence with its share
        in %.
    """
    if name in OUTPUT:
        return "output", "It changes no result."
    if name in SETTING:
        return "setting", "It makes another scene of it."
    part, by = _largest(found)
    text = f"It moves {part} by {by}, {100 * min(found.share, 99.99):.3g} % of what happens."
    if found.share >= NEEDED:
        return "needed", text
    return ("minor", text) if found.share >= WASTE else ("waste", text)


def _largest(found: Influence) -> tuple[str, str]:
    if abs(found.volume) == abs(found.area) == 0.0:
        return "positions", f"{found.drift / 1e3:.3g} km"
    if found.drift == 0.0:
        return "the ice", f"{found.volume:+.2g} m and its area by {100 * found.area:+.2g} %"
    return "positions and ice", f"{found.drift / 1e3:.3g} km and {found.volume:+.2g} m"


def estimate(
    c: Conditions, scene: Scene, effects: Iterable[str], fit: Coefficients
) -> list[Estimate]:
    """Estimates of all effects of the registry, in its order.

    Parameters
    ----------
    c : Conditions
        Of the scene.
    scene : Scene
        For the sizes that set the cost.
    effects : iterable of str
        Effects of the run.
    fit : mapping
        Coefficients of the cost model.
    """
    effects = tuple(effects)
    rows = []
    for name in EFFECTS:
        found = influence(c, name, effects)
        number = number_value(name, c)
        advice, reason = advise(name, found)
        rows.append(
            Estimate(
                name,
                name in effects,
                number if math.isfinite(number) else None,
                meaning(name),
                *(found.drift, found.volume, found.area, found.share),
                cost_share(c, scene, name, effects, fit),
                advice,
                reason,
            )
        )
    return rows


def recommended(rows: Iterable[Estimate], defaults: Iterable[str]) -> tuple[str, ...]:
    """Effects that are needed, what they need, and output and setting as the defaults have them.

    Parameters
    ----------
    rows : iterable of Estimate
        Estimates of all effects.
    defaults : iterable of str
        Effects of a scene that names none.

    Returns
    -------
    tuple of str
        In the registry's order.

    Raises
    ------
    FloeError
        For effects that do not go together.
    """
    rows = list(rows)
    wanted = {row.name for row in rows if row.advice == "needed"}
    wanted |= set(OUTPUT + SETTING) & set(defaults)
    while missing := {need for name in wanted for need in EFFECTS[name].needs} - wanted:
        wanted |= missing
    return check_effects(compatible(wanted))


def choose(scene: Scene) -> tuple[str, ...]:
    """Effects for ``effects: auto``: estimated with all of them, so that each meets the others.

    Parameters
    ----------
    scene : Scene
        Its keys; its effects are not read.
    """
    c = conditions(scene)
    default = type(scene).model_fields["effects"].default
    possible = [name for name in EFFECTS if _has_forcing(scene, name)]
    if scene.column.categories < 2:
        possible.remove("redistribution")
    if scene.column.scheme == "zero_layer":
        possible.remove("ponds")
    rows = estimate(c, scene, possible, coefficients())
    return recommended([row for row in rows if row.name in possible], default)


def _has_forcing(scene: Scene, name: str) -> bool:
    """Whether the user's forcing file has what an effect and its needs read."""
    if scene.forcing.source != "file":
        return True
    asked = (name, *EFFECTS[name].needs)
    try:
        check_forcing_file(scene.model_copy(update={"effects": asked}))
    except FloeError:
        return False
    return True


def scene_estimates(scene: Scene) -> list[Estimate]:
    """Estimates of all effects for a scene as it stands.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    return estimate(conditions(scene), scene, scene.effects, coefficients())


def as_table(rows: Iterable[Estimate]) -> str:
    """The estimates as text, most influential first.

    Parameters
    ----------
    rows : iterable of Estimate
        Estimates of effects.
    """
    head = (
        "effect",
        "named",
        "number",
        "drift km",
        "ice m",
        "area %",
        "influence",
        "cost",
        "advice",
    )
    lines = [head]
    for row in sorted(rows, key=lambda row: -row.share):
        number = "" if row.number is None else f"{row.number:.3g}"
        lines.append(
            (
                row.name,
                "yes" if row.named else "",
                number,
                f"{row.drift / 1e3:.3g}",
                f"{row.volume:+.3g}",
                f"{100 * row.area:+.3g}",
                f"{100 * row.share:.3g} %",
                f"{100 * row.cost:.3g} %",
                row.advice,
            )
        )
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def numbers_behind(c: Conditions) -> Mapping[str, float]:
    """The scene's conditions by name: the numbers behind the table.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return asdict(c)
