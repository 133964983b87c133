# SPDX-License-Identifier: GPL-2.0-or-later
"""Seas with coasts for days and months: storms in a basin, a strait, wind against a coast.

What holds in every window: no element's centre is on land, no ice is lost, areas and open water
add up to the sea, no open water is negative, and the time step stays near that of the start.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from floeflow.dynamics.remesh.absorb import ashore
from support.coasts import Wind, a_mask, a_scene, blowing, first_state, on_land, windows

DAY = 86400.0


def basin() -> np.ndarray:
    """A round sea with an island, closed by land."""
    y, x = np.mgrid[:24, :24] - 11.5
    return np.asarray((np.hypot(x, y) > 10.5) | (np.hypot(x - 4, y + 3) < 1.8))


def strait() -> np.ndarray:
    """Two seas joined by a strait of 40 km in a wall of land."""
    land = np.zeros((26, 16), dtype=bool)
    land[[0, -1]] = land[:, [0, -1]] = True
    land[11:14] = True
    land[11:14, 6:10] = False
    return land


def coast() -> np.ndarray:
    """Land with a jagged shore in the south, closed at the sides."""
    land = np.zeros((20, 20), dtype=bool)
    land[:, [0, -1]] = True
    land[:3] = True
    land[3:5, [4, 5, 10, 15]] = True
    return land


def storms(time: float) -> tuple[float, float]:
    """Winds that turn in four days and come and go in three."""
    speed = 14.0 * abs(np.sin(np.pi * time / (3.0 * DAY)))
    turn = 2.0 * np.pi * time / (4.0 * DAY)
    return speed * np.cos(turn), speed * np.sin(turn)


def southward(time: float) -> tuple[float, float]:
    return 0.0, -16.0


SEAS = {"basin": (basin, storms), "strait": (strait, southward), "coast": (coast, southward)}
QUICK = [(name, remesh, 3, 0.5 * DAY) for name in SEAS for remesh in ("", "remap")]
LONG = [
    ("basin", "remap", 60, DAY),
    ("basin", "", 20, 3 * DAY),
    ("strait", "remap", 40, 0.25 * DAY),
    ("coast", "remap", 10, DAY),
    ("coast", "", 10, DAY),
]


def hold(log: Path, land: np.ndarray, wind: Wind, remesh: str, count: int, window: float) -> None:
    scene, mask = a_scene(150, window, *([remesh] if remesh else [])), a_mask(land)
    start, _ = first_state(scene, mask)
    volume = float(start["area"] @ start["ice_volume"].sum("category"))
    steps = []
    for k, done in enumerate(windows(log, scene, mask, partial(blowing, wind), count), start=1):
        state, where = done.state, f"window {k}"
        assert not len(on_land(state, land)), where
        assert not len(ashore(scene, state)), where
        now = float(state["area"] @ state["ice_volume"].sum("category"))
        assert now == pytest.approx(volume, rel=1e-11), where
        water = state.attrs["unclaimed_water"]
        assert water > -1e-9 * state.attrs["ocean_area"], where
        owned = float(state["area"].sum()) + water
        assert owned == pytest.approx(state.attrs["ocean_area"], rel=1e-12), where
        assert max(done.motion.samples["largest_speed"]) < 1.5, where
        steps.append(done.motion.time_step)
    assert min(steps) > 0.6 * steps[0]


@pytest.mark.parametrize(("name", "remesh", "count", "window"), QUICK)
def test_a_sea_holds_for_days(
    tmp_path: Path, name: str, remesh: str, count: int, window: float
) -> None:
    land, wind = SEAS[name]
    hold(tmp_path / "log", land(), wind, remesh, count, window)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "remesh", "count", "window"), LONG)
def test_a_sea_holds_for_weeks(
    tmp_path: Path, name: str, remesh: str, count: int, window: float
) -> None:
    land, wind = SEAS[name]
    hold(tmp_path / "log", land(), wind, remesh, count, window)
