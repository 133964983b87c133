# SPDX-License-Identifier: GPL-2.0-or-later
"""Mushy ice with CCSM3 light against recorded columns of Icepack."""

from pathlib import Path

import numpy as np

from floeflow.column.layered import ice_residual, salt_residual, sea_residual, step, water_residual
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

CASE = "mushy_n1_ccsm3"


def test_one_category_step_by_step(shared: Path) -> None:
    data = open_case(shared, CASE, "state_y01.nc")
    p, before = physics(shared, CASE), starts(data)
    after, sums = step(before, each_step(data), DT, category_bounds(1), p)
    assert worst(after.ice_fraction, data["s2_aicen"].values[1:]) < 1e-12
    assert worst(after.ice_volume, data["s2_vicen"].values[1:]) < 1e-10
    assert worst(after.snow_volume, data["s2_vsnon"].values[1:]) < 1e-9
    assert worst(after.surface_temperature, data["s2_Tsfc"].values[1:]) < 1e-4
    assert worst(after.ice_enthalpy, data["s2_qice"].values[1:]) < 1.0  # of 3e8 J/m3
    assert worst(after.ice_salinity, data["s2_sice"].values[1:]) < 1e-8
    assert worst(after.sea_temperature, data["sst_end"].values[1:]) < 1e-9
    for ours, theirs in {
        "growth": "congel",
        "melt_top": "meltt",
        "melt_bottom": "meltb",
        "melt_lateral": "meltl",
        "new_ice": "frazil",
    }.items():
        assert worst(sums[ours], data[theirs].values[1:]) < 1e-10, ours
    assert np.abs(ice_residual(before, after, sums)).max() < 1e-8 * DT
    assert np.abs(sea_residual(before, after, sums, 20.0, p)).max() < 1e-8 * DT
    assert np.abs(salt_residual(before, after, sums)).max() < 1e-13
    assert max(np.abs(part).max() for part in water_residual(before, after, sums)) < 1e-14


def test_ten_years_run_freely(shared: Path) -> None:
    data = open_case(shared, CASE, "state_y01.nc")
    state, p = first(data), physics(shared, CASE)
    forcing, bounds = year(open_case(shared, CASE, "forcing_y01.nc")), category_bounds(1)
    last = open_case(shared, CASE, "state_last.nc")
    volume, salinity = [], []
    for day in range(10 * YEAR):
        hour = 24 * (day % YEAR)
        state, _ = step(state, forcing[hour : hour + 24], DT, bounds, p)
        volume.append(state.ice_volume.sum())
        salinity.append(state.ice_salinity[0, 0])
    theirs = open_case(shared, CASE, "agg_daily_all.nc")["s2_vice"].values
    # Asked: 1 %, 2 cm, and 0.3 of salinity.
    assert abs(np.mean(volume[-YEAR:]) / theirs[-YEAR:].mean() - 1.0) < 1e-5
    assert np.sqrt(np.mean((np.array(volume) - theirs) ** 2)) < 1e-4
    recorded = last["s2_sice"].values[23::24, 0]
    assert worst(np.array(salinity[-YEAR:]), recorded) < 1e-2
