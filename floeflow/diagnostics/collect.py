# SPDX-License-Identifier: GPL-2.0-or-later
"""Read what the chunks of a run left behind and lay it along common dimensions.

Snapshots of the elements are read one at a time: only their totals are kept.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.core.extensions import load_extensions
from floeflow.scene.blocks import Domain
from floeflow.scene.effects import diagnostic_series
from floeflow.state import read_dataset
from floeflow.state.files import CHECKSUM
from floeflow.state.schema import COAST, MOBILE

SAMPLED = ("time", "kinetic_energy", "elastic_energy", "drift_speed", "largest_speed")
SCALARS = (
    "momentum_x_start",
    "momentum_y_start",
    "momentum_x_end",
    "momentum_y_end",
    "ice_area_start",
    "ice_area_end",
    "ice_volume_start",
    "ice_volume_dynamics",
    "ice_volume_end",
)
GRID_QUANTITIES = {
    "ice_area": ("siconc",),
    "ice_volume": ("sivol",),
    "snow_volume": ("siconc", "sisnthick"),
}
# What lies in elements outside of the grid.
GRID_OUTSIDE = {
    "ice_area": "siarea_outside",
    "ice_volume": "sivolume_outside",
    "snow_volume": "sisnvolume_outside",
}


# Numbers of the elements at each boundary that extensions add, by name: function, unit, meaning.
ADDED: dict[str, tuple[Callable[[xr.Dataset], float], str, str]] = {}


def boundary_number(
    name: str, unit: str, meaning: str
) -> Callable[[Callable[[xr.Dataset], float]], Callable[[xr.Dataset], float]]:
    """Register a number of the elements, taken at each window boundary.

    Parameters
    ----------
    name : str
        Of the variable in ``diagnostics.nc``.
    unit, meaning : str
        Its attributes ``units`` and ``long_name``.

    Returns
    -------
    callable
        Decorator that registers a function and returns it.
    """

    def register(function: Callable[[xr.Dataset], float]) -> Callable[[xr.Dataset], float]:
        ADDED[name] = function, unit, meaning
        return function

    return register


# Sides of the scene's rectangle.
SIDES = ("left", "right", "bottom", "top")


def read_series(paths: Sequence[Path], effects: tuple[str, ...]) -> tuple[xr.Dataset, xr.Dataset]:
    """Read the series of all chunks.

    Parameters
    ----------
    paths : sequence of Path
        Series of the chunks, in order.
    effects : tuple of str
        The scene's effects: they say what must be there.

    Returns
    -------
    tuple of xarray.Dataset
        Samples of all windows on ``sample`` (a boundary stands twice, before and after the
        column), with ``sample_window``; and the budget scalars on ``window``.

    Raises
    ------
    FloeError
        For a missing or damaged file, or a variable that the effects ask for and is missing.
    """
    samples, scalars = [], []
    for path in paths:
        data = read_dataset(path)
        for name in expected_series(effects):
            if name not in data:
                raise FloeError(f"{path}: variable '{name}' is missing")
        data.attrs = {}
        samples.append(data.drop_dims("window"))
        scalars.append(data.drop_dims("sample").set_coords("window"))
    joined = xr.concat(scalars, "window", join="exact", combine_attrs="drop_conflicts")
    return xr.concat(samples, "sample", join="exact", combine_attrs="drop_conflicts"), joined


def expected_series(effects: tuple[str, ...]) -> list[str]:
    """Variables of a series that a scene with these effects must hold.

    Parameters
    ----------
    effects : tuple of str
        The scene's effects.

    Returns
    -------
    list of str
        Names in the file of the series.
    """
    names = [*SAMPLED, *SCALARS]
    for series in diagnostic_series(effects):
        if series.startswith("impulse_"):
            names += [f"{series}_x", f"{series}_y"]
        elif series.startswith(("remap_", "merge_")) or series in (
            "intact_bonds",
            "bonds_refrozen",
        ):
            names.append(series)
        elif series == "ridged_area":
            names += [series, "dissipation_ridging"]
        elif series == "ice_growth":
            names.append("energy_stored")
    return names


def intact(state: xr.Dataset) -> np.ndarray:
    """Pairs (id_lo, id_hi) of the bonds that still hold, (bond, 2), sorted.

    Parameters
    ----------
    state : xarray.Dataset
        With a bond table.

    Returns
    -------
    ndarray
        Ids, (bond, 2).
    """
    holds = state["bond_crack_a"].values + state["bond_crack_b"].values < 1.0
    return np.stack([state["bond_id_lo"].values, state["bond_id_hi"].values], axis=1)[holds]


def broken_by_motion(samples: xr.Dataset, windows: Iterable[int]) -> np.ndarray:
    """Bonds broken since the start at each boundary, from the samples of the motion alone.

    Remapping and merging make other bonds between windows, so pairs cannot be compared then.

    Parameters
    ----------
    samples : xarray.Dataset
        With ``sample_window`` and ``intact_bonds``.
    windows : iterable of int
        Their numbers.

    Returns
    -------
    ndarray
        Counts, (windows + 1,).
    """
    number, held = samples["sample_window"].values, samples["intact_bonds"].values
    lost = [held[number == window][0] - held[number == window][-1] for window in windows]
    return np.concatenate([[0], np.cumsum(lost)]).astype(np.int64)


def lost_pairs(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Pairs that are in the first list and not in the second, (n, 2).

    Parameters
    ----------
    before : ndarray
        Ids of pairs, (k, 2).
    after : ndarray
        Ids of pairs, (k, 2).

    Returns
    -------
    ndarray
        Ids.
    """
    kept = {tuple(pair) for pair in after.tolist()}
    rows = [tuple(pair) not in kept for pair in before.tolist()]
    return before[np.asarray(rows, dtype=bool)]


