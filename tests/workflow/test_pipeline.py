# SPDX-License-Identifier: GPL-2.0-or-later
"""``smoke`` through the real pipeline, and what a second, changed or longer run redoes."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr

from floeflow.state import read_dataset, read_state
from support.runner import Done, Place

pytestmark = pytest.mark.workflow


def planned(place: Place, scene: Path) -> dict[str, int]:
    """Jobs that Snakemake would run, by rule."""
    done = place.run(scene, "-n")
    assert done.returncode == 0, done.stdout
    table = re.search(r"Job stats:\njob +count\n[- ]+\n(.*?)\n\n", done.stdout, re.S)
    if table is None:
        assert "Nothing to be done" in done.stdout
        return {}
    rows = (row.split() for row in table[1].splitlines())
    return {row[0]: int(row[1]) for row in rows if row[0] not in ("all", "total")}


def test_the_run_leaves_a_report_and_says_where(smoke: Done):
    assert f"Report: {smoke.results.resolve()}/report.html" in smoke.output
    text = (smoke.results / "report.html").read_text()
    assert text.lstrip().startswith("<!doctype html>") or text.lstrip().startswith(
        "<!DOCTYPE html>"
    )
    assert not re.search(r"""(src|href)=["'](?!data:|#)(https?:|/|\.)""", text), (
        "not self-contained"
    )


def test_windows_alternate_and_add_up(smoke: Done):
    states = [read_state(smoke.results / f"state/{w:04d}.nc") for w in range(4)]
    assert [s.attrs["window"] for s in states] == [0, 1, 2, 3]
    assert [s.attrs["time"] for s in states] == [0.0, 21600.0, 43200.0, 64800.0]
    for before, after in zip(states, states[1:], strict=False):
        mobile = before["type"].values == 1
        assert (before["x"].values != after["x"].values)[mobile].all()
        assert (before["ice_volume"].values != after["ice_volume"].values)[mobile].any()
        # Coast stays where it is.
        assert (before["x"].values == after["x"].values)[~mobile].all()


def test_the_area_of_the_ocean_belongs_to_somebody(smoke: Done):
    for window in range(4):
        state = read_state(smoke.results / f"state/{window:04d}.nc")
        owned = float(state["area"].values[state["type"].values == 1].sum())
        total = owned + state.attrs["unclaimed_water"]
        assert total == pytest.approx(state.attrs["ocean_area"], rel=1e-12)


def test_the_budgets_close(smoke: Done):
    for window in (1, 2, 3):
        s = read_dataset(smoke.results / f"series/{window:04d}.nc")
        for axis in "xy":
            impulses = [
                s[n].item() for n in s if str(n).startswith("impulse_") and n.endswith(axis)
            ]
            change = s[f"momentum_{axis}_end"].item() - s[f"momentum_{axis}_start"].item()
            assert abs(change - sum(impulses)) < 1e-9 * sum(abs(i) for i in impulses)
        assert s["ice_volume_dynamics"].item() == s["ice_volume_start"].item()
        growth = sum(s[n].item() for n in s if str(n).startswith("growth_"))
        change = s["ice_volume_end"].item() - s["ice_volume_dynamics"].item()
        assert change == pytest.approx(growth, abs=1e-12 * s["ice_volume_end"].item())
        gained = sum(
            s[n].item() for n in s if str(n).startswith("energy_") and n != "energy_stored"
        )
        assert s["energy_stored"].item() == pytest.approx(gained, rel=1e-9)


def test_the_grid_is_cf_and_bounded(smoke: Done):
    with xr.open_dataset(smoke.results / "grid/0003.nc") as grid:
        assert grid.attrs["Conventions"].startswith("CF-")
        siconc = grid["siconc"].values
        assert "grid_mapping" in grid["siconc"].encoding | grid["siconc"].attrs
        finite = siconc[siconc == siconc]
        assert finite.size and finite.min() >= 0.0 and finite.max() <= 1.0 + 1e-9
        for name in ("sithick", "sivol", "sisnthick", "siu", "siv"):
            assert name in grid


def test_costs_are_records(smoke: Done):
    records = json.loads((smoke.results / "cost/0001.json").read_text())
    by_name = {record["name"]: record for record in records}
    assert set(by_name) == {"setup", "dynamics", "column", "exchange"}
    assert by_name["dynamics"]["ranks"] == 2
    assert by_name["dynamics"]["element_steps_per_s"] > 0


def test_a_second_run_has_nothing_to_do(smoke: Done):
    assert planned(smoke.place, smoke.scene) == {}


def test_a_changed_plot_key_redoes_the_report_only(smoke: Done):
    scene = smoke.place.scene(report={"dpi": 90})
    assert planned(smoke.place, scene) == {"report": 1}
    smoke.place.scene()


def test_a_changed_law_redoes_the_windows_and_what_follows(smoke: Done):
    scene = smoke.place.scene(dynamics={"friction_coefficient": 0.1})
    jobs = planned(smoke.place, scene)
    smoke.place.scene()
    assert jobs == {"estimate": 1, "window": 3, "grid": 3, "diagnostics": 1, "report": 1}


def test_a_longer_run_redoes_no_window(copy: Callable[[], Place]):
    place = copy()
    scene = place.scene(time={"windows": 4})
    jobs = planned(place, scene)
    assert jobs == {
        "estimate": 1, "analytic": 1, "forcing": 1, "window": 1, "grid": 1, "diagnostics": 1,
        "report": 1,
    }  # fmt: skip
    before = read_state(place.results() / "state/0003.nc").attrs["checksum"]
    done = place.run(scene, "results/smoke/state/0004.nc")
    assert done.returncode == 0, done.stdout
    assert read_state(place.results() / "state/0003.nc").attrs["checksum"] == before
    assert read_state(place.results() / "state/0004.nc").attrs["window"] == 4


def test_windows_in_one_job_give_the_same_bits(smoke: Done, place: Place):
    scene = place.scene(workflow={"windows_per_job": 3})
    done = place.run(scene, "results/smoke/state/0003.nc")
    assert done.returncode == 0, done.stdout
    for window in (1, 2, 3):
        alone = read_state(smoke.results / f"state/{window:04d}.nc")
        grouped = read_state(place.results() / f"state/{window:04d}.nc")
        assert alone.attrs["checksum"] == grouped.attrs["checksum"]
