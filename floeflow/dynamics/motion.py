# SPDX-License-Identifier: GPL-2.0-or-later
"""The dynamics of one window: from the state through LIGGGHTS to the moved state."""

from __future__ import annotations

import math
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import xarray as xr
from mpi4py import MPI

from floeflow.core.collective import on_root
from floeflow.core.constants import AIR_DENSITY, SEAWATER_DENSITY
from floeflow.dynamics.engine.energy_check import check_energy
from floeflow.dynamics.engine.engine import Engine, EngineParams, Forcing
from floeflow.dynamics.ridging.overlaps import rest_overlaps
from floeflow.dynamics.ridging.ridging import close_areas
from floeflow.dynamics.step.critical import critical_step
from floeflow.scene import Scene
from floeflow.scene.effects import plugin_switches
from floeflow.state.elements import Arrays, element_arrays, moved_state, pair_arrays
from floeflow.state.schema import MOBILE

Report = Callable[..., None]

# Stands in for the step while the step itself is sought.
_ANY_STEP = 1.0
_IMPULSES = ("wind", "ocean", "coriolis", "tilt")
_LOSSES = ("bond", "contact", "friction", "fracture", "ridging")


@dataclass
class Motion:
    """What the dynamics of a window leave."""

    state: xr.Dataset
    steps: int = 0
    time_step: float = 0.0
    limited_by: str = ""
    setup_seconds: float = 0.0
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    samples: dict[str, list[float]] = field(default_factory=dict)
    budget: dict[str, float] = field(default_factory=dict)
    # Given by each wall until the last sample, N s, (walls, 2).
    wall_impulse: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    # Given by wind and ocean to each mobile element, N s.
    impulses: Arrays = field(default_factory=dict)


def engine_params(scene: Scene, time_step: float = _ANY_STEP) -> EngineParams:
    """Parameters of the engine for a scene: SI units, angles in radians."""
    d = scene.dynamics
    switches: dict[str, bool] = dict.fromkeys(plugin_switches(scene.effects), True)
    turned = switches.pop("turning_angle", False)
    return EngineParams(
        time_step=time_step,
        **{"friction": False, **switches},
        period=None,
        young_modulus=d.young_modulus,
        poisson_ratio=d.poisson_ratio,
        bond_damping=d.bond_damping,
        strength=d.strength,
        compressive_strength=d.compressive_strength,
        tensile_share=d.tensile_share,
        friction_angle=math.radians(d.friction_angle),
        contact_modulus=d.contact_modulus,
        contact_damping=d.contact_damping,
        friction_coefficient=d.friction_coefficient,
        ridge_force=d.ridge_force,
        ridge_hardening=d.ridge_hardening,
        ridge_thickness=d.ridge_thickness,
        wind_stress_factor=AIR_DENSITY * d.air_drag,
        ocean_stress_factor=SEAWATER_DENSITY * d.ocean_drag,
        turning_angle=math.radians(d.turning_angle) if turned else 0.0,
        relative_wind=d.relative_wind,
        deterministic=d.deterministic,
        exact_losses=d.exact_losses,
    )


def choose_step(scene: Scene, elements: Arrays, bonds: Arrays | None) -> tuple[float, int, str]:
    """Time step, number of steps between two samples, and what limits the step.

    The step is the scene's share of the critical one, shortened so that a whole number of equal
    steps lies between two samples of the series.
    """
    critical, limited_by = critical_step(elements, bonds, engine_params(scene))
    between = scene.time.window / scene.dynamics.samples
    steps = max(1, math.ceil(between / (scene.dynamics.step_share * critical)))
    return between / steps, steps, limited_by


def engine_forcing(forcing: xr.Dataset, needed: tuple[str, ...]) -> Forcing:
    """Fields that the engine's switches need, from a window's forcing."""
    fields = {name: forcing[name].values for name in needed}
    return Forcing(forcing["time"].values, forcing["x"].values, forcing["y"].values, fields)


