# SPDX-License-Identifier: GPL-2.0-or-later
"""The MPI program of a job: windows of dynamics and column, one after the other.

``mpirun -n N python -m floeflow.coupling.coupled_windows`` reads a ``Job`` from its standard
input and reports on standard output, a line of JSON an event: progress, or the sentence of a
fault. The states go to the scene's work folder; publishing them is left to the rule.
"""

from __future__ import annotations

import json
import logging
import os
import sys
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr
from mpi4py import MPI

from floeflow.core.collective import leave, on_root
from floeflow.core.errors import FloeError
from floeflow.core.lock import join_run
from floeflow.core.records import WINDOW_CPU, Record, write_records
from floeflow.coupling import growth, resume
from floeflow.coupling.ages import grow_older
from floeflow.coupling.columns import advance_columns, settle_open_ice, totals
from floeflow.coupling.crowding import close_crowded
from floeflow.coupling.fluxes import window_fluxes
from floeflow.coupling.gates import gate_fluxes, gate_lines
from floeflow.coupling.job import Job
from floeflow.coupling.refreezing import freeze_window
from floeflow.coupling.sea.birth import OpenIce
from floeflow.coupling.sea.ice import Returned, add_terms
from floeflow.coupling.sea.places import SeaPlaces, read_places
from floeflow.coupling.series import sea_change, series_dataset, volumes
from floeflow.coupling.window_end import end_at_sea
from floeflow.dynamics.bonds.stress_free_growth import keep_forces
from floeflow.dynamics.motion import Motion, move
from floeflow.dynamics.remesh.absorb import ashore
from floeflow.dynamics.remesh.remesh import remesh
from floeflow.forcings.window import window_forcing
from floeflow.scene import Scene
from floeflow.state import read_dataset, read_state, write_dataset, write_state
from floeflow.state.cells import Cells, read_cells
from floeflow.state.elements import pair_arrays, thin_bonds
from floeflow.state.snapshots import join_snapshots

Report = Callable[..., None]

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Advanced:
    """What a window leaves; ``grown`` where the scene makes gridded tendencies."""

    state: xr.Dataset
    series: xr.Dataset
    cost: list[Record]
    fluxes: xr.Dataset | None = None
    grown: dict[str, np.ndarray] | None = None


