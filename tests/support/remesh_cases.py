# SPDX-License-Identifier: GPL-2.0-or-later
"""States of a packing with coast, and the cells into which they are remapped."""

from __future__ import annotations

import numpy as np
import xarray as xr

from floeflow.coupling import initial
from floeflow.dynamics.remesh.remap import lay, remap
from floeflow.dynamics.remesh.transport import amounts
from floeflow.packings import bonds, packing
from floeflow.packings import fresh_cells as cells
from floeflow.scene import parse_scene
from floeflow.scene.blocks import Packing
from floeflow.state.cells import Cells, read_cells
from floeflow.state.schema import MOBILE, VARIABLES
from unit.packings.test_packing import coastline

EFFECTS = "friction, bonds, ridging, thermodynamics, snow"


def coast_case(
    remesh: str = "remap", elements: int = 120, coast_bonds: bool = False, more: str = ""
) -> tuple[xr.Dataset, Cells]:
    """State at the start with random velocities, and the fresh cells of its sea."""
    mask = coastline()
    packed = packing.make_packing(mask, Packing(elements=elements), 7)
    scene = parse_scene(f"name: a\neffects: [{EFFECTS}, {remesh}]\n{more}".encode(), "a")
    state = initial.make_state(scene, packed, bonds.make_bonds(packed, 0.2, 0.0, coast_bonds))
    random = np.random.default_rng(3)
    mobile = state["type"].values == MOBILE
    for name in ("u", "v", "omega"):
        scale = 1e-6 if name == "omega" else 0.3
        values = np.where(mobile, scale * random.normal(size=len(mobile)), 0.0)
        state[name] = ("element", values)
    return state, read_cells(cells.make_cells(mask, packed, 7))


def spacing_of(cells: Cells) -> float:
    """Mean distance of the elements (m)."""
    return 2.0 * float(cells.radius.mean())


def jiggled(state: xr.Dataset, size: float, seed: int = 1) -> xr.Dataset:
    """State whose mobile elements are displaced at random (m) and turned a little."""
    random = np.random.default_rng(seed)
    mobile = state["type"].values == MOBILE
    out = state.copy(deep=True)
    for axis in ("x", "y"):
        out[axis].values[mobile] += size * random.uniform(-1, 1, mobile.sum())
    out["theta"].values[mobile] += 0.1 * random.normal(size=mobile.sum())
    return out


def remapped(state: xr.Dataset, cells: Cells) -> xr.Dataset:
    """State after a remap, whatever its distortion."""
    return remap(state, cells, lay(state, cells), 0.2)


def totals(state: xr.Dataset) -> dict[str, float]:
    """Sums of all amounts but the area, and of areas and unclaimed water."""
    values = {n: state[n].values for n, rule in VARIABLES.items() if rule.kind and n in state}
    sums = {name: float(amount.sum()) for name, amount in amounts(values).items()}
    sums["area"] += float(state.attrs["unclaimed_water"])
    return {name: v for name, v in sums.items() if not name.startswith("drift")}


def scales(state: xr.Dataset) -> dict[str, float]:
    """Sums of the absolute amounts."""
    return totals(state.map(np.abs, keep_attrs=True))
