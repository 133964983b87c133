# SPDX-License-Identifier: GPL-2.0-or-later
"""What a checkout alone can compare with the references: their digests in ``tests/data``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.column.layered import ice_residual, sea_residual, step
from floeflow.column.thickness.categories import category_bounds
from support.column.reference_columns import DT, each_step, open_case, physics, starts, worst
from support.reference_digests import COLUMNS, PAIRS, STEPS, digests
from verification.contact.test_verify_pairs import MODES, demsi_breaks
from verification.contact.test_verify_single import DRAG, drift_beside_demsi


@pytest.fixture
def kept(project: Path) -> Path:
    """Folder of the digests."""
    return project / "tests/data"


def test_digests_are_those_of_the_references(kept: Path, shared: Path) -> None:
    for path, made in digests(shared).items():
        if isinstance(made, str):
            assert (kept / path).read_text() == made, path
            continue
        with xr.open_dataset(kept / path, decode_times=False) as found:
            assert set(found.variables) == set(made.variables)
            for name in made.variables:
                np.testing.assert_array_equal(found[name].values, made[name].values, err_msg=path)


def test_digests_are_small(kept: Path) -> None:
    sizes = [path.stat().st_size for path in (kept / "reference").rglob("*") if path.is_file()]
    assert len(sizes) > 10 and sum(sizes) < 1_000_000


@pytest.mark.parametrize("case", COLUMNS)
def test_hours_of_a_year_beside_icepack(kept: Path, case: str) -> None:
    """Single steps from its states; the bars are those of the comparison with every hour."""
    data = open_case(kept, case, "state_y01.nc")
    p, before = physics(kept, case), starts(data)
    after, sums = step(before, each_step(data), DT, category_bounds(1), p)
    # Between one pair of hours and the next lie weeks.
    some = np.diff(data["istep"].values) == 1
    assert some.sum() == STEPS
    fine = 2e-8 if case.startswith("bl99") else 1e-10
    for ours, theirs, bar in (
        (after.ice_fraction, "s2_aicen", fine),
        (after.ice_volume, "s2_vicen", fine),
        (after.snow_volume, "s2_vsnon", 1e-9),
        (after.surface_temperature, "s2_Tsfc", 1e-4),
        (after.ice_enthalpy, "s2_qice", 1.0),
        (after.sea_temperature, "sst_end", 1e-9),
        (sums["growth"], "congel", fine),
        (sums["melt_top"], "meltt", fine),
        (sums["melt_bottom"], "meltb", fine),
        (sums["melt_lateral"], "meltl", fine),
        (sums["new_ice"], "frazil", fine),
    ):
        assert worst(ours[some], data[theirs].values[1:][some]) < bar, theirs
    for residual in (ice_residual(before, after, sums), sea_residual(before, after, sums, 20.0, p)):
        assert np.abs(residual[some]).max() < 1e-8 * DT
    # All seasons are there: it grows and melts.
    assert (sums["growth"][some] > 0).any() and (sums["melt_top"][some] > 0).any()


@pytest.mark.parametrize("name", MODES)
def test_bonds_break_where_demsis_do(kept: Path, name: str) -> None:
    assert set(MODES) == set(PAIRS)
    demsi_breaks(kept, name)


@pytest.mark.parametrize("name", DRAG)
def test_drift_from_rest_beside_demsi(log: Path, kept: Path, name: str) -> None:
    drift_beside_demsi(log, kept, name)
