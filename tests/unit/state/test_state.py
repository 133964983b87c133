# SPDX-License-Identifier: GPL-2.0-or-later
"""The state: what is written is read back bit for bit, or refused in one sentence."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.scene.effects import EFFECTS
from floeflow.state import SCHEMA_VERSION, VARIABLES, read_dataset, read_state, write_state
from floeflow.state.files import checksum
from floeflow.state.schema import EXACT, ROUNDED, check_state, expected_variables


def a_state(effects: tuple[str, ...] = ("wind", "bonds", "thermodynamics", "snow"), n: int = 4):
    """Build a valid state of n elements in a row, each bonded to the next."""
    rng = np.random.default_rng(5)
    sizes = {"element": n, "category": 1, "bond": n - 1, "contact": 1}
    state = xr.Dataset()
    for name in expected_variables(effects):
        rule = VARIABLES[name]
        shape = tuple(sizes[dim] for dim in rule.dims)
        low = max(rule.low, 0.0)
        values = low + rng.random(shape) * (min(rule.high, low + 1.0) - low)
        state[name] = (rule.dims, values.astype(rule.dtype))
    state["id"] = ("element", np.arange(1, n + 1))
    for kind, count in (("bond", n - 1), ("contact", 1)):
        if f"{kind}_id_lo" in state:
            state[f"{kind}_id_lo"] = (kind, np.arange(1, count + 1))
            state[f"{kind}_id_hi"] = (kind, np.arange(2, count + 2))
    state.attrs = {
        "schema_version": SCHEMA_VERSION,
        "scene": "test",
        "effects": " ".join(effects),
        "window": 0,
        "time": 0.0,
        "start": "2000-01-01T00:00:00",
        "seed": 1,
        "crs": "EPSG:6931",
        "ocean_area": 10.0,
        "unclaimed_water": 1.0,
        "provenance": json.dumps({}),
    }
    return state


def test_a_state_comes_back_bit_for_bit(tmp_path: Path):
    state = a_state()
    digest = write_state(state, tmp_path / "s.nc")
    back = read_state(tmp_path / "s.nc")
    assert back.attrs["checksum"] == digest == checksum(state)
    for name in state.variables:
        assert back[name].values.tobytes() == state[name].values.tobytes()
        assert back[name].attrs["units"] == VARIABLES[str(name)].units


def test_a_state_without_elements_is_a_state(tmp_path: Path):
    empty = a_state().isel(element=slice(0, 0), bond=slice(0, 0), contact=slice(0, 0))
    write_state(empty, tmp_path / "s.nc")
    assert read_state(tmp_path / "s.nc").sizes["element"] == 0


def test_only_the_scene_s_effects_bring_variables():
    without = expected_variables(("wind",))
    assert not any(name.startswith("bond_") for name in without)
    assert "surface_temperature" not in without
    added = {name for effect in EFFECTS.values() for name in effect.state}
    assert added <= set(VARIABLES)


def broken(change: str):
    """Break one thing of a state."""
    state = a_state()
    state.attrs["column_scheme"] = "zero_layer"
    if change == "missing":
        return state.drop_vars("x")
    if change == "nan":
        state["x"].values[2] = np.nan
    if change == "range":
        state["ice_fraction"].values[1] = 1.5
    if change == "type":
        state["x"] = state["x"].astype("float32")
    if change == "extra":
        state["colour"] = ("element", np.zeros(4))
    if change == "order":
        state["id"].values[:2] = [2, 1]
    if change == "pair":
        state["bond_id_lo"].values[0] = 3
    if change == "ghost":
        state["bond_id_hi"].values[2] = 99
    if change == "newer":
        state.attrs["schema_version"] = SCHEMA_VERSION + 1
    if change == "attribute":
        del state.attrs["seed"]
    if change in state.attrs:
        state.attrs[change] = UNTRUE[change]
    return state


UNTRUE = {
    "effects": "wind haze",
    "column_scheme": "onion",
    "time": np.nan,
    "start": "soon",
    "provenance": "[" * 10**5,
}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ("missing", "variable 'x' is missing"),
        ("nan", "variable 'x' is nan at element 2"),
        ("range", r"variable 'ice_fraction' is 1.5 at element 1, outside \[0, 1\]"),
        ("type", "variable 'x' is of type float32, not float64"),
        ("extra", "variable 'colour' is not of this scene's effects"),
        ("order", "not sorted by id"),
        ("pair", "does not name its lower id first"),
        ("ghost", "names an element that does not exist"),
        ("newer", f"schema version is {SCHEMA_VERSION + 1}, this FloeFlow writes version"),
        ("attribute", "attribute 'seed' is missing"),
        ("effects", "attribute 'effects' names 'haze', which is not an effect"),
        ("column_scheme", "'column_scheme' is 'onion', which is not a column scheme"),
        ("time", "attribute 'time' is nan"),
        ("start", "attribute 'start' is 'soon', which is not a time"),
        ("provenance", "attribute 'provenance' is not a JSON object"),
    ],
)
def test_a_broken_state_is_refused(tmp_path: Path, change: str, sentence: str):
    with pytest.raises(FloeError, match=sentence):
        check_state(broken(change))
    with pytest.raises(FloeError, match="not written"):
        write_state(broken(change), tmp_path / "s.nc")
    assert not list(tmp_path.iterdir())


def test_a_cut_file_is_refused(tmp_path: Path):
    path = tmp_path / "s.nc"
    write_state(a_state(), path)
    raw = path.read_bytes()
    for size in range(0, len(raw) - 1, 4096):
        path.write_bytes(raw[:size])
        with pytest.raises(FloeError, match=r"s\.nc"):
            read_state(path)


def test_a_foreign_file_is_refused(tmp_path: Path):
    path = tmp_path / "f.nc"
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(path)
    with pytest.raises(FloeError, match="no checksum"):
        read_dataset(path)
    with pytest.raises(FloeError, match="there is no such file"):
        read_dataset(tmp_path / "none.nc")


def test_a_failed_write_keeps_the_older_file(tmp_path: Path):
    path = tmp_path / "s.nc"
    digest = write_state(a_state(), path)
    with pytest.raises(FloeError):
        write_state(broken("nan"), path)
    assert read_state(path).attrs["checksum"] == digest
    (tmp_path / "file").write_text("")
    with pytest.raises(FloeError, match="cannot be written"):
        write_state(a_state(), tmp_path / "file" / "s.nc")


def test_single_precision_rounds_what_may_be_rounded_and_nothing_else(tmp_path: Path):
    state = a_state(n=50)
    write_state(state, tmp_path / "double.nc")
    digest = write_state(state, tmp_path / "single.nc", "single")
    stored, back = read_dataset(tmp_path / "single.nc"), read_state(tmp_path / "single.nc")
    assert back.attrs["checksum"] == digest and EXACT and ROUNDED
    for name in map(str, state.variables):
        assert back[name].dtype == state[name].dtype
        if name in ROUNDED:
            assert stored[name].dtype == np.float32
            np.testing.assert_allclose(back[name], state[name], rtol=2.0**-24)
        else:
            np.testing.assert_array_equal(back[name], state[name])
    assert {"x", "y", "area", "ice_fraction", "sea_temperature", "wall_face_ax"} <= set(EXACT)
    assert not set(EXACT) & set(ROUNDED)
    # Once rounded, a state comes back bit for bit.
    assert write_state(back, tmp_path / "again.nc", "single") == digest
    sizes = [(tmp_path / f"{name}.nc").stat().st_size for name in ("double", "single")]
    assert sizes[1] < sizes[0]


def test_rounding_keeps_the_schema_s_bounds():
    for name in ROUNDED:
        for bound in (VARIABLES[name].low, VARIABLES[name].high):
            assert np.float64(np.float32(bound)) == bound
