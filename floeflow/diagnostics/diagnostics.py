# SPDX-License-Identifier: GPL-2.0-or-later
"""Diagnostics of a run: series, totals and budgets of all windows, and the headline numbers.

Writes ``diagnostics.nc`` (everything, along ``sample``, ``window``, ``boundary`` and ``grid``) and
``diagnostics.json`` (headline numbers, budgets, cost). Only what the scene's effects bring is
there: without bonds no bond series, without thermodynamics no growth and no column energy.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from floeflow.core.atomic_write import write_text
from floeflow.diagnostics.analyses import Analyses
from floeflow.diagnostics.budgets import (
    Budget,
    column_budgets,
    dem_energy_budget,
    exports_of,
    grid_budget,
    ice_volume_budgets,
    momentum_budget,
    rim_terms,
    snow_volume_budget,
    total_of,
)
from floeflow.diagnostics.collect import (
    ADDED,
    SIDES,
    bond_counts,
    read_cost,
    read_grid,
    read_series,
    summarise_grid,
    summarise_states,
)
from floeflow.diagnostics.tendencies import tendencies
from floeflow.scene.blocks import Domain
from floeflow.state import read_state
from floeflow.state.snapshots import read_snapshots

UNITS = {
    "boundary_time": ("s", "time since the scene's start"),
    "time": ("s", "time since the scene's start"),
    "kinetic_energy": ("J", "kinetic energy of the mobile elements"),
    "elastic_energy": ("J", "elastic energy of bonds and contacts"),
    "drift_speed": ("m s-1", "area-weighted mean speed of the mobile elements"),
    "largest_speed": ("m s-1", "largest speed of a mobile element"),
    "intact_bonds": ("1", "bonds that hold"),
    "ice_area": ("m2", "ice area inside the scene's rectangle"),
    "ice_volume": ("m3", "ice volume inside the scene's rectangle"),
    "snow_volume": ("m3", "snow volume inside the scene's rectangle"),
    **{
        f"{name}_beyond_{side}": (unit, f"{text} beyond the {side} side of the rectangle")
        for side in SIDES
        for name, unit, text in (
            ("ice_area", "m2", "ice area"),
            ("ice_volume", "m3", "ice volume"),
            ("snow_volume", "m3", "snow volume"),
        )
    },
    "ocean_area": ("m2", "area of the scene that is not land"),
    "unclaimed_water": ("m2", "ocean area that no element stands for"),
    "mean_displacement": ("m", "area-weighted mean net displacement since the start"),
    "largest_displacement": ("m", "largest net displacement since the start"),
    "elements": ("1", "mobile elements"),
    "coast_elements": ("1", "fixed coast elements"),
    "bonds": ("1", "bonds that hold"),
    "bonds_broken": ("1", "bonds broken since the start"),
    "temperature_solves": ("1", "solves for the temperatures of a category in a step"),
    "temperature_rescued": ("1", "solves of which the second method did"),
    "temperature_unconverged": ("1", "solves of which ended short of their tolerance"),
    "grid_ice_area": ("m2", "ice area on the grid"),
    "grid_ice_volume": ("m3", "ice volume on the grid"),
    "grid_snow_volume": ("m3", "snow volume on the grid"),
    "outside_ice_area": ("m2", "ice area outside of the grid"),
    "outside_ice_volume": ("m3", "ice volume outside of the grid"),
    "outside_snow_volume": ("m3", "snow volume outside of the grid"),
}
GRID_LABELS = {
    "ice_area": ("Ice area on the grid", "m2"),
    "ice_volume": ("Ice volume on the grid", "m3"),
    "snow_volume": ("Snow volume on the grid", "m3"),
}


def change_over_windows(samples: xr.Dataset, name: str, windows: np.ndarray) -> np.ndarray:
    """Last minus first sample of each window, (window,).

    Parameters
    ----------
    samples : xarray.Dataset
        With ``sample_window``.
    name : str
        Of a variable of the samples.
    windows : ndarray
        Their numbers, (windows,).

    Returns
    -------
    ndarray
        In the unit of the variable.
    """
    number, values = samples["sample_window"].values, samples[name].values
    parts = (values[number == window] for window in windows)
    return np.array([float(part[-1] - part[0]) for part in parts])


def close_budgets(
    samples: xr.Dataset,
    scalars: xr.Dataset,
    boundaries: xr.Dataset,
    grids: xr.Dataset,
    effects: tuple[str, ...],
) -> list[Budget]:
    """All budgets that the scene's effects bring; see `floeflow.diagnostics.budgets`.

    Parameters
    ----------
    samples, scalars : xarray.Dataset
        From `read_series`.
    boundaries : xarray.Dataset
        From `summarise_states`.
    grids : xarray.Dataset
        From `summarise_grid`.
    effects : tuple of str
        The scene's effects.

    Returns
    -------
    list of Budget
        Momentum first.
    """
    found = [momentum_budget(scalars, axis) for axis in "xy"]
    volume, exports = boundaries["ice_volume"].values, exports_of(boundaries, "ice_volume")
    found += ice_volume_budgets(scalars, volume, exports)
    if "snow" in effects:
        volume, exports = boundaries["snow_volume"].values, exports_of(boundaries, "snow_volume")
        found.append(snow_volume_budget(scalars, volume, exports))
    if "thermodynamics" in effects:
        found += column_budgets(scalars)
    kinetic, elastic = (
        change_over_windows(samples, name, scalars["window"].values)
        for name in ("kinetic_energy", "elastic_energy")
    )
    mechanical = dem_energy_budget(scalars, kinetic, elastic)
    if mechanical is not None:
        found.append(mechanical)
    for name, (label, unit) in GRID_LABELS.items():
        if f"grid_{name}" in grids and name in boundaries:
            known = np.isin(grids["grid_window"].values, boundaries["boundary"].values)
            kept = grids.isel(grid=np.flatnonzero(known))
            elements = total_of(boundaries, name).sel(boundary=kept["grid_window"].values).values
            outside = kept.get(f"outside_{name}", xr.zeros_like(kept[f"grid_{name}"])).values
            found.append(grid_budget(name, label, unit, kept[f"grid_{name}"], elements, outside))
    return found


def cost_by_stage(costs: Sequence[Mapping[str, Any]], windows: np.ndarray) -> xr.DataArray:
    """Wall seconds on (window, stage), stages in the order in which they come.

    Parameters
    ----------
    costs : sequence of mapping of object
        Records with ``window``, ``name`` and ``seconds``.
    windows : ndarray
        Their numbers, ascending, (windows,).

    Returns
    -------
    xarray.DataArray
        s.
    """
    stages = list(dict.fromkeys(record["name"] for record in costs))
    seconds = np.zeros((len(windows), len(stages)))
    for record in costs:
        row = int(np.searchsorted(windows, record["window"]))
        seconds[row, stages.index(record["name"])] += record["seconds"]
    coords = {"window": windows, "stage": stages}
    attrs = {"units": "s", "long_name": "wall time inside the windows"}
    return xr.DataArray(seconds, coords, ("window", "stage"), attrs=attrs)


def dynamics_cost(costs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Speed of the DEM over all windows: element-steps, seconds, per second, ranks, time step.

    Parameters
    ----------
    costs : sequence of mapping
        Benchmark records of windows.

    Returns
    -------
    dict
        Numbers by name, times in s; step, limit and machine are those of the last window.
    """
    records = [record for record in costs if record["name"] == "dynamics"]
    steps = sum(record["n"] * int(record.get("steps", 0)) for record in records)
    seconds = sum(record["seconds"] for record in records)
    last = records[-1] if records else {}
    return {
        "element_steps": steps,
        "dynamics_seconds": seconds,
        "element_steps_per_s": steps / seconds if seconds > 0 else 0.0,
        "steps": sum(int(record.get("steps", 0)) for record in records),
        "ranks": last.get("ranks"),
        "time_step": last.get("time_step"),
        "limited_by": last.get("limited_by"),
        "machine": last.get("machine"),
        "git": last.get("git"),
    }


