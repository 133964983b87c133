# SPDX-License-Identifier: GPL-2.0-or-later
"""Stress of bonds and cracks on packs whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from floeflow.diagnostics.fracture import ANGLES, bond_stresses, by_angle, new_cracks
from floeflow.dynamics.engine.params import EngineParams
from floeflow.state.bonds import new_bonds

SPACING = 1.0e3


def lattice(side: int = 6) -> xr.Dataset:
    """Squares of ice, bonded along all sides."""
    row, column = (each.ravel() for each in np.mgrid[:side, :side])
    x, y = column * SPACING, row * SPACING
    ids = np.arange(x.size) + 1
    right, up = ids[column < side - 1], ids[row < side - 1]
    lo = np.concatenate([right, up])
    hi = np.concatenate([right + 1, up + side])
    elements = {"id": ids, "x": x, "y": y, "theta": np.zeros(x.size)}
    mx, my = (0.5 * (each[lo - 1] + each[hi - 1]) for each in (x, y))
    across = np.concatenate([np.zeros(right.size), np.ones(up.size)])
    half = 0.5 * SPACING
    ends = (mx - across * half, my - (1 - across) * half, mx + across * half,
            my + (1 - across) * half)  # fmt: skip
    table = new_bonds(elements, lo, hi, *ends, np.ones(lo.size))
    data = {name: ("element", values) for name, values in elements.items()}
    data |= {f"bond_{name}": ("bond", values) for name, values in table.items()}
    return xr.Dataset(data, attrs={"effects": "bonds wind"})


def test_a_stretched_pack_is_loaded_by_its_strain() -> None:
    params = EngineParams(time_step=1.0)
    state = lattice()
    normal, shear = bond_stresses(state, params)
    assert np.abs(normal).max() < 1e-9 and shear.max() < 1e-9
    strain = 0.4 * params.tensile_share * params.compressive_strength / params.young_modulus
    state["x"] = state["x"] * (1.0 + strain)
    normal, shear = bond_stresses(state, params)
    right = state["bond_id_hi"].values - state["bond_id_lo"].values == 1
    assert normal[right] == pytest.approx(0.4 * params.tensile_share, rel=1e-6)
    assert np.abs(normal[~right]).max() < 1e-9 and shear.max() < 1e-9


def test_a_sheared_pack_bears_shear_and_broken_bonds_nothing() -> None:
    params = EngineParams(time_step=1.0)
    state = lattice()
    slip = 0.1 * params.compressive_strength / params.shear_modulus
    state["x"] = state["x"] + slip * state["y"]
    normal, shear = bond_stresses(state, params)
    up = state["bond_id_hi"].values - state["bond_id_lo"].values > 1
    assert shear[up] == pytest.approx(0.1, rel=1e-6)
    state["bond_crack_a"] = ("bond", np.where(up, 1.0, 0.0))
    assert bond_stresses(state, params)[0].size == (~up).sum()


def test_the_end_that_is_nearer_to_failing_counts() -> None:
    """A turned element pulls one end of its bonds and presses the other: the pulled one counts."""
    state = lattice(2).isel(bond=[0])
    angle = 1e-4
    state["theta"] = ("element", np.array([0.0, angle, 0.0, 0.0]))
    normal, _ = bond_stresses(state, EngineParams(time_step=1.0))
    assert normal[0] > 0.0


def test_a_broken_row_is_one_crack_along_it() -> None:
    first, last = lattice(), lattice()
    last["y"] = last["y"].where(last["y"] < 2.5 * SPACING, last["y"] + 100.0)
    gap = (first["y"].values[first["bond_id_lo"].values - 1] == 2 * SPACING) & (
        first["bond_id_hi"].values - first["bond_id_lo"].values > 1
    )
    last["bond_crack_a"] = ("bond", np.where(gap, 1.0, 0.0))
    found = new_cracks(first, last)
    assert found is not None and gap.sum() == 6
    # The lines of bonds between rows lie along x.
    assert by_angle(found.angle, found.length)[[0, -1]].sum() == pytest.approx(6 * SPACING)
    assert found.length == pytest.approx(SPACING)
    # Lines of neighbours do not share an element here: six of them, but in a row.
    assert found.sizes.sum() == pytest.approx(6 * SPACING)
    assert found.before.sum() == pytest.approx(60 * SPACING) and found.before.size == ANGLES


def test_lines_around_an_element_are_one_crack() -> None:
    first, last = lattice(), lattice()
    lo, hi = (first[f"bond_id_{end}"].values for end in ("lo", "hi"))
    around = (lo == 15) | (hi == 15)
    alone = (lo == 1) & (hi == 2)
    last["bond_crack_b"] = ("bond", np.where(around | alone, 1.0, 0.0))
    found = new_cracks(first, last)
    assert found is not None
    assert found.sizes.tolist() == pytest.approx([4 * SPACING, SPACING])


def test_whole_packs_and_remapped_ones_have_no_new_cracks() -> None:
    first, last = lattice(), lattice()
    assert new_cracks(first, last) is None
    last["bond_crack_a"] = ("bond", np.ones(last.sizes["bond"]))
    last.attrs["effects"] = "bonds remap"
    assert new_cracks(first, last) is None
    # Elements that merged away took their bonds along.
    last.attrs["effects"] = "bonds"
    kept = last.isel(element=np.arange(1, last.sizes["element"]))
    found = new_cracks(first, kept.isel(bond=np.flatnonzero(kept["bond_id_lo"].values > 1)))
    assert found is not None and found.length.size == 58
