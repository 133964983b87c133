# SPDX-License-Identifier: GPL-2.0-or-later
"""``smoke`` through the real pipeline, and what a second, changed or longer run redoes."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.scene import load_scene, stage_hash
from floeflow.state import read_dataset, read_state
from floeflow.state.snapshots import BONDED, bonded_length, read_snapshots, snapshot
from support.kills import start_over
from support.runner import Done, Place, bits, digest

pytestmark = pytest.mark.workflow


def test_the_run_leaves_a_report_and_says_where(smoke: Done):
    assert f"Report: {smoke.results.resolve()}/report.html" in smoke.output
    # What was expected of the run before it began, and what it took.
    assert re.search(r"^Expected: \d+ elements, \d windows of 6 h in ", smoke.output, re.M)
    assert re.search(r"^Took .* \(expected: .*\) and .* on disk", smoke.output, re.M)
    text = (smoke.results / "report.html").read_text()
    assert text.lstrip().startswith("<!doctype html>") or text.lstrip().startswith(
        "<!DOCTYPE html>"
    )
    assert not re.search(r"""(src|href)=["'](?!data:|#)(https?:|/|\.)""", text), (
        "not self-contained"
    )


def boundaries(results: Path) -> list[xr.Dataset]:
    """Elements at all boundaries."""
    return [read_state(results / "state/0000.nc"), *read_snapshots([results / "elements/0003.nc"])]


def test_windows_alternate_and_add_up(smoke: Done):
    states = boundaries(smoke.results)
    assert [s.attrs["window"] for s in states] == [0, 1, 2, 3]
    assert [s.attrs["time"] for s in states] == [0.0, 21600.0, 43200.0, 64800.0]
    for before, after in zip(states, states[1:], strict=False):
        mobile = before["type"].values == 1
        assert (before["x"].values != after["x"].values)[mobile].all()
        assert (before["ice_volume"].values != after["ice_volume"].values)[mobile].any()
        # Coast stays where it is.
        assert (before["x"].values == after["x"].values)[~mobile].all()


def test_the_last_snapshot_is_the_state(smoke: Done):
    state, last = read_state(smoke.results / "state/0003.nc"), boundaries(smoke.results)[-1]
    assert last.attrs["checksum"] == state.attrs["checksum"]
    np.testing.assert_array_equal(last[BONDED].values, bonded_length(state))
    grown = {name for name, variable in last.data_vars.items() if variable.dims == ("grown",)}
    for name in set(last.data_vars) - {BONDED} - grown:
        assert last[name].values.tobytes() == state[name].values.tobytes(), name


def test_the_area_of_the_ocean_belongs_to_somebody(smoke: Done):
    for state in boundaries(smoke.results):
        owned = float(state["area"].values[state["type"].values == 1].sum())
        total = owned + state.attrs["unclaimed_water"]
        assert total == pytest.approx(state.attrs["ocean_area"], rel=1e-12)


def test_the_budgets_close(smoke: Done):
    whole = read_dataset(smoke.results / "series/0003.nc")
    assert whole["window"].values.tolist() == [1, 2, 3]
    for place in range(3):
        s = whole.drop_dims("sample").isel(window=place)
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
    with xr.open_dataset(smoke.results / "grid.nc") as grid:
        assert grid.attrs["Conventions"].startswith("CF-")
        assert grid["window"].values.tolist() == [0, 1, 2, 3]
        assert (grid["time"].diff("time").values > 0).all()
        siconc = grid["siconc"].values
        assert "grid_mapping" in grid["siconc"].encoding | grid["siconc"].attrs
        finite = siconc[siconc == siconc]
        assert finite.size and finite.min() >= 0.0 and finite.max() <= 100.0 + 1e-7
        for name in ("sithick", "sivol", "sisnthick", "siu", "siv"):
            assert name in grid


def test_tendencies_are_what_the_columns_and_the_states_say(smoke: Done):
    """Over the grid, growth is that of the series, and with motion the change of the ice."""
    scalars = read_dataset(smoke.results / "series/0003.nc").drop_dims("sample")
    with (
        xr.open_dataset(smoke.results / "tendencies.nc", decode_times=False) as made,
        xr.open_dataset(smoke.results / "grid.nc", decode_times=False) as grid,
    ):
        assert made["window"].values.tolist() == [1, 2, 3]
        np.testing.assert_array_equal(made["time_bnds"][:, 1], grid["time"][1:])
        area = made["sea_area"]
        for name, terms in (
            ("sidmassth", [n for n in scalars if str(n).startswith("growth_")]),
            ("sidmassgrowthbot", ["growth_base"]),
            ("sidmassmelttop", ["growth_melt_top"]),
            ("sidconcth", ["ice_area_grown"]),
        ):
            density = 1.0 if name == "sidconcth" else 917.0
            wanted = density * sum(scalars[term].values for term in terms)
            found = 21600.0 * (made[name] * area).sum(("y", "x")).values
            size = 21600.0 * float(abs(made["sidmassth"] * area).sum())
            np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12 * size, err_msg=name)
        assert float(abs(made["sidmassgrowthbot"]).max()) > 0.0
        total = 21600.0 * (made["sidmassth"] + made["sidmassdyn"])
        np.testing.assert_allclose(total, grid["simass"].diff("time"), atol=1e-9)
        # Motion makes and takes no ice: what it moves is back on the grid elsewhere.
        moved = (made["sidmassdyn"] * area).sum(("y", "x"))
        assert float(abs(moved).max()) < 1e-9 * float(abs(made["sidmassdyn"] * area).sum())


