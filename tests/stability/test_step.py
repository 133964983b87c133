# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 2: time steps up to the limit and beyond it.

What must hold: below the critical step no energy grows out of nothing, for any pack, stiffness and
damping; bonded packs blow up not far above it, so that it wastes little; the default step is at
least 60 % of the largest that holds; and what diverges is stopped, with the element named.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from packs import PACKS, neighbours, shaken
from watch import watch

from floeflow.config.blocks import Dynamics
from floeflow.dynamics.bondtable import Arrays
from floeflow.dynamics.energycheck import stored_energy
from floeflow.dynamics.engine import Engine, EngineError, EngineParams
from floeflow.dynamics.timestep import critical_step
from floeflow.errors import FloeError
from floeflow.studies.stability_figure import stability_map

# Contacts hardly matter, so that the bonds' limit is seen alone at any stiffness.
LAWS = EngineParams(
    time_step=1.0,
    bonds=True,
    bond_damping=0.1,
    contact_modulus=1.0,
    compressive_strength=1e8,
    friction=False,
)
STEPS, LOOKS = 3000, 15
DEFAULT = Dynamics().step_share


def growth(log: Path, pack: Arrays, bonds: Arrays, params: EngineParams) -> float:
    """Largest energy over the first; infinite where the run is stopped."""
    with Engine(MPI.COMM_SELF, params, log) as engine:
        engine.load(pack, bonds)
        first = largest = stored_energy(engine.diagnostics())
        for _ in range(LOOKS):
            try:
                engine.run(STEPS // LOOKS)
            except EngineError:
                return np.inf
            largest = max(largest, stored_energy(engine.diagnostics()))
            if not largest < 10.0 * first:
                return np.inf
    return largest / first


def setting(
    name: str, damping: float = 0.1, young: float = 1e9
) -> tuple[Arrays, Arrays, EngineParams, float]:
    """A shaken pack, its bonds, its laws and its critical step."""
    pack = shaken(PACKS[name](), 1e-5)
    laws = replace(
        LAWS, bond_damping=damping, young_modulus=young, compressive_strength=0.1 * young
    )
    bonds = neighbours(pack)
    return pack, bonds, laws, critical_step(pack, bonds, laws)[0]


def largest_stable(log: Path, name: str, damping: float, young: float = 1e9) -> float:
    """Largest share of the critical step at which energy does not grow, to 2 %."""
    pack, bonds, laws, critical = setting(name, damping, young)
    low, high = 0.5, 2.5
    while high > 1.02 * low:
        middle = np.sqrt(low * high)
        grown = growth(log, pack, bonds, replace(laws, time_step=middle * critical))
        low, high = (middle, high) if grown < 10.0 else (low, middle)
    return float(low)


@pytest.mark.parametrize("damping", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("name", PACKS)
def test_below_the_critical_step_no_energy_grows(log: Path, name: str, damping: float):
    pack, bonds, laws, critical = setting(name, damping)
    grown = growth(log, pack, bonds, replace(laws, time_step=0.97 * critical))
    # Without damping the energy swings by what leapfrog's own differs from it.
    assert grown < (10.0 if damping == 0.0 else 1.5)


def test_the_limit_goes_with_the_root_of_the_stiffness(log: Path):
    soft, hard = (setting("lattice", 0.0, young)[3] for young in (1e7, 1e9))
    assert soft / hard == pytest.approx(10.0, rel=0.02)


@pytest.mark.parametrize("name", ["lattice", "random"])
def test_the_default_step_is_most_of_the_largest_stable_one(log: Path, name: str, record):
    found = largest_stable(log, name, 0.1)
    record(largest_stable_share=found, default_over_largest=DEFAULT / found)
    assert found > 0.95
    assert DEFAULT / found >= 0.6


@pytest.mark.slow
def test_the_stability_map(log: Path, record, show):
    """Every pack, stiffness and damping: where the largest stable step lies."""
    dampings, youngs = (0.0, 0.05, 0.1, 0.3, 1.0), (1e7, 1e9)
    found = {
        (name, young): [largest_stable(log, name, damping, young) for damping in dampings]
        for name in PACKS
        for young in youngs
    }
    every = np.array(list(found.values()))
    at_default = every[:, dampings.index(0.1)]
    record(least=every.min(), most=every.max(), default_over_largest=DEFAULT / at_default.max())
    lines = [[name, young, shares] for (name, young), shares in found.items()]
    record(map={"dampings": dampings, "lines": lines, "default": DEFAULT})
    show("stability_map", stability_map, found, dampings, DEFAULT)
    assert every.min() > 0.95
    assert DEFAULT / at_default.max() >= 0.6


@pytest.mark.parametrize("name", ["chain", "lattice", "random"])
def test_what_diverges_is_stopped_and_named(log: Path, name: str):
    """Bonds break under their own motion, and the rest looks calm: the budget knows."""
    pack, bonds, laws, critical = setting(name, 0.1)
    laws = replace(laws, time_step=2.0 * critical)
    with pytest.raises(FloeError, match=r"(out of nothing|ran away|non-finite).*element \d+"):
        watch(log, pack, laws, 20000 * laws.time_step, bonds)
