# SPDX-License-Identifier: GPL-2.0-or-later
"""Weights as NetCDF files: a compressed sparse matrix with what it is for; the same bits again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from scipy.sparse import csr_array

from floeflow.core.errors import FloeError
from floeflow.state import read_dataset, write_dataset
from floeflow.transfer.grid import Grid
from floeflow.transfer.mesh import Mesh
from floeflow.transfer.stencil import Target
from floeflow.transfer.weights import Weights

KIND = "remap weights 2"


def target_variables(target: Target) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Variables that describe a target in a file of weights.

    Parameters
    ----------
    target : Target
        Grid or elements.

    Returns
    -------
    dict of (tuple of str, ndarray)
        Dimensions and values by name; lengths in m.

    Raises
    ------
    FloeError
        Of another kind of target.
    """
    if isinstance(target, Grid):
        return {"x": (("x",), target.x), "y": (("y",), target.y)}
    if isinstance(target, Mesh):
        return {
            "node_x": (("node",), target.x),
            "node_y": (("node",), target.y),
            "face_node": (("face", "corner"), target.faces),
            "node_area": (("node",), target.area),
            "layout": (("dim",), np.array(target.shape)),
        }
    raise FloeError(f"remap: weights for a {type(target).__name__} cannot be saved")


def save_weights(weights: Weights, path: str | Path) -> None:
    """Write weights to a NetCDF file, whole or not at all.

    Parameters
    ----------
    weights : Weights
        From elements to nodes.
    path : str or Path
        NetCDF file, replaced in one step.

    Raises
    ------
    FloeError
        Where it cannot be written.
    """
    matrix = weights.matrix
    variables = {
        "weight": (("pair",), matrix.data),
        "element": (("pair",), matrix.indices),
        "start": (("row",), matrix.indptr),
        "status": (("node",), weights.status.ravel()),
        "condition": (("node",), weights.condition.ravel()),
        **target_variables(weights.target),
    }
    attrs = {
        "kind": KIND,
        "elements": int(matrix.shape[1]),
        "reach": weights.reach,
        "crs": weights.target.crs,
    }
    write_dataset(xr.Dataset(variables, attrs=attrs), path)


def load_weights(path: str | Path) -> Weights:
    """Read weights that `save_weights` wrote; they give the same bits.

    Parameters
    ----------
    path : str or Path
        Of the file.

    Returns
    -------
    Weights
        On the target that the file describes.

    Raises
    ------
    FloeError
        Where the file is missing, damaged, or holds no weights of this format.
    """
    data = read_dataset(path)
    if data.attrs.get("kind") != KIND:
        raise FloeError(f"{path}: holds no remap weights of this version")
    crs = str(data.attrs["crs"])
    target: Target
    if "face_node" in data:
        nodes = data["node_x"].values, data["node_y"].values
        layout = tuple(int(n) for n in data["layout"].values)
        faces, area = data["face_node"].values, data["node_area"].values
        target = Mesh(*nodes, faces, area, crs, layout)
    else:
        target = Grid(data["x"].values, data["y"].values, crs)
    start = data["start"].values
    shape = (len(start) - 1, int(data.attrs["elements"]))
    matrix = csr_array((data["weight"].values, data["element"].values, start), shape=shape)
    return Weights(
        matrix,
        target,
        data["status"].values.reshape(target.shape),
        data["condition"].values.reshape(target.shape),
        int(data.attrs["reach"]),
    )
