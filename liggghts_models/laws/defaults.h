// SPDX-License-Identifier: GPL-2.0-or-later
//
// Written by `floeflow docs --write` from the defaults of scenes (floeflow/scene/blocks.py) and the
// physical constants (floeflow/core/constants.py): an input script that leaves a keyword out gets
// what a scene gets.
#ifndef FLOE_LAWS_DEFAULTS_H
#define FLOE_LAWS_DEFAULTS_H

namespace floe {
namespace defaults {

constexpr double bond_young = 15000000.0;          // Pa
constexpr double poisson = 0.3;                    // ratio
constexpr double bond_damping = 0.1;               // share of critical
constexpr double compressive_strength = 100000.0;  // Pa
constexpr double tensile_share = 0.2;              // of the compressive strength
constexpr double friction_angle = 35.0;            // degrees
constexpr double contact_young = 20000000.0;       // Pa
constexpr double contact_shear_ratio = 0.5;        // tangential over normal stiffness
constexpr double contact_damping = 0.3;            // share of critical
constexpr double friction_coefficient = 0.3;       // Coulomb
constexpr double ridge_force = 26126.0;            // N/m2
constexpr double ridge_hardening = 928.0;          // N/m4
constexpr double ridge_thickness = 0.3;            // m
constexpr double lead_softening = 20.0;            // ratio
constexpr double air_drag = 0.00156;               // kg/m3, density times coefficient
constexpr double water_drag = 5.643;               // kg/m3, density times coefficient
constexpr double keel_ratio = 8.0;                 // depth of keels over thickness
constexpr double seabed_strength = 15.0;           // N/m3
constexpr double seabed_creep = 5e-05;             // m/s
constexpr double seabed_openness = 20.0;           // ratio
constexpr double ice_density = 917.0;              // kg/m3
constexpr double edge_share = 0.577350269189626;   // side of a hexagon over its inner diameter

}  // namespace defaults
}  // namespace floe

#endif