def move(
    comm: MPI.Comm, scene: Scene, state: xr.Dataset, forcing: xr.Dataset, log: Path, report: Report
) -> Motion:
    """Move a state's elements for one window.

    Parameters
    ----------
    comm : MPI.Comm
        Collective; every rank has the whole state and gets the whole result.
    scene : Scene
        The scene.
    state, forcing : xarray.Dataset
        State at the window's start, and the window's forcing.
    log : Path
        LIGGGHTS' log.
    report : callable
        Gets step, steps and elements at each sample.

    Returns
    -------
    Motion
        Moved state, samples, impulses and what the motion cost.

    Raises
    ------
    FloeError
        Where LIGGGHTS, an element or the forcing fails; names the place.
    """
    began = time.perf_counter()
    elements = element_arrays(state, scene.dynamics.minimum_thickness)
    if not (elements["type"] == MOBILE).any():
        return _still(scene, state)
    bonds = pair_arrays(state, "bond") if "bonds" in scene.effects else None
    # On one rank: eigenvalues from unlike processors may differ in their last bit.
    step, between, limited_by = on_root(comm, choose_step, scene, elements, bonds)
    params = engine_params(scene, step)
    motion = Motion(state, between * scene.dynamics.samples, step, limited_by)
    log.parent.mkdir(parents=True, exist_ok=True)
    walled = "walls" in scene.effects
    faces, held = (
        pair_arrays(state, f"wall_{kind}") if walled else None for kind in ("face", "contact")
    )
    with Engine(comm, params, log, faces) as engine:
        contacts = rest_overlaps(elements, bonds, pair_arrays(state, "contact"))
        start = float(state.attrs["time"])
        engine.load(elements, bonds, contacts, start, held)
        if params.external:
            engine.set_forcing(engine_forcing(forcing, params.external))
        first = engine.diagnostics()
        _sample(motion, scene, engine.elements(), first, 0.0)
        if walled:
            _sample_walls(motion, scene, engine, 0.0)
        motion.setup_seconds = time.perf_counter() - began
        began, used = time.perf_counter(), time.process_time()
        for k in range(1, scene.dynamics.samples + 1):
            engine.run(between)
            sums = engine.diagnostics()
            here = engine.elements()
            check_energy(first, sums, here, k * between)
            _sample(motion, scene, here, sums, k * between * step)
            if walled:
                _sample_walls(motion, scene, engine, between * step)
            seconds = time.perf_counter() - began
            n = len(elements["id"])
            report(step=k * between, steps=motion.steps, elements=n, dynamics_seconds=seconds)
        motion.seconds = time.perf_counter() - began
        motion.cpu_seconds = comm.allreduce(time.process_time() - used)
        motion.budget = _budget(scene, first, sums)
        left = engine.bonds() if bonds is not None else None
        moved = engine.elements()
        walls = engine.wall_contacts() if walled else None
        motion.state = moved_state(state, moved, left, engine.contacts(), walls)
    mobile = moved["type"] == MOBILE
    switched = {"wind": params.wind, "ocean": params.ocean_drag}
    motion.impulses = {
        f"{name}_impulse_{axis}": moved[f"{name}_impulse_{axis}"][mobile]
        for name, is_on in switched.items()
        if is_on
        for axis in "xy"
    }
    if params.ridging:
        ridged = moved["ridged_area"]
        least, end = scene.dynamics.minimum_thickness, start + scene.time.window
        motion.state = close_areas(motion.state, ridged, least, end)
        motion.budget["ridged_area"] = float(ridged.sum())
    return motion


def _sample(
    motion: Motion, scene: Scene, elements: Arrays, sums: dict[str, float], at: float
) -> None:
    mobile = elements["type"] == MOBILE
    speed = np.hypot(elements["u"], elements["v"])[mobile]
    # Of ice that there is: where none is left, elements have a drag all the same.
    state = motion.state
    weight = (state["area"].values * state["ice_fraction"].values.sum(axis=1))[mobile]
    drift = float(weight @ speed / weight.sum()) if weight.sum() > 0 else float(speed.mean())
    values = {
        "time": at,
        "kinetic_energy": sums["kinetic"] + sums["rotational"],
        "elastic_energy": sums["elastic_bond"] + sums["elastic_contact"] + sums["elastic_wall"],
        "drift_speed": drift,
        "largest_speed": float(speed.max()),
    }
    if "bonds" in scene.effects:
        values["intact_bonds"] = sums["bonds"]
    for name, value in values.items():
        motion.samples.setdefault(name, []).append(value)


def _sample_walls(motion: Motion, scene: Scene, engine: Engine, seconds: float) -> None:
    """Force of the ice on each wall: its mean since the sample before; now, at the first."""
    impulse, now = engine.wall_forces()
    force = (impulse - motion.wall_impulse) / seconds if seconds else now
    motion.wall_impulse = impulse
    for name, each in zip(scene.walls.names, force, strict=True):
        for axis, value in zip("xy", each, strict=True):
            motion.samples.setdefault(f"wall_force_{name}_{axis}", []).append(-float(value))


def _budget(scene: Scene, first: dict[str, float], last: dict[str, float]) -> dict[str, float]:
    """Momentum, impulses, works and dissipations of a window, by the series' names."""
    on = engine_params(scene)
    switched = dict(zip(_IMPULSES, (on.wind, on.ocean_drag, on.coriolis, on.tilt), strict=True))
    kept = [name for name, is_on in switched.items() if is_on]
    budget = {}
    for axis in "xy":
        budget[f"momentum_{axis}_start"] = first[f"momentum_{axis}"]
        budget[f"momentum_{axis}_end"] = last[f"momentum_{axis}"]
        if "coast" in scene.effects:
            budget[f"impulse_coast_{axis}"] = -last[f"impulse_fixed_{axis}"]
        if "walls" in scene.effects:
            budget[f"impulse_wall_{axis}"] = last[f"impulse_wall_{axis}"]
        for name in kept:
            budget[f"impulse_{name}_{axis}"] = last[f"impulse_{name}_{axis}"]
    for name in kept:
        budget[f"work_{name}"] = last[f"work_{name}"]
    if "walls" in scene.effects:
        budget["work_wall"] = last["work_wall"]
    lossy = {"bond": on.bonds, "fracture": on.bonds, "friction": on.friction, "contact": True}
    lossy["ridging"] = on.ridging
    for name in _LOSSES:
        if lossy[name]:
            budget[f"dissipation_{name}"] = last[f"dissipation_{name}"]
    return budget


def _still(scene: Scene, state: xr.Dataset) -> Motion:
    """Motion of a scene without mobile elements: none."""
    names = ["kinetic_energy", "elastic_energy", "drift_speed", "largest_speed"]
    if "bonds" in scene.effects:
        names.append("intact_bonds")
    if "walls" in scene.effects:
        names += [f"wall_force_{name}_{axis}" for name in scene.walls.names for axis in "xy"]
    moments = np.linspace(0.0, scene.time.window, scene.dynamics.samples + 1)
    samples = {"time": moments.tolist()} | {name: [0.0] * len(moments) for name in names}
    nothing: dict[str, float] = defaultdict(float)
    budget = _budget(scene, nothing, nothing)
    if "ridging" in scene.effects:
        budget["ridged_area"] = 0.0
    return Motion(state, samples=samples, budget=budget)
