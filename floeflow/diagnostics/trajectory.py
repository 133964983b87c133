# SPDX-License-Identifier: GPL-2.0-or-later
"""Trajectory of the elements through all states of a run, for OVITO and MDAnalysis.

The file is a LAMMPS text dump: OVITO, VMD and MDAnalysis read it with no second file for the
topology, it holds any column, and as text it keeps positions of 1e6 m to the millimetre. What each
program makes of its units and precision stands in docs/export.md.
"""

import logging
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyproj
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.atomic_write import write_atomically
from floeflow.core.constants import ICE_DENSITY, SNOW_DENSITY
from floeflow.core.errors import FloeError
from floeflow.core.grids import to_lonlat
from floeflow.diagnostics.collect import intact
from floeflow.diagnostics.drift import (
    drift_distance,
    mean_squared_displacement,
    relative_dispersion,
)
from floeflow.scene.blocks import Domain
from floeflow.state.schema import MOBILE

if TYPE_CHECKING:
    import MDAnalysis

log = logging.getLogger(__name__)

Array = NDArray[np.float64]
Index = NDArray[np.int64]

KEPT = ("x", "y", "theta", "u", "v", "radius", "area")
# Fields of the elements at each frame that a Universe has.
FIELDS = ("mass", "radius", "theta", "area", "ice_fraction", "thickness", "present")
# XTC keeps thousandths of a nanometre, here centimetres, as whole numbers of 32 bits.
XTC_REACH = 2.0e7
# Columns of the dump after id and type: name there, name here (none: always 0), and format.
COLUMNS = (
    ("mass", "mass", "%.9g"),
    ("x", "x", "%.3f"),
    ("y", "y", "%.3f"),
    ("z", None, "%d"),
    ("vx", "u", "%.9g"),
    ("vy", "v", "%.9g"),
    ("vz", None, "%d"),
    ("radius", "radius", "%.9g"),
    ("theta", "theta", "%.9g"),
    ("area", "area", "%.9g"),
    ("ice_fraction", "ice_fraction", "%.9g"),
    ("thickness", "thickness", "%.9g"),
)


def make_frames(states: Iterable[xr.Dataset]) -> xr.Dataset:
    """Lay what a trajectory needs of the states along time.

    Every element that ever was is in all frames, as MDAnalysis asks for. Where it is not (before
    remapping made it, after it was merged) it stands where it was last or is next, with no mass.

    Parameters
    ----------
    states : iterable of xarray.Dataset
        States at window boundaries, ascending in time, from the first on; read once.

    Returns
    -------
    xarray.Dataset
        On (time, element): x, y, radius (m), theta (rad), u, v (m/s), area (m2), mass (kg),
        ice_fraction (1), thickness (m; 0 where an element has no ice), present; of remapped
        elements the net displacement of their ice, drift_x and drift_y (m). Coordinates time (s),
        id and type; the bonds intact at the first boundary as columns of their elements,
        pair(bond, end).

    Raises
    ------
    FloeError
        Where there is no element.
    """
    rows: list[dict[str, Array]] = []
    held: list[Index] = []
    times: list[float] = []
    kinds: dict[int, int] = {}
    first: xr.Dataset | None = None
    for state in states:
        if first is None:
            first = state
        times.append(float(state.attrs["time"]))
        rows.append(_columns(state))
        held.append(state["id"].values)
        kinds.update(zip(held[-1].tolist(), state["type"].values.tolist(), strict=True))
    if first is None or not first.sizes["element"]:
        raise FloeError("trajectory: the run has no elements, so there is nothing to follow")
    ids = np.array(sorted(kinds), dtype=np.int64)
    present = np.stack([np.isin(ids, some) for some in held])
    columns: dict[str, NDArray[Any]] = {name: _laid(present, rows, name) for name in rows[0]}
    data = {name: (("time", "element"), v) for name, v in (columns | {"present": present}).items()}
    pairs = intact(first) if "bond_id_lo" in first else np.zeros((0, 2), dtype=np.int64)
    return xr.Dataset(
        data | {"pair": (("bond", "end"), np.searchsorted(ids, pairs).astype(np.int64))},
        coords={
            "time": np.asarray(times),
            "id": ("element", ids),
            "type": ("element", np.array([kinds[i] for i in ids.tolist()], dtype=np.int8)),
        },
        attrs={name: str(first.attrs[name]) for name in ("start", "crs") if name in first.attrs},
    )


def _laid(present: NDArray[np.bool_], rows: list[dict[str, Array]], name: str) -> Array:
    """One column of all frames, (time, element); places are filled where elements are absent."""
    out = np.zeros(present.shape)
    for k, row in enumerate(rows):
        out[k, present[k]] = row[name]
    if name not in ("x", "y") or present.all():
        return out
    frame = np.arange(len(present))[:, None]
    last = np.maximum.accumulate(np.where(present, frame, -1), axis=0)
    nearest = np.where(last >= 0, last, present.argmax(axis=0))
    return np.asarray(np.take_along_axis(out, nearest, axis=0))


