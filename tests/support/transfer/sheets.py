# SPDX-License-Identifier: GPL-2.0-or-later
"""Sheets of ice on a square sea, their moves, and what is measured after remapping."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from floeflow.coupling import initial
from floeflow.dynamics.remesh.remap import lay, remap
from floeflow.dynamics.remesh.transport import amounts
from floeflow.packings import fresh_cells as cells
from floeflow.packings import packing
from floeflow.scene import Scene, parse_scene
from floeflow.state.cells import Cells, read_cells
from floeflow.state.schema import MOBILE, VARIABLES

SIDE, MASK_CELLS = 1.0e6, 50
CATEGORIES = 5
# Radius of the circle (m) on which a sheet stays on the sea.
WIDEST_CIRCLE = 0.06 * SIDE
# Thickness (m) of the categories where the sheet is smooth.
THICKNESS = np.array([0.3, 1.0, 1.8, 3.0, 5.5])
Move = Callable[[xr.Dataset, int], tuple[np.ndarray, np.ndarray, np.ndarray]]


def scene(elements: int, effects: str = "thermodynamics, remap", extra: str = "") -> Scene:
    """A scene of the square sea; its mask is not read."""
    text = f"name: sheet\neffects: [{effects}]\npacking: {{elements: {elements}}}\n{extra}"
    return parse_scene(text.encode(), "sheet")


def square_sea(ice: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> xr.Dataset:
    """Mask of a square sea with ice where a function of place (m) says so."""
    spacing = SIDE / MASK_CELLS
    axis = spacing * (np.arange(MASK_CELLS) + 0.5) - 0.5 * SIDE
    x, y = np.meshgrid(axis, axis)
    siconc = np.where(ice(x, y), 1.0, 0.0)
    dims = ("y", "x")
    return xr.Dataset(
        {
            "siconc": (dims, siconc),
            "sithick": (dims, 2.0 * siconc),
            "land": (dims, np.zeros_like(siconc, dtype=np.int8)),
            "cell_area": (dims, np.full_like(siconc, spacing**2)),
        },
        coords={"x": axis, "y": axis},
        attrs={"crs": "EPSG:6931"},
    )


@dataclass(frozen=True)
class Sheet:
    """Ice at its start, and the cells into which it is remapped."""

    state: xr.Dataset
    cells: Cells
    spacing: float


def make_sheet(
    elements: int, ice: Callable[[np.ndarray, np.ndarray], np.ndarray], layers: bool = False
) -> Sheet:
    """Sheet of five categories with snow, smooth concentrations and surface temperatures.

    With layers also enthalpies and salinities that wave with temperature.
    """
    scheme = "mushy" if layers else "zero_layer"
    extra = f"column: {{scheme: {scheme}, categories: {CATEGORIES}}}\n"
    setting = scene(elements, extra=extra)
    mask = square_sea(ice)
    packed = packing.make_packing(mask, setting.packing, setting.seed)
    made = read_cells(cells.make_cells(mask, packed, setting.seed))
    state = initial.make_state(setting, packed, None)
    wide = [n for n in state if state[n].dims == ("element", "category")]
    state = state.drop_vars(wide)
    for name, values in smooth(state["x"].values, state["y"].values).items():
        state[name] = (("element", "category"), values)
    wave = (state["surface_temperature"].values - 255.0) / 12.0
    for name in [n for n in state if state[n].ndim == 3]:
        state[name].values[:] *= 1.0 + 0.1 * wave[:, :, None]
    state["u"] = ("element", 0.3 + 0.2 * np.sin(2e-6 * np.pi * state["y"].values))
    state["v"] = ("element", 0.2 * np.cos(2e-6 * np.pi * state["x"].values))
    spacing = float(np.sqrt(state["area"].values.sum() / elements))
    return Sheet(state, made, spacing)


def smooth(x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
    """Columns at places (m), (n, 5): smooth, of wavelengths of the sea's side."""
    phase = np.arange(CATEGORIES)
    k = 2.0 * np.pi / SIDE
    wave = np.sin(k * x[:, None] + phase) * np.cos(k * y[:, None] - 0.7 * phase)
    fraction = 0.13 * (1.0 + 0.5 * wave)
    thickness = THICKNESS * (1.0 + 0.25 * np.cos(k * (x - y)[:, None] + phase))
    return {
        "ice_fraction": fraction,
        "ice_volume": fraction * thickness,
        "snow_volume": fraction * 0.2 * (1.0 + 0.5 * np.sin(k * y[:, None] + phase)),
        "surface_temperature": 255.0 + 12.0 * wave,
    }