def advance_window(
    comm: MPI.Comm,
    scene: Scene,
    state: xr.Dataset,
    forcing: xr.Dataset,
    log: Path,
    report: Report,
    cells: Cells | None = None,
    places: SeaPlaces | None = None,
) -> Advanced:
    """Advance a state by one window: dynamics, then column, then remapping and merging.

    Parameters
    ----------
    comm : MPI.Comm
        Collective; every rank has the whole state.
    scene : Scene
        The scene.
    state, forcing : xarray.Dataset
        State at the window's start, and the window's forcing on the scene's grid.
    log : Path
        LIGGGHTS' log.
    report : callable
        Called with the step reached, the number of steps and elements.
    cells : Cells, optional
        Fresh cells of a scene that remaps.
    places : SeaPlaces, optional
        The sea of a scene with a mixed layer.

    Returns
    -------
    Advanced
        State at the window's end, its series and what it cost.

    Raises
    ------
    FloeError
        Where the dynamics or the column fail; names the place.
    """
    start = float(state.attrs["time"])
    end = start + scene.time.window
    budget, first = volumes(state, "start"), state
    touched, area = pair_arrays(state, "contact"), state["area"].values
    # Half of the column before the dynamics makes the splitting second order (Strang 1968).
    middle = 0.5 * (start + end) if scene.column.splitting == "around" else start
    before = Grown(state)
    if middle > start:
        before = grow(comm, scene, state, forcing, (start, middle), area, start, places)
        if before.found is not None and places is not None:
            settled, terms, back = settle_open_ice(scene, before.state, before.found, places, False)
            terms = add_terms(before.terms, terms)
            before = replace(before, state=settled, terms=terms, back=back)
    first_half = volumes(before.state, "dynamics")
    motion = move(comm, scene, before.state, forcing, log, report)
    state = motion.state
    if "gates" in scene.effects:
        budget |= gate_fluxes(before.state, state, gate_lines(scene))
    if "ridging" in scene.effects and places is not None:
        state, crowded = on_root(comm, close_crowded, scene, state, places)
        budget |= crowded
    # What the dynamics alone change, counted from the window's start.
    for name, volume in volumes(state, "dynamics").items():
        at_start = budget[name.replace("_dynamics", "_start")]
        budget[name] = volume - (first_half[name] - at_start) if middle > start else volume
    after = grow(comm, scene, state, forcing, (middle, end), area, end, places)
    state = after.state
    budget |= add_terms(before.terms, after.terms)
    if "ice_age" in scene.effects:
        new = (part.each.get("growth_new_ice", 0.0) for part in (before, after))
        state = grow_older(state, sum(new), scene.time.window)
    began, used = time.perf_counter(), time.process_time()
    if "refreeze" in scene.effects:
        state, formed = freeze_window(scene, state, touched, forcing, (start, end))
        budget["bonds_refrozen"] = formed
    seconds = time.perf_counter() - began + before.seconds + after.seconds
    cpu = comm.allreduce(time.process_time() - used) + before.cpu_seconds + after.cpu_seconds
    state.attrs = {
        **state.attrs,
        "time": end,
        "window": int(state.attrs["window"]) + 1,
    }
    costs = _costs(scene, comm.size, motion, (seconds, cpu))
    fluxes = None
    if scene.exchange.fluxes:
        began = time.perf_counter()
        open_water = [part.found for part in (before, after) if part.found is not None]
        sums = _sums(motion, before, after)
        fluxes = window_fluxes(scene, state, sums, (start, end), open_water)
        n, seconds = state.sizes["element"], time.perf_counter() - began
        costs.append(Record("fluxes", n, comm.size, [seconds]))
    began = time.perf_counter()
    grown = _grown(scene, before, after, places)
    state, terms, melted_back = on_root(comm, end_at_sea, scene, state, after.found, places)
    budget = add_terms(budget, terms)
    for melted in (before.back, melted_back):
        if grown is not None and melted is not None:
            grown = growth.without(grown, melted)
    if "mixed_layer" in scene.effects and places is not None:
        budget |= sea_change(scene, first, state, places)
        n, seconds = state.sizes["element"], time.perf_counter() - began
        costs.append(Record("sea", n, comm.size, [seconds]))
    if {"remap", "merge", "ridging"} & set(scene.effects):
        began = time.perf_counter()
        state, terms = on_root(comm, remesh, scene, state, cells)
        budget |= terms
        n, seconds = state.sizes["element"], time.perf_counter() - began
        costs.append(Record("remesh", n, comm.size, [seconds]))
    if "coast" in scene.effects:
        on_land = state["id"].values[ashore(scene, state)]
        budget["coast_ashore"] = float(len(on_land))
        if len(on_land):
            _LOG.warning("elements ashore: %s", ", ".join(str(i) for i in on_land[:20]))
    budget |= volumes(state, "end")
    series = series_dataset(motion, budget, start)
    return Advanced(state, series, costs, fluxes, grown)


def _sums(motion: Motion, before: Grown, after: Grown) -> dict[str, np.ndarray]:
    """What each mobile element gave or got in a window."""
    terms = {
        name: after.each[name] + (before.each[name] if name in before.each else 0.0)
        for name in after.each
    }
    return {**motion.impulses, **terms}


def _grown(
    scene: Scene, before: Grown, after: Grown, places: SeaPlaces | None
) -> dict[str, np.ndarray] | None:
    """What froze and melted where, for gridded tendencies."""
    if not growth.wanted(scene):
        return None
    open_water = [part.found for part in (before, after) if part.found is not None]
    return growth.growth_places(after.state, (before.each, after.each), open_water, places)


