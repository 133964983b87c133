# SPDX-License-Identifier: GPL-2.0-or-later
"""Mushy ice under light of many directions, with ponds, against recorded columns of Icepack."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.column.layered import (
    LayeredState,
    ice_residual,
    pond_residual,
    salt_residual,
    sea_residual,
    step,
    take,
    water_residual,
)
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

CASE = "mushy_n5_dEdd_pondlvl"
POND = 1e-3  # m of water on the ice, from which on it counts as ponded


@pytest.mark.parametrize("month", ["winter", "summer"])
def test_five_categories_step_by_step(shared: Path, month: str) -> None:
    data = open_case(shared, CASE, f"state_y01_{month}.nc")
    p, before = physics(shared, CASE), starts(data)
    after, sums = step(before, each_step(data), DT, category_bounds(5), p)
    assert worst(after.ice_fraction, data["s2_aicen"].values[1:]) < 5e-11
    assert worst(after.ice_volume, data["s2_vicen"].values[1:]) < 5e-11
    # What is left is the tolerance of their surface temperature.
    assert worst(after.snow_volume, data["s2_vsnon"].values[1:]) < 5e-7
    assert worst(after.surface_temperature, data["s2_Tsfc"].values[1:]) < 1e-3
    assert worst(after.ice_enthalpy, data["s2_qice"].values[1:]) < 100.0  # of 3e8 J/m3
    assert worst(after.ice_salinity, data["s2_sice"].values[1:]) < 1e-7
    assert worst(after.level_area, data["s2_alvl"].values[1:]) < 1e-15
    assert worst(after.level_volume, data["s2_vlvl"].values[1:]) < 1e-15
    assert worst(after.pond_depth, data["s2_hpnd"].values[1:]) < 2e-7
    assert worst(after.pond_lid, data["s2_ipnd"].values[1:]) < 1e-12
    assert worst(after.lid_share, data["ffracn"].values[1:]) < 1e-12
    # A melt of round-off gives their ponds an area in the cold: only water is compared.
    theirs = data["s2_apnd"].values[1:] * data["s2_hpnd"].values[1:]
    assert worst(after.pond_area * after.pond_depth, theirs) < 2e-7

    # The step after sunrise is left out: the reference has no light to scale there.
    lit = data["scale_factor_used"].values[1:] != 1.0
    light = (sums["light_absorbed"] + sums["light_to_sea"]) / DT
    assert lit.sum() > (300 if month == "winter" else 700)
    assert worst(light[lit], data["fswabs"].values[1:][lit]) < 1e-11
    assert worst(sums["light_to_sea"][lit] / DT, data["fswthru"].values[1:][lit]) < 1e-12
    assert worst(sums["melt_top"], data["meltt"].values[1:]) < 1e-12
    assert worst(sums["melt_bottom"], data["meltb"].values[1:]) < 1e-12
    assert worst(sums["growth"], data["congel"].values[1:]) < 5e-11

    assert np.abs(ice_residual(before, after, sums)).max() < 1e-8 * DT
    assert np.abs(sea_residual(before, after, sums, 20.0, p)).max() < 1e-8 * DT
    assert np.abs(salt_residual(before, after, sums)).max() < 1e-13
    assert np.abs(pond_residual(before, after, sums)).max() < 1e-15
    assert max(np.abs(part).max() for part in water_residual(before, after, sums)) < 1e-14


def ponded(state: LayeredState) -> float:
    """Water on the ice (m)."""
    area = state.ice_fraction * state.level_area * state.pond_area
    return float((area * state.pond_depth).sum() / state.ice_fraction.sum())


def recorded_onset(data: xr.Dataset) -> int:
    """First recorded day with ponds."""
    area = data["s2_aicen"] * data["s2_alvl"] * data["s2_apnd"]
    water = ((area * data["s2_hpnd"]).sum("ncat") / data["s2_aice"]).values
    assert water[0] < POND  # they form in the recorded month
    return int((data["istep"].values[np.argmax(water > POND)] - 1) // 24) % YEAR


def showing(light: np.ndarray, sun: np.ndarray) -> int:
    """First day on which ponds show: what ice and snow absorb of the light turns up in July."""
    share = light[180:230] / sun[180:230]
    return 181 + int(np.argmax(np.diff(share) > 0.01))


def test_ten_years_run_freely(shared: Path) -> None:
    state = first(open_case(shared, CASE, "state_y01_winter.nc"))
    p, bounds = physics(shared, CASE), category_bounds(5)
    forcing = year(open_case(shared, CASE, "forcing_y01.nc"))
    daily = open_case(shared, CASE, "agg_daily_all.nc")
    volume, area, snow, water, light, flooded = np.zeros((6, 10 * YEAR))
    for day in range(10 * YEAR):
        hour = 24 * (day % YEAR)
        before, _ = step(state, forcing[hour : hour + 23], DT, bounds, p)
        state, sums = step(before, forcing[hour + 23 : hour + 24], DT, bounds, p)
        assert abs(ice_residual(before, state, sums)[0]) < 1e-8 * DT
        volume[day], area[day] = state.ice_volume.sum(), state.ice_fraction.sum()
        snow[day], water[day] = state.snow_volume.sum(), ponded(state)
        flooded[day] = sums["snow_ice"][0]
        light[day] = (sums["light_absorbed"] + sums["light_to_sea"])[0] / DT
    theirs = daily["s2_vice"].values
    last = slice(-YEAR, None)
    # Asked: 3 %, seasonal maximum and minimum within 5 cm.
    assert abs(volume[last].mean() / theirs[last].mean() - 1.0) < 0.03
    assert abs(volume[last].max() - theirs[last].max()) < 0.05
    assert abs(volume[last].min() - theirs[last].min()) < 0.05
    # Before the first ponds show all is as tight as without them.
    assert worst(volume[:195], theirs[:195]) < 1e-4
    assert worst(area, daily["s2_aice"].values) < 0.01
    assert worst(snow, daily["s2_vsno"].values) < 1e-3

    # Snow floods on a month of days in the first autumn, the only ones that are recorded.
    recorded = daily["snoice"].values[:YEAR]
    assert np.array_equal(flooded[:YEAR] > 0.0, recorded > 0.0) and (recorded > 0.0).sum() == 30
    assert abs(flooded[:YEAR].sum() / recorded.sum() - 1.0) < 0.02

    # Asked: onset of ponds within 5 days, here that of their water and of their sight.
    onset = int(np.argmax(water[:YEAR] > POND))
    assert abs(onset - recorded_onset(open_case(shared, CASE, "state_y01_summer.nc"))) <= 1
    sun = open_case(shared, CASE, "forcing_y01.nc")["fsw"].values[23::24]
    for n in (0, 9):
        part = slice(n * YEAR, (n + 1) * YEAR)
        shows = showing(light[part], sun)
        assert abs(shows - showing(daily["fswabs"].values[part], sun)) <= 5
        assert 190 < shows < 215


def test_a_slice_gives_the_same_bits(shared: Path) -> None:
    data = open_case(shared, CASE, "state_y01_summer.nc")
    p, before, forcing = physics(shared, CASE), starts(data), each_step(data)
    whole, _ = step(before, forcing, DT, category_bounds(5), p)
    part = slice(301, 399)
    alone, _ = step(take(before, part), forcing[:, part], DT, category_bounds(5), p)
    assert np.array_equal(alone.pond_depth, whole.pond_depth[part])
    assert np.array_equal(alone.ice_enthalpy, whole.ice_enthalpy[part])
