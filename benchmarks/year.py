# SPDX-License-Identifier: GPL-2.0-or-later
"""A year of the Arctic beside published figures, and what a day of it costs.

Usage: python benchmarks/year.py [--scene FILE] [--ranks 2] [--keep] [--figure FILE]
Runs the scene to its report and prints two tables, the first of the last 365 days; with ``--keep``
it reads a run that lies there, with ``--figure`` it draws March, September and the seasons of
volume and extent. Writes ``results/benchmarks/year.json``. Wall time wants idle cores.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import cmocean
import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from tables import show

from floeflow.core.atomic_write import write_text
from floeflow.diagnostics import season
from floeflow.diagnostics.collect import with_shares
from floeflow.scene import Scene, load_scene
from floeflow.scene.docs import PROJECT
from floeflow.state import read_dataset

RESULTS = Path("results")
KM2, KM3 = 1e6, 1e9
# Extent of the whole hemisphere, mean of 1979 to 1990 (million km2; NSIDC Sea Ice Index v3, doi
# 10.7265/N5K072F8), and the share of it inside the scene's rectangle: of NSIDC's concentration
# (0051, doi 10.5067/8GQ8LZQVL0VL) of 1 February and 18 August 2015.
EXTENT = {3: 15.9, 9: 7.1}
INSIDE = {3: 0.76, 9: 0.95}
WINTER = (11, 12, 1, 2, 3, 4)
BELOW = ("growth_base", "growth_snow_ice")  # what grows on ice that is there


def run(scene: Path, ranks: int) -> float:
    """Run a scene to its report; wall seconds."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(PROJECT / "Snakefile")]
    command += ["--profile", str(PROJECT / "workflows/profiles/local"), "--cores", str(ranks)]
    command += ["--set-threads", f"windows={ranks}", "--config", f"scene={scene}"]
    began = time.perf_counter()
    subprocess.run(command, check=True)
    return time.perf_counter() - began


def chunks(folder: Path) -> list[xr.Dataset]:
    """All files of a folder of a run, in order, with their times decoded."""
    return [xr.decode_cf(read_dataset(path)) for path in sorted(folder.glob("*.nc"))]


@dataclass(frozen=True)
class LastYear:
    """What a run published of its last 365 days.

    Attributes
    ----------
    grid : Dataset
        Of ``grid.nc``.
    series : list of Dataset
        Of ``series/``.
    skipped : int
        Windows before.
    days : float
        Length, less than 365 of a shorter run.
    """

    grid: xr.Dataset
    series: list[xr.Dataset]
    skipped: int
    days: float


def last_year(scene: Scene, folder: Path) -> LastYear:
    """Read the last 365 days of a run."""
    window = scene.time.window
    skipped = max(0, scene.time.windows - round(365.0 * season.DAY / window))
    with xr.open_dataset(folder / "grid.nc") as grid:
        begin = np.datetime64(scene.time.start, "s") + np.timedelta64(round(skipped * window), "s")
        kept = grid.isel(time=grid["time"].values > begin) if skipped else grid
        kept.load()
    series = [
        chunk.isel(window=chunk["window"].values > skipped) for chunk in chunks(folder / "series")
    ]
    days = sum(chunk.sizes["window"] for chunk in series) * window / season.DAY
    return LastYear(kept, [chunk for chunk in series if chunk.sizes["window"]], skipped, days)


