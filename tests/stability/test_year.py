# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 8: a year of daily windows on `smoke`, a chunk of windows in each launch.

What a window loses, the next one builds upon: a budget that is open by a millionth a day, a pair
table that grows by a row a day, a clock that slips a day at new year or on 29 February would be
seen after a year. What must hold: every window's budgets closed, and those of the year as a whole;
each day's weather on its own day; the same files for each window, of about the same size; speeds
below what wind and current give.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.core.constants import AIR_DENSITY, SEAWATER_DENSITY
from floeflow.coupling import resume
from floeflow.diagnostics.diagnostics import RunFiles, diagnose
from floeflow.forcings.forcing import make_forcing
from floeflow.scene import Scene
from floeflow.state import read_dataset, read_state
from support.stability import year
from support.stability.year import DAY, Start

# Light floes that heavy ones hit leave with up to twice their speed.
HIT = 2.0


@dataclass
class Seen:
    """What the windows of a run left behind, one entry a window (or a launch)."""

    files: list[int] = field(default_factory=list)
    bytes: list[int] = field(default_factory=list)
    volume: list[float] = field(default_factory=list)
    snow: list[float] = field(default_factory=list)
    contacts: list[int] = field(default_factory=list)
    fastest: float = 0.0
    worst_total: float = 0.0


def fastest_drift(at: Start) -> float:
    """Speed that the strongest wind gives on top of the strongest current, m/s."""
    keys, cyclone = at.scene.dynamics, at.scene.forcing.cyclone
    rule = np.sqrt(AIR_DENSITY * keys.air_drag / (SEAWATER_DENSITY * keys.ocean_drag))
    return float(rule * cyclone.wind_speed) + at.scene.forcing.gyre.current_speed


def look_at_state(at: Start, window: str, seen: Seen) -> None:
    """Finite, in bounds, on time, and the sea whole."""
    state = read_state(at.folder / f"state/{window}.nc")
    for name in state.data_vars:
        if state[name].dtype.kind == "f":
            assert np.isfinite(state[name].values).all(), f"{name} after window {window}"
    assert state.attrs["time"] == int(window) * DAY
    assert state["ice_fraction"].values.sum(axis=1).max() <= 1.0 + 1e-12
    for name in ("area", "ice_fraction", "ice_volume", "snow_volume"):
        assert state[name].values.min() >= 0.0, f"{name} after window {window}"
    ocean = state.attrs["ocean_area"]
    sea = float(state["area"].values.sum()) + state.attrs["unclaimed_water"]
    seen.worst_total = max(seen.worst_total, abs(sea / ocean - 1.0))
    area = state["area"].values
    seen.volume.append(float(area @ state["ice_volume"].values.sum(axis=1)))
    seen.snow.append(float(area @ state["snow_volume"].values.sum(axis=1)))
    seen.contacts.append(state.sizes["contact"])
    seen.bytes.append((at.folder / f"state/{window}.nc").stat().st_size)


def look_at_forcing(scene: Scene, window: int, forcing: xr.Dataset) -> None:
    """The day's weather is that of its date, whatever calendar turns lie before it."""
    begin = (window - 1) * DAY
    assert forcing["time"].values.tolist() == [begin, begin + DAY]
    for k in range(2):
        date = scene.time.start + timedelta(days=window - 1 + k)
        for name, value in year.weather(date).items():
            found = forcing[name].values[k]
            np.testing.assert_allclose(found, value, rtol=1e-6, atol=1e-12, err_msg=f"{date}")


def live(at: Start, ranks: int) -> Seen:
    """Run to the end and look at everything on the way."""
    seen = Seen()
    look_at_state(at, "0000", seen)
    for chunk in year.run(at, ranks):
        for window in chunk:
            look_at_state(at, window, seen)
            forcing = make_forcing(at.scene, at.scene.forcing.file, int(window))
            look_at_forcing(at.scene, int(window), forcing)
        series = read_dataset(at.folder / f"series/{chunk[-1]}.nc")
        seen.fastest = max(seen.fastest, float(series["largest_speed"].max()))
    seen.files = files_of_windows(at)
    return seen


