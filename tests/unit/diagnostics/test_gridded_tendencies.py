# SPDX-License-Identifier: GPL-2.0-or-later
"""Tendencies on the grid: the table's names, sums that close, growth where the ice grew."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from floeflow.core.constants import ICE_DENSITY
from floeflow.core.errors import FloeError
from floeflow.coupling.growth import growth_places, without
from floeflow.coupling.sea.ice import Returned
from floeflow.diagnostics.cf_output import join_times, write_grid
from floeflow.diagnostics.gridded import make_grid
from floeflow.diagnostics.gridded_tendencies import TENDENCIES, growth_on_grid, make_tendencies
from floeflow.state.snapshots import join_snapshots, split_snapshots
from floeflow.transfer import open_room
from unit.diagnostics.test_gridded import ALL, GRID, make_mask, make_state, scene_of

# Standard name and unit in the CMIP6 table SImon, data request 01.00.31
# (github.com/PCMDI/cmip6-cmor-tables, Tables/CMIP6_SImon.json).
AMOUNT = "tendency_of_sea_ice_amount_due_to_"
SHARE = "tendency_of_sea_ice_area_fraction_due_to_"
SIMON = {
    "sidmassgrowthbot": (f"{AMOUNT}congelation_ice_accumulation", "kg m-2 s-1"),
    "sidmassgrowthwat": (f"{AMOUNT}frazil_ice_accumulation_in_leads", "kg m-2 s-1"),
    "sidmasssi": (f"{AMOUNT}conversion_of_snow_to_sea_ice", "kg m-2 s-1"),
    "sidmassmelttop": (f"{AMOUNT}surface_melting", "kg m-2 s-1"),
    "sidmassmeltbot": (f"{AMOUNT}basal_melting", "kg m-2 s-1"),
    "sidmasslat": (f"{AMOUNT}lateral_melting", "kg m-2 s-1"),
    "sidmassevapsubl": ("water_evapotranspiration_flux", "kg m-2 s-1"),
    "sidmassth": (f"{AMOUNT}sea_ice_thermodynamics", "kg m-2 s-1"),
    "sidmassdyn": (f"{AMOUNT}sea_ice_dynamics", "kg m-2 s-1"),
    "sidconcth": (f"{SHARE}thermodynamics", "s-1"),
    "sidconcdyn": (f"{SHARE}dynamics", "s-1"),
}
DAY = 86400.0
# Metres of ice a window on the whole area, and the share of area that is under ice more.
TERMS = {
    "growth_base": 0.02,
    "growth_new_ice": 0.004,
    "growth_snow_ice": 0.001,
    "growth_melt_top": -0.003,
    "growth_melt_base": -0.002,
    "growth_melt_lateral": -0.001,
    "growth_sublimation": -0.0005,
    "ice_area_grown": 0.01,
}


def grown(state: xr.Dataset, window: int, drift: float = 0.0) -> xr.Dataset:
    """The state after a window: it drifts along x (m), all of it grows by the terms."""
    mobile = state["type"].values == 1
    area = state["area"].values[mobile]
    after = state.copy(deep=True)
    after["x"] = ("element", state["x"].values + drift * mobile)
    growth = sum(value for name, value in TERMS.items() if name.startswith("growth_"))
    after["ice_volume"][mobile] += growth
    after["ice_fraction"][mobile] += TERMS["ice_area_grown"]
    each = {name: area * value for name, value in TERMS.items()}
    made = growth_places(after, (each,), (), None)
    after.attrs |= {"window": window, "time": DAY * window}
    return after.assign({name: ("grown", values) for name, values in made.items()})


def run(folder: Path, drift: float) -> tuple[xr.Dataset, xr.Dataset]:
    """Gridded fields and tendencies of two windows, as they are read from their files."""
    scene, mask = scene_of(folder, ALL), make_mask(2)
    states = [make_state(right=2.0e5, left=-3.0e5)]
    states[0].attrs |= {"window": 0, "time": 0.0}
    for window in (1, 2):
        bare = states[-1].drop_dims("grown", errors="ignore")
        states.append(grown(bare, window, drift))
    fields = join_times([make_grid(scene, state, mask) for state in states])
    write_grid(fields, folder / "grid.nc")
    snapshots = split_snapshots(join_snapshots(states[1:]))
    made = make_tendencies(scene, folder / "grid.nc", mask, snapshots)
    write_grid(made, folder / "tendencies.nc")
    with (
        xr.open_dataset(folder / "grid.nc", decode_times=False) as grid,
        xr.open_dataset(folder / "tendencies.nc", decode_times=False) as found,
    ):
        return grid.load(), found.load()


@pytest.fixture(scope="module")
def moving(tmp_path_factory: pytest.TempPathFactory) -> tuple[xr.Dataset, xr.Dataset]:
    return run(tmp_path_factory.mktemp("moving"), 2.0e4)


def test_names_and_units_are_those_of_the_table(moving, tmp_path_factory):
    _, made = moving
    assert {name: (each.standard_name, each.units) for name, each in TENDENCIES.items()} == SIMON
    assert set(SIMON) <= set(made.data_vars)
    for name, (standard_name, unit) in SIMON.items():
        said = made[name].attrs
        assert (said["standard_name"], said["units"]) == (standard_name, unit)
        assert said["cell_methods"] == "area: mean where sea time: mean"
        for other in (said["grid_mapping"], said["cell_measures"].split(": ")[1]):
            assert other in made.variables
    np.testing.assert_array_equal(made["time_bnds"], [[0.0, DAY], [DAY, 2 * DAY]])
    np.testing.assert_array_equal(made["time"], [0.5 * DAY, 1.5 * DAY])
    assert made["time"].attrs["bounds"] == "time_bnds" and made["lat"].dims == ("y", "x")


def test_terms_add_up_to_the_change_of_mass_and_concentration(moving):
    grid, made = moving
    parts = [name for name in SIMON if name.startswith("sidmass")]
    parts = [name for name in parts if name not in ("sidmassth", "sidmassdyn", "sidmassevapsubl")]
    total = sum(made[name] for name in parts) - made["sidmassevapsubl"]
    sea = made["sea_area"].values > 0.0
    np.testing.assert_allclose(total, made["sidmassth"], rtol=1e-12)
    assert np.isfinite(made["sidmassth"].values[:, sea]).all()
    assert np.isnan(made["sidmassth"].values[:, ~sea]).all()
    for change, thermal, dynamic, scale in (
        ("simass", "sidmassth", "sidmassdyn", 1.0),
        ("siconc", "sidconcth", "sidconcdyn", 100.0),
    ):
        came = scale * DAY * (made[thermal] + made[dynamic])
        np.testing.assert_allclose(came, grid[change].diff("time"), atol=1e-9)


def test_growth_on_the_grid_is_all_growth_and_motion_makes_none(moving):
    grid, made = moving
    area, sea = float(make_state(right=2.0e5, left=-3.0e5)["area"].sum()), made["sea_area"]
    for name, term, factor in (
        ("sidmassgrowthbot", "growth_base", ICE_DENSITY),
        ("sidmassevapsubl", "growth_sublimation", -ICE_DENSITY),
        ("sidconcth", "ice_area_grown", 1.0),
    ):
        found = DAY * (made[name] * sea).sum(("y", "x"))
        np.testing.assert_allclose(found, factor * TERMS[term] * area, rtol=1e-9, err_msg=name)
    moved = (made["sidmassdyn"] * sea).sum(("y", "x"))
    size = float(abs(made["sidmassdyn"] * sea).sum())
    assert size > 0.0 and float(abs(moved).max()) < 1e-9 * size


def test_ice_that_lies_still_has_no_dynamics(tmp_path: Path):
    """Growth goes to the cells as the ice itself does: nothing of it looks like motion."""
    _, made = run(tmp_path, 0.0)
    for thermal, dynamic in (("sidmassth", "sidmassdyn"), ("sidconcth", "sidconcdyn")):
        largest = float(abs(made[thermal]).max())
        assert float(abs(made[dynamic]).max()) < 0.02 * largest, dynamic


def test_what_melts_back_is_taken_from_its_own_place():
    state = make_state()
    places = growth_places(state, ({"growth_new_ice": np.ones(256)},), (), None)
    x, y = places["grown_x"][[3, 7]], places["grown_y"][[3, 7]]
    back = Returned(x, y, np.array([0.25, 2.0]), np.array([0.5, 4.0]), np.array([True, False]))
    left = without(places, back)
    assert left["growth_new_ice"][3] == 0.75 and left["growth_new_ice"].sum() == 255.75
    assert left["growth_melt_base"][7] == -2.0 and left["growth_melt_base"].sum() == -2.0
    assert left["ice_area_grown"][[3, 7]].tolist() == [-0.5, -4.0]


def test_crowded_elements_lose_no_growth():
    """Elements that claim twice the sea that there is: the cells are full, and have it all."""
    x, y = (axis.ravel() for axis in np.meshgrid(GRID.x, GRID.y))
    area = np.full(x.size, 2.0e10)
    places = {"grown_x": x, "grown_y": y, "grown_area": area, "growth_base": 0.1 * area}
    found = growth_on_grid(places, open_room(GRID))
    assert found["growth_base"].sum() == pytest.approx(0.1 * area.sum(), rel=1e-12)


def test_a_file_of_another_run_is_refused(tmp_path: Path):
    scene, mask, state = scene_of(tmp_path, ALL), make_mask(), make_state()
    state.attrs |= {"window": 0, "time": 0.0}
    write_grid(make_grid(scene, state, mask), tmp_path / "grid.nc")
    with pytest.raises(FloeError, match=r"grid\.nc: it does not hold the end of window 1"):
        make_tendencies(scene, tmp_path / "grid.nc", mask, [grown(state, 1)])
    with netCDF4.Dataset(tmp_path / "grid.nc", "a") as data:
        data.renameVariable("simass", "other")
    with pytest.raises(FloeError, match=r"grid\.nc: variable 'simass' is missing"):
        make_tendencies(scene, tmp_path / "grid.nc", mask, [])
