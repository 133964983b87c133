# SPDX-License-Identifier: GPL-2.0-or-later
"""Checks across keys: combinations that no single key can refuse."""

from __future__ import annotations

import logging
import math
from datetime import timedelta
from typing import TYPE_CHECKING

from floeflow.core.errors import FloeError
from floeflow.scene.physics import unread_keys
from floeflow.scene.windows import window_chunks

if TYPE_CHECKING:
    from floeflow.scene.blocks import Scene

MAX_CELLS = 4_000_000
# Values of a quantity of the forcing in a window, 0.4 GB.
MAX_FORCING = 50_000_000
# Mush of fresher water holds liquid that nothing freezes (1e-3).
LEAST_SALINITY = 0.5

log = logging.getLogger(__name__)


def check_combinations(scene: Scene) -> None:
    """Refuse impossible combinations of keys.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Raises
    ------
    FloeError
        One sentence that names the keys.
    """
    if "+" in scene.name:
        raise FloeError(
            f"name: {scene.name!r} is not a plain name (lower-case letters, digits, '_' and '-', "
            "at most 64, no path)"
        )
    _check_domain(scene)
    _check_times(scene)
    _check_step(scene)
    if "walls" in scene.effects and not scene.walls.names:
        raise FloeError("effects: 'walls' is named but walls.rim, planes and mesh name none")
    for number, (_, _, *normal, _, _) in enumerate(scene.walls.planes):
        if math.hypot(*normal) == 0.0:
            raise FloeError(
                f"walls.planes.{number}: its normal is 0, so which side is the ice's is not said"
            )
    if len(set(scene.walls.rim)) < len(scene.walls.rim):
        raise FloeError("walls.rim names a side twice")
    if len(set(scene.gates.names)) < len(scene.gates.names):
        raise FloeError("gates.names names a gate twice")
    if len(scene.gates.names) != len(scene.gates.lines):
        raise FloeError("gates.names and gates.lines must be as many")
    for name, line in zip(scene.gates.names, scene.gates.lines, strict=True):
        if line[:2] == line[2:]:
            raise FloeError(f"gates.lines: the gate '{name}' ends where it begins")
    if "gates" in scene.effects and not scene.gates.names:
        raise FloeError("effects: 'gates' is named but gates.names names none")
    if "grounding" in scene.effects and not (scene.grounding.file or scene.grounding.depth):
        raise FloeError("effects: 'grounding' needs grounding.file or a grounding.depth above 0")
    given = scene.forcing.file or scene.forcing.files
    if scene.forcing.source == "file" and not given:
        raise FloeError("forcing.source is 'file' but forcing.file and forcing.files name none")
    if scene.forcing.source != "file" and given:
        raise FloeError(f"forcing.file is given but forcing.source is '{scene.forcing.source}'")
    angle = type(scene.dynamics).model_fields["turning_angle"].default
    if scene.dynamics.turning_angle != angle and "turning_angle" not in scene.effects:
        raise FloeError("dynamics.turning_angle is given but effects does not name turning_angle")
    if scene.mask.land == "mask" and not scene.mask.file:
        raise FloeError("mask.land is 'mask' but mask.file names none")
    if "ponds" in scene.effects and scene.column.scheme == "zero_layer":
        raise FloeError("effect 'ponds' needs column.scheme 'bl99' or 'mushy'")
    if scene.column.scheme == "mushy" and scene.column.ocean_salinity < LEAST_SALINITY:
        raise FloeError(
            f"column.ocean_salinity must be {LEAST_SALINITY:g} (1e-3) or more with column.scheme "
            "'mushy': fresh water makes no mush"
        )
    ponds, light = "ponds" in scene.effects, scene.column.light
    for name in unread_keys(scene.physics, scene.column.scheme, light, ponds):
        log.warning("physics.%s is given, but this scheme, light and effects do not read it", name)
    if "redistribution" in scene.effects and scene.column.categories < 2:
        raise FloeError("effect 'redistribution' needs column.categories of 2 or more")
    _check_generator(scene)
    if "periodic" in scene.effects:
        _check_periodic(scene)
    if scene.packing.coast_bonds and not {"bonds", "coast"} <= set(scene.effects):
        raise FloeError("packing.coast_bonds needs the effects 'bonds' and 'coast'")


def _check_generator(scene: Scene) -> None:
    generator, labels = scene.packing.generator, scene.mask.labels
    if generator == "floes" and not labels.file:
        raise FloeError("packing.generator is 'floes' but mask.labels.file names no image of floes")
    if scene.mask.uniform > 0.0 and (generator == "floes" or scene.mask.land == "mask"):
        raise FloeError(
            "mask.uniform is ice without a file: it goes with neither packing.generator 'floes' "
            "nor mask.land 'mask'"
        )
    if generator == "floes" and scene.mask.land == "mask":
        raise FloeError("mask.land is 'mask', but a labelled image of floes shows no land")
    if generator != "floes" and labels != type(labels)():
        raise FloeError(
            f"mask.labels is given but packing.generator is '{generator}', which reads no labels"
        )
    discs = scene.packing.discs
    if generator != "dense" and discs != type(discs)():
        raise FloeError("packing.discs is read by packing.generator 'dense' alone")
    if generator != "tessellation":
        size = scene.packing.size
        if size != type(size)():
            raise FloeError("packing.size is read by packing.generator 'tessellation' alone")
        if "remap" in scene.effects:
            raise FloeError(
                "effect 'remap' makes cells that fill the sea anew; with packing.generator "
                f"'{generator}' the floes would be lost"
            )


