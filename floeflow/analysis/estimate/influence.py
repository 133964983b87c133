# SPDX-License-Identifier: GPL-2.0-or-later
"""How far each effect would move a run's headline results, from the scene's conditions alone.

The results are the drift (position of the elements), the ice volume and the ice area at the end. An
effect's influence is the difference with and without it, each relative to what happens in the run
at all; the largest of the three ranks the effect. Balances of one point say what forces and heat do
(`drift`, `ice`); for what happens between elements there are scalings, stated below.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from floeflow.analysis.estimate.conditions import Conditions
from floeflow.analysis.estimate.dimensionless_numbers import NUMBERS
from floeflow.analysis.estimate.drift import run_drift
from floeflow.analysis.estimate.ice import run_ice
from floeflow.scene.effects import EFFECTS

# What happens at all is at least this much: a drift of 1 km, a hundredth of the ice.
DRIFT_FLOOR, ICE_FLOOR = 1.0e3, 0.01
# Parts of thermodynamics as long as they are no effects of their own.
PARTS = ("snow", "shortwave", "frazil")
# Share of the wind's spread by which the calm half lies below the whole.
CALM = 0.7
POINT = ("wind", "ocean_drag", "turning_angle", "coriolis", "tilt")


@dataclass(frozen=True)
class Influence:
    """What an effect changes by the end of the run.

    Parameters
    ----------
    drift : float
        Root mean square change of the elements' positions, m.
    volume : float
        Change of the ice volume per area of sea, m.
    area : float
        Change of the share of the sea under ice.
    share : float
        The largest of them, relative to what happens in the run.
    """

    drift: float
    volume: float
    area: float
    share: float


def mechanical_drift(c: Conditions, name: str, effects: frozenset[str]) -> float:
    """Change of positions (m) by what happens between elements.

    Bonds even out the drift as far as they hold, friction what has no bonds; the coast stops what
    lies at it; ridging lets the pack close, where elastic contacts would hold it apart.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    name : str
        Effect that is left out.
    effects : frozenset of str
        Those that are simulated.

    Returns
    -------
    float
        m, over the run.
    """
    torn, free = c.spread * c.seconds, c.slip * c.seconds
    held = min(1.0, NUMBERS["bonds"](c))
    loose = 1.0 - held if "bonds" in effects else 1.0
    if name == "bonds":
        return held * torn
    if name == "friction":
        return min(1.0, NUMBERS["friction"](c)) * loose * torn
    if name == "coast":
        # The root mean square where a share of the ice stands still and the rest goes on.
        return math.sqrt(min(1.0, c.coast_share)) * free
    if name == "grounding":
        return math.sqrt(min(1.0, c.grounded_share)) * free
    if name == "walls":
        return min(1.0, NUMBERS["walls"](c)) * free
    if name == "ridging":
        # Closing adds up over the width of the pack: a linear profile and its spread.
        return NUMBERS["ridging"](c) * c.fetch / math.sqrt(12.0)
    if name == "refreeze":
        return min(1.0, NUMBERS["refreeze"](c)) * held * loose * torn
    return 0.0


def influence(c: Conditions, name: str, effects: Iterable[str]) -> Influence:
    """Influence of one effect in a run with these effects (its own presence does not matter).

    Parameters
    ----------
    c : Conditions
        Of the scene.
    name : str
        The effect.
    effects : iterable of str
        Effects of the run.
    """
    there = frozenset(effects) | {name} | {part for part in PARTS if part not in EFFECTS}
    gone = without(there, name)
    with_ice, without_ice = run_ice(c, there), run_ice(c, gone)
    volume, area = with_ice.volume - without_ice.volume, with_ice.area - without_ice.area
    start = c.concentration * c.thickness
    # What moves is the ice of mid run, thicker or thinner than at the start.
    share = 0.5 * (1.0 + with_ice.volume / start) if start > 0 else 1.0
    moving = replace(c, thickness=share * c.thickness)
    drift = mechanical_drift(moving, name, there)
    paths = [run_drift(part, there) for part in calm_and_windy(moving)]
    if name in POINT:
        others = [run_drift(part, gone) for part in calm_and_windy(moving)]
        drift = _rms([abs(a - b) for a, b in zip(paths, others, strict=True)])
    scales = (
        max(_rms([abs(path) for path in paths]), DRIFT_FLOOR),
        max(abs(with_ice.volume - start), ICE_FLOOR * start),
        max(abs(with_ice.area - c.concentration), ICE_FLOOR * c.concentration),
    )
    shares = [
        abs(part) / scale if scale > 0 else 0.0
        for part, scale in zip((drift, volume, area), scales, strict=True)
    ]
    return Influence(drift, volume, area, max(shares))


def calm_and_windy(c: Conditions) -> tuple[Conditions, Conditions]:
    """Two halves of the ice, with less and more wind, whose root mean square is the scene's.

    Where the wind is weak, what else moves the ice moves it further.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    calm = 1.0 - CALM * min(1.0, c.wind_spread / c.wind) if c.wind else 1.0
    windy = math.sqrt(2.0 - calm**2)
    return replace(c, wind=calm * c.wind), replace(c, wind=windy * c.wind)


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(sum(value**2 for value in values) / len(values))


def without(effects: Iterable[str], name: str) -> frozenset[str]:
    """These effects without one, and without those that need it.

    Parameters
    ----------
    effects : iterable of str
        Names.
    name : str
        Effect that is left out.

    Returns
    -------
    frozenset of str
        The rest.
    """
    left = frozenset(effects) - {name}
    while lost := {e for e in left if e in EFFECTS and not set(EFFECTS[e].needs) <= left}:
        left -= lost
    return left
