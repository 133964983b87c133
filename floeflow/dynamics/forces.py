# SPDX-License-Identifier: GPL-2.0-or-later
"""Forces of the plugin's integrator that a scene's effects add, by the effects' switches.

A new one is a function here: it says with which keywords `fix floe/integrate` gets it, and which
fields of the forcing it reads. Its effect names the switch in ``plugin`` and its sums in ``ledger``
(`floeflow.scene.effects`); docs/contributing/effect.md has the whole recipe.
"""

from __future__ import annotations

from collections.abc import Callable

from floeflow.dynamics.engine.params import Force
from floeflow.scene import Scene

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


@force("seabed")
def seabed(scene: Scene) -> Force:
    """Friction of grounded ridges on the seabed (Lemieux et al. 2015).

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    g = scene.grounding
    settings = (
        ("keel_ratio", g.keel_ratio),
        ("seabed_strength", g.strength),
        ("seabed_creep", g.creep),
        ("seabed_openness", g.openness),
    )
    return Force("seabed", settings, ("sea_floor_depth",))
