# SPDX-License-Identifier: GPL-2.0-or-later
"""What a run costs, stage by stage, from its scene: the cost model of estimates and plans.

Seconds of one core are linear in a few sizes of the scene (elements times steps, cells, windows)
with the coefficients of ``costs.json``, fitted to runs by
``floeflow plan --refit``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from floeflow.core.constants import ICE_DENSITY
from floeflow.scene.effects import EFFECTS, plugin_switches
from floeflow.scene.windows import window_chunks

if TYPE_CHECKING:
    from floeflow.analysis.estimate.conditions import Conditions
    from floeflow.scene import Scene

COSTS = Path(__file__).with_name("costs.json")
Coefficients = Mapping[str, float]
# What physics and settings set; starting programs costs the same for any of them.
WORK = ("dynamics", "column")
# Concentration varies within the ice: where the mean is this little below, most has bonds.
BOND_MARGIN = 0.05
# Size of elements for which the coefficient of the coast stands, m.
COAST_SIZE = 1.0e5
# Layers of ice for which the schemes' coefficients stand.
LAYERS = 7
# Effects that have work of their own between windows: the sea, remapping and merging.
IN_WINDOWS = ("mixed_layer", "remap", "merge", "ridging")


class Pack(Protocol):
    """What sizes of a run follow from: `Conditions`, or an outline of them."""

    @property
    def elements(self) -> int:
        """Number of elements."""

    @property
    def element_size(self) -> float:
        """Side of a square of the area of an element (m)."""

    @property
    def concentration(self) -> float:
        """Of the ice at the start."""

    @property
    def bond_concentration(self) -> float:
        """Concentration below which ice has no bonds."""

    @property
    def coast_share(self) -> float:
        """Share of the ice within an element of land."""


@dataclass(frozen=True)
class Sizes:
    """Sizes of a run that its cost depends on.

    Parameters
    ----------
    elements : float
        With the coast's.
    steps : float
        Steps of the element model in the whole run.
    windows, launches : int
        Coupling windows, and the jobs in which they run.
    column_steps : float
        Column steps in the whole run.
    cells : float
        Cells of the scene grid.
    mask_cells : float
        Cells of the mask grid.
    land, bonded : bool
        Whether the 1 km land mask is read, and whether most of the ice has bonds.
    column : mapping
        How often an element does each part of the column's step, see `column_parts`.
    """

    elements: float
    steps: float
    windows: int
    launches: int
    column_steps: float
    cells: float
    mask_cells: float
    land: bool
    bonded: bool
    column: Mapping[str, float] = field(default_factory=dict)


def coefficients() -> dict[str, float]:
    """Fitted coefficients of the cost model."""
    data: dict[str, float] = json.loads(COSTS.read_text())["seconds"]
    return data


def bonded(c: Pack, effects: Iterable[str]) -> bool:
    """Whether most of the ice is dense enough for the scene's bonds.

    Parameters
    ----------
    c : Pack
        Conditions of the scene.
    effects : iterable of str
        Those that are simulated.

    Returns
    -------
    bool
        Whether bonds are made there.
    """
    return "bonds" in effects and c.concentration >= c.bond_concentration - BOND_MARGIN


def critical_step(c: Pack, scene: Scene, effects: Iterable[str], fit: Coefficients) -> float:
    """Critical step of the element model (s): stiffnesses of contacts, friction and bonds add up.

    Each alone allows a step of size over speed of sound, times a fitted factor that holds what the
    smallest elements take from it; squares of the rates add. Independent of thickness.

    Parameters
    ----------
    c : Pack
        Conditions of the scene.
    scene : Scene
        Its keys.
    effects : iterable of str
        Those that are simulated.
    fit : Coefficients
        Coefficients of the cost model.

    Returns
    -------
    float
        s.
    """
    rates = {"step_contacts": scene.dynamics.contact_modulus}
    if "friction" in effects:
        rates["step_friction"] = scene.dynamics.contact_modulus
    if bonded(c, effects):
        rates["step_bonds"] = scene.dynamics.young_modulus
    square = sum(modulus / ICE_DENSITY / fit[name] ** 2 for name, modulus in rates.items())
    return c.element_size / math.sqrt(square)


def coast_measure(c: Pack) -> float:
    """What the elements that a coast adds are proportional to, of those aimed at (1).

    Coasts cut elements that lie at them into pieces: a share of all that falls with their size.

    Parameters
    ----------
    c : Pack
        Conditions of the scene.
    """
    return c.coast_share * c.element_size / COAST_SIZE


def sizes(c: Pack, scene: Scene, effects: Iterable[str], fit: Coefficients) -> Sizes:
    """Sizes of a run of the scene with these effects.

    Parameters
    ----------
    c : Pack
        Conditions of the scene.
    scene : Scene
        Its keys.
    effects : iterable of str
        Those that are simulated.
    fit : Coefficients
        Coefficients of the cost model.

    Returns
    -------
    Sizes
        Counts of elements, steps, cells and windows.
    """
    effects = tuple(effects)
    domain = scene.domain
    cells = (domain.x_max - domain.x_min) * (domain.y_max - domain.y_min) / domain.spacing**2
    coast = fit["coast_elements"] * coast_measure(c) if "coast" in effects else 0.0
    between = scene.time.window / scene.dynamics.samples
    step = scene.dynamics.step_share * critical_step(c, scene, effects, fit)
    steps = math.ceil(between / step) * scene.dynamics.samples * scene.time.windows
    inner = math.ceil(scene.time.window / scene.column.step) * scene.time.windows
    return Sizes(
        elements=c.elements * (1.0 + coast),
        steps=steps,
        windows=scene.time.windows,
        launches=len(window_chunks(scene.time.windows, scene.workflow.windows_per_job)),
        column_steps=inner,
        cells=cells,
        mask_cells=cells * scene.mask.refine**2,
        land=scene.mask.land == "global_land_mask",
        bonded=bonded(c, effects),
        column=column_parts(scene, effects),
    )


def column_parts(scene: Scene, effects: Iterable[str]) -> dict[str, float]:
    """How often one element does each part of one column step.

    The scheme works category by category and, where it has layers, in proportion to these and the
    snow's; light that is scattered in layers, and the effects, category by category.

    Parameters
    ----------
    scene : Scene
        Its keys.
    effects : iterable of str
        Those that are simulated.

    Returns
    -------
    dict of float
        Counts by the names of the coefficients.
    """
    keys, effects = scene.column, tuple(effects)
    many, layered = float(keys.categories), keys.scheme != "zero_layer"
    share = (1 + keys.layers) / (1 + LAYERS) if layered else 1.0
    parts: dict[str, float] = {keys.scheme: many * share}
    if layered and keys.light == "delta_eddington" and "shortwave" in effects:
        parts["delta_eddington"] = many
    own = (name for name in effects if EFFECTS[name].column and name != "thermodynamics")
    return parts | dict.fromkeys(own, many)


def stage_seconds(s: Sizes, effects: Iterable[str], fit: Coefficients) -> dict[str, float]:
    """Seconds of one core for each stage of a run.

    Parameters
    ----------
    s : Sizes
        Of the run.
    effects : iterable of str
        Its effects.
    fit : mapping
        Coefficients: ``<stage>`` for a job, ``<stage>_per_<size>``, ``dynamics_<effect>``,
        ``column_<part>`` of `column_parts`, ``window_<effect>`` for an element.
    """
    effects = tuple(effects)
    switched = [e for e in effects if plugin_switches((e,)) and (e != "bonds" or s.bonded)]
    a_step = fit["dynamics"] + sum(fit.get(f"dynamics_{name}", 0.0) for name in switched)
    seconds = dict.fromkeys(("mask", "packing", "initial"), fit["job"])
    seconds["report"] = fit["report"]
    seconds["mask"] += fit["mask_per_cell"] * s.mask_cells
    seconds["packing"] += fit["packing_per_element"] * s.elements
    seconds["forcing"] = fit["forcing_per_cell"] * s.cells * s.windows
    an_element = fit["window_per_element"] + sum(
        fit.get(f"window_{name}", 0.0) for name in IN_WINDOWS if name in effects
    )
    a_window = fit["window"] + an_element * s.elements
    seconds["window"] = s.launches * fit["launch"] + s.windows * a_window
    seconds["dynamics"] = s.steps * (fit["step"] + s.elements * a_step)
    if "bonds" in effects:
        seconds["bonds"] = fit["job"]
    if s.land:
        seconds["land"] = fit["land"]
    if "thermodynamics" in effects:
        a_step = fit["column"] + sum(
            fit.get(f"column_{name}", 0.0) * often for name, often in s.column.items()
        )
        seconds["column"] = fit["column_start"] * s.windows
        seconds["column"] += a_step * s.elements * s.column_steps
    if "grid_output" in effects:
        # A job for each chunk, and one that joins them.
        jobs = (s.launches + 1) * fit["job"]
        seconds["grid"] = jobs + (s.windows + 1) * fit["grid_per_cell"] * s.cells
        if "thermodynamics" in effects:
            each = fit["tendencies_per_cell"] * s.cells
            seconds["tendencies"] = fit["job"] + s.windows * each
    if "trajectory_output" in effects:
        seconds["trajectory"] = fit["job"] + fit["window_per_element"] * s.elements * s.windows
    return seconds


def run_seconds(
    c: Pack, scene: Scene, effects: Iterable[str], ranks: int, fit: Coefficients
) -> float:
    """Wall seconds of a run on so many ranks, other stages one after the other.

    Element model and column are shared by the ranks; each step takes time for their messages.

    Parameters
    ----------
    c : Pack
        Conditions of the scene.
    scene : Scene
        Its keys.
    effects : iterable of str
        Those that are simulated.
    ranks : int
        Number of MPI ranks.
    fit : Coefficients
        Coefficients of the cost model.

    Returns
    -------
    float
        s.
    """
    effects = tuple(effects)
    s = sizes(c, scene, effects, fit)
    seconds = stage_seconds(s, effects, fit)
    shared = sum(seconds.pop(part, 0.0) for part in WORK)
    alone = s.steps * fit["step"]
    talk = s.steps * fit["message"] * (ranks > 1)
    return sum(seconds.values()) + alone + talk + (shared - alone) / ranks


def cost_share(
    c: Conditions,
    scene: Scene,
    name: str,
    effects: Iterable[str],
    fit: Coefficients,
    parts: tuple[str, ...] = (),
) -> float:
    """Share of the run time with an effect that goes when it is left out.

    `parts` restricts it to some stages, such as ``WORK``; empty: the whole run.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    scene : Scene
        Its keys.
    name : str
        Effect that is left out, and those that need it.
    effects : iterable of str
        Those that are simulated.
    fit : Coefficients
        Coefficients of the cost model.
    parts : tuple of str, optional
        Stages that count.

    Returns
    -------
    float
        0 to 1, of the stages that count.
    """
    from floeflow.analysis.estimate.influence import without

    there = frozenset(effects) | {name}
    return saved_share(c, scene, there, without(there, name), fit, parts)


def saved_share(
    c: Conditions,
    scene: Scene,
    effects: Iterable[str],
    fewer: Iterable[str],
    fit: Coefficients,
    parts: tuple[str, ...] = (),
) -> float:
    """Share of the run time of a scene with these effects that fewer of them save.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    scene : Scene
        Its keys.
    effects : iterable of str
        Those that are simulated.
    fewer : iterable of str
        Those that are left.
    fit : Coefficients
        Coefficients of the cost model.
    parts : tuple of str, optional
        Stages that count; empty: the whole run.

    Returns
    -------
    float
        0 to 1, of the stages that count.
    """
    full, less = (
        sum(
            value
            for stage, value in stage_seconds(sizes(c, scene, e, fit), e, fit).items()
            if not parts or stage in parts
        )
        for e in (tuple(effects), tuple(fewer))
    )
    return (full - less) / full if full else 0.0
