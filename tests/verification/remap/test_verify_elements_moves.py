# SPDX-License-Identifier: GPL-2.0-or-later
"""Sheets of ice that move over fresh cells: amounts, bounds, errors and diffusion.

The moves of Turner et al. (2022, GMD 15, 1953): translation by fractions of a cell, rotation,
converging and diverging flow, an ice edge that crosses cells; five categories with snow,
temperatures and whatever else the state's schema has.
"""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from floeflow.dynamics.remesh.remap import lay
from floeflow.dynamics.remesh.transport import amounts, transport
from floeflow.state.schema import MOBILE, VARIABLES
from support.transfer import remap_figures, sheets
from support.transfer.sheets import (
    SIDE,
    Move,
    Sheet,
    breathing,
    disc,
    displaced,
    drift_of_totals,
    make_sheet,
    ratios,
    repeat,
    rotation,
    round_trip,
    thickness_error,
)

ROUND_OFF = 1e-12


@pytest.fixture(scope="module")
def sheet() -> Sheet:
    return make_sheet(250, disc(0.32 * SIDE))


def moves(sheet: Sheet, steps: int) -> dict[str, Move]:
    """The moves of the paper, of so many steps."""
    return {
        "translation": round_trip(0.3 * sheet.spacing, steps),
        "small translation": round_trip(0.05 * sheet.spacing, steps),
        "whole cells": round_trip(1.0 * sheet.spacing, steps),
        "rotation": rotation(steps),
        "convergence and divergence": breathing(0.04),
    }


