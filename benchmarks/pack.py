# SPDX-License-Identifier: GPL-2.0-or-later
"""Watch the pack of finished runs: step, cost, coasts, bonds and areas, window by window.

Usage: python benchmarks/pack.py results/NAME [results/NAME ...] [--figure FOLDER] [--days 5 30 60]
Prints a table of a column a run, of what docs/verification/pack.md tells, and writes it to
``results/benchmarks/pack.json``; with ``--figure`` it draws the pack of some days and the bonds in
time of each run.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from packfigures import draw_bonds, draw_days
from packwatch import DAY, Watched, read_sea, shapes, watch
from tables import show

from floeflow.core.atomic_write import write_text
from floeflow.core.errors import FloeError
from floeflow.core.records import WINDOW_CPU
from floeflow.scene import Scene, load_scene
from floeflow.state import read_dataset
from floeflow.state.schema import MOBILE
from floeflow.state.snapshots import read_snapshots, snapshot

Array = NDArray[np.float64]


@dataclass
class Run:
    """A finished run, window by window.

    Parameters
    ----------
    name : str
        Its scene.
    scene : Scene
        Its keys.
    watched : list of Watched
        At the start and at the ends of all windows.
    kept : dict
        Elements of some days, by the day, for figures.
    strength : list of tuple
        Day, sum of whole length times thickness (m2) and mean thickness (m) of the bonds, of the
        states that are kept.
    windows : dict
        Of each window: ``step`` (s), ``dynamics`` and ``remesh`` (CPU s a day), bonds ``broken``
        and ``frozen``, mean ``speed`` (m/s), and ``remapped``.
    budgets : list
        Of ``diagnostics.json``.
    """

    name: str
    scene: Scene
    watched: list[Watched] = field(default_factory=list)
    kept: dict[float, xr.Dataset] = field(default_factory=dict)
    strength: list[tuple[float, float, float]] = field(default_factory=list)
    windows: dict[str, Array] = field(default_factory=dict)
    budgets: list[dict[str, Any]] = field(default_factory=list)

    def over_time(self, name: str) -> Array:
        """One of the figures of `Watched` at all ends of windows, the start first."""
        return np.array([getattr(each, name) for each in self.watched])


def read_run(folder: Path, days: list[float]) -> Run:
    """Watch all windows of a finished run."""
    scene = load_scene(folder / "scene.yaml")
    sea, run = read_sea(folder, scene), Run(scene.name, scene)
    first = snapshot(read_dataset(folder / "state/0000.nc"))
    if "cell_corners" not in first or "bonded_length" not in first:
        raise FloeError(f"{folder}: only scenes with the effects bonds and remap can be watched")
    for state in chain([first], read_snapshots(sorted((folder / "elements").glob("*.nc")))):
        run.watched.append(watch(state, sea))
        day = run.watched[-1].day
        if any(abs(day - wanted) < 1e-6 for wanted in days):
            run.kept[day] = state
    for path in sorted((folder / "state").glob("*.nc")):
        state = read_dataset(path)
        left = 1.0 - state["bond_crack_a"].values - state["bond_crack_b"].values
        whole = state["bond_length"].values * np.clip(left, 0.0, 1.0)
        held = float(whole @ state["bond_thickness"].values)
        mean = held / whole.sum() if whole.any() else 0.0
        run.strength.append((float(state.attrs["time"]) / DAY, held, float(mean)))
    run.windows = read_windows(folder, scene)
    run.budgets = json.loads((folder / "diagnostics.json").read_text())["budgets"]
    return run


def read_windows(folder: Path, scene: Scene) -> dict[str, Array]:
    """What each window cost and did."""
    out: dict[str, list[float]] = {
        name: []
        for name in (
            *("step", "dynamics", "remesh", "whole", "broken", "frozen", "speed", "remapped"),
            *("merged", "ashore"),
        )
    }
    a_day = DAY / scene.time.window
    for records in by_window(folder):
        seconds = {record["name"]: record["seconds"][0] for record in records}
        cpu = records[-1][WINDOW_CPU]
        dynamics = next(record for record in records if record["name"] == "dynamics")
        out["step"].append(dynamics["time_step"])
        out["dynamics"].append(dynamics["cpu_seconds"] * a_day)
        if "remesh" in seconds:
            # It runs on one rank and never waits, so it has its share of the window's CPU time.
            out["remesh"].append(seconds["remesh"] * cpu / sum(seconds.values()) * a_day)
        out["whole"].append(cpu * a_day)
    for path in sorted((folder / "series").glob("*.nc")):
        series = read_dataset(path)
        number, held = series["sample_window"].values, series["intact_bonds"].values
        for k, window in enumerate(series["window"].values):
            mine = number == window
            out["broken"].append(float(held[mine][0] - held[mine][-1]))
            out["speed"].append(float(series["drift_speed"].values[mine].mean()))
            for name, source in (
                *(("frozen", "bonds_refrozen"), ("remapped", "remap_done")),
                *(("merged", "merge_elements"), ("ashore", "coast_ashore")),
            ):
                out[name].append(float(series[source].values[k]) if source in series else 0.0)
    return {name: np.array(values) for name, values in out.items()}


def by_window(folder: Path) -> Iterator[list[dict[str, Any]]]:
    """Cost records of each window in turn; the last one holds the CPU time of all of it."""
    window: list[dict[str, Any]] = []
    for path in sorted((folder / "cost").glob("*.json")):
        for record in json.loads(path.read_text()):
            window.append(record)
            if WINDOW_CPU in record:
                yield window
                window = []


def rows(run: Run) -> list[tuple[str, str]]:
    """The table's rows of a run."""
    w, seen = run.windows, run.over_time
    bonds = seen("bonded") / seen("perimeter")
    days = run.scene.time.window / DAY
    second = slice(len(w["broken"]) // 2, None)

    def half(name: str) -> float:
        return float(w[name][second].mean())

    lost = w["broken"] - w["frozen"]
    storm = np.corrcoef(w["speed"], lost)[0, 1] if len(lost) > 2 else np.nan
    loose = [budget for budget in run.budgets if budget["verdict"] != "closed"]
    months = [f"{bonds[np.searchsorted(seen('day'), day - 1e-6)]:.3f}"
              for day in (0, 5, 30, 60) if day <= seen("day")[-1] + 1e-6]  # fmt: skip
    return [
        ("start", str(run.scene.time.start)),
        ("windows, hours each", f"{len(w['step'])}, {run.scene.time.window / 3600:g}"),
        ("step at the start, least (s)", f"{w['step'][0]:.1f}, {w['step'].min():.1f}"),
        ("least over the first (%)", f"{100 * w['step'].min() / w['step'][0]:.0f}"),
        ("CPU a day: dynamics (s)", f"{w['dynamics'].mean():.2f}"),
        ("CPU a day: remeshing (s)", f"{w['remesh'].mean():.2f}" if len(w["remesh"]) else "none"),
        ("CPU a day: the whole window (s)", f"{w['whole'].mean():.2f}"),
        ("centres ashore, all windows", f"{int(seen('ashore').sum())}"),
        ("outlines on land, first, most (% of ice area)",
         f"{100 * seen('outlines_on_land')[0]:.3f}, {100 * seen('outlines_on_land').max():.3f}"),
        ("discs on land, first, most (% of ice area)",
         f"{100 * seen('discs_on_land')[0]:.3f}, {100 * seen('discs_on_land').max():.3f}"),
        ("elements, first, least, most",
         f"{seen('elements')[0]}, {seen('elements').min()}, {seen('elements').max()}"),
        ("remaps, elements merged",
         f"{int(w['remapped'].sum())}, {int(w['merged'].sum())}"),
        ("whole bonds over outlines, days 0, 5, 30, 60", ", ".join(months)),
        ("whole length times thickness, first, last (million m2)",
         f"{run.strength[0][1] / 1e6:.0f}, {run.strength[-1][1] / 1e6:.0f}"),
        ("mean thickness of whole bonds, first, last (m)",
         f"{run.strength[0][2]:.2f}, {run.strength[-1][2]:.2f}"),
        ("bonds a day: break, freeze together, mean of the second half",
         f"{half('broken') / days:.0f}, {half('frozen') / days:.0f}"),
        ("correlation of drift with bonds broken less frozen", f"{storm:.2f}"),
        ("outline's area, largest error", f"{seen('outline_error').max():.1e}"),
        ("areas and water less ocean", f"{seen('sum_error').max():.1e}"),
        ("unclaimed water, least (% of the ocean)", f"{100 * seen('water').min():.3f}"),
        ("outlines overlap, first, most (%)",
         f"{100 * seen('cells_overlap')[0]:.2f}, {100 * seen('cells_overlap').max():.2f}"),
        ("claimed beyond the sea of grid cells, first, most (%)",
         f"{100 * seen('crowded')[0]:.2f}, {100 * seen('crowded').max():.2f}"),
        ("the same as the sea deals out areas (%)",
         f"{100 * seen('dealt')[0]:.2f}, {100 * seen('dealt').max():.2f}"),
        ("neighbours that an element touches, median, least and most of windows",
         f"{seen('neighbours')[1:].min():g}, {seen('neighbours')[1:].max():g}"),
        ("contacts over outlines, median, least and most of windows (%)",
         f"{100 * seen('touching')[1:].min():.0f}, {100 * seen('touching')[1:].max():.0f}"),
        ("ridged share of volume, first, last (%)",
         ", ".join(f"{100 * v:.1f}" for v in (seen("ridged_volume") / seen("volume"))[[0, -1]])),
        ("budgets closed", f"{len(run.budgets) - len(loose)} of {len(run.budgets)}"),
        ("residuals of the others", ", ".join(
            f"{b['label'].lower()} {b['relative']:.1g}" for b in loose) or "none"),
    ]  # fmt: skip


def main() -> None:
    """Read runs, print, and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", type=Path, nargs="+", help="results/NAME of finished runs")
    parser.add_argument("--figure", type=Path, help="folder for the pictures, PNG")
    parser.add_argument("--days", type=float, nargs="+", default=[5.0, 30.0, 60.0])
    chosen = parser.parse_args()
    table, told = {}, {}
    for folder in chosen.runs:
        try:
            run = read_run(folder, chosen.days)
        except FloeError as error:
            sys.exit(str(error))
        table[run.name] = rows(run)
        told[run.name] = {
            "rows": table[run.name],
            "windows": {name: values.tolist() for name, values in run.windows.items()},
            "strength": run.strength,
            **{f.name: run.over_time(f.name).tolist() for f in fields(Watched)},
        }
        if chosen.figure:
            chosen.figure.mkdir(parents=True, exist_ok=True)
            mask = read_dataset(folder / "preprocess/mask.nc")
            outlined = {
                day: shapes(state, np.flatnonzero(state["type"].values == MOBILE))
                for day, state in run.kept.items()
            }
            draw_days(run.kept, outlined, mask, chosen.figure / f"pack_{run.name}.png")
            draw_bonds(told[run.name], chosen.figure / f"pack_bonds_{run.name}.png")
    parts = [
        (lines[0][0], *(value for _, value in lines)) for lines in zip(*table.values(), strict=True)
    ]
    show(("", *table), parts)
    out = Path("results/benchmarks/pack.json")
    out.parent.mkdir(parents=True, exist_ok=True)
    write_text(json.dumps(told, indent=1) + "\n", out)


if __name__ == "__main__":
    main()