def displacement(first: xr.Dataset, last: xr.Dataset) -> tuple[xr.Dataset, np.ndarray]:
    """Net displacement of the mobile elements that are in both states, or of remapped ice.

    Parameters
    ----------
    first : xarray.Dataset
        Snapshots or states, in the order of time.
    last : xarray.Dataset
        Snapshots or states, in the order of time.

    Returns
    -------
    tuple of xarray.Dataset and ndarray
        Those elements of ``last``, and their displacement from ``first`` (m), (element, 2).
    """
    if "drift_x" in last:
        # Fresh elements take the displacement of their ice with them.
        last = last.isel(element=np.flatnonzero(last["type"].values == MOBILE))
        return last, np.stack([last["drift_x"].values, last["drift_y"].values], axis=1)
    first = first.isel(element=np.flatnonzero(first["type"].values == MOBILE))
    last = last.isel(element=np.flatnonzero(last["type"].values == MOBILE))
    _, here, there = np.intersect1d(
        first["id"].values, last["id"].values, assume_unique=True, return_indices=True
    )
    first, last = first.isel(element=here), last.isel(element=there)
    dx = last["x"].values - first["x"].values
    dy = last["y"].values - first["y"].values
    return last, np.stack([dx, dy], axis=1)


def mean(values: np.ndarray, weights: np.ndarray) -> float:
    """Weighted mean; 0 where there is nothing to weigh.

    Parameters
    ----------
    values : ndarray
        (n,).
    weights : ndarray
        (n,).

    Returns
    -------
    float
        In the unit of the values.
    """
    total = float(weights.sum())
    return float((values * weights).sum() / total) if total > 0 else 0.0


def summarise_states(
    first: xr.Dataset,
    snapshots: Iterable[xr.Dataset],
    effects: tuple[str, ...],
    domain: Domain,
) -> tuple[xr.Dataset, list[dict[str, Any]]]:
    """Totals of the elements at all boundaries, 0 to the last window.

    Parameters
    ----------
    first : xarray.Dataset
        State 0.
    snapshots : iterable of xarray.Dataset
        Elements at the ends of all windows, in order; read once.
    effects : tuple of str
        The scene's effects.
    domain : Domain
        The scene's rectangle.

    Returns
    -------
    tuple of xarray.Dataset and list of dict
        On ``boundary``: ``boundary_time`` (s), ``ice_area`` (m2), ``ice_volume`` (m3) and with snow
        ``snow_volume`` (m3), all inside the scene's rectangle; the same beyond each of its sides as
        ``ice_area_beyond_left``, ...; ``mean_displacement`` and ``largest_displacement`` since the
        start (m), ``elements``, ``coast_elements``, ``ocean_area`` and ``unclaimed_water`` (m2);
        and each state's window and checksum.
    """
    load_extensions()
    rows: list[dict[str, float]] = []
    sums = []
    for state in itertools.chain([first], snapshots):
        row = _totals(first, state)
        row |= stocks(state, "snow" in effects, domain)
        row |= {name: float(number(state)) for name, (number, *_) in ADDED.items()}
        rows.append(row)
        sums.append({"window": int(state.attrs["window"]), "checksum": str(state.attrs[CHECKSUM])})
    columns = {name: ("boundary", np.array([row[name] for row in rows])) for name in rows[0]}
    return xr.Dataset(columns, coords={"boundary": [row["window"] for row in sums]}), sums


