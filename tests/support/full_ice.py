# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters of the element model with the stiffness of sea ice and a strength of 1 MPa.

Scenes take softer and weaker ice (`floeflow/scene/blocks.py`); closed forms are known for any.
"""

from __future__ import annotations

from typing import Any

from floeflow.dynamics.engine.params import EngineParams

FULL = {
    "young_modulus": 1.0e9,
    "compressive_strength": 1.0e6,
    "tensile_share": 0.1,
    "contact_modulus": 1.0e8,
}


def full_params(time_step: float, **given: Any) -> EngineParams:
    """Parameters with a time step (s), stiff and strong where not given otherwise."""
    return EngineParams(time_step, **(FULL | given))
