# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin's defaults, a C++ header written from the defaults of scenes."""

from __future__ import annotations

from floeflow.core.constants import (
    AIR_DENSITY,
    CONTACT_SHEAR_RATIO,
    EDGE_SHARE,
    ICE_DENSITY,
    SEAWATER_DENSITY,
)
from floeflow.scene.blocks import Dynamics, Grounding

HEAD = """\
// SPDX-License-Identifier: GPL-2.0-or-later
//
// Written by `floeflow docs --write` from the defaults of scenes (floeflow/scene/blocks.py) and the
// physical constants (floeflow/core/constants.py): an input script that leaves a keyword out gets
// what a scene gets.
#ifndef FLOE_LAWS_DEFAULTS_H
#define FLOE_LAWS_DEFAULTS_H

namespace floe {
namespace defaults {

"""
TAIL = """
}  // namespace defaults
}  // namespace floe

#endif
"""


def plugin_defaults() -> str:
    """Text of ``liggghts_models/laws/defaults.h``."""
    d, g = Dynamics(), Grounding()
    rows = (
        ("bond_young", d.young_modulus, "Pa"),
        ("poisson", d.poisson_ratio, "ratio"),
        ("bond_damping", d.bond_damping, "share of critical"),
        ("compressive_strength", d.compressive_strength, "Pa"),
        ("tensile_share", d.tensile_share, "of the compressive strength"),
        ("friction_angle", d.friction_angle, "degrees"),
        ("contact_young", d.contact_modulus, "Pa"),
        ("contact_shear_ratio", CONTACT_SHEAR_RATIO, "tangential over normal stiffness"),
        ("contact_damping", d.contact_damping, "share of critical"),
        ("friction_coefficient", d.friction_coefficient, "Coulomb"),
        ("ridge_force", d.ridge_force, "N/m2"),
        ("ridge_hardening", d.ridge_hardening, "N/m4"),
        ("ridge_thickness", d.ridge_thickness, "m"),
        ("lead_softening", d.lead_softening, "ratio"),
        ("air_drag", AIR_DENSITY * d.air_drag, "kg/m3, density times coefficient"),
        ("water_drag", SEAWATER_DENSITY * d.ocean_drag, "kg/m3, density times coefficient"),
        ("keel_ratio", g.keel_ratio, "depth of keels over thickness"),
        ("seabed_strength", g.strength, "N/m3"),
        ("seabed_creep", g.creep, "m/s"),
        ("seabed_openness", g.openness, "ratio"),
        ("ice_density", ICE_DENSITY, "kg/m3"),
        ("edge_share", EDGE_SHARE, "side of a hexagon over its inner diameter"),
    )
    lines = [(f"constexpr double {name} = {value!r};", unit) for name, value, unit in rows]
    width = max(len(line) for line, _ in lines)
    text = "\n".join(f"{line:{width}}  // {unit}" for line, unit in lines)
    return HEAD + text + "\n" + TAIL