def disc(radius: float) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Ice within a distance of the middle (m)."""
    return lambda x, y: np.hypot(x, y) < radius


def round_trip(step: float, steps: int) -> Move:
    """Translations by ``step`` (m) each that lead back around a circle, once or several times."""
    turns = int(np.ceil(step * steps / (2.0 * np.pi * WIDEST_CIRCLE)))

    def move(state: xr.Dataset, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        angle = 2.0 * np.pi * turns * (k + 0.5) / steps
        still = np.zeros(state.sizes["element"])
        return still + step * np.cos(angle), still + step * np.sin(angle), still

    return move


def rotation(steps: int) -> Move:
    """One turn around the middle."""
    turn = 2.0 * np.pi / steps

    def move(state: xr.Dataset, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x, y = state["x"].values, state["y"].values
        cos, sin = np.cos(turn) - 1.0, np.sin(turn)
        return cos * x - sin * y, sin * x + cos * y, np.full(len(x), turn)

    return move


def breathing(strain: float) -> Move:
    """Convergence along x, then divergence, in turns."""

    def move(state: xr.Dataset, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x = state["x"].values
        factor = -strain if k % 2 == 0 else strain / (1.0 - strain)
        return factor * x, np.zeros_like(x), np.zeros_like(x)

    return move


def displaced(state: xr.Dataset, move: Move, k: int) -> xr.Dataset:
    """State whose mobile elements have moved and turned."""
    mobile = state["type"].values == MOBILE
    dx, dy, turn = (np.where(mobile, part, 0.0) for part in move(state, k))
    return state.assign(
        x=("element", state["x"].values + dx),
        y=("element", state["y"].values + dy),
        theta=("element", state["theta"].values + turn),
    )


def repeat(
    sheet: Sheet, move: Move, steps: int, slopes: bool = True
) -> tuple[xr.Dataset, list[tuple[xr.Dataset, xr.Dataset]]]:
    """Move and remap so many times; the last state, and the states around each remap."""
    state, around = sheet.state, []
    for k in range(steps):
        moved = displaced(state, move, k)
        state = remap(moved, sheet.cells, lay(moved, sheet.cells), 0.2, slopes)
        around.append((moved, state))
    return state, around


def totals(state: xr.Dataset) -> dict[str, np.ndarray]:
    """Amounts of all variables, summed over the elements, per category."""
    values = {n: state[n].values for n, rule in VARIABLES.items() if rule.kind and n in state}
    found = {name: amount.sum(axis=0) for name, amount in amounts(values).items()}
    return found | {"sea": np.array(state["area"].values.sum() + state.attrs["unclaimed_water"])}


def drift_of_totals(first: xr.Dataset, last: xr.Dataset) -> float:
    """Largest change of a conserved total, relative to the sum of absolute parts."""
    before, after = totals(first), totals(last)
    scale = totals(first.map(np.abs))
    worst = 0.0
    # Area may take in gaps; that of sea, ice and all that sits on ice may not change.
    for name in before:
        if name not in ("area", "drift_x", "drift_y"):
            change = np.abs(after[name] - before[name]) / np.maximum(np.abs(scale[name]), 1e-300)
            worst = max(worst, float(np.max(np.where(scale[name] == 0, 0.0, change))))
    return worst


def ratios(state: xr.Dataset) -> dict[str, np.ndarray]:
    """Properties per what they sit on, (n, 5), of the mobile elements; NaN where it is missing."""
    mobile = state["type"].values == MOBILE
    fraction = state["ice_fraction"].values[mobile]
    there = fraction > 0

    def per_ice(name: str) -> np.ndarray:
        values = state[name].values[mobile]
        return np.divide(values, fraction, out=np.full_like(values, np.nan), where=there)

    return {
        "concentration": fraction,
        "thickness": per_ice("ice_volume"),
        "snow": per_ice("snow_volume"),
        "temperature": np.where(there, state["surface_temperature"].values[mobile], np.nan),
    }


def thickness_error(
    state: xr.Dataset, exact: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> float:
    """Mean error of the thickness per category, weighted by ice area, over its mean."""
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    x, y, area = (state[name].values[mobile] for name in ("x", "y", "area"))
    found = ratios(state)["thickness"]
    weight = area[:, None] * state["ice_fraction"].values[mobile]
    right = exact(x, y)
    return float(np.nansum(weight * np.abs(found - right)) / np.nansum(weight * right))