def test_costs_are_records(smoke: Done):
    records = json.loads((smoke.results / "cost/0003.json").read_text())
    for window in (1, 2, 3):
        by_name = {record["name"]: record for record in records if record["window"] == window}
        assert set(by_name) == {"forcing", "setup", "dynamics", "column", "exchange"}
        assert by_name["dynamics"]["ranks"] == 2
        assert by_name["dynamics"]["element_steps_per_s"] > 0
    for rule in ("mask", "packing", "windows-0003", "report"):
        spent = json.loads((smoke.results / f"cpu/{rule}.json").read_text())
        assert spent["cpu_seconds"] > 0


def test_a_second_run_has_nothing_to_do(smoke: Done):
    assert smoke.place.planned(smoke.scene) == {}


def test_a_changed_plot_key_redoes_the_report_only(smoke: Done):
    scene = smoke.place.scene(file="plot.yaml", report={"dpi": 90})
    assert smoke.place.planned(scene) == {"report": 1}


def test_a_changed_law_redoes_the_windows_and_what_follows(smoke: Done):
    scene = smoke.place.scene(file="law.yaml", dynamics={"friction_coefficient": 0.1})
    assert smoke.place.planned(scene) == {
        "estimate": 1, "windows": 1, "fields": 1, "grid": 1, "tendencies": 1,
        "diagnostics": 1, "report": 1,
    }  # fmt: skip


def test_a_longer_run_takes_the_windows_of_a_chunk_that_was_not_full(
    smoke: Done, copy: Callable[[], Place]
):
    place = copy()
    scene = place.scene(time={"windows": 4})
    assert place.planned(scene) == {
        "estimate": 1, "windows": 1, "fields": 1, "grid": 1, "tendencies": 1,
        "diagnostics": 1, "report": 1,
    }  # fmt: skip
    done = place.run(scene, "results/smoke/state/0004.nc")
    assert done.returncode == 0, done.stdout
    assert "window 0004: step" in done.stdout and "window 0003: step" not in done.stdout
    # Whoever reads all files of a folder counts each window once.
    for kind in ("series", "elements", "fields", "cost"):
        assert not list((place.results() / kind).glob("0003.*")), kind
    made = bits(place.results())
    assert list(made) == [1, 2, 3, 4] and bits(smoke.results).items() <= made.items()
    assert read_state(place.results() / "state/0004.nc").attrs["window"] == 4


def test_windows_in_jobs_of_their_own_give_the_same_bits(smoke: Done, copy: Callable[[], Place]):
    place = copy()
    start_over(place)
    scene = place.scene(workflow={"windows_per_job": 1})
    done = place.run(scene, "results/smoke/state/0003.nc")
    assert done.returncode == 0, done.stdout
    assert bits(place.results()) == bits(smoke.results)
    ends = [read_state(results / "state/0003.nc") for results in (place.results(), smoke.results)]
    assert digest(ends[0]) == digest(ends[1])


def test_all_states_stay_where_they_are_wanted(smoke: Done, copy: Callable[[], Place]):
    place = copy()
    scene = place.scene(state={"keep": "all"})
    # What stays is no result: nothing that follows from the windows' results is planned alone.
    assert "windows" in place.planned(scene)
    done = place.run(scene, "results/smoke/state/0003.nc")
    assert done.returncode == 0, done.stdout
    states = [read_state(place.results() / f"state/{window:04d}.nc") for window in (1, 2, 3)]
    found = {window: digest(snapshot(state)) for window, state in enumerate(states, 1)}
    # What froze and melted in a window is no part of its state.
    kept = read_snapshots(sorted((smoke.results / "elements").glob("*.nc")))
    assert found == {int(part.attrs["window"]): digest(part.drop_dims("grown")) for part in kept}


def test_the_manifest_says_what_the_run_was_made_from(smoke: Done):
    said = json.loads((smoke.results / "manifest.json").read_text())
    state = read_state(smoke.results / "state/0003.nc")
    provenance = json.loads(state.attrs["provenance"])
    assert said["ranks"] == 2 and said["seed"] == said["scene"]["seed"]
    assert said["last_state"] == {"window": "0003", "hash": provenance["window"]}
    assert said["plugin"] == provenance["plugin"]
    assert said["code"]["windows"] == provenance["library"]
    (mask,) = said["inputs"]
    content = (smoke.place.folder / mask).read_bytes()
    assert said["inputs"] == {mask: hashlib.sha256(content).hexdigest()}
    assert {"python", "numpy", "floeflow", "snakemake"} <= set(said["versions"])
    assert {"mask", "windows/0003", "report"} <= set(said["timings"])
    assert all(job["seconds"] > 0 for job in said["timings"].values())


def test_a_run_is_repeated_from_its_manifest(smoke: Done, place: Place):
    scene = place.folder / "again.yaml"
    scene.write_text(json.dumps(json.loads((smoke.results / "manifest.json").read_text())["scene"]))
    assert place.run(scene, "-n").returncode == 0
    hashes = [stage_hash(load_scene(path), "dynamics") for path in (scene, smoke.scene)]
    assert hashes[0] == hashes[1]