@dataclass(frozen=True)
class Grown:
    """A state after its columns were advanced, terms in all and of each element, and seconds.

    ``found`` is the ice that formed in open water, which has to be settled, ``back`` what of it
    has melted.
    """

    state: xr.Dataset
    terms: Mapping[str, float] = field(default_factory=dict)
    each: Mapping[str, np.ndarray] = field(default_factory=dict)
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    found: OpenIce | None = None
    back: Returned | None = None


def grow(
    comm: MPI.Comm,
    scene: Scene,
    state: xr.Dataset,
    forcing: xr.Dataset,
    span: tuple[float, float],
    area: np.ndarray,
    moved: float,
    places: SeaPlaces | None = None,
) -> Grown:
    """Advance the columns over a part of a window, if the scene has any, and what they join.

    Bonds get thinner where ice melts; contacts keep their force where it grows.

    Parameters
    ----------
    comm, scene, state, forcing
        As for `advance_window`.
    span : tuple of float
        Start and end, s since the scene's start.
    area : ndarray
        Effective areas before the dynamics (m2): what closed since then ridges.
    moved : float
        Time to which elements and walls have moved, s since the scene's start.
    places : SeaPlaces, optional
        As for `advance_window`.
    """
    if "thermodynamics" not in scene.effects:
        return Grown(state)
    began, used = time.perf_counter(), time.process_time()
    grown, each, more, found = advance_columns(comm, scene, state, forcing, span, area, places)
    state = keep_forces(state, thin_bonds(grown), scene.dynamics.minimum_thickness, moved)
    cpu = comm.allreduce(time.process_time() - used)
    terms = add_terms(totals(each), more)
    return Grown(state, terms, each, time.perf_counter() - began, cpu, found)


def warm_up(
    comm: MPI.Comm,
    scene: Scene,
    state: xr.Dataset,
    forcing: xr.Dataset,
    places: SeaPlaces | None = None,
) -> None:
    """Let the column be compiled, or its compiled code be read, before anything is timed.

    One step of no elements: what that takes is the program's start, not a window's cost.

    Parameters
    ----------
    comm : MPI.Comm
        Ranks that share the run.
    scene : Scene
        Effects and column.
    state : xarray.Dataset
        From which the job starts.
    forcing : xarray.Dataset
        Of its first window.
    places : SeaPlaces, optional
        Grid of the mixed layer.
    """
    if "thermodynamics" in scene.effects:
        start = float(state.attrs["time"])
        none = state.isel(element=slice(0, 0))
        span = (start, start + min(scene.column.step, scene.time.window))
        advance_columns(comm, scene, none, forcing, span, none["area"].values, places)


def _costs(scene: Scene, ranks: int, motion: Motion, column: tuple[float, float]) -> list[Record]:
    """Records of a window; of the column, wall and processor seconds."""
    n = motion.state.sizes["element"]
    speed = n * motion.steps / motion.seconds if motion.seconds else 0.0
    figures = {
        "steps": motion.steps,
        "element_steps_per_s": speed,
        "cpu_seconds": motion.cpu_seconds,
        "time_step": motion.time_step,
        "limited_by": motion.limited_by,
    }
    records = [
        Record("setup", n, ranks, [motion.setup_seconds]),
        Record("dynamics", n, ranks, [motion.seconds], extra=figures),
    ]
    if "thermodynamics" in scene.effects:
        cpu = {"cpu_seconds": column[1]}
        records.append(Record("column", n, ranks, [column[0]], extra=cpu))
    return records


def run_windows(comm: MPI.Comm, job: Job) -> None:
    """Advance a job's windows and write each to the work folder.

    Parameters
    ----------
    comm : MPI.Comm
        Ranks that share the run.
    job : Job
        Scene, windows and folders.

    Raises
    ------
    FloeError
        For bad input, and for a run that fails, with the file, element or place.
    """
    folder = Path(job.folder)
    # Ranks may outlive the rule that started them; the next run sees them by this lock.
    lock = on_root(comm, join_run, folder)
    try:
        _run_windows(comm, job, folder)
    finally:
        if comm.rank == 0:
            os.close(lock)


