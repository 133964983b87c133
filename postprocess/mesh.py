# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes of the elements' cells at all window boundaries, for ParaView.

Each element is drawn as its cell of the packing, carried and turned with it, so that leads show as
gaps; elements without a cell, as those of the coast, are drawn as their discs.
"""

import logging
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow import stage
from floeflow.errors import FloeError
from floeflow.postprocess.collect import window_file
from floeflow.state import read_dataset, read_state

log = logging.getLogger(__name__)

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DISC_CORNERS = 24


@dataclass(frozen=True)
class Outlines:
    """Outlines of elements as open rings, anticlockwise.

    Parameters
    ----------
    id : ndarray
        Ids of the elements, ascending, (element,).
    start : ndarray
        First corner of each, and the end, (element + 1,).
    x, y : ndarray
        Corners (m), (corner,).
    """

    id: Index
    start: Index
    x: Array
    y: Array

    def take(self, ids: Index) -> "Outlines":
        """Outlines of some of the elements, by their ids, all known."""
        rows = np.searchsorted(self.id, ids)
        corners = np.diff(self.start)[rows]
        start = np.concatenate([[0], np.cumsum(corners)])
        place = np.repeat(self.start[rows] - start[:-1], corners) + np.arange(start[-1])
        return Outlines(ids, start, self.x[place], self.y[place])


def _turned(outlines: Outlines, angle: Array) -> tuple[Array, Array]:
    angle = np.repeat(angle, np.diff(outlines.start))
    cos, sin = np.cos(angle), np.sin(angle)
    return cos * outlines.x - sin * outlines.y, sin * outlines.x + cos * outlines.y


def body_outlines(packing: xr.Dataset, first: xr.Dataset) -> Outlines:
    """Outlines in the body frames of the elements: about their centres, unturned.

    Parameters
    ----------
    packing : xarray.Dataset
        Cells of the elements, and radii for those that have none.
    first : xarray.Dataset
        State that was made from this packing.

    Raises
    ------
    FloeError
        Where the two do not have the same elements.
    """
    ids, corners = packing["id"].values, np.diff(packing["cell_start"].values)
    if not np.array_equal(ids, first["id"].values):
        raise FloeError("mesh: the packing does not have the elements of the first state")
    has_cell = corners >= 3
    count = np.where(has_cell, corners, DISC_CORNERS)
    start = np.concatenate([[0], np.cumsum(count)])
    of = np.repeat(np.arange(len(ids)), count)
    rank = np.arange(start[-1]) - start[of]
    turn = 2.0 * np.pi * rank / DISC_CORNERS
    x = packing["radius"].values[of] * np.cos(turn)
    y = packing["radius"].values[of] * np.sin(turn)
    cell = has_cell[of]
    place = packing["cell_start"].values[of[cell]] + rank[cell]
    x[cell] = packing["cell_x"].values[place] - first["x"].values[of[cell]]
    y[cell] = packing["cell_y"].values[place] - first["y"].values[of[cell]]
    there = Outlines(ids, start, x, y)
    return Outlines(ids, start, *_turned(there, -first["theta"].values))


def own_outlines(state: xr.Dataset) -> Outlines:
    """Outlines that a state of remapped elements holds, in the form of `body_outlines`."""
    count = state.sizes["element"]
    data = {name: ("element", state[name].values) for name in ("id", "radius")}
    held = xr.Dataset(
        data
        | {"cell_start": ("bound", np.append(0, np.cumsum(state["cell_corners"].values)))}
        | {f"cell_{axis}": ("vertex", state[f"corner_{axis}"].values) for axis in ("x", "y")}
    )
    still = {name: ("element", np.zeros(count)) for name in ("x", "y", "theta")}
    return body_outlines(held, xr.Dataset(still | {"id": ("element", state["id"].values)}))


def carried_outlines(body: Outlines, state: xr.Dataset) -> Outlines:
    """Outlines of a state's elements where they are: turned by their orientation, then shifted.

    Parameters
    ----------
    body : Outlines
        From `body_outlines`.
    state : xarray.Dataset
        State at a window boundary; elements that it has lost are left out.

    Raises
    ------
    FloeError
        Where the state has an element that has no outline.
    """
    ids = state["id"].values
    new = np.setdiff1d(ids, body.id)
    if len(new):
        raise FloeError(
            f"mesh: element {new[0]} of state {int(state.attrs['window']):04d} is not in the "
            "packing, so it has no cell"
        )
    own = body.take(ids)
    corners = np.diff(own.start)
    x, y = _turned(own, state["theta"].values)
    x += np.repeat(state["x"].values, corners)
    y += np.repeat(state["y"].values, corners)
    return Outlines(ids, own.start, x, y)


def cell_fields(state: xr.Dataset) -> dict[str, NDArray[np.generic]]:
    """Fields of a state's elements, by the names under which ParaView shows them.

    Parameters
    ----------
    state : xarray.Dataset
        State at a window boundary.

    Returns
    -------
    dict of ndarray
        (element,), or (element, 3) for vectors: id, type, area (m2), ice_fraction (1), thickness
        (m over the ice), speed and velocity (m/s), spin (rad/s); with thermodynamics
        snow_thickness (m over the ice) and surface_temperature (K, mean over the ice). What is
        per ice is NaN where there is none.
    """
    fraction = state["ice_fraction"].values
    total = fraction.sum(axis=1)

    def per_ice(amount: Array) -> Array:
        summed = amount.sum(axis=1)
        return np.divide(summed, total, out=np.full_like(total, np.nan), where=total > 0)

    u, v = state["u"].values, state["v"].values
    fields = {
        "id": state["id"].values,
        "type": state["type"].values,
        "area": state["area"].values,
        "ice_fraction": total,
        "thickness": per_ice(state["ice_volume"].values),
        "speed": np.hypot(u, v),
        "velocity": np.stack([u, v, np.zeros_like(u)], axis=1),
        "spin": state["omega"].values,
    }
    if "snow_volume" in state:
        fields["snow_thickness"] = per_ice(state["snow_volume"].values)
    if "surface_temperature" in state:
        fields["surface_temperature"] = per_ice(fraction * state["surface_temperature"].values)
    return fields


def write_meshes(
    packing: xr.Dataset, states: Iterable[xr.Dataset], paths: list[Path], series: Path
) -> None:
    """Write a mesh for each state, and the series that names them with their times.

    Parameters
    ----------
    packing : xarray.Dataset
        Packing from which the first state was made.
    states : iterable of xarray.Dataset
        States, the first one before all windows; read once.
    paths : list of Path
        A file for each state, all in the folder of `series`.
    series : Path
        The ``.pvd`` file.

    Raises
    ------
    FloeError
        Where there are no elements, states do not fit the packing, or a file cannot be written.
    """
    # meshio takes 0.2 s to import.
    from floeflow.postprocess.meshes import write_polygons, write_series

    body: Outlines | None = None
    times = []
    for state, path in zip(states, paths, strict=True):
        if "cell_corners" in state:
            body = own_outlines(state)
        else:
            body = body_outlines(packing, state) if body is None else body
        outlines = carried_outlines(body, state)
        write_polygons(path, outlines.start, outlines.x, outlines.y, cell_fields(state))
        times.append(float(state.attrs["time"]))
    write_series(series, [path.name for path in paths], times)


def main(snakemake: stage.Snakemake) -> None:
    """Rule ``mesh_files``."""
    folder = Path(snakemake.input.states[0]).parent
    windows = (0, *(int(window) for window in snakemake.params.windows))
    paths = [Path(path) for path in snakemake.output.meshes]
    states = (read_state(window_file(folder, window, ".nc")) for window in windows)
    packing = read_dataset(snakemake.input.packing)
    write_meshes(packing, states, paths, Path(str(snakemake.output.series)))
    log.info("%d meshes of %d elements", len(paths), packing.sizes["element"])


if "snakemake" in globals():
    stage.run(main, globals()["snakemake"])