def headline(
    samples: xr.Dataset,
    scalars: xr.Dataset,
    boundaries: xr.Dataset,
    costs: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """Headline numbers of the run, SI units but for drift in km.

    What went through a side is negative where it left. Bonds add up: those of the end are those of
    the start, less the broken, with those that froze and those that remapping and merging made.

    Parameters
    ----------
    samples : xarray.Dataset
        Within the windows.
    scalars : xarray.Dataset
        On ``window``.
    boundaries : xarray.Dataset
        On ``boundary``.
    costs : sequence of mapping of object
        Records with ``window``, ``name`` and ``seconds``.

    Returns
    -------
    dict of object
        By name, in the order of the report.
    """
    first, last = boundaries.isel(boundary=0), boundaries.isel(boundary=-1)
    speeds = samples["largest_speed"].values
    means = samples["drift_speed"].values
    numbers: dict[str, Any] = {
        "elements": int(last["elements"]),
        "coast_elements": int(last["coast_elements"]),
        "windows": boundaries.sizes["boundary"] - 1,
        "seconds": float(last["boundary_time"]),
        "mean_drift_km": float(last["mean_displacement"]) / 1e3,
        "largest_drift_km": float(last["largest_displacement"]) / 1e3,
        "mean_speed": float(np.nanmean(means)) if np.isfinite(means).any() else 0.0,
        "largest_speed": float(np.max(speeds[np.isfinite(speeds)], initial=0.0)),
        "ocean_area": float(last["ocean_area"]),
        "unclaimed_water_end": float(last["unclaimed_water"]),
    }
    for name in ("ice_area", "ice_volume", "snow_volume"):
        if name in boundaries:
            numbers[f"{name}_start"] = float(first[name])
            numbers[f"{name}_end"] = float(last[name])
            numbers |= passed_sides(scalars, boundaries, name)
    if "bonds" in boundaries:
        numbers |= bond_balance(scalars, first, last)
    summed = [
        str(name) for name in scalars.data_vars if str(name).startswith(("gate_", "temperature_"))
    ]
    numbers |= {name: float(scalars[name].sum()) for name in summed}
    return {**numbers, **dynamics_cost(costs)}


def passed_sides(scalars: xr.Dataset, boundaries: xr.Dataset, name: str) -> dict[str, float]:
    """What came in through each side of the rectangle less what left, over the run.

    Parameters
    ----------
    scalars : xarray.Dataset
        On ``window``.
    boundaries : xarray.Dataset
        On ``boundary``.
    name : str
        ``ice_area``, ``ice_volume`` or ``snow_volume``.

    Returns
    -------
    dict of float
        By ``<name>_through_<side>_side``, m2 or m3.
    """
    found: dict[str, float] = {}
    terms = [*exports_of(boundaries, name).items(), *rim_terms(scalars, name).items()]
    for words, term in terms:
        # "through left side", "export left" or "inflow left".
        key = f"{name}_through_{words.split()[1]}_side"
        found[key] = found.get(key, 0.0) + float(term.sum())
    return found


def bond_balance(scalars: xr.Dataset, first: xr.Dataset, last: xr.Dataset) -> dict[str, int]:
    """Bonds of the start and the end, and what lies between them.

    Parameters
    ----------
    scalars : xarray.Dataset
        On ``window``.
    first : xarray.Dataset
        Start and end of the run.
    last : xarray.Dataset
        Start and end of the run.

    Returns
    -------
    dict of int
        Numbers of bonds, by name.
    """
    start, end, broken = int(first["bonds"]), int(last["bonds"]), int(last["bonds_broken"])
    numbers = {"bonds_start": start, "bonds_broken": broken}
    refrozen = 0
    if "bonds_refrozen" in scalars:
        numbers["bonds_refrozen"] = refrozen = int(scalars["bonds_refrozen"].sum())
    if end - start + broken - refrozen:
        numbers["bonds_remade"] = end - start + broken - refrozen
    return {**numbers, "bonds_end": end}


def assemble(
    samples: xr.Dataset,
    scalars: xr.Dataset,
    boundaries: xr.Dataset,
    grids: xr.Dataset,
    budgets: Sequence[Budget],
    seconds: xr.DataArray,
    start: str,
) -> xr.Dataset:
    """One dataset of it all, with units, and the residuals of each budget per window.

    Times count from ``start`` (ISO 8601), in words that CF readers decode.

    Parameters
    ----------
    samples : xarray.Dataset
        Within the windows.
    scalars : xarray.Dataset
        On ``window``.
    boundaries : xarray.Dataset
        On ``boundary``.
    grids : xarray.Dataset
        On ``grid``.
    budgets : sequence of Budget
        Their residuals become variables.
    seconds : xarray.DataArray
        Cost on (window, stage) (s).
    start : str
        Of the scene (ISO 8601).

    Returns
    -------
    xarray.Dataset
        For NetCDF.
    """
    data = xr.merge([samples, scalars, boundaries, grids], join="exact", compat="no_conflicts")
    for budget in budgets:
        dim = "grid" if budget.name.startswith("grid_") else "window"
        for kind, values, unit in (
            ("residual", budget.residual, budget.unit),
            ("relative", budget.relative, "1"),
        ):
            text = f"{kind} of: {budget.label}" if kind == "residual" else f"{budget.label}, rel."
            data[f"{budget.name}_{kind}"] = ((dim,), values, {"units": unit, "long_name": text})
    data["cost_seconds"] = seconds
    added = {name: (unit, text) for name, (_, unit, text) in ADDED.items()}
    for name, (unit, text) in {**UNITS, **added}.items():
        if name in data:
            data[name].attrs = {"units": unit, "long_name": text}
    for name in ("time", "boundary_time"):
        data[name].attrs = {
            "standard_name": "time",
            "long_name": UNITS[name][1],
            "units": f"seconds since {start.replace('T', ' ')}",
            "calendar": "standard",
        }
    return data


def remapped_windows(scalars: xr.Dataset) -> set[int]:
    """Windows at whose end ice was remapped between elements.

    Parameters
    ----------
    scalars : xarray.Dataset
        On ``window``.

    Returns
    -------
    set of int
        Numbers of windows, from 1.
    """
    if "remap_done" not in scalars:
        return set()
    return {int(number) for number in scalars["window"].values[scalars["remap_done"].values > 0]}


def write_json(data: Mapping[str, Any], path: Path) -> None:
    """Write JSON atomically; numbers that are not finite become null.

    Parameters
    ----------
    data : mapping of object
        What is not finite becomes null.
    path : Path
        File, replaced in one step.
    """
    write_text(json.dumps(_finite(data), indent=1, allow_nan=False) + "\n", path)


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


@dataclass(frozen=True)
class RunFiles:
    """Files of a run, chunks in order.

    Parameters
    ----------
    first : Path
        State 0.
    elements, series, cost : sequence of Path
        Of the chunks.
    grid : Path or None
        Fields of all boundaries, where the scene has gridded output.
    last : Path or None
        The last state, with its bonds.
    """

    first: Path
    elements: Sequence[Path]
    series: Sequence[Path]
    cost: Sequence[Path]
    grid: Path | None = None
    last: Path | None = None


def analyse(files: RunFiles, analyses: Analyses) -> xr.Dataset:
    """What goes to ``analyses.nc``, after `diagnose` has gone through the run.

    Parameters
    ----------
    files : RunFiles
        Of the run.
    analyses : Analyses
        Which have been given all windows.

    Returns
    -------
    xarray.Dataset
        For NetCDF.

    Raises
    ------
    FloeError
        For a file that cannot be read.
    """
    grid = read_grid(files.grid) if files.grid else None
    states = {"start": read_state(files.first)}
    states |= {"end": read_state(files.last)} if files.last else {}
    return analyses.result(grid, states)


def diagnose(
    files: RunFiles,
    effects: tuple[str, ...],
    domain: Domain,
    analyses: Analyses | None = None,
) -> tuple[xr.Dataset, dict[str, Any]]:
    """Diagnose a run.

    Parameters
    ----------
    files : RunFiles
        What its chunks left.
    effects : tuple of str
        The scene's effects.
    domain : Domain
        The scene's rectangle.
    analyses : Analyses, optional
        Gathers from the states as they are read.

    Returns
    -------
    tuple of xarray.Dataset and dict
        What goes to ``diagnostics.nc`` and to ``diagnostics.json``.

    Raises
    ------
    FloeError
        For a missing or damaged file, in one sentence that names it.
    """
    samples, scalars = read_series(files.series, effects)
    first = read_state(files.first)
    snapshots = read_snapshots(files.elements)
    if analyses is not None:
        analyses.remapped |= remapped_windows(scalars)
        analyses.take_samples(samples)
        analyses.take(first)
        snapshots = analyses.follow(snapshots)
    boundaries, states = summarise_states(first, snapshots, effects, domain)
    if "bonds" in effects:
        boundaries = boundaries.assign(bond_counts(first, samples, scalars))
    costs = read_cost(files.cost)
    gridded = summarise_grid(files.grid) if files.grid else xr.Dataset()
    budgets = close_budgets(samples, scalars, boundaries, gridded, effects)
    seconds = cost_by_stage(costs, scalars["window"].values)
    start = str(first.attrs["start"])
    lengths = np.diff(boundaries["boundary_time"].values)
    sea = float(boundaries["ocean_area"].values[0])
    scalars = scalars.merge(tendencies(scalars, sea, float(lengths[0])))
    data = assemble(samples, scalars, boundaries, gridded, budgets, seconds, start)
    stages = {str(name): float(seconds.sel(stage=name).sum()) for name in seconds["stage"].values}
    return data, {
        "headline": headline(samples, scalars, boundaries, costs),
        "budgets": [budget.summary() for budget in budgets],
        "window_seconds": stages,
        "states": states,
    }
