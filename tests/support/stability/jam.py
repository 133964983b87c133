# SPDX-License-Identifier: GPL-2.0-or-later
"""A pack in a bay that the wind presses against its coast, through whole coupling windows."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import xarray as xr
from mpi4py import MPI

from floeflow.core.constants import AIR_DENSITY, EDGE_SHARE, SEAWATER_DENSITY
from floeflow.coupling import initial
from floeflow.coupling.coupled_windows import advance_window
from floeflow.diagnostics.budgets import Budget, dem_energy_budget
from floeflow.diagnostics.diagnostics import change_over_windows
from floeflow.dynamics.ridging.ridging import contact_share
from floeflow.packings import bonds, packing
from floeflow.packings import fresh_cells as cells
from floeflow.scene import Scene, parse_scene
from floeflow.state.bonds import element_rows
from floeflow.state.cells import Cells, read_cells
from floeflow.state.elements import element_arrays
from floeflow.state.schema import MOBILE, check_state
from unit.packings.test_packing import mask_of

WIND = 20.0
HOUR = 3600.0
WINDOW = 6.0 * HOUR
EFFECTS = "wind, ocean_drag, coriolis, friction, bonds, coast, ridging"
# What a window's end does about distortion: effect and keys.
REMESHING = {
    "none": ("", ""),
    "remap": (", remap", ""),
    "remap every window": (", remap", "remap: {every: 1}\n"),
    "merge": (", merge", "merge: {radius: 0.9}\n"),
}
KEYS = f"time: {{window: {WINDOW}}}\nforcing: {{step: {WINDOW}}}\ndynamics: {{samples: 6}}\n"


def bay() -> xr.Dataset:
    """Mask of a bay that is open to the right: ice in its inner part, water beyond."""
    land = np.zeros((14, 22), dtype=bool)
    land[:2] = land[-2:] = land[:, :2] = True
    ice = np.zeros_like(land)
    ice[:, :14] = True
    random = np.random.default_rng(4)
    thick = random.uniform(0.3, 2.0, land.shape)
    return mask_of(np.where(ice & ~land, 1.0, 0.0), land, thick)


@dataclass(frozen=True)
class Setting:
    """What window ends do, scene, state 0, fresh cells and the wind (m/s)."""

    remesh: str
    scene: Scene
    state: xr.Dataset
    cells: Cells | None
    wind: tuple[float, float]


def setting(remesh: str, elements: int, wind: tuple[float, float] = (-WIND, 0.0)) -> Setting:
    """Pack of so many elements.

    Parameters
    ----------
    remesh : str
        One of `REMESHING`.
    elements : int
        Number of mobile elements to aim at.
    wind : tuple of float
        Along x and y, m/s.
    """
    mask = bay()
    effect, keys = REMESHING[remesh]
    text = f"name: jam\neffects: [{EFFECTS}{effect}]\n{KEYS}{keys}"
    scene = parse_scene(f"{text}packing: {{elements: {elements}}}".encode(), "jam")
    packed = packing.make_packing(mask, scene.packing, scene.seed)
    glued = bonds.make_bonds(packed, scene.packing.bond_gap, scene.packing.bond_concentration)
    fresh = None
    if "remap" in scene.effects:
        fresh = read_cells(cells.make_cells(mask, packed, scene.seed))
    return Setting(remesh, scene, initial.make_state(scene, packed, glued), fresh, wind)


def forcing(at: Setting, seconds: float) -> xr.Dataset:
    """Wind over still water, the same everywhere."""
    axis = np.array([-3e6, 3e6])
    one = np.ones((1, 2, 2))
    fields = {"wind_u": at.wind[0], "wind_v": at.wind[1], "ocean_u": 0.0, "ocean_v": 0.0}
    data = {name: (("time", "y", "x"), value * one) for name, value in fields.items()}
    data["coriolis"] = (("y", "x"), 1.4e-4 * one[0])
    return xr.Dataset(data, coords={"time": [seconds], "x": axis, "y": axis})


def free_drift(at: Setting) -> float:
    """Speed at which the ocean's drag balances the wind's, m/s."""
    keys = at.scene.dynamics
    rule = AIR_DENSITY * keys.air_drag / (SEAWATER_DENSITY * keys.ocean_drag)
    return float(np.hypot(*at.wind) * np.sqrt(rule))


def ice_volume(state: xr.Dataset) -> float:
    """Volume of all ice, m3."""
    return float(state["area"].values @ state["ice_volume"].values.sum(axis=1))


def overlap_share(state: xr.Dataset, scene: Scene) -> float:
    """Largest elastic overlap of two elements over that at which their ridge yields.

    No ridge holds more than what crushes its ice, its thickness times the strength.
    """
    lo, hi = (element_rows(state["id"].values, state[f"contact_id_{e}"].values) for e in
              ("lo", "hi"))  # fmt: skip
    if not len(lo):
        return 0.0
    made = element_arrays(state, scene.dynamics.minimum_thickness)
    x, y, radius, h = (made[name] for name in ("x", "y", "radius", "thickness"))
    reach = radius[lo] + radius[hi]
    rest = state["contact_rest_overlap"].values
    overlap = reach - np.hypot(x[hi] - x[lo], y[hi] - y[lo]) - rest
    # An open pair that was never pressed has no ridge yet: it starts with the thinner ice.
    thick = np.maximum(state["contact_ridge_thickness"].values, np.minimum(h[lo], h[hi]))
    length = state["contact_ridge_length"].values
    length = np.where(length > 0, length, 2.0 * EDGE_SHARE * np.minimum(radius[lo], radius[hi]))
    stiffness = scene.dynamics.contact_modulus * contact_share(made, lo, hi)
    bound = length * thick * scene.dynamics.compressive_strength / stiffness
    return float((overlap / bound).max())


@dataclass
class Pressed:
    """What the windows showed: one entry a window, but for what is said of the whole."""

    state: xr.Dataset
    series: list[xr.Dataset] = field(default_factory=list)
    overlap: list[float] = field(default_factory=list)
    volume_error: float = 0.0
    sea_error: float = 0.0
    steps: list[float] = field(default_factory=list)

    def energy(self) -> Budget:
        """Mechanical energy of every window."""
        number = np.arange(1, len(self.series) + 1)
        samples = xr.concat(
            [s[["kinetic_energy", "elastic_energy"]].assign(
                sample_window=("sample", np.full(s.sizes["sample"], k)))
             for k, s in zip(number, self.series, strict=True)],
            "sample",
        )  # fmt: skip
        plain = [s[[n for n in s.data_vars if not s[n].dims]] for s in self.series]
        scalars = xr.concat(plain, "window", join="exact").assign_coords(window=number)
        change = [change_over_windows(samples, f"{k}_energy", number) for k in
                  ("kinetic", "elastic")]  # fmt: skip
        budget = dem_energy_budget(scalars, *change)
        assert budget is not None
        return budget

    def largest(self, name: str) -> float:
        """Largest value of a variable of the series."""
        return max(float(each[name].max()) for each in self.series)

    def total(self, name: str) -> float:
        """Sum of a variable of the series over the windows."""
        return sum(float(each[name]) for each in self.series)


def press(at: Setting, windows: int, log: Path, comm: MPI.Comm = MPI.COMM_SELF) -> Pressed:
    """Advance window after window; at the end of each all must be finite, there and in bounds."""
    seen = Pressed(at.state)
    first = ice_volume(at.state)
    for _ in range(windows):
        blown = forcing(at, float(seen.state.attrs["time"]))
        done = advance_window(comm, at.scene, seen.state, blown, log, lambda **_: None, at.cells)
        state = done.state
        check_state(state)
        for name in state.data_vars:
            if state[name].dtype.kind == "f":
                assert np.isfinite(state[name].values).all(), f"{name} is not finite"
        mobile = state["type"].values == MOBILE
        assert (state["area"].values[mobile] > 0.0).all()
        assert state["ice_fraction"].values.sum(axis=1).max() <= 1.0 + 1e-12
        assert state["ice_volume"].values.min() >= 0.0
        sea = float(state["area"].values.sum()) + state.attrs["unclaimed_water"]
        seen.sea_error = max(seen.sea_error, abs(sea / state.attrs["ocean_area"] - 1.0))
        seen.volume_error = max(seen.volume_error, abs(ice_volume(state) / first - 1.0))
        seen.overlap.append(overlap_share(state, at.scene))
        seen.series.append(done.series)
        cost = next(record for record in done.cost if record.name == "dynamics")
        seen.steps.append(float(cost.extra["time_step"]))
        # What the next window starts from is what a file holds.
        state.attrs["provenance"] = json.dumps({})
        seen.state = state
    return seen
