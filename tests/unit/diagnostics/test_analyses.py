# SPDX-License-Identifier: GPL-2.0-or-later
"""Analyses of a whole run, and how elements are followed through it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.diagnostics.analyses import Analyses, floe_rows, period_of, seasons_of
from floeflow.diagnostics.diagnostics import analyse, diagnose
from floeflow.diagnostics.followed import Frame, frame_of, step_between
from floeflow.diagnostics.motion_analyses import Motion, correlation
from floeflow.diagnostics.thickness_distribution import thickness_areas
from floeflow.state import read_dataset, read_state, write_dataset
from support.synthetic import Run


def pack(window: int, x: np.ndarray, y: np.ndarray, window_length: float = 86400.0) -> Frame:
    ids = np.arange(x.size) + 1
    area = np.full(x.size, 1e8)
    return Frame(window, window * window_length, ids, x, y, x, y, area, np.ones(x.size), 0j * x)


def windows_of(path: Path) -> list[xr.Dataset]:
    """Samples of each window of a series file."""
    data = read_dataset(path).drop_dims("window")
    numbers = data["sample_window"].values
    return [data.isel(sample=numbers == number) for number in np.unique(numbers)]


class Steady:
    """Wind from the west on all places."""

    every = 1

    def at(self, window: int, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return (5.0 + window) * np.exp(2e-6j * y)


def square(side: int = 20) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    x, y = (each.ravel() for each in np.meshgrid(np.arange(side) * 1e4, np.arange(side) * 1e4))
    return x + rng.uniform(-2e3, 2e3, x.size), y + rng.uniform(-2e3, 2e3, x.size)


def test_a_run_has_all_analyses_that_it_supports(run: Run, tmp_path):
    analyses = Analyses(run.scene)
    diagnose(run.files, run.scene.effects, run.scene.domain, analyses)
    data = analyse(run.files, analyses)
    assert {"thickness_area", "extent", "wind_factor", "deformation_total", "lag"} <= set(
        data.variables
    )
    broken = sum(
        int(chunk["intact_bonds"].values[0] - chunk["intact_bonds"].values[-1])
        for chunk in (part for path in run.of_chunks("series") for part in windows_of(path))
    )
    assert broken > 0 and int(data["break_count"].sum()) == broken
    # Some 200 elements of 20 km: no floes, and too few scales for an exponent.
    assert not {"floe_diameter_start", "scaling_exponent"} & set(data.variables)
    last = read_state(run.state(3))
    area = float((last["area"] * last["ice_fraction"].sum("category")).sum())
    assert data["thickness_area"].values[-1].sum() == pytest.approx(area, rel=1e-12)
    write_dataset(data, tmp_path / "analyses.nc")
    kept = read_dataset(tmp_path / "analyses.nc")
    assert kept["period"].values.tolist() == ["all", "run"]
    with xr.open_dataset(tmp_path / "analyses.nc") as found:
        assert found["thickness_time"].values[0] == np.datetime64("1981-12-31T00:00:00")


def test_steady_shear_is_found_by_every_sum():
    x, y = square()
    motion = Motion(86400.0, 30, set(), Steady())
    rate = 2e-7
    for window in range(7):
        motion.take(pack(window, x + rate * y * 86400.0 * window, y))
    assert motion.interval == 3 and len(motion.intervals) == 2
    total, opening, shear = motion.means[0]
    assert (total, shear) == (pytest.approx(rate, rel=1e-6), pytest.approx(rate, rel=1e-6))
    assert opening < 1e-3 * rate
    # Velocities stay as they are, so all lags correlate that enough were followed for.
    found = correlation(motion.lagged)
    np.testing.assert_allclose(found[:5], 1.0, atol=1e-9)
    assert np.isnan(found[5:]).all()
    assert len(motion.winds) == 6
    mean = motion.pairs[1:7, 1] / motion.pairs[1:7, 0]
    np.testing.assert_allclose(mean / mean[0], np.arange(1, 7) ** 2, rtol=0.05)


def test_nothing_is_followed_across_a_remap():
    x, y = square(6)
    motion = Motion(86400.0, 30, {2}, None)
    for window in range(6):
        # The remap puts the elements somewhere else altogether.
        motion.take(pack(window, x + (1e6 if window >= 2 else 0.0), y))
    assert len(motion.intervals) == 1
    assert motion.means[0][0] < 1e-15
    assert motion.pairs[1:, 1].max() < 1e-6


def test_an_element_that_took_its_neighbour_in_jumps_and_is_left_out():
    x, y = square(5)
    one, two = pack(0, x, y), pack(1, x + 3e3, y)
    moved = two.x.copy()
    moved[4] += 5e3
    jumped = Frame(1, 86400.0, two.id, moved, y, x + 3e3, y, two.area, two.share, two.velocity)
    step = step_between(one, jumped)
    assert 4 not in step.before and step.before.size == 24
    np.testing.assert_allclose(step.dx, 3e3)


def test_frames_hold_mobile_ice_alone(run: Run):
    state = read_state(run.state(0))
    frame = frame_of(state)
    assert frame.id.size == int((state["type"].values == 1).sum())
    state["ice_fraction"].values[:5] = 0.0
    assert frame_of(state).id.size == frame.id.size - 5


def test_thickness_counts_every_category_with_its_own():
    state = xr.Dataset(
        {
            "type": ("element", np.array([1, 2], dtype=np.int8)),
            "area": ("element", [100.0, 100.0]),
            "ice_fraction": (("element", "category"), [[0.5, 0.2], [1.0, 0.0]]),
            "ice_volume": (("element", "category"), [[0.25, 0.4], [1.0, 0.0]]),
        }
    )
    found = thickness_areas(state, np.array([0.0, 1.0, 3.0, np.inf]))
    assert found.tolist() == [50.0, 20.0, 0.0]


def test_long_runs_are_cut_into_months_and_seasons(run: Run):
    seconds = np.arange(0.0, 400.0, 20.0) * 86400.0
    assert set(period_of(run.scene, seconds)) == {"run"}
    time = run.scene.time.model_copy(update={"windows": 800})
    year = run.scene.model_copy(update={"time": time})
    assert period_of(year, seconds)[:3] == ["1981-12", "1982-01", "1982-02"]
    seasons = seasons_of(year, seconds)
    assert set(seasons) == {"all", "winter", "summer"}
    assert not (seasons["winter"] & seasons["summer"]).any()


def test_floes_are_told_where_elements_are_small_enough(run: Run):
    state = read_state(run.state(0))
    assert floe_rows(state, "start") == {}
