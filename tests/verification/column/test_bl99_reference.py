# SPDX-License-Identifier: GPL-2.0-or-later
"""BL99 with CCSM3 light against recorded columns of Icepack, step by step and in free runs."""

from pathlib import Path

import numpy as np
import pytest

from floeflow.column.layered import ice_residual, sea_residual, step
from floeflow.column.thickness.categories import category_bounds
from support.column.reference_columns import (
    DT,
    YEAR,
    each_step,
    first,
    open_case,
    physics,
    starts,
    worst,
    year,
)


def test_one_category_step_by_step(shared: Path) -> None:
    data = open_case(shared, "bl99_n1_ccsm3", "state_y01.nc")
    p, before = physics(shared, "bl99_n1_ccsm3"), starts(data)
    after, sums = step(before, each_step(data), DT, category_bounds(1), p)
    recorded = {name: data[f"s2_{name}"].values[1:] for name in ("aicen", "vicen", "vsnon")}
    thickness = after.ice_volume / after.ice_fraction
    error = np.abs(thickness - recorded["vicen"] / recorded["aicen"])
    # Asked: 2e-6 m in 99.9 % of the steps, 0.01 K. What is left is the tolerance of their solver.
    assert len(error) == YEAR * 24 - 1
    assert error.max() < 2e-8
    assert worst(after.surface_temperature, data["s2_Tsfc"].values[1:]) < 1e-4
    assert worst(after.ice_fraction, recorded["aicen"]) < 1e-8
    assert worst(after.snow_volume, recorded["vsnon"]) < 1e-9
    assert worst(after.ice_enthalpy, data["s2_qice"].values[1:]) < 1.0  # of 3e8 J/m3
    assert worst(after.sea_temperature, data["sst_end"].values[1:]) < 1e-9
    freezing = np.maximum(data["frzmlt_end"].values[1:], 0.0) * DT
    assert worst(after.pending_freeze, freezing) < 0.01
    for ours, theirs in {
        "growth": "congel",
        "melt_top": "meltt",
        "melt_bottom": "meltb",
        "melt_lateral": "meltl",
        "new_ice": "frazil",
        "snow_ice": "snoice",
    }.items():
        assert worst(sums[ours], data[theirs].values[1:]) < 2e-8, ours
    # The step after sunrise is left out: the reference has no light to scale there.
    lit = data["scale_factor_used"].values[1:] != 1.0
    assert lit.sum() > 7000
    through = data["fswthru"].values[1:] * DT
    assert worst(sums["light_to_sea"][lit], through[lit]) < 1e-6
    assert sums["rescued"].sum() == 0
    assert np.abs(ice_residual(before, after, sums)).max() < 1e-8 * DT
    assert np.abs(sea_residual(before, after, sums, 20.0, p)).max() < 1e-8 * DT


@pytest.mark.parametrize("month", ["winter", "summer"])
def test_five_categories_step_by_step(shared: Path, month: str) -> None:
    data = open_case(shared, "bl99_n5_ccsm3", f"state_y01_{month}.nc")
    p, before = physics(shared, "bl99_n5_ccsm3"), starts(data)
    after, sums = step(before, each_step(data), DT, category_bounds(5), p)
    # Asked: 1e-4 of the cell.
    assert worst(after.ice_fraction, data["s2_aicen"].values[1:]) < 5e-8
    assert worst(after.ice_volume, data["s2_vicen"].values[1:]) < 5e-8
    assert worst(after.snow_volume, data["s2_vsnon"].values[1:]) < 5e-9
    assert worst(after.surface_temperature, data["s2_Tsfc"].values[1:]) < 1e-4
    assert np.abs(ice_residual(before, after, sums)).max() < 1e-8 * DT


@pytest.mark.parametrize("categories", [1, 5])
def test_ten_years_run_freely(shared: Path, categories: int) -> None:
    case = f"bl99_n{categories}_ccsm3"
    start = "state_y01.nc" if categories == 1 else "state_y01_winter.nc"
    state, p = first(open_case(shared, case, start)), physics(shared, case)
    # The forcing of the last year is that of the first: the years repeat.
    forcing = year(open_case(shared, case, "forcing_y01.nc"))
    last = year(open_case(shared, case, "forcing_last.nc"))
    assert np.abs(last - forcing).max() < 1e-9
    bounds = category_bounds(categories)
    ours = []
    for day in range(10 * YEAR):
        hour = 24 * (day % YEAR)
        before = state
        state, sums = step(state, forcing[hour : hour + 24], DT, bounds, p)
        assert abs(ice_residual(before, state, sums)[0]) < 24 * 1e-8 * DT
        ours.append((state.ice_volume.sum(), state.ice_fraction.sum(), state.snow_volume.sum()))
    daily = open_case(shared, case, "agg_daily_all.nc")
    volume, area, snow = np.array(ours).T
    theirs = daily["s2_vice"].values
    # Asked: 0.5 % and 1 cm with one category, 1 % and 2 cm with five.
    assert abs(volume[-YEAR:].mean() / theirs[-YEAR:].mean() - 1.0) < 1e-4
    assert np.sqrt(np.mean((volume - theirs) ** 2)) < 1e-4
    assert worst(area, daily["s2_aice"].values) < 1e-4
    assert worst(snow, daily["s2_vsno"].values) < 1e-4


def test_the_two_solvers_agree(shared: Path) -> None:
    data = open_case(shared, "bl99_n1_ccsm3", "state_y01.nc")
    p, before, forcing = physics(shared, "bl99_n1_ccsm3"), starts(data), each_step(data)
    bounds = category_bounds(1)
    after, _ = step(before, forcing, DT, bounds, p)
    fallback, sums = step(before, forcing, DT, bounds, p._replace(iterations=0))
    assert sums["rescued"].sum() == sums["solves"].sum() > 0
    assert worst(fallback.surface_temperature, after.surface_temperature) < 1e-3
    assert worst(fallback.ice_volume, after.ice_volume) < 2e-8
    assert np.abs(ice_residual(before, fallback, sums)).max() < 1e-8 * DT