def files_of_windows(at: Start) -> list[int]:
    """Number of files of each window; what is one for a chunk of windows does not count."""
    work = at.folder / resume.WORK
    found = [*(at.folder / "state").glob("*.nc"), *(at.folder / "log").rglob("*.liggghts.log")]
    owner = Counter(path.name.split(".")[0] for path in found)
    owner.update(path.parent.name for path in work.glob("*/*"))
    return [owner[f"{window:04d}"] for window in range(1, at.scene.time.windows + 1)]


def files_of(at: Start) -> RunFiles:
    """What diagnostics read of the run."""

    def of_chunks(kind: str) -> list[Path]:
        return sorted((at.folder / kind).iterdir())

    parts = [of_chunks(kind) for kind in ("elements", "series", "cost")]
    return RunFiles(at.folder / "state/0000.nc", *parts)


def hold(at: Start, seen: Seen, record) -> None:
    """Budgets of every window and of the run as a whole, files, speeds."""
    count = at.scene.time.windows
    data, told = diagnose(files_of(at), at.scene.effects, at.scene.domain)
    budgets = {b["name"]: b for b in told["budgets"]}
    worst = {name: b["relative"] for name, b in budgets.items()}
    growth = sum(
        float(data[name].sum()) for name in data.data_vars if str(name).startswith("growth_")
    )
    gained = seen.volume[-1] - seen.volume[0]
    moved = sum(
        float(np.abs(data[name]).sum())
        for name in data.data_vars
        if str(name).startswith("growth_")
    )
    whole = abs(gained - growth) / max(seen.volume[0], moved)
    record(
        windows=count,
        largest_speed=seen.fastest,
        least_volume=min(seen.volume) / seen.volume[0],
        most_volume=max(seen.volume) / seen.volume[0],
        last_volume=seen.volume[-1] / seen.volume[0],
        volume_not_explained=whole,
        most_contacts=max(seen.contacts),
        largest_state=max(seen.bytes),
        residual=worst["dem_energy"],
        **{f"worst_{name}": value for name, value in worst.items() if name != "dem_energy"},
    )
    # The elements' energy turns over many times what it changes by: its residual is small beside
    # what was done and lost, and the report calls it closed only if it is beside the change too.
    assert [b["name"] for b in told["budgets"] if b["relative"] > b["closed_limit"]] == []
    fair = [b["name"] for b in told["budgets"] if b["verdict"] != "closed"]
    assert set(fair) <= {"dem_energy"}
    assert whole < 1e-10
    assert seen.worst_total < 1e-12
    assert seen.fastest < HIT * fastest_drift(at)
    assert len(set(seen.files)) == 1
    # The end of a window is the start of the next, to the last bit.
    for kind in ("ice_volume", "ice_area", "snow_volume"):
        ends, starts = data[f"{kind}_end"].values, data[f"{kind}_start"].values
        np.testing.assert_array_equal(ends[:-1], starts[1:])


def test_weather_around_a_leap_day_is_on_its_days(project: Path, tmp_path: Path):
    scene = year.make_scene(project, tmp_path, "1983-12-27", 70, 10)
    for window in (63, 64, 65, 66, 67):
        look_at_forcing(scene, window, make_forcing(scene, scene.forcing.file, window))
    leap = scene.time.start + timedelta(days=64)
    assert (leap.month, leap.day) == (2, 29)


@pytest.mark.mpi
def test_twelve_windows_over_new_year(project: Path, tmp_path: Path, record):
    """Twelve days in launches of six, from 27 December."""
    at = year.prepare(project, tmp_path, year.make_scene(project, tmp_path, "1983-12-27", 12, 6))
    hold(at, live(at, 1), record)


@pytest.mark.mpi
@pytest.mark.slow
@pytest.mark.parametrize("more", [(), ("ridging", "refreeze", "remap")], ids=["smoke", "remap"])
def test_a_year_of_daily_windows(project: Path, tmp_path: Path, more: tuple[str, ...], record):
    """366 windows in launches of 61, from the first day of December to the next."""
    scene = year.make_scene(project, tmp_path, "1983-12-01", 366, 61, more)
    at = year.prepare(project, tmp_path, scene)
    # On one rank: so few elements wait for each other more than they compute.
    seen = live(at, 1)
    hold(at, seen, record)
    # Tables do not grow from season to season.
    assert max(seen.bytes[183:]) < 1.2 * max(seen.bytes[:183])