SIDES_ACROSS = {"x": ("left", "right"), "y": ("bottom", "top")}


def _check_periodic(scene: Scene) -> None:
    axes, walls = scene.periodic.axes, scene.walls
    if len(set(axes)) < len(axes):
        raise FloeError("periodic.axes names an axis twice")
    if scene.packing.generator != "dense":
        raise FloeError(
            "effect 'periodic' needs packing.generator 'dense': the cells of a "
            f"'{scene.packing.generator}' end at the sides of the rectangle"
        )
    if scene.mask.land != "none" or scene.mask.shoreline:
        raise FloeError(
            "effect 'periodic' needs mask.land 'none' and no mask.shoreline: a coast does not "
            "repeat itself"
        )
    if "walls" not in scene.effects:
        return
    for axis, (number, across) in zip("xy", enumerate(SIDES_ACROSS.values()), strict=True):
        if axis not in axes:
            continue
        for side in set(across) & set(walls.rim):
            raise FloeError(
                f"walls.rim names '{side}', beyond which the ice repeats itself (periodic.axes)"
            )
        if walls.mesh or any(plane[2 + number] != 0.0 for plane in walls.planes):
            raise FloeError(
                f"periodic.axes names {axis}: walls.planes must run along it (normal_{axis} 0), "
                "and walls.mesh cannot be used"
            )


def _check_step(scene: Scene) -> None:
    share = scene.dynamics.step_share
    if share > 1 and not scene.dynamics.allow_unstable_step:
        raise FloeError(
            f"dynamics.step_share ({share:g}) is above 1: the ice may blow up at such a time step; "
            "dynamics.allow_unstable_step: true allows it"
        )


def _check_domain(scene: Scene) -> None:
    domain = scene.domain
    for axis in ("x", "y"):
        low, high = getattr(domain, f"{axis}_min"), getattr(domain, f"{axis}_max")
        if low >= high:
            raise FloeError(f"domain.{axis}_min ({low:g} m) must lie below {axis}_max ({high:g} m)")
        cells = (high - low) / domain.spacing
        if abs(cells - round(cells)) > 1e-9 * cells or round(cells) < 2:
            raise FloeError(
                f"domain.spacing ({domain.spacing:g} m) must divide the scene's width in {axis} "
                f"({high - low:g} m) into two cells or more"
            )
    cells = _cells(scene) * scene.mask.refine**2
    if cells > MAX_CELLS:
        raise FloeError(
            f"domain.spacing and mask.refine ask for {cells:.3g} mask cells; at most "
            f"{MAX_CELLS:g} are allowed"
        )


def _cells(scene: Scene) -> float:
    """Number of cells of the scene's grid."""
    domain = scene.domain
    return (domain.x_max - domain.x_min) * (domain.y_max - domain.y_min) / domain.spacing**2


def _check_times(scene: Scene) -> None:
    if scene.time.start.tzinfo is not None:
        raise FloeError("time.start: give UTC without a time zone")
    # Refuses what would be too many jobs.
    window_chunks(scene.time.windows, scene.workflow.windows_per_job)
    window = scene.time.window
    try:
        scene.time.start + timedelta(seconds=scene.time.windows * window)
    except OverflowError:
        raise FloeError(
            f"time: {scene.time.windows} windows of {window:g} s from {scene.time.start} on end "
            "after the year 9999, the last that is known"
        ) from None
    if scene.forcing.source != "file":
        steps = window / scene.forcing.step
        if not math.isclose(steps, round(steps), rel_tol=1e-12) or round(steps) < 1:
            raise FloeError(
                f"forcing.step ({scene.forcing.step:g} s) must divide time.window ({window:g} s)"
            )
        if steps * _cells(scene) > MAX_FORCING:
            raise FloeError(
                f"forcing.step ({scene.forcing.step:g} s) and domain.spacing ask for "
                f"{steps * _cells(scene):.3g} numbers of each quantity in a window; at most "
                f"{MAX_FORCING:g} are allowed"
            )


# Below this an angle in degrees is likely one in radians (rad and degree).
RADIANS = 1.6


def scene_warnings(scene: Scene) -> list[str]:
    """What a scene may say, but hardly means: a sentence each, with the unit.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    list of str
        Empty for most scenes.
    """
    found = []
    for name in ("friction_angle", "turning_angle"):
        value = getattr(scene.dynamics, name)
        if name in scene.dynamics.model_fields_set and 0.0 < abs(value) < RADIANS:
            found.append(f"dynamics.{name} is {value:g} degrees; was it meant in radians?")
    return found
