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
from floeflow.core.errors import FloeError
from floeflow.core.period import Period, shortest, sides
from floeflow.dynamics.engine.energy_check import check_energy
from floeflow.dynamics.engine.engine import Engine, EngineParams, Forcing
from floeflow.dynamics.engine.setup import within_reach
from floeflow.dynamics.forces import ENGINE_SWITCHES, scene_forces
from floeflow.dynamics.ridging.filled_discs import fill_areas
from floeflow.dynamics.ridging.overlaps import rest_overlaps
from floeflow.dynamics.ridging.ridging import close_areas
from floeflow.dynamics.step.critical import critical_step
from floeflow.scene import Scene
from floeflow.scene.effects import ledger_sums, plugin_switches
from floeflow.state.elements import (
    Arrays,
    carry_drift,
    element_arrays,
    moved_state,
    pair_arrays,
)
from floeflow.state.schema import MOBILE

Report = Callable[..., None]

# Stands in for the step while the step itself is sought.
_ANY_STEP = 1.0


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
    """Parameters of the engine for a scene: SI units, angles in radians.

    Parameters
    ----------
    scene : Scene
        Its effects and dynamics.
    time_step : float, optional
        s.

    Returns
    -------
    EngineParams
        SI units, angles in radians.
    """
    d = scene.dynamics
    switches = {name: True for name in plugin_switches(scene.effects) if name in ENGINE_SWITCHES}
    turned = switches.pop("turning_angle", False)
    return EngineParams(
        time_step=time_step,
        **{"friction": False, **switches},
        period=scene.period,
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
        lead_softening=d.lead_softening,
        wind_stress_factor=AIR_DENSITY * d.air_drag,
        ocean_stress_factor=SEAWATER_DENSITY * d.ocean_drag,
        turning_angle=math.radians(d.turning_angle) if turned else 0.0,
        forces=scene_forces(scene),
        relative_wind=d.relative_wind,
        # The lines of the coast hold the ice; its elements only bond.
        fixed_contacts="coast" not in scene.effects or scene.packing.coast_bonds,
        walls=bool({"walls", "coast"} & set(scene.effects)),
        deterministic=d.deterministic,
        exact_losses=d.exact_losses,
    )


def choose_step(
    scene: Scene, elements: Arrays, bonds: Arrays | None, way: float = math.inf
) -> tuple[float, int, str]:
    """Time step, number of steps between two samples, and what limits the step.

    The step is the scene's share of the critical one, shortened so that a whole number of equal
    steps lies between two samples of the series.

    Parameters
    ----------
    scene : Scene
        The scene.
    elements, bonds : dict of ndarray
        As `Engine.load` takes them.
    way : float
        By how much elements may come nearer to each other in the window, m (`nearing`).

    Returns
    -------
    time_step : float
        s.
    steps : int
        Between two samples, 1 or more.
    limited_by : str
        In words, for the report.
    """
    critical, limited_by = critical_step(elements, bonds, engine_params(scene), way)
    between = scene.time.window / scene.dynamics.samples
    steps = max(1, math.ceil(between / (scene.dynamics.step_share * critical)))
    return between / steps, steps, limited_by


def nearing(scene: Scene, elements: Arrays, forcing: xr.Dataset) -> float:
    """By how much two elements may come nearer to each other in a window, m.

    Ice that nothing hinders drifts with the water and a share of the wind, the root of the drags'
    ratio; contacts only slow it. Without a drag that bounds its speed: infinite.

    Parameters
    ----------
    scene : Scene
        Its effects and dynamics.
    elements : Arrays
        Table of n elements, sorted by id.
    forcing : xarray.Dataset
        Of the window.

    Returns
    -------
    float
        m.
    """
    params = engine_params(scene)
    if not params.ocean_drag or params.ocean_stress_factor == 0.0:
        return math.inf
    speeds = {
        kind: float(np.hypot(forcing[f"{kind}_u"].values, forcing[f"{kind}_v"].values).max())
        for kind, there in (("ocean", True), ("wind", params.wind))
        if there
    }
    ratio = math.sqrt(params.wind_stress_factor / params.ocean_stress_factor)
    drift = speeds["ocean"] + ratio * speeds.get("wind", 0.0)
    now = float(np.hypot(elements["u"], elements["v"]).max(initial=0.0))
    return 2.0 * max(drift, now) * scene.time.window


