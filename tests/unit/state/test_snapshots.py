# SPDX-License-Identifier: GPL-2.0-or-later
"""Snapshots: rows of many boundaries in one file come apart again as they were."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.state.snapshots import (
    join_snapshots,
    read_snapshots,
    snapshot,
    split_snapshots,
    write_snapshots,
)
from unit.state.test_state import a_state


def boundary(window: int, elements: int, corners: bool) -> xr.Dataset:
    """A state with layers, bonds and contacts; where asked with an outline for every element."""
    state = a_state(("wind", "bonds", "thermodynamics", "snow"), n=elements)
    state["x"].values[:] += 100.0 * window
    state.attrs |= {"window": window, "time": 60.0 * window, "checksum": f"{window:064x}"}
    state.attrs |= {"unclaimed_water": 1.0 + window, "column_scheme": "zero_layer"}
    if corners:
        count = np.arange(3, 3 + elements, dtype=np.int64)
        state["cell_corners"] = ("element", count)
        for name in ("corner_x", "corner_y"):
            state[name] = ("corner", np.arange(count.sum()) + 0.5 * window)
    return state


def same(part: xr.Dataset, state: xr.Dataset) -> None:
    """Variables to the last bit, and what the attributes of a boundary say."""
    kept = snapshot(state)
    assert set(part.data_vars) == set(kept.data_vars)
    for name in kept.data_vars:
        assert part[name].dims == kept[name].dims and part[name].dtype == kept[name].dtype
        assert part[name].values.tobytes() == kept[name].values.tobytes(), name
    for name in ("window", "time", "ocean_area", "unclaimed_water", "checksum", "scene", "crs"):
        assert part.attrs[name] == state.attrs[name], name
        assert type(part.attrs[name]) is type(state.attrs[name]), name


@pytest.mark.parametrize("corners", [False, True])
@pytest.mark.parametrize("counts", [(4,), (4, 4, 4), (5, 2, 7), (3, 1)])
def test_boundaries_come_back_from_a_file(tmp_path: Path, counts: tuple[int, ...], corners: bool):
    states = [boundary(k, n, corners) for k, n in enumerate(counts)]
    write_snapshots(states, tmp_path / "0003.nc")
    found = list(read_snapshots([tmp_path / "0003.nc"]))
    assert len(found) == len(states)
    for part, state in zip(found, states, strict=True):
        same(part, state)
    # What comes back can be laid together again.
    again = list(split_snapshots(join_snapshots(found)))
    for part, state in zip(again, states, strict=True):
        same(part, state)


def test_a_snapshot_has_no_pairs_and_no_layers():
    kept = snapshot(boundary(1, 4, corners=True))
    assert set(kept.sizes) <= {"element", "category", "corner"}
    assert {"x", "ice_volume", "snow_volume", "corner_x"} <= set(kept.data_vars)


def test_boundaries_without_elements_are_boundaries(tmp_path: Path):
    states = [
        boundary(k, 3, corners=False).isel(element=slice(0, n), bond=slice(0, 0))
        for k, n in enumerate((0, 3, 0))
    ]
    write_snapshots(states, tmp_path / "0003.nc")
    found = list(read_snapshots([tmp_path / "0003.nc"]))
    assert [part.sizes["element"] for part in found] == [0, 3, 0]


def test_files_follow_each_other_and_a_missing_one_is_named(tmp_path: Path):
    write_snapshots([boundary(1, 4, False), boundary(2, 3, False)], tmp_path / "0002.nc")
    write_snapshots([boundary(3, 2, False)], tmp_path / "0003.nc")
    paths = [tmp_path / "0002.nc", tmp_path / "0003.nc"]
    assert [part.attrs["window"] for part in read_snapshots(paths)] == [1, 2, 3]
    paths[1].unlink()
    with pytest.raises(FloeError, match="0003.nc: there is no such file"):
        list(read_snapshots(paths))
