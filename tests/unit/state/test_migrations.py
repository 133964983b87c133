# SPDX-License-Identifier: GPL-2.0-or-later
"""States of older schema versions: read where they can be, else refused with a reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.state import SCHEMA_VERSION, read_state, write_dataset
from floeflow.state.migrations import MIGRATIONS, migrate
from unit.state.test_state import a_state


def test_each_version_leads_to_the_next():
    assert sorted(MIGRATIONS) == list(range(1, SCHEMA_VERSION))


def test_a_state_of_version_1_is_read(tmp_path: Path):
    old = a_state()
    old.attrs["schema_version"] = 1
    write_dataset(old, tmp_path / "old.nc")
    back = read_state(tmp_path / "old.nc")
    assert back.attrs["schema_version"] == SCHEMA_VERSION
    for name in old.variables:
        np.testing.assert_array_equal(back[name], old[name])
    assert old.attrs["schema_version"] == 1


def test_a_sea_of_each_element_is_refused_with_the_reason(tmp_path: Path):
    old = a_state()
    old.attrs["schema_version"] = 1
    old["sea_temperature"] = ("element", np.full(old.sizes["element"], 271.3))
    write_dataset(old, tmp_path / "old.nc")
    with pytest.raises(FloeError, match=r"old\.nc: its mixed layer is kept per element .* anew"):
        read_state(tmp_path / "old.nc")


@pytest.mark.parametrize("version", [0, SCHEMA_VERSION + 1, "two", [1, 2]])
def test_other_versions_are_named(version: object):
    with pytest.raises(FloeError, match="reads versions 1 to"):
        migrate(xr.Dataset(attrs={"schema_version": version}))