def physics(scene: Scene, folder: Path, year: LastYear) -> list[tuple[str, str, str]]:
    """Rows of the table: what, in this run, published."""
    found, series, per_year = season.cycle(year.grid), year.series, 365.0 / year.days
    area, volume = season.passed(series, "fram_strait")
    remapped = [
        int(window)
        for chunk in series
        for window, done in zip(chunk["window"].values, chunk["remap_done"].values, strict=True)
        if done
    ]
    moved = season.drift(
        chunks(folder / "elements"), remapped, scene.domain.crs, scene.time.window, year.skipped
    )
    extents = season.by_month(found, found.extent / KM2 / 1e6)
    rows = [
        (
            f"extent of month {month} (million km2)",
            f"{extents[month]:.1f}" if month in extents else "not reached",
            f"{EXTENT[month] * INSIDE[month]:.1f} inside the rectangle of {EXTENT[month]}",
        )
        for month in EXTENT
    ]
    rows += [
        ("month of the largest extent", str(season.month_of(found, found.extent, largest=True)),
         "3"),
        ("month of the smallest extent", str(season.month_of(found, found.extent, largest=False)),
         "9"),
        ("thickness of the central basin, swing of monthly means (m)",
         f"{season.swing(found):.2f}", "0.4 to 1.2"),
        ("thickness of the central basin, mean (m)", f"{found.thickness.mean():.2f}",
         "2.6 to 3.6 (Rothrock et al. 2008)"),
        ("Fram Strait, area a year (million km2)", f"{area / KM2 / 1e6 * per_year:.2f}",
         "0.6 to 1.0 (Smedsrud et al. 2017)"),
        ("Fram Strait, volume a year (km3)", f"{volume / KM3 * per_year:.0f}",
         "1,970 to 2,490, 2010 to 2016 (Min et al. 2019); 2,370, 1978 to 1996 "
         "(Kwok and Rothrock 1999); 2,850, 1990 to 1996 (Vinje et al. 1998)"),
        ("drift over a day, central basin, median of months (cm/s)",
         f"{100 * moved.median.min():.1f} to {100 * moved.median.max():.1f}", "4 to 10"),
    ]  # fmt: skip
    return rows


def deformed(scene: Scene, year: LastYear) -> list[tuple[str, str, str]]:
    """Rows of the table: ridged ice, and what grew where the ice had opened."""
    ridges, found, series = season.ridged(year.grid), season.cycle(year.grid), year.series

    def sums(*names: str) -> dict[str, float]:
        every = season.month_sums(series, names, str(scene.time.start), scene.time.window)
        return {month: value for month, value in every.items() if int(month[5:7]) in WINTER}

    opened, base = sums("growth_new_ice", "growth_dissolved"), sums(*BELOW)
    closed = sums("ridged_area", "crowded_area")
    new, rest = sum(opened.values()), sum(base.values())
    area = dict(zip(found.months.astype(str), found.area, strict=True))
    metres = [value / area[month] for month, value in opened.items() if month in area]
    return [
        ("ridged share of the area, months (%)", percents(ridges.area),
         "25 to 45 (a model: Mårtensson et al. 2012)"),
        ("ridged share of the volume, months (%)", percents(ridges.volume),
         "45 to 60 (a model: Mårtensson et al. 2012)"),
        ("new ice in openings, November to April, share of what grows (%)",
         f"{100 * new / (new + rest):.0f}" if new else "not reached",
         "25 to 40, with its growth until spring (Kwok 2006)"),
        ("new ice in openings, November to April (m a month)",
         f"{np.mean(metres):.3f}" if metres else "not reached",
         "0.07, with its growth until spring (Kwok and Cunningham 2002)"),
        ("area closed by ridging, November to April (million km2 a month)",
         " ".join(f"{value / KM2 / 1e6:.2f}" for value in closed.values()), ""),
    ]  # fmt: skip


def percents(shares: np.ndarray) -> str:
    """Smallest and largest of some shares."""
    return f"{100 * shares.min():.0f} to {100 * shares.max():.0f}"


def costs(folder: Path, wall: float | None, days: float) -> list[tuple[str, str]]:
    """Rows of the table: part, seconds a day."""
    parts: dict[str, float] = {}
    for path in sorted((folder / "cost").glob("*.json")):
        for record in json.loads(path.read_text()):
            parts[record["name"]] = parts.get(record["name"], 0.0) + sum(record["seconds"])
    rows = [(name, f"{seconds / days:.2f}") for name, seconds in parts.items()]
    inside = sum(parts.values())
    rows.append(("all parts of windows", f"{inside / days:.2f}"))
    if wall is not None:
        rows.append(("the whole run", f"{wall / days:.2f}"))
        rows.append(("share outside of the windows' parts", f"{100 * (1 - inside / wall):.0f} %"))
    return rows


