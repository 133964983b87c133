# SPDX-License-Identifier: GPL-2.0-or-later
"""Elements that cannot go on by themselves become part of a neighbour."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from floeflow.dynamics.engine.setup import LONGEST_REACH, bond_reach, within_reach
from floeflow.dynamics.remesh.absorb import absorbed, used_up_alone
from floeflow.dynamics.remesh.merge import merge
from floeflow.state.bonds import new_bonds
from floeflow.state.schema import check_state
from support.full_ice import full_params
from support.rafts import bonded, lattice
from unit.state.test_state import a_state

EFFECTS = ("friction", "bonds", "ridging", "thermodynamics", "snow")
LAWS = full_params(time_step=1.0, bonds=True, ridging=True)


def a_raft() -> xr.Dataset:
    """Thirty equal elements in a lattice, at rest, without pairs."""
    raft = lattice(6, 5)
    state = a_state(EFFECTS, n=30).isel(bond=slice(0, 0), contact=slice(0, 0))
    for name in ("type", "x", "y", "theta", "u", "v", "omega", "radius"):
        state[name] = ("element", raft[name].copy())
    state["area"] = ("element", raft["ice_area"].copy())
    state["ice_fraction"].values[:, 0], state["ice_volume"].values[:, 0] = 0.9, 1.0
    state["snow_volume"].values[:, 0] = 0.1
    total = float(state["area"].sum())
    state.attrs |= {"ocean_area": total + 5e6, "unclaimed_water": 5e6}
    return state


def totals(state: xr.Dataset) -> list[float]:
    area = state["area"].values
    return [float(area.sum()), float(area @ state["ice_volume"].values.sum(axis=1))]


def test_sound_elements_stay() -> None:
    state = a_raft()
    assert (absorbed(state, LAWS) == np.arange(30)).all()


@pytest.mark.parametrize("kind", ["used up", "run over", "torn"])
def test_what_cannot_go_on_joins_a_neighbour(kind: str) -> None:
    state = a_raft()
    if kind == "used up":
        state["area"].values[14] *= 0.1
        state["radius"].values[14] *= 0.3
    elif kind == "run over":
        state["area"].values[14] *= 0.9
        state["x"].values[14] = state["x"].values[15] - 0.4 * state["radius"].values[15]
    else:
        ids = state["id"].values
        elements = {name: state[name].values for name in ("id", "x", "y", "theta", "radius")}
        x = 0.5 * (state["x"].values[14] + state["x"].values[15])
        y, half = state["y"].values[14], 0.577 * state["radius"].values[14]
        bonds = new_bonds(
            elements,
            ids[[14]],
            ids[[15]],
            *(np.array([v]) for v in (x, y - half, x, y + half)),
            np.array([1.0]),
        )
        state = state.assign({f"bond_{name}": ("bond", v) for name, v in bonds.items()})
        state["area"].values[14] *= 0.9
        state["radius"].values[[14, 15]] *= 0.2
    into = absorbed(state, LAWS)
    assert into[14] != 14 and (np.delete(into, 14) == np.delete(np.arange(30), 14)).all()
    if kind != "used up":
        assert into[14] == 15
    joined = merge(state, into)
    check_state(joined)
    assert joined.sizes["element"] == 29
    np.testing.assert_allclose(totals(joined), totals(state), rtol=1e-14)


def test_bonds_that_no_list_can_hold_are_let_go() -> None:
    raft = lattice(6, 5)
    table = bonded(raft)
    assert len(within_reach(raft, table, LAWS)["id_lo"]) == len(table["id_lo"])
    small = raft | {"radius": np.where(raft["id"] == 15, 0.05, 0.3) * raft["radius"]}
    kept = within_reach(small, table, LAWS)
    assert 0 < len(kept["id_lo"]) < len(table["id_lo"])
    assert bond_reach(small, kept, LAWS) <= LONGEST_REACH * 1.01


def test_a_fine_part_of_a_packing_stays() -> None:
    state = a_raft()
    fine = np.arange(30) >= 12
    # Discs of a sixth of the radius, as close to each other as the wide ones are.
    for axis in "xy":
        first = state[axis].values[12]
        state[axis].values[fine] = first + (state[axis].values[fine] - first) / 6.0
    state["area"].values[fine] /= 36.0
    state["radius"].values[fine] /= 6.0
    assert (absorbed(state, LAWS) == np.arange(30)).all()
    state["area"].values[29] *= 0.1
    state["radius"].values[29] *= 0.3
    assert absorbed(state, LAWS)[29] != 29


@pytest.mark.parametrize(
    ("share", "away", "found"), [(0.04, 1e6, [0]), (0.06, 1e6, []), (0.04, 0.0, [])]
)
def test_one_that_is_alone_is_left_to_the_sea(share: float, away: float, found: list[int]) -> None:
    state = a_raft()
    state["area"].values[0] *= share
    state["x"].values[0] -= away
    assert list(used_up_alone(state)) == found
    # What is alone joins nobody; what has a neighbour does.
    assert (absorbed(state, LAWS)[0] == 0) == (away > 0.0)
