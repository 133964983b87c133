# SPDX-License-Identifier: GPL-2.0-or-later
"""Diagnostics on a synthetic run whose budgets close, and on spoiled copies of it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.diagnostics.budgets import Limits, relative, verdict
from floeflow.diagnostics.collect import (
    cell_area,
    displacement,
    read_cost,
    read_grid,
    summarise_grid,
)
from floeflow.diagnostics.diagnostics import diagnose, write_json
from floeflow.state import read_dataset, read_state, write_dataset
from support.scripts import load_script
from support.synthetic import WINDOW, Run, make_run


@pytest.fixture
def copy(run: Run, tmp_path: Path) -> Run:
    shutil.copytree(run.root, tmp_path / "copy")
    return Run(tmp_path / "copy", run.scene_file, run.scene, run.windows)


def results(run: Run) -> tuple[xr.Dataset, dict]:
    return diagnose(run.files, run.scene.effects, run.scene.domain)


def budget(numbers: dict, name: str) -> dict:
    return next(each for each in numbers["budgets"] if each["name"] == name)


def test_budgets_of_an_intact_run_close(run: Run):
    data, numbers = results(run)
    names = {each["name"] for each in numbers["budgets"]}
    assert names == {
        "momentum_x",
        "momentum_y",
        "ice_volume",
        "ice_volume_dynamics",
        "snow_volume",
        "column_energy",
        "dem_energy",
        "grid_ice_area",
        "grid_ice_volume",
        "grid_snow_volume",
    }
    assert [each["verdict"] for each in numbers["budgets"]] == ["closed"] * len(names)
    assert np.all(data["ice_volume_relative"].values < 1e-14)


def test_totals_are_those_of_the_states(run: Run):
    data, numbers = results(run)
    last = read_state(run.state(3))
    volume = float((last["area"] * last["ice_volume"].sum("category")).sum())
    assert data["ice_volume"].values[-1] == pytest.approx(volume, rel=1e-14)
    assert numbers["headline"]["ice_volume_end"] == data["ice_volume"].values[-1]
    assert data["boundary_time"].values.tolist() == [0, WINDOW, 2 * WINDOW, 3 * WINDOW]
    first = read_state(run.state(0))
    mobile = last["type"].values == 1
    step = np.hypot(last["x"] - first["x"], last["y"] - first["y"]).values
    drift = np.average(step[mobile], weights=last["area"].values[mobile])
    assert numbers["headline"]["mean_drift_km"] == pytest.approx(drift / 1e3, rel=1e-12)
    assert numbers["headline"]["largest_drift_km"] == pytest.approx(step.max() / 1e3, rel=1e-12)


def test_broken_bonds_are_counted_over_all_windows(run: Run):
    _, numbers = results(run)
    pairs = [
        set(zip(s["bond_id_lo"].values, s["bond_id_hi"].values, strict=True))
        for s in (read_state(run.state(window)) for window in (0, 3))
    ]
    lost = pairs[0] - pairs[1]
    assert len(lost) > 5
    assert numbers["headline"]["bonds_broken"] == len(lost)


def test_bond_that_heals_in_a_later_window_still_broke(copy: Run):
    before = results(copy)[1]["headline"]["bonds_broken"]
    path = copy.chunk_of("series", 1)
    series = read_dataset(path)
    # One more breaks in window 1, and is there again when window 2 starts.
    series["intact_bonds"].values[np.flatnonzero(series["sample_window"] == 1)[-1]] -= 1
    write_dataset(series, path)
    assert results(copy)[1]["headline"]["bonds_broken"] == before + 1


def test_cost_adds_up(run: Run):
    _, numbers = results(run)
    steps, elements = 3 * 4000, read_state(run.state(0)).sizes["element"]
    assert numbers["headline"]["element_steps"] == steps * elements
    assert numbers["window_seconds"]["dynamics"] == pytest.approx(1.0 + 1.1 + 1.2)
    speed = steps * elements / 3.3
    assert numbers["headline"]["element_steps_per_s"] == pytest.approx(speed)


def test_spoiled_impulse_is_found_in_its_window(copy: Run):
    copy.change_series(2, "impulse_wind_y", 5.0e9)
    data, numbers = results(copy)
    found = budget(numbers, "momentum_y")
    assert found["worst_window"] == 2
    assert found["residual"] == pytest.approx(-5.0e9, rel=1e-4)
    series = read_dataset(copy.chunk_of("series", 2)).sel(window=2)
    terms = [n for n in series if str(n).startswith("impulse_")]
    scale = sum(abs(float(series[n])) for n in terms if str(n).endswith("_y"))
    assert found["relative"] == pytest.approx(5.0e9 / scale, rel=1e-4)
    assert found["verdict"] == "open"
    assert budget(numbers, "momentum_x")["verdict"] == "closed"
    assert data["momentum_y_residual"].values[[0, 2]] == pytest.approx([0, 0], abs=1.0)


def test_faults_of_opposite_sign_do_not_cancel(copy: Run):
    copy.change_series(1, "energy_ocean", 1.0e15)
    copy.change_series(2, "energy_ocean", -1.0e15)
    found = budget(results(copy)[1], "column_energy")
    assert abs(found["residual"]) < 1e6
    assert found["verdict"] == "open"


def test_volume_lost_in_the_dynamics_opens_its_budget(copy: Run):
    copy.change_series(3, "ice_volume_dynamics", -1.0e3)
    found = budget(results(copy)[1], "ice_volume_dynamics")
    assert found["change"] == pytest.approx(-1.0e3, rel=1e-3)
    assert found["verdict"] == "open"


def test_state_that_lost_ice_opens_the_volume_budget(copy: Run):
    def lose(state: xr.Dataset) -> None:
        state["ice_volume"] = state["ice_volume"] * (1.0 - 1e-7)

    copy.change_elements(2, lose)
    found = budget(results(copy)[1], "ice_volume")
    assert found["verdict"] == "fair"
    assert found["relative"] == pytest.approx(1e-7, rel=0.05)


def test_grid_that_lost_ice_opens_its_budget(copy: Run):
    grid = read_grid(copy.grid)
    grid["siconc"].values[3] *= 0.9
    grid.to_netcdf(copy.grid)
    found = budget(results(copy)[1], "grid_ice_area")
    assert found["relative"] == pytest.approx(0.1)
    assert (found["verdict"], found["worst_window"]) == ("open", 3)


def test_ice_that_has_left_the_grid_is_a_term_of_its_budget(copy: Run):
    """Half of the ice off the grid, and said so: the budget closes as it did before."""
    before = budget(results(copy)[1], "grid_ice_area")
    grid = read_grid(copy.grid)
    left = np.array([0.0, 0.0, 0.0, 0.5])
    total = (grid["siconc"] * cell_area(grid, copy.grid)).sum(("y", "x")).values
    grid["siarea_outside"] = ("time", left * total)
    grid["siconc"].values[:] *= 1.0 - left[:, None, None]
    grid.to_netcdf(copy.grid)
    found = budget(results(copy)[1], "grid_ice_area")
    assert found["verdict"] == before["verdict"]
    assert found["relative"] == pytest.approx(before["relative"], abs=1e-12)


def test_grid_totals_take_the_named_area_and_per_cent(tmp_path: Path):
    attrs = {"units": "%", "cell_measures": "area: sea"}
    grid = xr.Dataset(
        {
            "siconc": (("time", "y", "x"), [[[50.0, np.nan]], [[25.0, 0.0]]], attrs),
            "sea": (("y", "x"), [[4.0, 8.0]]),
            "cell_area": (("y", "x"), [[10.0, 10.0]]),
            "window": ("time", [7, 8]),
        },
        coords={"x": [0.0, 1.0], "y": [0.0], "time": [0.0, 1.0]},
    )
    grid.to_netcdf(tmp_path / "grid.nc")
    totals = summarise_grid(tmp_path / "grid.nc")
    assert totals["grid_ice_area"].values.tolist() == [2.0, 1.0]
    assert totals["grid_window"].values.tolist() == [7, 8]


def test_only_what_the_effects_bring(tmp_path: Path):
    run = make_run(tmp_path, effects=("wind", "ocean_drag"), windows=2)
    data, numbers = results(run)
    names = {str(name) for name in data.variables}
    assert not [name for name in names if "bond" in name or "snow" in name or "growth" in name]
    assert not [name for name in names if "coriolis" in name or "tilt" in name]
    assert "column_energy" not in {each["name"] for each in numbers["budgets"]}
    assert not [name for name in numbers["headline"] if "bond" in name or "snow" in name]
    assert set(budget(numbers, "momentum_x")["terms"]) == {"wind", "ocean", "coast"}


def test_no_ice_gives_zeros_and_no_nan(tmp_path: Path):
    run = make_run(tmp_path, windows=2, elements=False)
    data, numbers = results(run)
    for name, values in data.data_vars.items():
        if values.dtype.kind == "f":
            assert np.isfinite(values.values).all(), name
    assert numbers["headline"]["elements"] == 0
    assert numbers["headline"]["mean_drift_km"] == 0.0
    assert {each["verdict"] for each in numbers["budgets"]} == {"closed"}
    json.dumps(numbers, allow_nan=False)


@pytest.mark.parametrize(
    "kind, suffix", [("series", ".nc"), ("elements", ".nc"), ("cost", ".json")]
)
def test_missing_file_is_one_sentence(copy: Run, kind: str, suffix: str):
    path = copy.chunk_of(kind, 2, suffix)
    path.unlink()
    with pytest.raises(FloeError) as fault:
        results(copy)
    assert str(path) in str(fault.value)
    assert "\n" not in str(fault.value)


def test_missing_variable_names_file_and_variable(copy: Run):
    path = copy.chunk_of("series", 3)
    write_dataset(read_dataset(path).drop_vars("impulse_tilt_x"), path)
    with pytest.raises(FloeError, match="0003.nc: variable 'impulse_tilt_x' is missing"):
        results(copy)


@pytest.mark.parametrize("text", ["", "{}}", '[{"name": "dynamics"}]', "3"])
def test_broken_cost_file_is_named(copy: Run, text: str):
    path = copy.chunk_of("cost", 1, ".json")
    path.write_text(text)
    with pytest.raises(FloeError, match="0002.json: is not a list of benchmark records"):
        read_cost([path])


def test_damaged_grid_is_named(copy: Run):
    copy.grid.write_bytes(b"no NetCDF")
    with pytest.raises(FloeError, match="grid.nc: cannot be read as NetCDF"):
        results(copy)


def test_the_rule_joins_all_chunks(copy: Run):
    folder, files = copy.folder, copy.files
    given = SimpleNamespace(
        input=SimpleNamespace(
            scene=str(copy.scene_file),
            first=str(files.first),
            elements=list(map(str, files.elements)),
            series=list(map(str, files.series)),
            cost=list(map(str, files.cost)),
            grid=str(files.grid),
            last=str(copy.state(3)),
        ),
        output=SimpleNamespace(
            dataset=str(folder / "diagnostics.nc"),
            headline=str(folder / "diagnostics.json"),
            analyses=str(folder / "analyses.nc"),
        ),
    )
    load_script("postprocess/diagnostics").main(given)
    data = read_dataset(folder / "diagnostics.nc")
    expected, numbers = results(copy)
    assert data["window"].values.tolist() == [1, 2, 3]
    # Which coordinates are indices is not kept in the file.
    xr.testing.assert_equal(
        data.reset_coords().drop_vars("stage"), expected.reset_coords().drop_vars("stage")
    )
    assert json.loads((folder / "diagnostics.json").read_text()) == numbers


def test_displacement_is_of_elements_in_both_states(run: Run):
    first, last = read_state(run.state(0)), read_state(run.state(3))
    fewer = last.isel(element=slice(5, None))
    moved, step = displacement(first, fewer)
    assert moved["id"].values[0] == 6
    assert set(moved["type"].values) == {1}
    whole = displacement(first, last)[1]
    np.testing.assert_array_equal(step, whole[5:])


def test_relative_residual():
    ratios = relative(np.array([0.0, 1.0, -2.0, 0.0]), np.array([0.0, 0.0, 4.0, 3.0]))
    assert ratios.tolist() == [0.0, np.inf, 0.5, 0.0]
    limits = Limits(1e-8, 1e-4)
    words = [verdict(value, limits) for value in (0.0, 1e-8, 1e-5, 1e-3, np.inf)]
    assert words == ["closed", "closed", "fair", "open", "open"]


def test_json_holds_null_for_what_is_not_finite(tmp_path: Path):
    write_json({"a": float("nan"), "b": [1.0, float("inf")]}, tmp_path / "x.json")
    assert json.loads((tmp_path / "x.json").read_text()) == {"a": None, "b": [1.0, None]}
    assert [path.name for path in tmp_path.iterdir()] == ["x.json"]


def test_times_can_be_decoded(run: Run, tmp_path: Path):
    data, _ = diagnose(run.files, run.scene.effects, run.scene.domain)
    write_dataset(data, tmp_path / "diagnostics.nc")
    with xr.open_dataset(tmp_path / "diagnostics.nc") as found:
        assert found["boundary_time"].values[-1] == np.datetime64("1982-01-01T12:00:00")
        assert found["time"].values[0] == np.datetime64("1981-12-31T00:00:00")


def test_a_residual_larger_than_a_tenth_of_the_change_is_not_closed():
    limits = Limits(2e-2, 1e-1)
    assert verdict(5e-3, limits, 0.05) == "closed"
    assert verdict(5e-3, limits, 1.7) == "fair"
    # Round-off of a large turnover may exceed a change that is nearly none.
    assert verdict(1e-14, limits, 1.7) == "closed"
    assert verdict(0.5, limits, 0.0) == "open"
