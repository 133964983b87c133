# SPDX-License-Identifier: GPL-2.0-or-later
"""The whole of preprocessing on the smoke scene, up to state 0; and what an effect leaves out."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.coupling import initial
from floeflow.masks import land, mask
from floeflow.packings import bonds, packing
from floeflow.scene import load_scene, stage_hash
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import EFFECTS
from floeflow.state import check_state, read_state, write_state
from floeflow.state.files import checksum

BARE = ("wind", "ocean_drag")


@pytest.fixture(scope="module")
def scene(project: Path) -> Scene:
    found = load_scene(project / "config/scenes/smoke.yaml")
    block = found.mask.model_copy(update={"file": str(project / found.mask.file)})
    return found.model_copy(update={"mask": block})


@pytest.fixture(scope="module")
def ice(scene: Scene) -> xr.Dataset:
    share = land.make_land(scene)["land_fraction"].values
    return mask.make_mask(scene, share)


@pytest.fixture(scope="module")
def packed(scene: Scene, ice: xr.Dataset) -> xr.Dataset:
    return packing.make_packing(ice, scene.packing, scene.seed)


def state_of(scene: Scene, packed: xr.Dataset) -> xr.Dataset:
    table = None
    if "bonds" in scene.effects:
        table = bonds.make_bonds(packed, scene.packing.bond_gap, scene.packing.bond_concentration)
    return initial.make_state(scene, packed, table)


def test_smoke_scene_has_some_200_elements_and_a_coast(packed: xr.Dataset) -> None:
    kind = packed["type"].values
    assert 190 <= (kind == 1).sum() <= 220
    assert (kind == 2).sum() > 20


def test_state_is_written_and_read(scene: Scene, packed: xr.Dataset, tmp_path: Path) -> None:
    write_state(state_of(scene, packed), tmp_path / "0000.nc")
    state = read_state(tmp_path / "0000.nc")
    assert state.attrs["window"] == 0 and state.attrs["time"] == 0.0
    assert state.attrs["start"] == scene.time.start.isoformat()
    assert state.attrs["effects"].split() == list(scene.effects)
    assert json.loads(state.attrs["provenance"])["mask"] == stage_hash(scene, "mask")
    assert state.sizes["bond"] > state.sizes["element"] / 2
    assert state.sizes["contact"] == 0


def test_ice_of_the_state_is_that_of_the_mask(
    scene: Scene, ice: xr.Dataset, packed: xr.Dataset
) -> None:
    state = state_of(scene, packed)
    area = state["area"].values
    ice_area = (area * state["ice_fraction"].values[:, 0]).sum()
    volume = (area * state["ice_volume"].values[:, 0]).sum()
    cells = ice["cell_area"].values * ice["siconc"].values
    assert ice_area == pytest.approx(cells.sum(), rel=1e-12)
    assert volume == pytest.approx((cells * ice["sithick"].values).sum(), rel=1e-12)
    total = area.sum() + state.attrs["unclaimed_water"]
    assert total == pytest.approx(state.attrs["ocean_area"], rel=1e-12)


def test_snow_lies_on_the_ice_and_the_surface_is_at_the_freezing_point(
    scene: Scene, packed: xr.Dataset
) -> None:
    state = state_of(scene, packed)
    snow = state["snow_volume"].values
    np.testing.assert_allclose(snow, scene.mask.snow_thickness * state["ice_fraction"].values)
    freezing = 273.15 - 0.054 * scene.column.ocean_salinity
    np.testing.assert_allclose(state["surface_temperature"], freezing, rtol=1e-12)


def test_ridges_of_the_start_leave_a_share_of_level_ice(scene: Scene, packed: xr.Dataset) -> None:
    names = ("thermodynamics", "snow", "shortwave", "ponds", "ridging", "redistribution")
    column = scene.column.model_copy(update={"scheme": "mushy", "categories": 5})
    block = scene.mask.model_copy(update={"level_share": 0.65})
    melting = scene.model_copy(update={"effects": (*BARE, *names), "column": column, "mask": block})
    state = initial.make_state(melting, packed, None)
    ice = state["ice_fraction"].values > 0.0
    for name in ("level_area", "level_volume"):
        np.testing.assert_array_equal(state[name].values, np.where(ice, 0.65, 0.0))


@pytest.mark.parametrize("scheme", ["zero_layer", "bl99", "mushy"])
def test_leads_of_the_pack_bear_young_ice(scene: Scene, packed: xr.Dataset, scheme: str) -> None:
    column = scene.column.model_copy(
        update={"scheme": scheme, "categories": 1 if scheme == "zero_layer" else 5}
    )
    block = scene.mask.model_copy(update={"lead_ice": 0.1})
    plain = scene.model_copy(update={"column": column})
    states = state_of(plain, packed), state_of(plain.model_copy(update={"mask": block}), packed)
    open_leads, frozen = (state["ice_fraction"].values.sum(axis=1) for state in states)
    pack = open_leads >= 0.8
    assert 0 < pack.sum() < len(pack)
    np.testing.assert_allclose(frozen[pack], 1.0, rtol=1e-12)
    np.testing.assert_array_equal(frozen[~pack], open_leads[~pack])
    grown = [state["ice_volume"].values.sum(axis=1) for state in states]
    np.testing.assert_allclose(grown[1] - grown[0], 0.1 * (frozen - open_leads), atol=1e-12)
    snow = [state["snow_volume"].values.sum() for state in states]
    assert snow[0] == pytest.approx(snow[1], rel=1e-12)


def test_an_effect_left_out_leaves_no_variable(scene: Scene, packed: xr.Dataset) -> None:
    state = state_of(scene.model_copy(update={"effects": BARE}), packed)
    check_state(state)
    gone = {name for effect in EFFECTS.values() for name in effect.state}
    assert gone and not gone & {str(name) for name in state.variables}
    assert "bonds" not in json.loads(state.attrs["provenance"])


def test_no_ice_makes_an_empty_state(scene: Scene, ice: xr.Dataset, tmp_path: Path) -> None:
    water = ice.assign(siconc=0 * ice["siconc"], sithick=0 * ice["sithick"])
    none = packing.make_packing(water, scene.packing, scene.seed)
    write_state(state_of(scene, none), tmp_path / "0000.nc")
    state = read_state(tmp_path / "0000.nc")
    assert state.sizes["element"] == state.sizes["bond"] == 0
    assert state.attrs["unclaimed_water"] == state.attrs["ocean_area"]


def test_all_again_gives_the_same_bits(scene: Scene, ice: xr.Dataset, packed: xr.Dataset) -> None:
    again = mask.make_mask(scene, land.make_land(scene)["land_fraction"].values)
    assert checksum(again) == checksum(ice)
    made = packing.make_packing(again, scene.packing, scene.seed)
    assert checksum(state_of(scene, made)) == checksum(state_of(scene, packed))
