# SPDX-License-Identifier: GPL-2.0-or-later
"""The vortex with FloeFlow's own laws: friction, damping and ridging, in coupling windows.

It goes the way of a scene (state, engine, areas that close at a window's end) at a time step that
the test gives, the same for any ice. The wind stress is the absolute one.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from mpi4py import MPI
from scipy.spatial import cKDTree

from floeflow.coupling.initial import make_state
from floeflow.dynamics.engine.engine import Engine, Forcing
from floeflow.dynamics.ridging.ridging import close_areas
from floeflow.scene.load import parse_scene
from floeflow.state.elements import element_arrays, moved_state, pair_arrays
from support.contact import vortex
from support.full_ice import full_params

SCENE = b"""
effects: [wind, ocean_drag, friction, ridging, walls]
domain: {x_min: 0.0, x_max: 5.0e5, y_min: 0.0, y_max: 5.0e5, spacing: 5.0e3}
"""
WINDOW, LEAST = 900.0, 1e-3  # s; m of ice below which ice moves as if it had this much
LAWS = {
    "ridging": True, "wind": True, "ocean_drag": True, "compressive_strength": 1e5,
    "wind_stress_factor": vortex.AIR, "ocean_stress_factor": vortex.WATER,
}  # fmt: skip


@dataclass
class Worst:
    """Largest overlaps at any window's end, m: of two discs, of what makes force, with a wall."""

    discs: float = 0.0
    elastic: float = 0.0
    wall: float = 0.0


def start(thickness: np.ndarray) -> xr.Dataset:
    """State 0: the lattice with this thickness (m) of ice."""
    places = vortex.lattice()
    n, area = len(places), np.pi * vortex.RADIUS**2
    element = {
        "id": np.arange(1, n + 1), "type": np.ones(n, np.int8), "x": places[:, 0],
        "y": places[:, 1], "radius": np.full(n, vortex.RADIUS), "area": np.full(n, area),
    }  # fmt: skip
    column = {"ice_fraction": np.ones((n, 1)), "ice_volume": thickness[:, None]}
    data = {name: ("element", values) for name, values in element.items()}
    data |= {name: (("element", "category"), values) for name, values in column.items()}
    data["cell_start"] = ("element_bound", np.zeros(n + 1, np.int64))  # no outlines
    data |= {f"cell_{axis}": ("vertex", np.zeros(0)) for axis in "xy"}
    ocean = vortex.BOX**2
    water = {"ocean_area": ocean, "unclaimed_water": ocean - n * area}
    return make_state(parse_scene(SCENE, "vortex"), xr.Dataset(data, attrs=water), None)


def run(log: Path, state: xr.Dataset, step: float, hours: float) -> tuple[xr.Dataset, Worst]:
    """State after some hours, and the largest overlaps on the way."""
    params = full_params(time_step=step, **LAWS)
    faces, worst = pair_arrays(state, "wall_face"), Worst()
    u, v = vortex.STILL[:, None]
    fields = {"wind_u": u, "wind_v": v, "ocean_u": 0 * u, "ocean_v": 0 * v}
    forcing = Forcing(np.array([0.0]), vortex.AXIS, vortex.AXIS, fields)
    with Engine(MPI.COMM_SELF, params, log, faces) as engine:
        for _ in range(round(hours * 3600 / WINDOW)):
            contacts, held = (pair_arrays(state, kind) for kind in ("contact", "wall_contact"))
            engine.load(element_arrays(state, LEAST), None, contacts, 0.0, held)
            engine.set_forcing(forcing)
            engine.run(round(WINDOW / step))
            out, sums = engine.elements(), engine.diagnostics()
            moved = moved_state(state, out, None, engine.contacts(), engine.wall_contacts())
            tables = {"contact": contacts, "wall_contact": held}
            state = close_areas(moved, out["ridged_area"], LEAST, tables)
            _note(worst, state, sums["max_overlap"])
    return state, worst


def _note(worst: Worst, state: xr.Dataset, elastic: float) -> None:
    x, y, radius = (state[name].values for name in ("x", "y", "radius"))
    place = np.column_stack([x, y])
    lo, hi = cKDTree(place).query_pairs(2 * radius.max(), output_type="ndarray").T
    apart = np.hypot(*(place[lo] - place[hi]).T)
    wall = np.concatenate(
        [radius - x, radius - y, x + radius - vortex.BOX, y + radius - vortex.BOX]
    )
    worst.discs = max(worst.discs, float((radius[lo] + radius[hi] - apart).max()))
    worst.elastic = max(worst.elastic, elastic)
    worst.wall = max(worst.wall, float(wall.max()))