def _run_windows(comm: MPI.Comm, job: Job, folder: Path) -> None:
    scene = job.read_scene()
    state = on_root(comm, read_state, job.state)
    cells = read_cells(on_root(comm, read_dataset, job.cells)) if job.cells else None
    places = on_root(comm, read_places, scene, job.mask) if job.mask else None
    for number in range(job.done, len(job.windows)):
        window, work = job.windows[number], resume.work_folder(folder, job.windows[number])
        began, used = time.perf_counter(), time.process_time()
        forcing = on_root(comm, window_forcing, scene, int(window), work)
        n, spent = state.sizes["element"], time.perf_counter() - began
        cpu = {"cpu_seconds": comm.bcast(time.process_time() - used)}
        cost = [Record("forcing", n, comm.size, [spent], extra=cpu)]
        if number == job.done:
            warm_up(comm, scene, state, forcing, places)
            began = time.perf_counter() - cost[0].seconds[0]
            used = time.process_time() - cpu["cpu_seconds"]
        log = folder / "log/windows" / f"{window}.liggghts.log"
        report = _reporter(comm, window)
        advanced = advance_window(comm, scene, state, forcing, log, report, cells, places)
        advanced.cost[:0] = cost
        provenance = json.loads(state.attrs["provenance"])
        provenance |= job.fixed | {"window": job.hashes[number]}
        advanced.state.attrs["provenance"] = json.dumps(provenance, sort_keys=True)
        clocks = began, used
        # What the next window starts from is what a restart would read.
        state = on_root(
            comm, _write, advanced, work, clocks, job.hashes[number], scene.state.precision
        )
        if scene.state.keep == "chunks" and comm.rank == 0:
            resume.drop_old_states(folder, job.windows[: number + 1])


def _write(
    advanced: Advanced,
    work: Path,
    clocks: tuple[float, float],
    made_from: str,
    precision: Literal["double", "single"],
) -> xr.Dataset:
    """Write a window's files; its state as its file has it."""
    # All carry the hash: a window counts as finished only where it is whole.
    mark = {resume.MADE_FROM: made_from, "window": int(advanced.state.attrs["window"])}
    advanced.series.attrs = mark
    write_dataset(advanced.series, work / resume.SERIES)
    known = sum(record.seconds[0] for record in advanced.cost)
    n, ranks = advanced.cost[0].n, advanced.cost[0].ranks
    write_state(advanced.state, work / resume.STATE, precision)
    if advanced.fluxes is not None:
        advanced.fluxes.attrs |= mark
        write_dataset(advanced.fluxes, work / resume.FLUXES)
    state = read_state(work / resume.STATE)
    grown = growth.as_variables(advanced.grown) if advanced.grown is not None else {}
    kept = join_snapshots([state.assign(grown)])
    kept.attrs[resume.MADE_FROM] = made_from
    write_dataset(kept, work / resume.ELEMENTS)
    rest = time.perf_counter() - clocks[0] - known
    whole = {WINDOW_CPU: time.process_time() - clocks[1]}
    records = [*advanced.cost, Record("exchange", n, ranks, [rest], extra=whole)]
    write_records(records, work / resume.COST)
    return state


def _reporter(comm: MPI.Comm, window: str) -> Report:
    def report(**event: Any) -> None:
        if comm.rank == 0:
            print(json.dumps({"window": window, **event}), flush=True)

    return report


def main() -> None:
    """Entry point of every rank."""
    comm = MPI.COMM_WORLD
    try:
        text = sys.stdin.readline() if comm.rank == 0 else ""
        run_windows(comm, Job.from_json(comm.bcast(text)))
    except FloeError as error:
        print(json.dumps({"error": str(error)}), flush=True)
        leave(comm)
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        comm.Abort(1)


if __name__ == "__main__":
    main()
