# SPDX-License-Identifier: GPL-2.0-or-later
"""Snapshots of the elements at window boundaries, many in one file.

A snapshot is what maps, tracks and totals need of a state: the elements with their ice by category,
their outlines, and the length of these that bonds hold, without layers, bonds and contacts. The
number of elements changes between boundaries, so rows of all boundaries follow each other (CF:
contiguous ragged arrays), counted by ``element_count`` and ``corner_count``. For gridded tendencies
there is what froze and melted where in the window before (``grown_count``;
`floeflow.coupling.growth`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from floeflow.state.files import CHECKSUM, read_dataset, write_dataset

RAGGED = ("element", "corner", "grown")
# Attributes of a state that differ between boundaries, and those that do not.
MOMENT = ("window", "time", "ocean_area", "unclaimed_water")
COMMON = ("schema_version", "scene", "effects", "start", "seed", "crs", "column_scheme")
CHECKSUMS = "state_checksum"
# What is kept of the bonds, which snapshots do not hold.
BONDED = "bonded_length"


def snapshot(state: xr.Dataset) -> xr.Dataset:
    """What is kept of a state at a boundary, its attributes included.

    Parameters
    ----------
    state : xarray.Dataset
        The state.

    Returns
    -------
    xarray.Dataset
        Element variables that later stages read and, with bonds, the length (m) that they hold.
    """
    kept = [
        str(name)
        for name, variable in state.data_vars.items()
        if variable.dims
        and variable.dims[0] in RAGGED
        and set(variable.dims) <= {*RAGGED, "category"}
    ]
    if "bond_id_lo" not in state:
        return state[kept]
    said = {"units": "m", "long_name": "length of the outline that bonds hold"}
    return state[kept].assign({BONDED: ("element", bonded_length(state), said)})


def bonded_length(state: xr.Dataset) -> np.ndarray:
    """Length of the glue lines that hold each element, less their cracks (m), (element,).

    Parameters
    ----------
    state : xarray.Dataset
        With a bond table.

    Returns
    -------
    ndarray
        m, (element,); 0 without bonds.
    """
    ids = state["id"].values
    left = 1.0 - state["bond_crack_a"].values - state["bond_crack_b"].values
    length = state["bond_length"].values * np.clip(left, 0.0, 1.0)
    held = np.zeros(ids.size)
    for end in ("lo", "hi"):
        places = np.searchsorted(ids, state[f"bond_id_{end}"].values)
        held += np.bincount(places, length, ids.size)[: ids.size]
    return held


def join_snapshots(snapshots: Sequence[xr.Dataset]) -> xr.Dataset:
    """Lay snapshots, or states, behind each other.

    Parameters
    ----------
    snapshots : sequence of xarray.Dataset
        In the order of time; all with the same variables.

    Returns
    -------
    xarray.Dataset
        Rows of all boundaries on ``element`` and ``corner``, and on ``boundary`` their counts, the
        attributes of the states and their checksums.
    """
    parts = [snapshot(each) for each in snapshots]
    data: dict[str, tuple[tuple[str, ...], np.ndarray]] = {}
    for name, variable in parts[0].data_vars.items():
        dims = tuple(str(dim) for dim in variable.dims)
        data[str(name)] = (dims, np.concatenate([part[name].values for part in parts]))
    for dim in RAGGED:
        if any(dim in part.sizes for part in parts):
            counts = np.array([part.sizes.get(dim, 0) for part in parts], dtype=np.int64)
            data[f"{dim}_count"] = (("boundary",), counts)
    for name in MOMENT:
        data[name] = (("boundary",), np.array([part.attrs[name] for part in parts]))
    sums = [str(part.attrs.get(CHECKSUM, "")) for part in parts]
    data[CHECKSUMS] = (("boundary",), np.array(sums, dtype="U64"))
    attrs = {name: parts[0].attrs[name] for name in COMMON if name in parts[0].attrs}
    joined = xr.Dataset(data, attrs=attrs)
    joined["time"].attrs = {
        "units": f"seconds since {str(attrs['start']).replace('T', ' ')}",
        "calendar": "standard",
        "standard_name": "time",
    }
    return joined


def split_snapshots(joined: xr.Dataset) -> Iterator[xr.Dataset]:
    """Snapshots of what `join_snapshots` laid together, one after the other, as parts of states.

    Parameters
    ----------
    joined : xarray.Dataset
        Snapshots along ``boundary``.

    Yields
    ------
    xarray.Dataset
        Of one boundary, in the order of time.
    """
    ends = {
        dim: np.cumsum(joined[f"{dim}_count"].values) for dim in RAGGED if f"{dim}_count" in joined
    }
    for k in range(joined.sizes["boundary"]):
        rows = {
            dim: slice(int(end[k - 1]) if k else 0, int(end[k]))
            for dim, end in ends.items()
            if dim in joined.sizes
        }
        names = [name for name, v in joined.data_vars.items() if "boundary" not in v.dims]
        part = joined[names].isel(rows)
        part.attrs = dict(joined.attrs)
        for name in MOMENT:
            part.attrs[name] = joined[name].values[k].item()
        part.attrs[CHECKSUM] = str(joined[CHECKSUMS].values[k])
        yield part


def write_snapshots(snapshots: Sequence[xr.Dataset], path: str | Path) -> None:
    """Write snapshots, or what is kept of states, whole or not at all.

    Parameters
    ----------
    snapshots : sequence of xarray.Dataset
        In the order of time.
    path : str or Path
        NetCDF file, replaced in one step.

    Raises
    ------
    FloeError
        Where it cannot be written.
    """
    write_dataset(join_snapshots(snapshots), path)


def read_snapshots(paths: Iterable[str | Path]) -> Iterator[xr.Dataset]:
    """Snapshots of several files, one after the other; one file is in memory at a time.

    Parameters
    ----------
    paths : iterable of str or Path
        Of files of ``elements/``.

    Yields
    ------
    xarray.Dataset
        Of one boundary, in the order of the files.

    Raises
    ------
    FloeError
        Where a file is missing or damaged.
    """
    for path in paths:
        yield from split_snapshots(read_dataset(path))
