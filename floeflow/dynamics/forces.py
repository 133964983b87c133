# SPDX-License-Identifier: GPL-2.0-or-later
"""Forces of the plugin's integrator that a scene's effects add, by the effects' switches.

An effect names the switch of its force in ``plugin``, its sums in ``ledger`` and the fields that it
reads in ``forcing`` (`floeflow.scene.effects`); that is all, unless the scene has keys for it: a
function here then says with which keywords `fix floe/integrate` gets it.
docs/contributing/effect.md has the whole recipe.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

from floeflow.dynamics.engine.params import EngineParams, Force
from floeflow.scene import Scene
from floeflow.scene.effects import EFFECTS

FORCES: dict[str, Callable[[Scene], Force]] = {}


def force(switch: str) -> Callable[[Callable[[Scene], Force]], Callable[[Scene], Force]]:
    """Register the force that a switch of the plugin turns on.

    Parameters
    ----------
    switch : str
        Name of the switch.

    Returns
    -------
    callable
        Decorator that registers a function and returns it.
    """

    def register(function: Callable[[Scene], Force]) -> Callable[[Scene], Force]:
        FORCES[switch] = function
        return function

    return register


# Switches that the engine has parameters of its own for.
ENGINE_SWITCHES = frozenset(field.name for field in fields(EngineParams))


def scene_forces(scene: Scene) -> tuple[Force, ...]:
    """Forces that the effects of a scene add to wind, water and the rotation of the earth.

    Parameters
    ----------
    scene : Scene
        Its effects, and the keys of their forces.

    Returns
    -------
    tuple of Force
        In the order of the effects.
    """
    found = (
        FORCES[switch](scene) if switch in FORCES else Force(switch, (), EFFECTS[name].forcing)
        for name in scene.effects
        for switch in EFFECTS[name].plugin
        if switch not in ENGINE_SWITCHES
    )
    return tuple({force.switch: force for force in found}.values())


@force("seabed")
def seabed(scene: Scene) -> Force:
    """Friction of grounded ridges on the seabed (Lemieux et al. 2015).

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    Force
        Keywords in SI units; it reads the depth of the sea.
    """
    g = scene.grounding
    settings = (
        ("keel_ratio", g.keel_ratio),
        ("seabed_strength", g.strength),
        ("seabed_creep", g.creep),
        ("seabed_openness", g.openness),
    )
    return Force("seabed", settings, ("sea_floor_depth",))
