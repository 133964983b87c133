# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene's pack, made for its plan: how many elements there are and which step they allow.

The step hangs on the smallest elements, and these on the coast's shape: no typical size tells them.
Making the pack takes seconds, and the plan then knows the very step that the run will take.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from floeflow.analysis.estimate import cost
from floeflow.analysis.estimate.conditions import Conditions
from floeflow.analysis.estimate.cost import Coefficients
from floeflow.analysis.plan.propose import adjusted
from floeflow.coupling.first_state import first_pack
from floeflow.coupling.initial import make_state
from floeflow.dynamics.motion import engine_params, nearing
from floeflow.dynamics.step.critical import critical_step
from floeflow.forcings.window import window_forcing
from floeflow.scene import Scene
from floeflow.state.elements import element_arrays, pair_arrays
from floeflow.state.schema import COAST, MOBILE

# Larger packs are made this large: their elements are as unlike.
MOST_ELEMENTS = 20_000


def fitted_to_pack(scene: Scene, c: Conditions, fit: Coefficients) -> Coefficients:
    """Cost coefficients with the step and the coast of the scene's own pack.

    Parameters
    ----------
    scene : Scene
        The scene.
    c : Conditions
        Of the scene.
    fit : mapping
        Coefficients that hold for a typical pack.
    """
    keys = scene.packing
    keys = keys.model_copy(update={"elements": min(keys.elements, MOST_ELEMENTS)})
    scene = scene.model_copy(update={"packing": keys})
    with tempfile.TemporaryDirectory() as scratch:
        made = first_pack(scene, Path(scratch))
        forcing = window_forcing(scene, 1, Path(scratch))
    state = make_state(scene, made.packing, made.bonds, made.mask)
    elements = element_arrays(state, scene.dynamics.minimum_thickness)
    mobile, coast = (int((elements["type"] == kind).sum()) for kind in (MOBILE, COAST))
    if not mobile:
        return fit
    pairs = None if made.bonds is None else pair_arrays(state, "bond")
    # As far as elements come in a window: the smallest of a fjord are no neighbours of all.
    way = nearing(scene, elements, forcing)
    step = critical_step(elements, pairs, engine_params(scene), way)[0]
    own = adjusted(c, scene)
    typical = cost.critical_step(own, scene, scene.effects, fit)
    longer = {name: step / typical * fit[name] for name in fit if name.startswith("step_")}
    measure, more = cost.coast_measure(own), (mobile + coast) / keys.elements - 1.0
    share = max(more, 0.0) / measure if measure else fit["coast_elements"]
    return {**fit, **longer, "coast_elements": share}