def bond_counts(
    first: xr.Dataset, samples: xr.Dataset, scalars: xr.Dataset
) -> dict[str, tuple[str, np.ndarray]]:
    """Bonds alive, and broken by motion since the start, at all boundaries.

    Parameters
    ----------
    first : xarray.Dataset
        State 0.
    samples, scalars : xarray.Dataset
        From `read_series`.

    Returns
    -------
    dict of (str, ndarray)
        Dimension and counts by name, (boundary,).
    """
    number, held = samples["sample_window"].values, samples["intact_bonds"].values
    windows = scalars["window"].values
    ends = [int(held[number == window][-1]) for window in windows]
    # Bonds that froze or that remapping made come between the windows.
    after = [int(held[number == window][0]) for window in windows[1:]]
    formed = scalars["bonds_refrozen"].values[-1] if "bonds_refrozen" in scalars else 0
    alive = [len(intact(first)), *after, ends[-1] + int(formed)]
    return {
        "bonds": ("boundary", np.array(alive, dtype=np.int64)),
        "bonds_broken": ("boundary", broken_by_motion(samples, windows)),
    }


def side_beyond(x: np.ndarray, y: np.ndarray, domain: Domain) -> np.ndarray:
    """The side of the scene's rectangle beyond which a place lies: an index of `SIDES`, or -1.

    Beyond two sides the one counts that it is further from.

    Parameters
    ----------
    x : ndarray
        m, (n,).
    y : ndarray
        m, (n,).
    domain : Domain
        Rectangle of the scene (m).

    Returns
    -------
    ndarray
        (n,).
    """
    off = np.stack([domain.x_min - x, x - domain.x_max, domain.y_min - y, y - domain.y_max])
    return np.where(off.max(axis=0) > 0, off.argmax(axis=0), -1)


def stocks(state: xr.Dataset, snow: bool, domain: Domain) -> dict[str, float]:
    """Ice area, ice and snow volume inside the rectangle, and beyond each of its sides.

    An element is where its centre is.

    Parameters
    ----------
    state : xarray.Dataset
        Elements.
    snow : bool
        Whether the state has snow.
    domain : Domain
        Rectangle of the scene (m).

    Returns
    -------
    dict of float
        m2 and m3, by ``<name>`` and ``<name>_beyond_<side>``.
    """
    names = {"ice_area": "ice_fraction", "ice_volume": "ice_volume"}
    names |= {"snow_volume": "snow_volume"} if snow else {}
    side = side_beyond(state["x"].values, state["y"].values, domain)
    found = {}
    for name, variable in names.items():
        each = state["area"].values * state[variable].values.sum(axis=1)
        found[name] = float(each[side < 0].sum())
        for number, word in enumerate(SIDES):
            found[f"{name}_beyond_{word}"] = float(each[side == number].sum())
    return found


def _totals(first: xr.Dataset, state: xr.Dataset) -> dict[str, float]:
    moved, step = displacement(first, state)
    distance = np.hypot(step[:, 0], step[:, 1])
    return {
        "boundary_time": float(state.attrs["time"]),
        "elements": int((state["type"].values == MOBILE).sum()),
        "coast_elements": int((state["type"].values == COAST).sum()),
        "ocean_area": float(state.attrs["ocean_area"]),
        "unclaimed_water": float(state.attrs["unclaimed_water"]),
        "mean_displacement": mean(distance, moved["area"].values),
        "largest_displacement": float(distance.max(initial=0.0)),
    }


def read_grid(path: Path) -> xr.Dataset:
    """Read CF fields with all their times: missing values as NaN, concentration as a share.

    Parameters
    ----------
    path : Path
        ``grid.nc`` or one of its chunks.

    Returns
    -------
    xarray.Dataset
        In memory.

    Raises
    ------
    FloeError
        Where it is missing, damaged, or holds no such fields.
    """
    return with_shares(read_fields(path, ("x", "y", "siconc")))