def _columns(state: xr.Dataset) -> dict[str, Array]:
    area = state["area"].values
    fraction, volume = (state[name].values.sum(axis=1) for name in ("ice_fraction", "ice_volume"))
    load = ICE_DENSITY * volume
    if "snow_volume" in state:
        load = load + SNOW_DENSITY * state["snow_volume"].values.sum(axis=1)
    thickness = np.divide(volume, fraction, out=np.zeros_like(volume), where=fraction > 0)
    made = {"mass": area * load, "ice_fraction": fraction, "thickness": thickness}
    kept = [*KEPT, *(name for name in ("drift_x", "drift_y") if name in state)]
    return {name: state[name].values for name in kept} | made


def make_universe(frames: xr.Dataset, corner: tuple[float, float]) -> "MDAnalysis.Universe":
    """Make an MDAnalysis Universe in memory, in single precision as all of MDAnalysis.

    Parameters
    ----------
    frames : xarray.Dataset
        From `make_frames`.
    corner : tuple of float
        Origin of its coordinates in the scene's projection (m). The lower left corner of the
        scene gives what MDAnalysis reads from the dump.

    Returns
    -------
    MDAnalysis.Universe
        Atoms in the order of the ids, with ids, types, masses, radii (of the first frame) and the
        bonds of the first frame. Its Angstrom are metres, its picoseconds seconds. Fields of the
        elements (`FIELDS`) at each frame are auxiliary data: ``trajectory.ts.aux.thickness``; where
        ``present`` is 0, an element is parked and has no ice.
    """
    import MDAnalysis

    from floeflow.diagnostics.element_fields import ElementFields

    universe = MDAnalysis.Universe.empty(frames.sizes["element"], trajectory=False)
    universe.add_TopologyAttr("ids", frames["id"].values)
    universe.add_TopologyAttr("types", frames["type"].values.astype(str).astype(object))
    universe.add_TopologyAttr("masses", frames["mass"].values[0])
    universe.add_TopologyAttr("radii", frames["radius"].values[0])
    universe.add_TopologyAttr("bonds", [tuple(pair) for pair in frames["pair"].values.tolist()])
    places, velocities = (np.zeros((*frames["x"].shape, 3)) for _ in range(2))
    for axis, (place, velocity) in enumerate((("x", "u"), ("y", "v"))):
        places[..., axis] = frames[place].values - corner[axis]
        velocities[..., axis] = frames[velocity].values
    time = frames["time"].values
    step = float(time[1] - time[0]) if len(time) > 1 else 1.0
    universe.load_new(places, order="fac", velocities=velocities, dt=step)
    fields = {name: frames[name].values for name in FIELDS}
    universe.trajectory.add_auxiliary(None, ElementFields(fields, dt=step))
    return universe


def write_xtc(frames: xr.Dataset, domain: Domain, path: Path) -> None:
    """Write the elements' places as an XTC trajectory, whole or not at all.

    Parameters
    ----------
    frames : xarray.Dataset
        From `make_frames`.
    domain : Domain
        Places count from its lower left corner, as MDAnalysis reads them from the dump.
    path : Path
        The file; its folder is made.

    Raises
    ------
    FloeError
        Where it cannot be written, or places are too far for the format.
    """
    import MDAnalysis

    corner = domain.x_min, domain.y_min
    away = [np.abs(frames[axis].values - low) for axis, low in zip("xy", corner, strict=True)]
    reach = float(np.max(away))
    if reach > XTC_REACH:
        raise FloeError(
            f"{path}: an element is {reach / 1e3:.0f} km off the domain's lower left corner, and "
            f"the format XTC reaches {XTC_REACH / 1e3:.0f} km: take the dump, elements.lammpsdump"
        )
    universe = make_universe(frames, corner)
    size = [domain.x_max - domain.x_min, domain.y_max - domain.y_min, 1.0, 90.0, 90.0, 90.0]
    with write_atomically(path) as temporary:
        # Three digits of a nanometre, here of ten metres; single precision has fewer far off.
        with MDAnalysis.Writer(
            str(temporary), n_atoms=len(universe.atoms), format="XTC", precision=3
        ) as writer:
            for step in universe.trajectory:
                step.dimensions = size
                writer.write(universe.atoms)


