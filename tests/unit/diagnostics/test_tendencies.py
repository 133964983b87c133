# SPDX-License-Identifier: GPL-2.0-or-later
"""Tendencies by process add up to what the states say."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from floeflow.core.constants import ICE_DENSITY
from floeflow.diagnostics.diagnostics import diagnose
from floeflow.diagnostics.tendencies import MASS, tendencies
from support.synthetic import WINDOW, Run


def series(**terms: float) -> xr.Dataset:
    columns = {name: ("window", np.array([value, 2.0 * value])) for name, value in terms.items()}
    return xr.Dataset(columns, coords={"window": [1, 2]})


def test_mass_and_area_are_dealt_to_their_processes():
    scalars = series(
        growth_base=5.0, growth_melt_top=-2.0, growth_sublimation=-0.5, export_ice_volume_left=1.0,
        growth_melt_base=-1.5, growth_new_ice=0.75, growth_dissolved=-0.5, sea_melted_back=0.25,
        ice_area_start=100.0, ice_area_end=90.0, ice_area_grown=-2.0, ice_area_dissolved=-1.0,
    )  # fmt: skip
    found = tendencies(scalars, 50.0, 10.0)
    per = ICE_DENSITY / 500.0
    for name, value in (
        ("sidmassgrowthbot", 5.0),
        ("sidmassmelttop", -2.0),
        ("sidmassevapsubl", 0.5),
        # New ice that melted back is none; what else dissolved melted from below.
        ("sidmassgrowthwat", 0.5),
        ("sidmassmeltbot", -1.75),
        ("sidmassth", 1.25),
        ("sidmassdyn", -1.0),
    ):
        np.testing.assert_allclose(found[name], [value * per, 2.0 * value * per], err_msg=name)
    # 10 m2 went, 3 of them by melt.
    assert found["sidconcth"].values[0] == pytest.approx(-3.0 / 500.0)
    assert found["sidconcdyn"].values[0] == pytest.approx(-7.0 / 500.0)
    assert "sidmasslat" not in found


def test_a_run_gains_what_its_tendencies_say(run: Run):
    data, _ = diagnose(run.files, run.scene.effects, run.scene.domain)
    volume, sea = data["ice_volume"].values, data["ocean_area"].values[0]
    gained = (data["sidmassth"] + data["sidmassdyn"]).values * sea * WINDOW / ICE_DENSITY
    np.testing.assert_allclose(gained, np.diff(volume), rtol=1e-9)
    assert set(MASS) & set(data.variables)


def test_without_growth_there_is_motion_alone():
    found = tendencies(series(ice_area_start=1.0, ice_area_end=1.0), 5.0, 1.0)
    assert set(found.data_vars) == {"sidmassdyn"}
    assert not tendencies(series(ice_area_start=0.0), 0.0, 1.0).data_vars