def read_tendencies(path: str) -> xr.Dataset:
    """Read the file of tendencies on the grid, as `read_fields`.

    Parameters
    ----------
    path : str
        ``tendencies.nc``.

    Returns
    -------
    xarray.Dataset
        In memory.
    """
    return read_fields(Path(path), ("window", "sidmassth", "sidmassdyn"))


def read_fields(path: Path, names: Sequence[str]) -> xr.Dataset:
    """Read a CF file that has to hold some variables, missing values as NaN, times as numbers.

    Parameters
    ----------
    path : Path
        NetCDF file.
    names : sequence of str
        Variables that it needs.

    Returns
    -------
    xarray.Dataset
        In memory.

    Raises
    ------
    FloeError
        Where it cannot be read, or a variable is missing.
    """
    try:
        with xr.open_dataset(path, decode_times=False) as opened:
            data = opened.load()
    except Exception as error:  # a damaged HDF5 file raises whatever its bytes lead to
        reason = "there is no such file" if not path.is_file() else type(error).__name__
        raise FloeError(f"{path}: cannot be read as NetCDF: {reason}") from None
    for name in names:
        if name not in data.variables:
            raise FloeError(f"{path}: variable '{name}' is missing")
    return data


def with_shares(grid: xr.Dataset) -> xr.Dataset:
    """The fields with concentration as a share of 1, whatever its unit is in the file.

    Parameters
    ----------
    grid : xarray.Dataset
        On ``time``, ``y`` and ``x``.

    Returns
    -------
    xarray.Dataset
        The given one where it has shares.
    """
    if grid["siconc"].attrs.get("units") not in ("%", "percent"):
        return grid
    share = (grid["siconc"] / 100.0).assign_attrs(grid["siconc"].attrs | {"units": "1"})
    return grid.assign(siconc=share)


def cell_area(grid: xr.Dataset, path: Path) -> np.ndarray:
    """Cell areas (m2) of a CF grid, named by the ``cell_measures`` of siconc, (y, x).

    Parameters
    ----------
    grid : xarray.Dataset
        CF dataset with ``siconc``.
    path : Path
        Of the file, for messages.

    Returns
    -------
    ndarray
        m2.

    Raises
    ------
    FloeError
        For areas that are missing.
    """
    words = str(grid["siconc"].attrs.get("cell_measures", "area: areacello")).split()
    name = words[words.index("area:") + 1] if "area:" in words[:-1] else "areacello"
    if name not in grid:
        raise FloeError(f"{path}: its cell areas, variable '{name}', are missing")
    return np.asarray(grid[name].values, dtype=float)


def summarise_grid(path: Path) -> xr.Dataset:
    """Totals of the gridded output on ``grid``, one a time: grid_ice_area, outside_ice_area, ...

    Parameters
    ----------
    path : Path
        ``grid.nc`` or one of its chunks.

    Returns
    -------
    xarray.Dataset
        On ``time``: areas (m2) and volumes (m3).
    """
    data = read_grid(path)
    area = cell_area(data, path)
    columns = {}
    for name, factors in GRID_QUANTITIES.items():
        if all(factor in data for factor in factors):
            product = np.broadcast_to(area, data["siconc"].shape)
            for factor in factors:
                product = product * data[factor].values
            columns[f"grid_{name}"] = ("grid", np.nansum(product, axis=(1, 2)))
            if GRID_OUTSIDE[name] in data:
                columns[f"outside_{name}"] = ("grid", data[GRID_OUTSIDE[name]].values)
    windows = data["window"].values.astype(np.int64)
    return xr.Dataset(columns, coords={"grid_window": ("grid", windows)})


def read_cost(paths: Iterable[Path]) -> list[dict[str, Any]]:
    """Benchmark records of all windows, each with its ``window``.

    Parameters
    ----------
    paths : iterable of Path
        Files of ``cost/``.

    Returns
    -------
    list of dict
        In the order of the windows.

    Raises
    ------
    FloeError
        For a missing file or one that is no list of records.
    """
    found = []
    for path in paths:
        try:
            records = json.loads(path.read_text())
            found += [
                {
                    **record,
                    "window": int(record["window"]),
                    "seconds": float(sum(record["seconds"])),
                    "name": str(record["name"]),
                    "n": int(record["n"]),
                }
                for record in records
            ]
        except (OSError, ValueError, TypeError, KeyError):
            raise FloeError(f"{path}: is not a list of benchmark records") from None
    return found
