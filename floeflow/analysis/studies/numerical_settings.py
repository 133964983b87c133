# SPDX-License-Identifier: GPL-2.0-or-later
"""Numerical settings that trade accuracy for time: values from fine to coarse, expected orders.

A level is a factor by which a setting is coarser (above 1) or finer (below 1) than in the scene, so
that the error goes as level ** order.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from floeflow.scene import Scene

Changes = dict[str, Any]
MANY_WINDOWS = 8
# From fine to coarse.
SCHEMES = ("mushy", "bl99", "zero_layer")
PRECISIONS = ("double", "single")
TRANSFERS = ("conservative", "mls", "shepard", "nearest")
MOST_CATEGORIES = 10


@dataclass(frozen=True)
class Setting:
    """One setting of a study.

    Parameters
    ----------
    name : str
        Short name, also of its runs.
    text : str
        What is varied, for people.
    order : float or None
        Order of convergence that theory expects; None where none is known.
    levels : tuple of float
        From fine to coarse; 1 is the scene itself.
    changes : callable
        Level to changed keys.
    ways : mapping
        Names of the levels, where they are ways to do a thing and no factors.
    """

    name: str
    text: str
    order: float | None
    levels: tuple[float, ...]
    changes: Callable[[float], Changes]
    ways: Mapping[float, str] = field(default_factory=dict)

    def told(self, level: float) -> str:
        """A level in words.

        Parameters
        ----------
        level : float
            Factor by which it is coarser (above 1) or finer than in the scene.
        """
        return self.ways.get(level, f"x {level:.3g}")


def numerical_settings(scene: Scene) -> list[Setting]:
    """Settings that act in a scene.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    found = [_step(scene), _stiffness(scene), _elements(scene), _window(scene), _spacing(scene)]
    found += [_precision(scene), _transfer(scene)]
    if "thermodynamics" in scene.effects:
        found += [_column_step(scene), _splitting(scene), _scheme(scene), _categories(scene)]
        # Zero-layer ice has none.
        if scene.column.scheme != SCHEMES[-1]:
            found.append(_layers(scene))
    if "remap" in scene.effects:
        found += [_remap(scene), _remap_order(scene)]
    return found


def _ways(name: str, text: str, key: str, ways: tuple[Any, ...], own: Any) -> Setting:
    """Ways to do one thing, the most accurate first; factors of two are only their places."""
    levels = tuple(2.0 ** (place - ways.index(own)) for place in range(len(ways)))
    changes = {level: {key: way} for level, way in zip(levels, ways, strict=True)}
    told = {level: str(way) for level, way in zip(levels, ways, strict=True)}
    return Setting(name, text, None, levels, changes.__getitem__, told)


def _precision(scene: Scene) -> Setting:
    """Precision of what a window hands to the next."""
    text, own = "precision of the state between windows", scene.state.precision
    return _ways("state_precision", text, "state.precision", PRECISIONS, own)


def _transfer(scene: Scene) -> Setting:
    """Way to the grid: seen by the norms on the grid alone, after the run."""
    text, own = "transfer to the grid", scene.grid.transfer
    return _ways("grid_transfer", text, "grid.transfer", TRANSFERS, own)


def _remap_order(scene: Scene) -> Setting:
    """Linear slopes in the elements, or donor cells."""
    return _ways("remap_order", "order of the remap", "remap.order", (2, 1), scene.remap.order)


def _remap(scene: Scene) -> Setting:
    """How often elements are replaced by fresh ones."""
    every = max(1, scene.remap.every)

    def changes(level: float) -> Changes:
        return {"remap.every": round(every * level)}

    fine = [1.0 / n for n in (4, 2) if every % n == 0]
    coarse = [float(n) for n in (2, 4) if n * every <= scene.time.windows]
    text = "windows between remaps"
    return Setting("remap_interval", text, None, (*fine, 1.0, *coarse), changes)