def draw(grid: xr.Dataset, path: Path) -> None:
    """Thickness in March and September, and the months of extent and volume."""
    found = season.cycle(grid)
    months = grid["time"].dt.month.values
    figure, axes = plt.subplots(1, 3, figsize=(13.0, 4.2), layout="constrained")
    sides = [float(v) / 1e3 for v in (grid.x.min(), grid.x.max(), grid.y.min(), grid.y.max())]
    for axis, month, title in zip(axes[:2], (3, 9), ("March", "September"), strict=True):
        part = grid.isel(time=months == month)
        share = with_shares(part)["siconc"].fillna(0.0).values.mean(axis=0)
        ice = np.where(share >= season.EDGE, part["sivol"].mean("time").values, np.nan)
        axis.set_facecolor("0.75")
        sea = np.where(grid["sea_area"].values > 0.0, 1.0, np.nan)
        axis.imshow(sea, extent=sides, origin="lower", cmap="Blues", vmin=0.0, vmax=4.0)
        drawn = axis.imshow(
            ice, extent=sides, origin="lower", cmap=cmocean.cm.ice, vmin=0.0, vmax=5.0
        )
        axis.set_title(f"{title}: ice volume per area (m)")
        axis.set_xticks([])
        axis.set_yticks([])
    figure.colorbar(drawn, ax=axes[:2], shrink=0.8)
    numbers = np.arange(len(found.months))
    axes[2].plot(numbers, found.extent / KM2 / 1e6, "o-", label="extent (million km2)")
    axes[2].plot(numbers, found.volume / KM3 / 1e3, "s--", label="volume (1000 km3)")
    for number, name in enumerate(found.months):
        month = int(str(name)[5:7])
        if month in EXTENT:
            axes[2].plot(number, EXTENT[month] * INSIDE[month], "k*", markersize=12)
    axes[2].plot([], [], "k*", label="extent observed, 1979 to 1990")
    axes[2].set_xticks(numbers, [str(month)[2:] for month in found.months], rotation=90)
    axes[2].set_ylim(0.0, 1.4 * float(found.volume.max()) / KM3 / 1e3)  # room for the legend
    axes[2].legend(frameon=False, loc="upper right")
    figure.savefig(path, dpi=80)


def main() -> None:
    """Run, or read a run, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", type=Path, default=Path("config/scenes/arctic_year.yaml"))
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--keep", action="store_true", help="read the run that lies there")
    parser.add_argument("--figure", type=Path, help="picture of the seasons, PNG")
    chosen = parser.parse_args()
    scene = load_scene(chosen.scene)
    folder = RESULTS / scene.name
    wall = None if chosen.keep else run(chosen.scene, chosen.ranks)
    days = scene.time.windows * scene.time.window / season.DAY
    year = last_year(scene, folder)
    seasons, spent = (
        physics(scene, folder, year) + deformed(scene, year),
        costs(folder, wall, days),
    )
    print(f"the last {year.days:g} of {days:g} days")
    show(("", "this run", "published"), seasons)
    show(("part", "seconds a day"), spent)
    told = {"scene": scene.name, "ranks": chosen.ranks, "seasons": seasons, "seconds_a_day": spent}
    out = RESULTS / "benchmarks" / "year.json"
    out.parent.mkdir(parents=True, exist_ok=True)
    write_text(json.dumps(told, indent=1) + "\n", out)
    if chosen.figure:
        draw(year.grid, chosen.figure)
    if np.any([row[1] == "not reached" for row in seasons]):
        print("The run ends before some months.")


if __name__ == "__main__":
    main()
