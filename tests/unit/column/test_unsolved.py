# SPDX-License-Identifier: GPL-2.0-or-later
"""Temperatures that do not converge are counted, and stop a run where they are no solution."""

from dataclasses import replace

import numpy as np
import pytest

from floeflow.column.layered import LayeredState, pack_forcing, step
from floeflow.column.layered_run import budget_terms
from floeflow.column.physics import Physics
from floeflow.column.thermodynamics.enthalpy import ice_enthalpy, salinity_profile
from floeflow.column.thickness.categories import category_bounds
from floeflow.column.unsolved import UnsolvedError

P = Physics()
HOUR = 3600.0
# One step of a method that needs about five: no solution, as by a fault of the method.
STUCK = P._replace(iterations=0, fallback_iterations=1)


def ice(count: int = 3) -> LayeredState:
    """Columns of 2 m of ice at -10 degC."""
    shape = (count, 1)
    salinity = salinity_profile(7, P)
    cold = [ice_enthalpy.py_func(-10.0, -P.melting_slope * s, P) for s in salinity]
    return LayeredState(
        np.ones(shape), np.full(shape, 2.0), np.zeros(shape), np.full(shape, -10.0),
        np.broadcast_to(cold, (*shape, 7)), np.zeros((*shape, 1)),
        np.broadcast_to(salinity, (*shape, 7)), np.full(count, -1.8), np.zeros(count),
    )  # fmt: skip


def sky(count: int = 3, air: float = 240.0) -> np.ndarray:
    """One step of a clear winter sky."""
    values = {
        "potential_temperature": air, "humidity": 2e-4, "density": 1.4, "wind": 8.0,
        "longwave": 150.0, "visible": 0.0, "infrared": 0.0, "snowfall": 0.0,
        "sea_salinity": 34.0, "deep_heat": 2.0, "mixed_depth": 20.0, "ocean_friction": 0.005,
    }  # fmt: skip
    return pack_forcing({name: np.array(value) for name, value in values.items()}, 1, count)


@pytest.mark.parametrize("stuck", [STUCK, P._replace(mushy=True, mush_iterations=1)])
def test_temperatures_that_are_no_solution_stop_the_run(stuck: Physics) -> None:
    with pytest.raises(UnsolvedError, match="in 3 of 3 columns, first in column 0: they still"):
        step(ice(), sky(), HOUR, category_bounds(1), stuck)
    # The same columns have a solution.
    _, sums = step(ice(), sky(), HOUR, category_bounds(1), stuck._replace(**limits(P)))
    assert sums["unconverged"].sum() == sums["failed"].sum() == 0 and sums["solves"].sum() == 3


def limits(p: Physics) -> dict[str, int]:
    """How often the methods may iterate."""
    names = ("iterations", "fallback_iterations", "mush_iterations")
    return {name: getattr(p, name) for name in names}


def test_what_is_short_of_the_tolerance_but_near_is_counted() -> None:
    # Four steps leave less than a thousandth of a kelvin, more than the tolerance of 1e-9 K.
    near = STUCK._replace(fallback_iterations=4)
    _, sums = step(ice(), sky(), HOUR, category_bounds(1), near)
    assert (sums["unconverged"] == 1).all() and (sums["failed"] == 0).all()
    terms = budget_terms(sums, near)
    assert terms["temperature_unconverged"].sum() == terms["temperature_rescued"].sum() == 3


@pytest.mark.parametrize("mushy", [False, True])
def test_what_is_not_a_number_is_no_solution(mushy: bool) -> None:
    before = ice()
    enthalpy = before.ice_enthalpy.copy()
    enthalpy[1, 0, 6] = np.nan
    with pytest.raises(UnsolvedError, match="in 1 of 3 columns, first in column 1"):
        step(
            replace(before, ice_enthalpy=enthalpy), sky(), HOUR, category_bounds(1),
            P._replace(mushy=mushy),
        )  # fmt: skip