def wall_faces(state: xr.Dataset) -> Arrays | None:
    """Faces of a state's walls and coast; None where it has none.

    Parameters
    ----------
    state : xarray.Dataset
        The state.

    Returns
    -------
    dict of ndarray or None
        Columns of the table by name, (faces,) each.
    """
    if "wall_face_ax" not in state or state.sizes["wall_face"] == 0:
        return None
    return pair_arrays(state, "wall_face")


def without_fixed(elements: Arrays, contacts: Arrays) -> Arrays:
    """Contacts among mobile elements only.

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.
    contacts : Arrays
        Contact table of k contacts.

    Returns
    -------
    Arrays
        A new table.
    """
    fixed = elements["id"][elements["type"] != MOBILE]
    both = ~(np.isin(contacts["id_lo"], fixed) | np.isin(contacts["id_hi"], fixed))
    return {name: values[both] for name, values in contacts.items()}


def engine_forcing(scene: Scene, forcing: xr.Dataset, needed: tuple[str, ...]) -> Forcing:
    """Fields that the engine's switches need, from a window's forcing.

    Parameters
    ----------
    scene : Scene
        How fields are read: at points or over discs, wind or its stress.
    forcing : xarray.Dataset
        Of the window.
    needed : tuple of str
        Names of the fields.

    Returns
    -------
    Forcing
        Fields on (time, y, x).
    """
    fields = {name: forcing[name].values for name in needed}
    return Forcing(
        *(forcing["time"].values, forcing["x"].values, forcing["y"].values, fields),
        over_discs=scene.forcing.at == "cell",
        wind_stress=scene.forcing.wind_mean == "stress",
    )


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
    if "ridging" in scene.effects:
        state = fill_areas(state, float(state.attrs["time"]))
    elements = element_arrays(state, scene.dynamics.minimum_thickness)
    if not (elements["type"] == MOBILE).any():
        return _still(scene, state)
    bonds = pair_arrays(state, "bond") if "bonds" in scene.effects else None
    if bonds is not None:
        bonds = within_reach(elements, bonds, engine_params(scene))
    # On one rank: eigenvalues from unlike processors may differ in their last bit.
    way = nearing(scene, elements, forcing)
    step, between, limited_by = on_root(comm, choose_step, scene, elements, bonds, way)
    params = engine_params(scene, step)
    motion = Motion(state, between * scene.dynamics.samples, step, limited_by)
    log.parent.mkdir(parents=True, exist_ok=True)
    held = pair_arrays(state, "wall_contact") if "wall_contact_id" in state else None
    faces = wall_faces(state)
    walled = "walls" in scene.effects
    with Engine(comm, params, log, faces) as engine:
        contacts = rest_overlaps(elements, bonds, pair_arrays(state, "contact"), params.period)
        if not params.fixed_contacts:
            contacts = without_fixed(elements, contacts)
        start = float(state.attrs["time"])
        engine.load(elements, bonds, contacts, start, held)
        if params.external:
            engine.set_forcing(engine_forcing(scene, forcing, params.external))
        first = engine.diagnostics()
        here, drift = engine.elements(), np.zeros((2, len(elements["id"])))
        _sample(motion, scene, here, first, 0.0)
        if walled:
            _sample_walls(motion, scene, engine, 0.0)
        motion.setup_seconds = time.perf_counter() - began
        began, used = time.perf_counter(), time.process_time()
        for k in range(1, scene.dynamics.samples + 1):
            engine.run(between)
            sums = engine.diagnostics()
            here, last = engine.elements(), here
            if params.period is not None:
                drift += steps_between(last, here, between * step, params.period)
            check_energy(first, sums, here, k * between)
            _sample(motion, scene, here, sums, k * between * step)
            if walled:
                _sample_walls(motion, scene, engine, between * step)
            seconds = time.perf_counter() - began
            n = len(elements["id"])
            report(step=k * between, steps=motion.steps, elements=n, dynamics_seconds=seconds)
        motion.seconds = time.perf_counter() - began
        motion.cpu_seconds = comm.allreduce(time.process_time() - used)
        by_wall = engine.wall_forces()[0] if faces is not None else np.zeros((0, 2))
        motion.budget = _budget(scene, first, sums, by_wall)
        left = engine.bonds() if bonds is not None else None
        moved = engine.elements()
        walls = engine.wall_contacts() if faces is not None else held
        inside = engine.internal_forces() if "internal_stress" in scene.effects else {}
        after = moved_state(state, moved, left, engine.contacts(), walls)
        gone = None if params.period is None else (drift[0], drift[1])
        motion.state = carry_drift(state, after, gone)
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
        tables = {"contact": contacts} | ({"wall_contact": held} if held is not None else {})
        leads = "redistribution" not in scene.effects
        motion.state = close_areas(motion.state, ridged, least, tables, end, leads)
        motion.budget["ridged_area"] = float(ridged.sum())
    if inside:
        motion.state = with_stress(motion.state, inside)
    return motion


