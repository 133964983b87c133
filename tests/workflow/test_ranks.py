# SPDX-License-Identifier: GPL-2.0-or-later
"""One rank against two: the same bonds and positions at first, the same statistics later."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

from floeflow.state import read_dataset, read_state
from support.runner import Done, Place

pytestmark = pytest.mark.workflow

SHORT = 9000.0  # s: a little over 1000 steps of 0.26 of the critical one


def restarted(copy: Callable[[], Place], ranks: int, **changes: dict) -> tuple[Place, str]:
    """Run the windows of a copied scene again, on so many ranks."""
    place = copy()
    for folder in ("state", "series", "elements", "cost", ".windows"):
        for path in (place.results() / folder).iterdir():
            if path.name != "0000.nc":
                shutil.rmtree(path) if path.is_dir() else path.unlink()
    scene = place.scene(**changes)
    windows = changes.get("time", {}).get("windows", 3)
    last = f"results/smoke/state/{windows:04d}.nc"
    done = place.run(scene, last, ranks=ranks)
    assert done.returncode == 0, done.stdout
    return place, last


def positions(state: xr.Dataset) -> np.ndarray:
    return np.column_stack([state["x"].values, state["y"].values])


def test_deterministic_windows_have_the_same_bits(smoke: Done, copy: Callable[[], Place]):
    changes = {
        "time": {"windows": 2, "window": SHORT / 2},
        "forcing": {"step": SHORT / 2},
        "dynamics": {"samples": 1, "deterministic": True},
    }
    states = []
    for ranks in (1, 2):
        place, last = restarted(copy, ranks, **changes)
        states.append(read_state(place.folder / last).load())
        shutil.rmtree(place.folder)
    one, two = states
    assert one.sizes["bond"] > 0 and one.sizes["contact"] > 0
    assert set(one.variables) == set(two.variables)
    for name in one.variables:
        np.testing.assert_array_equal(two[name].values, one[name].values, err_msg=name)


def test_the_first_thousand_steps_agree(smoke: Done, copy: Callable[[], Place]):
    changes = {
        "time": {"windows": 1, "window": SHORT},
        "forcing": {"step": SHORT},
        "dynamics": {"samples": 1, "step_share": 0.26, "stiffness": "full"},
    }
    states, steps = [], []
    for ranks in (1, 2):
        place, last = restarted(copy, ranks, **changes)
        states.append(read_state(place.folder / last))
        cost = json.loads((place.results() / "cost/0001.json").read_text())
        steps += [r["steps"] for r in cost if r["name"] == "dynamics"]
        assert all(r["ranks"] == ranks for r in cost)
        shutil.rmtree(place.folder)
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


def test_later_the_statistics_agree(smoke: Done, copy: Callable[[], Place]):
    place, last = restarted(copy, 1)
    start = read_state(smoke.results / "state/0000.nc")
    one, two = read_state(place.folder / last), read_state(smoke.place.folder / last)
    mobile = start["type"].values == 1
    drift = [
        np.linalg.norm((positions(end) - positions(start))[mobile], axis=1) for end in (one, two)
    ]
    assert drift[0].mean() == pytest.approx(drift[1].mean(), rel=0.02)
    broken = [start.sizes["bond"] - end.sizes["bond"] for end in (one, two)]
    # Bonds break one by one: their number scatters as its square root.
    assert abs(broken[0] - broken[1]) <= 3.0 * np.sqrt(max(broken))
    ends = [read_dataset(p.results() / "series/0003.nc") for p in (place, smoke.place)]
    volumes = [end["ice_volume_end"].values[-1] for end in ends]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-4)