def _step(scene: Scene) -> Setting:
    share = scene.dynamics.step_share

    def changes(level: float) -> Changes:
        return {"dynamics.step_share": share * level}

    text = "time step, share of the critical one"
    coarse = [1.0 / share] if share < 1.0 else []
    return Setting("step_share", text, 1.0, (0.125, 0.25, 0.5, 1.0, *coarse), changes)


def _stiffness(scene: Scene) -> Setting:
    d = scene.dynamics

    def changes(level: float) -> Changes:
        return {
            "dynamics.young_modulus": d.young_modulus / level,
            "dynamics.contact_modulus": d.contact_modulus / level,
        }

    return Setting(
        "softness", "stiffness of bonds and contacts", 1.0, (0.25, 1, 4, 16, 64), changes
    )


def _elements(scene: Scene) -> Setting:
    count = scene.packing.elements

    def changes(level: float) -> Changes:
        return {"packing.elements": max(8, round(count / level**2))}

    levels = (0.5, math.sqrt(0.5), 1.0, math.sqrt(2.0), 2.0)
    return Setting("element_size", "size of the elements", 1.0, levels, changes)


def _window(scene: Scene) -> Setting:
    t, samples = scene.time, scene.dynamics.samples

    def changes(level: float) -> Changes:
        length = t.window * level
        return {
            "time.window": length,
            "time.windows": round(t.windows / level),
            "forcing.step": min(scene.forcing.step, length),
            "dynamics.samples": max(1, round(samples * level)),
        }

    # Many short windows are many files of forcing.
    fine = (0.25, 0.5) if t.windows <= MANY_WINDOWS else (0.5,)
    coarse = [float(n) for n in range(2, t.windows + 1) if t.windows % n == 0][:3]
    return Setting("window", "coupling window", 1.0, (*fine, 1.0, *coarse), changes)


def _spacing(scene: Scene) -> Setting:
    domain, refine = scene.domain, scene.mask.refine

    def changes(level: float) -> Changes:
        # The mask grid, and with it the ice, stays as it is.
        return {"domain.spacing": domain.spacing * level, "mask.refine": round(refine * level)}

    fine = [1.0 / n for n in (4, 2) if refine % n == 0]
    widths = (domain.x_max - domain.x_min, domain.y_max - domain.y_min)
    coarse = [float(n) for n in (2, 4) if all((w / domain.spacing / n) % 1 == 0 for w in widths)]
    levels = (*fine, 1.0, *coarse)
    return Setting("forcing_grid", "cells of the forcing's grid", 2.0, levels, changes)


def _splitting(scene: Scene) -> Setting:
    """Column around the dynamics stands for half a level: it costs nearly nothing."""
    text, own = "column after or around the dynamics", scene.column.splitting
    return _ways("splitting", text, "column.splitting", ("around", "after"), own)


def _scheme(scene: Scene) -> Setting:
    """Schemes stand in the order of what they tell of."""
    text, own = "scheme of the column", scene.column.scheme
    return _ways("column_scheme", text, "column.scheme", SCHEMES, own)


def _layers(scene: Scene) -> Setting:
    layers = scene.column.layers

    def changes(level: float) -> Changes:
        return {"column.layers": max(2, round(layers / level))}

    text = "thickness of the column's layers"
    return Setting("layer_thickness", text, 2.0, (0.25, 0.5, 1.0, 2.0), changes)


def _categories(scene: Scene) -> Setting:
    """Width of the categories; with redistribution there are two at least."""
    count = scene.column.categories

    def changes(level: float) -> Changes:
        return {"column.categories": round(count / level)}

    fine = [1.0 / n for n in (9, 5, 3, 2) if n * count <= MOST_CATEGORIES]
    return Setting("category_width", "width of the categories", 1.0, (*fine, 1.0), changes)


def _column_step(scene: Scene) -> Setting:
    step = min(scene.column.step, scene.time.window)

    def changes(level: float) -> Changes:
        return {"column.step": step * level}

    most = scene.time.window / step
    coarse = [float(n) for n in (2, 4, 8) if n <= most]
    return Setting(
        "column_step", "time step of the column", 1.0, (0.25, 0.5, 1.0, *coarse), changes
    )
