# SPDX-License-Identifier: GPL-2.0-or-later
"""The table of the central Arctic: its sampling, on packs whose answer is known."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from floeflow.diagnostics.followed import Frame
from floeflow.diagnostics.motion_analyses import Motion

DAY = 86400.0


@pytest.fixture
def central(project: object, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(f"{project}/benchmarks")
    import central_arctic

    return central_arctic


class Gusts:
    """A wind that turns from day to day."""

    every = 1

    def at(self, window: int, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.full(x.size, 10.0 * np.exp(1j * window))


def frame(window: int, gradients: np.ndarray, drift: complex = 0j) -> Frame:
    """A pack of 10 km with one coarse element, that deforms steadily (1/s) and drifted (m)."""
    rng = np.random.default_rng(0)
    x, y = (each.ravel() * 1e4 for each in np.mgrid[:30, :30].astype(float))
    x, y = x + rng.uniform(-1e3, 1e3, x.size), y + rng.uniform(-1e3, 1e3, x.size)
    (ux, uy), (vx, vy) = gradients * window * DAY
    moved = (x + ux * x + uy * y + drift.real, y + vx * x + vy * y + drift.imag)
    area = np.full(x.size, 1e8)
    area[17] = 4e8
    return Frame(window, window * DAY, np.arange(x.size), *moved, *moved, area, 1.0 + 0 * x, 0j * x)


def motion_of(central: ModuleType, gradients: np.ndarray) -> Motion:
    motion, at = Motion(DAY, 30, set(), Gusts()), 0j
    for window in range(10):
        motion.take(central.fine_part(frame(window, gradients, at), 1.5e4))
        # What the wind of the next day makes: 1 % of it, 30 degrees to its right.
        at += 0.1 * np.exp(1j * (window + 1) - 1j * np.radians(30.0)) * DAY
    return motion


def test_the_fine_elements_alone_are_followed(central: ModuleType) -> None:
    fine = central.fine_part(frame(0, np.zeros((2, 2))), 1.5e4)
    assert fine.id.size == 899 and 17 not in fine.id and fine.x.size == 899


def test_steady_deformation_and_drift_are_told(central: ModuleType) -> None:
    """Divergence of 0.1 and shear of 0.2 % a day everywhere: no fall with scale."""
    opening, shear = 0.001 / DAY, 0.002 / DAY
    motion = motion_of(central, 0.5 * np.array([[opening + shear, 0.0], [0.0, opening - shear]]))
    told = {row[0]: row[2] for row in central.deformation_rows(motion)}
    exponent = next(text for name, text in told.items() if name.startswith("exponent"))
    assert exponent.split(" ")[0].lstrip("-") == "0.00"
    assert told["a, b of a q² + b q"].replace("-", "") == "0.00, 0.00"
    assert told["mean absolute divergence over mean shear"] == "0.50"
    assert told["share of the area with half of the deformation (%)"] == "50 to 50"
    total = next(text for name, text in told.items() if name.startswith("mean total"))
    assert total == "0.2 (0.2 to 0.2)"
    wind, over_geostrophic = central.drift_rows(motion)
    assert wind[2] == "1.00 %; 30°; 100 %" and over_geostrophic[2] == "0.70 %; 5°"
    assert all(len(row) == 4 for row in [wind, *central.deformation_rows(motion)])


def test_lines_of_one_direction_are_aligned(central: ModuleType) -> None:
    along, way = central.alignment(np.radians([178.0, 2.0, 0.0]), np.ones(3))
    assert along == pytest.approx(1.0, abs=0.01) and min(way, 180.0 - way) < 1e-6
    assert central.alignment(np.radians([0.0, 90.0]), np.ones(2))[0] == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(central.alignment(np.zeros(0), np.zeros(0))).all()