def exact(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Thickness of the sheet at its start, (n, 5)."""
    field = sheets.smooth(x, y)
    return field["ice_volume"] / field["ice_fraction"]


def assert_right(sheet: Sheet, last: xr.Dataset, around: list, tolerance: float) -> None:
    """Amounts kept; everything within the bounds of what was there before each remap."""
    assert drift_of_totals(sheet.state, last) <= tolerance
    for before, after in around:
        mobile = after["type"].values == MOBILE
        total = after["ice_fraction"].values.sum(axis=1)[mobile]
        assert total.min() >= 0.0 and total.max() <= 1.0 + 1e-14
        old, new = ratios(before), ratios(after)
        for name in ("thickness", "snow", "temperature"):
            low, high = np.nanmin(old[name], axis=0), np.nanmax(old[name], axis=0)
            assert (np.nanmin(new[name], axis=0) >= low - ROUND_OFF * np.abs(low)).all(), name
            assert (np.nanmax(new[name], axis=0) <= high + ROUND_OFF * np.abs(high)).all(), name


@pytest.mark.parametrize("name", list(moves(Sheet(None, None, 1.0), 2)))
def test_ten_remaps(sheet: Sheet, name: str) -> None:
    last, around = repeat(sheet, moves(sheet, 10)[name], 10)
    assert_right(sheet, last, around, ROUND_OFF)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(moves(Sheet(None, None, 1.0), 2)))
def test_a_hundred_remaps(sheet: Sheet, name: str) -> None:
    last, around = repeat(sheet, moves(sheet, 100)[name], 100)
    assert_right(sheet, last, around, ROUND_OFF)
    if name != "convergence and divergence":
        plain, _ = repeat(sheet, moves(sheet, 100)[name], 100, slopes=False)
        errors = [thickness_error(state, exact) for state in (last, plain)]
        print(f"{name}: error after 100 remaps {errors[0]:.4f}, donor-cell {errors[1]:.4f}")
        assert errors[0] < 0.5 * errors[1]


@pytest.mark.parametrize("steps", [5, pytest.param(100, marks=pytest.mark.slow)])
def test_enthalpy_and_salt(steps: int) -> None:
    sheet = make_sheet(120, disc(0.32 * SIDE), layers=True)
    last, around = repeat(sheet, round_trip(0.3 * sheet.spacing, steps), steps)
    assert_right(sheet, last, around, ROUND_OFF)
    layered = [name for name in last if last[name].ndim == 3]
    assert "ice_enthalpy" in layered and "ice_salinity" in layered
    for before, after in around:
        for name in layered:
            old, new = (s[name].values[s["type"].values == MOBILE] for s in (before, after))
            size = ROUND_OFF * np.abs(old).max()
            assert old.min() - size <= new.min() and new.max() <= old.max() + size, name


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
def test_cells_stay_within_their_own_sources(sheet: Sheet, part: float) -> None:
    moved = displaced(sheet.state, round_trip(part * sheet.spacing, 7), 2)
    laid = lay(moved, sheet.cells)
    names = [n for n, rule in VARIABLES.items() if rule.kind and n in moved]
    values = {name: moved[name].values[laid.rows] for name in names}
    before, after = amounts(values), transport(values, laid.centre, laid.pieces)
    for name, parent in (("ice_fraction", "area"), ("ice_volume", "ice_fraction"),
                         ("snow_volume", "ice_fraction"), ("surface_temperature", "ice_fraction"),
                         ("u", "mass"), ("v", "mass")):  # fmt: skip
        old, new = (found[name] / _wide(found, name, parent) for found in (before, after))
        for j in np.unique(laid.pieces.target):
            sources = old[laid.pieces.source[laid.pieces.target == j]]
            size = ROUND_OFF * np.abs(sources).max()
            assert (new[j] <= sources.max(axis=0) + size).all(), name
            assert (new[j] >= sources.min(axis=0) - size).all(), name


def _wide(found: dict[str, np.ndarray], name: str, parent: str) -> np.ndarray:
    per = found[parent].reshape(
        found[parent].shape + (1,) * (found[name].ndim - found[parent].ndim)
    )
    return np.where(per > 0, per, np.nan)


def test_the_ice_edge_stays_sharp(sheet: Sheet) -> None:
    """Area of cells that are neither full nor empty, after crossing cells, over the rim's cells."""
    last, _ = repeat(sheet, round_trip(0.3 * sheet.spacing, 20), 20)
    mobile = np.flatnonzero(last["type"].values == MOBILE)
    fill = (
        last["area"].values[mobile]
        / sheet.cells.area[np.searchsorted(sheet.cells.id, last["id"].values[mobile])]
    )
    partial = (fill < 0.99).sum()
    rim = 2 * np.pi * 0.32 * SIDE / sheet.spacing
    assert partial < 1.5 * rim
    # No ice lies further from where the sheet is than a cell.
    far = np.hypot(last["x"].values[mobile], last["y"].values[mobile]).max()
    assert far < 0.32 * SIDE + 1.5 * sheet.spacing
    total = last["area"].values.sum() / sheet.state["area"].values.sum()
    assert total == pytest.approx(1.0, abs=0.02)


def step_thickness(x: np.ndarray) -> np.ndarray:
    """1 m left of the middle, 2 m right of it."""
    return np.where(x < 0, 1.0, 2.0)


def step_sheet(elements: int) -> Sheet:
    """A sheet whose categories are alike and step from 1 m to 2 m in the middle."""
    made = make_sheet(elements, disc(0.34 * SIDE))
    state = made.state.copy(deep=True)
    fraction = np.full(state["ice_fraction"].shape, 0.19)
    fraction[state["type"].values != MOBILE] = 0.0
    state["ice_fraction"].values[:] = fraction
    state["ice_volume"].values[:] = fraction * step_thickness(state["x"].values)[:, None]
    return Sheet(state, made.cells, made.spacing)


def smeared(state: xr.Dataset) -> float:
    """Width (m) over which a step is smeared: area of |h - exact| over the step's length."""
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    x, y, area = (state[name].values[mobile] for name in ("x", "y", "area"))
    inner = np.hypot(x, y) < 0.25 * SIDE
    wrong = np.abs(ratios(state)["thickness"][:, 0] - step_thickness(x))
    return float((area * wrong)[inner].sum() / (0.5 * SIDE))


def test_a_step_is_smeared_less_than_by_donor_cell() -> None:
    sheet = step_sheet(250)
    move = round_trip(0.3 * sheet.spacing, 16)
    widths = [smeared(repeat(sheet, move, 16, slopes)[0]) for slopes in (True, False)]
    assert widths[0] < 0.7 * widths[1]


@pytest.mark.slow
def test_diffusion_of_a_step_after_a_hundred_remaps(show) -> None:
    sheet = step_sheet(700)
    move = round_trip(0.3 * sheet.spacing, 100)
    after = {
        "second order, 100 remaps": repeat(sheet, move, 100)[0],
        "donor-cell, 100 remaps": repeat(sheet, move, 100, slopes=False)[0],
    }
    widths = [smeared(state) / sheet.spacing for state in after.values()]
    print(f"a step is smeared over {widths[0]:.2f} spacings, by donor-cell over {widths[1]:.2f}")
    show("remap_step", remap_figures.steps, sheet, after)
    assert widths[0] < 0.6 * widths[1]


@pytest.mark.slow
def test_errors_fall_with_the_spacing() -> None:
    """Translation over a given way: the error falls by more than donor-cell's."""
    errors = []
    for elements in (150, 600):
        sheet = make_sheet(elements, disc(0.32 * SIDE))
        count = round(20 * np.sqrt(elements / 150))
        move = round_trip(0.3 * sheet.spacing, count)
        errors.append(
            [
                thickness_error(repeat(sheet, move, count, slopes)[0], exact)
                for slopes in (True, False)
            ]
        )
    second, first = (np.log2(a / b) for a, b in zip(*errors, strict=True))
    print(f"orders: {second:.2f}, donor-cell {first:.2f}")
    assert second > 1.5 > first
