# SPDX-License-Identifier: GPL-2.0-or-later
"""A crack that freezes: what it bears after so many days of cold, pulled apart by the engine."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from floeflow.dynamics.bonds.refreeze import freeze, heal, thicken
from support.contact import figures
from support.rafts import bonded, discs
from unit.dynamics.test_refreeze import COLD, DAY, contact, winter
from unit.dynamics.test_refreeze_strength import PULL, strength

DAYS = np.array([0.0, 1.0, 3.0, 8.0, 12.0, 16.0])
THICKNESS, TENSILE = 0.6, 1e5
GROWTH = COLD.growth * 20.0 * DAY  # of the squared thickness in a day, m2


def regrown(days: np.ndarray) -> np.ndarray:
    """Strength (N/m) of a new bond by Stefan's law."""
    return TENSILE * np.minimum(np.sqrt(COLD.thickness**2 + GROWTH * days), THICKNESS)


def closing(days: np.ndarray) -> np.ndarray:
    """Strength (N/m) of a bond that has lost a third of its line."""
    return TENSILE * THICKNESS * (1 - np.exp(-3 * GROWTH * days / THICKNESS**2) / 3)


def test_a_crack_regains_its_strength_as_ice_grows(log: Path, show) -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0], thickness=THICKNESS)
    table, _ = freeze(contact((1, 2), touch=DAY), pair, COLD, PULL)
    # A third of the line of an old bond is cracked.
    torn = bonded(pair) | {"crack_a": np.array([1 / 3])}
    length = float(table["length"][0])
    new, old = [], []
    gaps = np.diff(DAYS, prepend=0.0) * DAY
    for gap in gaps:
        table = thicken(table, pair, winter, COLD, gap)
        torn = heal(torn, pair, winter, COLD, gap, PULL)
        new.append(strength(pair, table, log) / length)
        old.append(strength(pair, torn, log) / length)
    np.testing.assert_allclose(new, regrown(DAYS), rtol=1e-2)
    np.testing.assert_allclose(old, closing(DAYS), rtol=1e-2)
    assert regrown(DAYS[-2]) < TENSILE * THICKNESS == regrown(DAYS[-1])
    fine = np.linspace(0.0, DAYS[-1], 200)
    lines = {
        "a new bond: Stefan's law": (fine, regrown(fine) / 1e3),
        "a cracked bond: cracks that close": (fine, closing(fine) / 1e3),
    }
    points = {
        "FloeFlow: new": (DAYS, np.array(new) / 1e3),
        "FloeFlow: cracked": (DAYS, np.array(old) / 1e3),
    }
    label = ("days at 20 K below freezing", "largest force per length (kN/m)")
    show("refreezing", figures.curves, lines, points, *label)
