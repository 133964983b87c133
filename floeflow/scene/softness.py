# SPDX-License-Identifier: GPL-2.0-or-later
"""How soft bonds and contacts may be: ``dynamics.stiffness: auto``.

The time step follows from the stiffness of ice, though on the scale of elements ice breaks and
ridges long before its elasticity shows. What softer ice must not change is where it breaks and
where it ridges.
"""

from __future__ import annotations

from typing import Any

from floeflow.core.constants import EDGE_SHARE

# Full moduli of sea ice in bonds and of unbonded contact, Pa.
YOUNG, CONTACT = 1.0e9, 1.0e8
# Moduli over the compressive strength. A bond that breaks in compression is shorter by 1 / 150 of
# the span then. A contact as long as a hexagon's side takes the crushing force L h sigma with the
# spring E h / 2: at that limit it has closed elastically by 2 x 0.577 / 200 of the span, 0.58 %;
# 1 % is the most that may be.
YOUNG_OVER_STRENGTH, CONTACT_OVER_STRENGTH = 150.0, 200.0
LEAST = 1.0e3
# Strength of Kovacs & Sodhi's bonds at this thickness (m), the thickest level ice: stiff enough for
# thinner ice too.
THICKEST = 3.0
KOVACS_SODHI = 1285.0e3


def softened(data: dict[str, Any]) -> dict[str, Any]:
    """Keys of the block ``dynamics`` with the moduli that ``stiffness`` asks for.

    A modulus that is named stays. Values that no scene may have are left to the model's checks.

    Parameters
    ----------
    data : dict
        Keys of the block, which stay as they are.

    Returns
    -------
    dict
        The block with ``young_modulus`` and ``contact_modulus`` (Pa), or as it was.
    """
    if data.get("stiffness", "auto") == "full":
        return {"young_modulus": YOUNG, "contact_modulus": CONTACT} | data
    strength = data.get("compressive_strength", 1.0e5)
    if data.get("strength") == "kovacs_sodhi":
        strength = KOVACS_SODHI * THICKEST ** (2.0 / 3.0)
    if isinstance(strength, bool) or not isinstance(strength, int | float) or not strength > 0:
        return data
    young, contact = moduli(float(strength))
    return {"young_modulus": young, "contact_modulus": contact} | data


def moduli(strength: float) -> tuple[float, float]:
    """Young's modulus of bonds and modulus of contacts (Pa) for a compressive strength (Pa).

    Parameters
    ----------
    strength : float
        Compressive strength (Pa).

    Returns
    -------
    young, contact : float
        Pa, within the bounds of the scene's keys.
    """
    young, contact = YOUNG_OVER_STRENGTH * strength, CONTACT_OVER_STRENGTH * strength
    # No softer than what a scene may name.
    return min(YOUNG, max(young, LEAST)), min(CONTACT, max(contact, LEAST))


def sentence(young: float, contact: float, strength: float) -> str:
    """What was chosen and why, for a log or a report.

    Parameters
    ----------
    young : float
        Young's modulus, contact modulus and compressive strength (Pa).
    contact : float
        Young's modulus, contact modulus and compressive strength (Pa).
    strength : float
        Young's modulus, contact modulus and compressive strength (Pa).

    Returns
    -------
    str
        One sentence, with Pa and percentages.
    """
    return (
        f"bonds of {young:.3g} Pa break at a compression of {100 * strength / young:.2g} % of the "
        f"span (sea ice: {YOUNG:.3g} Pa), contacts of {contact:.3g} Pa close elastically by "
        f"{100 * 2 * EDGE_SHARE * strength / contact:.2g} % before ice of that strength is crushed "
        f"(full: {CONTACT:.3g} Pa); dynamics.stiffness: full takes the full ones"
    )
