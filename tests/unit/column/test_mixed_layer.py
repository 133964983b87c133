# SPDX-License-Identifier: GPL-2.0-or-later
"""The mixed layer under zero-layer ice and that under layered ice: one set of equations.

They are written twice, over arrays of elements and for one compiled column.
"""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.column.ocean import ocean, slab
from floeflow.column.params import ColumnParams
from floeflow.column.physics import KELVIN, Physics
from floeflow.column.thermodynamics.boundary_layer import Air

P = Physics()
PARAMS = ColumnParams(mixed_layer_depth=20.0, ocean_salinity=34.0)
FREEZING = PARAMS.freezing_temperature - KELVIN
DT = 3600.0
COUNT = 400
AIR = Air(260.0, 1e-3, 1.3, 5.0, 200.0)


def seas(random: np.random.Generator) -> slab.Sea:
    """From freezing, with ice to be made in every fourth, to warm enough to be limited."""
    warm = 10.0 ** random.uniform(-3.0, 0.7, COUNT)
    pending = np.where(np.arange(COUNT) % 4 == 0, random.uniform(0.0, 1e5, COUNT), 0.0)
    return slab.Sea(PARAMS.freezing_temperature + np.where(pending > 0.0, 0.0, warm), pending)


def test_heat_to_the_ice_is_the_same():
    random = np.random.default_rng(5)
    sea = seas(random)
    friction = 10.0 ** random.uniform(-2.0, -0.7, COUNT)
    stored = 10.0 ** random.uniform(3.0, 9.0, COUNT)
    bottom, side = slab.heat_to_ice(sea, friction, stored, DT, PARAMS)
    store = P.heat_water * P.water_density * PARAMS.mixed_layer_depth / DT
    limited = 0
    for e in range(COUNT):
        temperature = float(sea.temperature[e]) - KELVIN
        potential = float(sea.pending_freeze[e]) / DT
        if potential <= 0.0:
            potential = max((FREEZING - temperature) * store, -P.largest_potential)
        wanted = ocean.heat_to_ice.py_func(
            temperature, FREEZING, potential, float(friction[e]), DT, P
        )
        found = ocean.limit.py_func(*wanted, -float(stored[e]), potential, DT)
        limited += found != wanted
        assert bottom[e] == pytest.approx(found[0], rel=1e-8, abs=1e-9)
        assert side[e] == pytest.approx(found[1], rel=1e-8, abs=1e-15)
    assert COUNT / 20 < limited < COUNT / 2


def still(temperature: float, light: float, air: Air, p: Physics) -> tuple[float, float]:
    """Fluxes into open water, of which there is none."""
    return 0.0, 0.0


def test_the_layer_after_a_step_is_the_same(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(ocean, "sea_balance", still)
    random = np.random.default_rng(6)
    sea = seas(random)
    heat, deep = random.uniform(-6e6, 2e6, COUNT), random.uniform(-200.0, 100.0, COUNT)
    after, taken = slab.mix(sea, heat, deep, DT, PARAMS)
    frozen = capped = mixed_down = 0
    for e in range(COUNT):
        layer = ocean.MixedLayer(
            float(sea.temperature[e]) - KELVIN, FREEZING, PARAMS.mixed_layer_depth, float(deep[e])
        )
        temperature, potential, *_, given = ocean.mix.py_func(
            layer, 0.0, 0.0, AIR, float(heat[e]) / DT, DT, P
        )
        assert after.temperature[e] - KELVIN == pytest.approx(temperature, abs=1e-10)
        assert after.pending_freeze[e] == pytest.approx(max(potential, 0.0) * DT, abs=1e-3)
        assert taken[e] == pytest.approx(given * DT, abs=1e-3)
        frozen += potential > 0.0
        capped += potential == P.largest_potential
        mixed_down += deep[e] < 0.0 and given > deep[e]
    assert min(frozen - capped, capped, mixed_down) > 10
