# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 4: ice that the wind jams against a coast, into a corner, into a strait.

All of a pack's push gathers at the coast: without a limit to the force, overlaps grow with the
fetch; ridging bounds the force, but takes the stiffness away where it acts, so that closing could
run on. Bonded ice must hold over a strait, and when it breaks, the energy of the arch must not
throw the pieces. What must hold: finite, nothing lost, one time step from start to end, speeds
below twice the free drift that the wind gives, overlaps within what the ridging force takes, energy
accounted for.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from floeflow.dynamics.engine.engine import EngineParams
from floeflow.state.bonds import Arrays
from support.full_ice import full_params
from support.rafts import lattice, uniform
from support.stability.packs import neighbours
from support.stability.watch import Watched, default_step, watch

WIND = 20.0
HOUR, DAY = 3600.0, 86400.0
LAWS = full_params(
    time_step=1.0, ridging=True, wind=True, ocean_drag=True, coriolis=True, compressive_strength=1e5
)


def pack(columns: int, rows: int, thin: float = 0.3) -> Arrays:
    """A lattice of mixed thicknesses."""
    ice = lattice(columns, rows)
    ice["thickness"] = np.random.default_rng(4).uniform(thin, 2.0, len(ice["id"]))
    ice["mass"] = ice["mass"] * ice["thickness"]
    return ice


def free_drift(params: EngineParams, wind: float = WIND) -> float:
    """Speed at which the ocean's drag balances the wind's, m/s."""
    return wind * float(np.sqrt(params.wind_stress_factor / params.ocean_stress_factor))


def elastic_bound(params: EngineParams, seen: Watched) -> float:
    """Overlap at which the thickest ridge that there is yields, m; contact line of a hexagon."""
    h = seen.elements["thickness"]
    ridge = max(float(seen.contacts["ridge_thickness"].max(initial=0.0)), float(h.max()))
    least = params.contact_modulus * float((h.min() * h.max()) / (h.min() + h.max()))
    return 2000.0 / np.sqrt(3.0) * ridge * params.compressive_strength / least


def press(
    log: Path, ice: Arrays, coast: np.ndarray, towards: tuple[float, float], seconds: float, record
) -> tuple[Watched, EngineParams]:
    """Let the wind press ice against elements that do not move."""
    ice["type"][coast] = 2
    params = default_step(ice, None, LAWS, 0.8)
    wind = WIND * np.asarray(towards) / np.hypot(*towards)
    seen = watch(log, ice, params, seconds, forcing=uniform(tuple(wind), (0.0, 0.0), 1.4e-4))
    overlap, bound = seen.largest_overlap * float(ice["radius"].min()), elastic_bound(params, seen)
    record(
        hours=seen.steps * seen.time_step / HOUR,
        largest_speed=seen.largest_speed,
        overlap_over_bound=overlap / bound,
        ridged=seen.sums.get("dissipation_ridging", 0.0),
        residual=seen.residual,
    )
    # Light ice that is hit by heavy ice leaves with at most twice its speed.
    assert seen.largest_speed < 2.0 * free_drift(params)
    assert overlap <= 1.02 * bound
    assert seen.residual < 0.02
    return seen, params


@pytest.mark.parametrize(
    "seconds", [6 * HOUR, pytest.param(10 * DAY, marks=pytest.mark.slow)], ids=["6 h", "10 days"]
)
def test_a_pack_pressed_against_a_coast(log: Path, seconds: float, record):
    ice = pack(16, 8)
    # The coast of a bay, out of which the ice cannot slide to the sides.
    coast = (ice["x"] < 1500.0) | (ice["y"] < 500.0) | (ice["y"] > ice["y"].max() - 500.0)
    seen, _ = press(log, ice, coast, (-1.0, 0.0), seconds, record)
    assert len(seen.contacts["id_lo"]) > 50
    pushed = np.hypot(seen.elements["u"], seen.elements["v"])
    # The push is taken by the coast: what lies there does not drift.
    assert np.median(pushed) < 0.2 * free_drift(LAWS)


@pytest.mark.parametrize(
    "seconds", [6 * HOUR, pytest.param(10 * DAY, marks=pytest.mark.slow)], ids=["6 h", "10 days"]
)
def test_a_pack_pressed_into_a_corner(log: Path, seconds: float, record):
    ice = pack(12, 12)
    coast = (ice["x"] < 1500.0) | (ice["y"] < 500.0)
    seen, _ = press(log, ice, coast, (-1.0, -1.0), seconds, record)
    assert len(seen.contacts["id_lo"]) > 100


def strait(width: int = 3) -> tuple[Arrays, Arrays]:
    """Bonded ice above a wall of elements with a gap of so many diameters; bonds of the ice."""
    ice = lattice(15, 8)
    column = np.round(ice["x"] / 2000.0).astype(int)
    wall = (ice["y"] < 500.0) & (np.abs(column - 7) > width // 2)
    ice["type"][wall] = 2
    below = (ice["y"] < 500.0) & ~wall
    ice = {name: values[~below] for name, values in ice.items()}
    ice["id"] = np.arange(1, len(ice["id"]) + 1)
    bonds = neighbours(ice)
    fixed = ice["type"] == 2
    both = fixed[bonds["id_lo"] - 1] & fixed[bonds["id_hi"] - 1]
    return ice, {name: values[~both] for name, values in bonds.items()}


@pytest.mark.parametrize(("wind", "holds"), [(5.0, True), (45.0, False)])
def test_an_arch_over_a_strait_holds_and_breaks(log: Path, wind: float, holds: bool, record):
    """Light wind: the ice hangs on the coast. A hurricane: the arch breaks and ice goes through."""
    ice, bonds = strait()
    laws = replace(LAWS, bonds=True, compressive_strength=3e4, tensile_share=0.2)
    params = default_step(ice, bonds, laws, 0.8)
    seen = watch(
        log, ice, params, 4 * HOUR, bonds, forcing=uniform((0.0, -wind), (0.0, 0.0), 1.4e-4)
    )
    through = int((seen.elements["y"] < -1000.0).sum())
    broken = int(seen.sums["bonds_broken"])
    record(broken=broken, through=through, largest_speed=seen.largest_speed, residual=seen.residual)
    assert (broken == 0) == holds and (through == 0) == holds
    assert seen.largest_speed < 1.5 * free_drift(params, wind)
    assert seen.residual < 0.02
