# SPDX-License-Identifier: GPL-2.0-or-later
"""One rank against two: the same bonds and positions at first, the same statistics later."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.core.plugin import plugin_path
from floeflow.coupling.chunk import Chunk, run_chunk
from floeflow.scene import load_scene
from floeflow.scene.windows import window_name
from floeflow.state import read_dataset, read_state
from support.runner import Done, Place

pytestmark = pytest.mark.workflow

SHORT = 6900.0  # s: a little over 1000 steps of 0.26 of the critical one


def restarted(smoke: Done, folder: Path, ranks: int, **changes: dict) -> Path:
    """Run the windows of the finished scene again, with changes, on so many ranks; its folder."""
    place = Place(folder)
    folder.mkdir()
    scene = load_scene(place.scene(**changes))
    made = smoke.results
    chunk = Chunk(
        scene=scene,
        folder=place.results(),
        windows=tuple(window_name(number + 1) for number in range(scene.time.windows)),
        state=made / "state/0000.nc",
        plugin=plugin_path(),
        ranks=ranks,
        mask=made / "preprocess/mask.nc",
    )
    assert run_chunk(chunk) == scene.time.windows
    return place.results()


def positions(state: xr.Dataset) -> np.ndarray:
    return np.column_stack([state["x"].values, state["y"].values])


def test_deterministic_windows_have_the_same_bits(smoke: Done, tmp_path: Path):
    # Long enough for bonds to break and their elements to touch.
    changes = {"time": {"windows": 2}, "dynamics": {"samples": 1, "deterministic": True}}
    one, two = (
        read_state(restarted(smoke, tmp_path / f"{ranks}", ranks, **changes) / "state/0002.nc")
        for ranks in (1, 2)
    )
    assert one.sizes["bond"] > 0 and one.sizes["contact"] > 0
    assert set(one.variables) == set(two.variables)
    for name in one.variables:
        np.testing.assert_array_equal(two[name].values, one[name].values, err_msg=name)


def test_the_first_thousand_steps_agree(smoke: Done, tmp_path: Path):
    changes = {
        "time": {"windows": 1, "window": SHORT},
        "forcing": {"step": SHORT},
        "dynamics": {"samples": 1, "step_share": 0.26, "stiffness": "full"},
    }
    states, steps = [], []
    for ranks in (1, 2):
        results = restarted(smoke, tmp_path / f"{ranks}", ranks, **changes)
        states.append(read_state(results / "state/0001.nc"))
        cost = json.loads((results / "cost/0001.json").read_text())
        steps += [r["steps"] for r in cost if r["name"] == "dynamics"]
        assert all(r["ranks"] == ranks for r in cost)
    one, two = states
    assert steps[0] == steps[1] >= 1000
    for name in ("bond_id_lo", "bond_id_hi"):
        assert np.array_equal(one[name].values, two[name].values)
    for name in ("bond_crack_a", "bond_crack_b"):
        a, b = one[name].values, two[name].values
        assert np.array_equal(a > 0, b > 0)
        # A crack's end is a displacement of some metres over its slope along the line: it is
        # known to fewer digits than the positions, which are millions of metres.
        assert a == pytest.approx(b, abs=1e-6)
    start = read_state(smoke.results / "state/0000.nc")
    broken = start.sizes["bond"] - one.sizes["bond"]
    cracked = np.count_nonzero(one["bond_crack_a"].values + one["bond_crack_b"].values)
    assert broken + cracked > 0, "nothing cracked, so nothing was compared"
    scale = np.abs(positions(one)).max()
    assert np.abs(positions(one) - positions(two)).max() <= 1e-9 * scale


def test_later_the_statistics_agree(smoke: Done, tmp_path: Path):
    folders = (restarted(smoke, tmp_path / "1", 1), smoke.results)
    start = read_state(smoke.results / "state/0000.nc")
    one, two = (read_state(folder / "state/0003.nc") for folder in folders)
    mobile = start["type"].values == 1
    drift = [
        np.linalg.norm((positions(end) - positions(start))[mobile], axis=1) for end in (one, two)
    ]
    assert drift[0].mean() == pytest.approx(drift[1].mean(), rel=0.02)
    broken = [start.sizes["bond"] - end.sizes["bond"] for end in (one, two)]
    # Bonds break one by one: their number scatters as its square root.
    assert abs(broken[0] - broken[1]) <= 3.0 * np.sqrt(max(broken))
    ends = [read_dataset(folder / "series/0003.nc") for folder in folders]
    volumes = [end["ice_volume_end"].values[-1] for end in ends]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-4)