def write_dump(frames: xr.Dataset, domain: Domain, path: Path) -> None:
    """Write a trajectory as a LAMMPS text dump, whole or not at all.

    Parameters
    ----------
    frames : xarray.Dataset
        From `make_frames`.
    domain : Domain
        Its rectangle is the box.
    path : Path
        The file; its folder is made.

    Raises
    ------
    FloeError
        Where two frames fall on one second, which numbers them, or the file cannot be written.
    """
    seconds = np.rint(frames["time"].values).astype(np.int64)
    if np.any(np.diff(seconds) < 1):
        raise FloeError(f"{path}: windows below one second cannot be numbered by their seconds")
    with write_atomically(path) as temporary, temporary.open("w", encoding="ascii") as file:
        for index, second in enumerate(seconds.tolist()):
            file.write(_head(second, frames.sizes["element"], domain))
            file.writelines(_rows(frames.isel(time=index)))


def _head(second: int, elements: int, domain: Domain) -> str:
    # z from 0, as MDAnalysis takes the box's lower corner off all positions. No 'ITEM: TIME':
    # MDAnalysis counts on nine lines.
    return (
        f"ITEM: TIMESTEP\n{second}\nITEM: NUMBER OF ATOMS\n{elements}\n"
        "ITEM: BOX BOUNDS ff ff ff\n"
        f"{domain.x_min!r} {domain.x_max!r}\n{domain.y_min!r} {domain.y_max!r}\n0.0 1.0\n"
        f"ITEM: ATOMS id type {' '.join(name for name, _, _ in COLUMNS)}\n"
    )


def _rows(frame: xr.Dataset) -> Iterable[str]:
    form = " ".join(["%d", "%d", *(form for _, _, form in COLUMNS)]) + "\n"
    zero = [0] * frame.sizes["element"]
    columns = [
        zero if source is None else frame[source].values.tolist() for _, source, _ in COLUMNS
    ]
    ids, types = (frame[name].values.tolist() for name in ("id", "type"))
    return (form % row for row in zip(ids, types, *columns, strict=True))


def drift_statistics(frames: xr.Dataset) -> xr.Dataset:
    """Statistics of the drift of the mobile elements that are in all frames.

    Remapped elements begin at their cells, so that positions tell no paths: of those there is
    only the net displacement that their ice carries, as drift_distance.

    Parameters
    ----------
    frames : xarray.Dataset
        From `make_frames`, at least two boundaries.

    Returns
    -------
    xarray.Dataset
        drift_distance(time, element) in m, with id(element), and where positions tell paths their
        longitudes and latitudes, lon and lat(time, element); mean_squared_displacement(lag) in m2
        over lag (s); with bonds at the start relative_dispersion(time) in m2 of their pairs, on
        whether they still hold or not.

    Raises
    ------
    FloeError
        Where no element is mobile or the windows are not of one length.
    """
    time, x, y = (frames[name].values for name in ("time", "x", "y"))
    steady = (frames["type"].values == MOBILE) & frames["present"].values.all(axis=0)
    mobile = np.flatnonzero(steady)
    gone = drift_distance(x[:, mobile], y[:, mobile])
    if "drift_x" in frames:
        gone = np.hypot(*(frames[f"drift_{axis}"].values[:, mobile] for axis in ("x", "y")))
    data = xr.Dataset(
        {
            "id": ("element", frames["id"].values[mobile], {"units": "1"}),
            "drift_distance": (
                ("time", "element"),
                gone,
                {"units": "m", "long_name": "distance gone since the start"},
            ),
        },
        coords={"time": ("time", time, _time_attributes(frames))},
    )
    if "drift_x" in frames:
        return data
    if "crs" in frames.attrs:
        lon, lat = to_lonlat(pyproj.CRS(frames.attrs["crs"]), x[:, mobile], y[:, mobile])
        for name, values, word in (("lon", lon, "longitude"), ("lat", lat, "latitude")):
            unit = "degrees_east" if name == "lon" else "degrees_north"
            attrs = {"standard_name": word, "units": unit}
            data[name] = (("time", "element"), values, attrs)
        data["drift_distance"].attrs["coordinates"] = "lat lon"
    lag, msd = mean_squared_displacement(time, x[:, mobile], y[:, mobile])
    attrs = {"units": "m2", "long_name": "mean over elements and times of the same lag"}
    data["mean_squared_displacement"] = ("lag", msd, attrs)
    data = data.assign_coords(lag=("lag", lag, {"units": "s"}))
    pairs = frames["pair"].values
    pairs = pairs[steady[pairs].all(axis=1)]
    if len(pairs):
        text = "mean squared change of the vectors between elements bonded at the start"
        attrs = {"units": "m2", "long_name": text}
        data["relative_dispersion"] = ("time", relative_dispersion(x, y, pairs), attrs)
    return data


def _time_attributes(frames: xr.Dataset) -> dict[str, str]:
    """Units of the times, which CF readers decode where the start of the run is known."""
    if "start" not in frames.attrs:
        return {"units": "s"}
    start = str(frames.attrs["start"]).replace("T", " ")
    return {"standard_name": "time", "units": f"seconds since {start}", "calendar": "standard"}