def steps_between(last: Arrays, now: Arrays, seconds: float, period: Period) -> np.ndarray:
    """How far elements of a repeated rectangle went between two samples (m), (2, n).

    Parameters
    ----------
    last : Arrays
        Elements of both samples, in one order, (n,).
    now : Arrays
        Elements of both samples, in one order, (n,).
    seconds : float
        Between the samples (s).
    period : Period
        Along which axes the rectangle repeats itself.

    Returns
    -------
    ndarray
        Along x and y (m), the shorter way around a periodic axis, (2, n).

    Raises
    ------
    FloeError
        Where one may have gone half around the rectangle: which way, its places do not tell.
    """
    for axis, speed, side in zip("xy", "uv", sides(period), strict=True):
        fastest = float(max(np.abs(each[speed]).max() for each in (last, now)))
        if fastest * seconds >= 0.5 * side:
            raise FloeError(
                f"dynamics.samples: ice of {fastest:.3g} m/s goes half around the rectangle in "
                f"{axis} ({side:g} m, effect periodic) between two samples: ask for more samples"
            )
    moved = now["x"] - last["x"], now["y"] - last["y"]
    return np.stack(shortest(moved, period))


def with_stress(state: xr.Dataset, inside: Arrays) -> xr.Dataset:
    """State with the stress in its elements and the force that it makes.

    The stress in an element is the sum of arms times forces over its effective area, as for a body
    in balance (Love 1927).

    Parameters
    ----------
    state : xarray.Dataset
        After the motion.
    inside : dict of ndarray
        From `Engine.internal_forces`, (n,).

    Returns
    -------
    xarray.Dataset
        With internal_force_x and internal_force_y (N) and stress_xx, stress_yy and stress_xy (N/m),
        over the elements; 0 for elements without area.
    """
    area = state["area"].values
    found = {f"internal_force_{axis}": inside[f"force_{axis}"] for axis in "xy"}
    found |= {f"stress_{pair}": inside[f"moment_{pair}"] for pair in ("xx", "yy", "xy")}
    # The coast's elements stand for no area.
    return state.assign(
        {
            name: ("element", np.divide(amount, area, out=np.zeros_like(area), where=area > 0.0))
            for name, amount in found.items()
        }
    )


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
    # The coast, where there is one, is the last.
    for name, each in zip(scene.walls.names, force, strict=False):
        for axis, value in zip("xy", each, strict=True):
            motion.samples.setdefault(f"wall_force_{name}_{axis}", []).append(-float(value))


def _budget(
    scene: Scene, first: dict[str, float], last: dict[str, float], by_wall: np.ndarray
) -> dict[str, float]:
    """Momentum, impulses, works and dissipations of a window, by the series' names.

    ``by_wall`` are the impulses of the walls on the ice (N s), (walls, 2), the coast's the last.
    """
    named = len(scene.walls.names) if "walls" in scene.effects else 0
    coast = by_wall[named:].sum(axis=0)
    budget = {}
    for axis, by_coast in zip("xy", coast, strict=True):
        budget[f"momentum_{axis}_start"] = first[f"momentum_{axis}"]
        budget[f"momentum_{axis}_end"] = last[f"momentum_{axis}"]
        if "coast" in scene.effects:
            budget[f"impulse_coast_{axis}"] = float(by_coast) - last[f"impulse_fixed_{axis}"]
        if "walls" in scene.effects:
            budget[f"impulse_wall_{axis}"] = last[f"impulse_wall_{axis}"] - float(by_coast)
    if "walls" in scene.effects:
        budget["work_wall"] = last["work_wall"]
    # Contacts damp whatever the effects are.
    for name in ("dissipation_contact", *ledger_sums(scene.effects)):
        budget[name] = last[name]
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
    budget = _budget(scene, nothing, nothing, np.zeros((0, 2)))
    if "ridging" in scene.effects:
        budget["ridged_area"] = 0.0
    return Motion(state, samples=samples, budget=budget)
