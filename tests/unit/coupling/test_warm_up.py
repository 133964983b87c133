# SPDX-License-Identifier: GPL-2.0-or-later
"""The column's warm-up: one step of no elements, in every scheme, that changes nothing."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.column import schemes
from floeflow.coupling import columns as coupling
from floeflow.coupling import coupled_windows
from floeflow.scene import Scene, parse_scene
from support.remesh_cases import coast_case
from unit.column.test_forcing import forcing_data

EFFECTS = "friction, bonds, ridging, thermodynamics, snow, redistribution"


def scene_of(column: str) -> Scene:
    text = f"name: a\neffects: [{EFFECTS}]\ncolumn: {{{column}}}\n"
    return parse_scene(text.encode(), "a")


@pytest.mark.parametrize("scheme", list(schemes.SCHEMES))
def test_the_column_takes_a_step_of_no_elements(scheme: str, monkeypatch: pytest.MonkeyPatch):
    column = f"scheme: {scheme}, categories: 2, layers: 3"
    scene = scene_of(column)
    state, _ = coast_case("redistribution", more=f"column: {{{column}}}\n")
    before = state.copy(deep=True)
    asked: list[tuple[int, tuple[float, float]]] = []
    plain = coupling.advance_slice

    def advance(columns: dict, sample: object, span: tuple, *more: object) -> tuple:
        asked.append((len(columns["ice_fraction"]), span))
        return plain(columns, sample, span, *more)

    monkeypatch.setattr(coupling, "advance_slice", advance)
    coupled_windows.warm_up(MPI.COMM_SELF, scene, state, forcing_data())
    assert asked == [(0, (0.0, 3600.0))]
    xr.testing.assert_identical(state, before)


def test_a_scene_without_columns_has_nothing_to_warm(monkeypatch: pytest.MonkeyPatch):
    def never(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(coupled_windows, "advance_columns", never)
    scene = parse_scene(b"name: a\neffects: [wind]\n", "a")
    coupled_windows.warm_up(
        MPI.COMM_SELF, scene, xr.Dataset({"area": ("element", np.ones(2))}), xr.Dataset()
    )
