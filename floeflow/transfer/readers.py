# SPDX-License-Identifier: GPL-2.0-or-later
"""Grids and meshes of other programs as targets: CF grids, UGRID and MPAS, and meshio's files.

All end up in the scene's projection. Places in degrees are projected; what lies beyond the
projection, or beyond a rectangle of interest, belongs to no face and gets no field.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyproj
import xarray as xr
from pyproj.exceptions import CRSError

from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError
from floeflow.core.fields import Source, open_file, source_grid
from floeflow.core.grids import EARTH_RADIUS, from_lonlat, metres_per_unit
from floeflow.core.meshes import read_faces
from floeflow.core.unpack import unpack
from floeflow.transfer.grid import Grid
from floeflow.transfer.mesh import Mesh, good_faces
from floeflow.transfer.stencil import Array, Index

NETCDF = (".nc", ".nc4", ".cdf")
# A map that makes lengths longer than this is not meant for the place.
STRETCH = 3.0
Rectangle = tuple[float, float, float, float]


def read_target(
    path: str | Path, crs: str, variable: str = "", within: Rectangle | None = None
) -> Grid | Mesh:
    """Read the grid or mesh of a file.

    Parameters
    ----------
    path : str or Path
        NetCDF: MPAS, UGRID, or a CF file with a grid; otherwise any mesh that meshio reads, whose
        nodes are taken as metres of the projection.
    crs : str
        Projection of the elements, to which places are brought.
    variable : str
        A variable on the grid that is meant, where a CF file has several; the first without it.
    within : tuple of float, optional
        Least and largest x, least and largest y (m) that matter: faces wholly outside are left
        out.

    Returns
    -------
    Grid or Mesh
        A regular grid in the elements' own projection is a `Grid`, all else a `Mesh`. Fields on
        its nodes have the shape and order of the file's.

    Raises
    ------
    FloeError
        In a sentence that names file and variable: no projection, degrees where metres are needed,
        axes that are not monotone, faces of more than four corners.
    """
    path = Path(path)
    plane = _projection(path, crs)
    if path.suffix.lower() not in NETCDF:
        x, y, faces = read_faces(path)
        if len(x) and np.abs(x).max() <= 360.0 and np.abs(y).max() <= 90.0:
            raise FloeError(f"{path}: its points look like degrees, but metres of {crs} are needed")
        return _mesh(x, y, faces, crs, within, path)
    variables = cf.describe(path)
    with open_file(path) as data:
        if "cellsOnVertex" in variables:
            return _mpas(data, plane, crs, within, path)
        topology = [v for v in variables.values() if v.text("cf_role") == "mesh_topology"]
        if topology:
            return _ugrid(data, variables, topology[0], plane, crs, within, path)
        return _structured(data, variables, variable, plane, crs, within, path)


def _projection(path: Path, crs: str) -> pyproj.CRS:
    if not crs:
        raise FloeError(f"{path}: no projection (crs) is given to which it could be brought")
    try:
        plane = pyproj.CRS.from_user_input(crs)
    except CRSError:
        raise FloeError(f"{path}: '{crs}' names no coordinate system") from None
    if not plane.is_projected or any(axis.unit_name != "metre" for axis in plane.axis_info[:2]):
        raise FloeError(f"{path}: '{crs}' is not a projection in metres")
    return plane


def _mesh(
    x: Array,
    y: Array,
    faces: Index,
    crs: str,
    within: Rectangle | None,
    path: Path,
    area: Array | None = None,
    layout: tuple[int, ...] = (),
) -> Mesh:
    """Mesh of the faces that lie on the map and matter."""
    keep = good_faces(x, y, faces)
    if within is not None:
        corner = np.where(faces >= 0, faces, faces[:, 2:3])
        fx, fy = x[corner], y[corner]
        with np.errstate(invalid="ignore"):
            keep &= (fx.max(axis=1) >= within[0]) & (fx.min(axis=1) <= within[1])
            keep &= (fy.max(axis=1) >= within[2]) & (fy.min(axis=1) <= within[3])
    if not keep.any():
        raise FloeError(f"{path}: none of its faces lies on the map of {crs}, or where it matters")
    return Mesh(x, y, faces[keep], np.zeros(0) if area is None else area, crs, layout)


def _near_map(lon: Array, lat: Array, x: Array, y: Array, faces: Index) -> Index:
    """Faces whose sides the map stretches less than `STRETCH` times.

    A face around the point opposite to the map's centre is turned inside out: it would hold all.
    """
    corner = np.where(faces >= 0, faces, faces[:, 2:3])
    keep = np.ones(len(faces), bool)
    for a, b in ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2)):
        i, j = corner[:, a], corner[:, b]
        far = np.sin(np.radians(lat[i] - lat[j]) / 2) ** 2
        far += (
            np.cos(np.radians(lat[i]))
            * np.cos(np.radians(lat[j]))
            * np.sin(np.radians(lon[i] - lon[j]) / 2) ** 2
        )
        true = 2.0 * EARTH_RADIUS * np.arcsin(np.sqrt(np.clip(far, 0.0, 1.0)))
        with np.errstate(invalid="ignore"):
            keep &= np.hypot(x[i] - x[j], y[i] - y[j]) <= STRETCH * true + 1.0
    return faces[keep]


def _values(data: xr.Dataset, name: str, path: Path) -> Array:
    if name not in data.variables:
        raise FloeError(f"{path}: variable '{name}' is missing")
    return unpack(np.asarray(data[name].values), data[name].attrs).values


def _mpas(
    data: xr.Dataset, plane: pyproj.CRS, crs: str, within: Rectangle | None, path: Path
) -> Mesh:
    """Cells of an MPAS mesh, which are the corners of its dual triangles."""
    faces = np.nan_to_num(_values(data, "cellsOnVertex", path)).astype(np.int64) - 1
    if faces.shape[1] not in (3, 4):
        raise FloeError(f"{path}: 'cellsOnVertex' has {faces.shape[1]} cells a vertex, not 3 or 4")
    faces = faces[(faces >= 0).all(axis=1)]
    if faces.shape[1] == 3:
        faces = np.concatenate([faces, np.full((len(faces), 1), -1)], axis=1)
    area = _values(data, "areaCell", path)
    if str(data.attrs.get("on_a_sphere", "YES")).strip().upper() == "NO":
        x, y = _values(data, "xCell", path), _values(data, "yCell", path)
    else:
        lon, lat = (np.degrees(_values(data, name, path)) for name in ("lonCell", "latCell"))
        x, y = from_lonlat(plane, lon, lat)
        faces = _near_map(lon, lat, x, y, faces)
        area = area * (EARTH_RADIUS / float(data.attrs.get("sphere_radius", EARTH_RADIUS))) ** 2
    return _mesh(x, y, faces, crs, within, path, area)


def _ugrid(
    data: xr.Dataset,
    variables: dict[str, cf.Variable],
    topology: cf.Variable,
    plane: pyproj.CRS,
    crs: str,
    within: Rectangle | None,
    path: Path,
) -> Mesh:
    """Nodes of a UGRID mesh of triangles and quadrilaterals."""
    names = topology.text("node_coordinates").split()
    if len(names) != 2 or any(name not in variables for name in names):
        raise FloeError(f"{path}: '{topology.name}' names no two node_coordinates that are there")
    table = topology.text("face_node_connectivity")
    rows = _values(data, table, path)
    base = int(data[table].attrs.get("start_index", 0)) if table in data else 0
    faces = np.where(np.isfinite(rows) & (rows >= base), rows - base, -1).astype(np.int64)
    wide = (faces[:, 4:] >= 0).any(axis=1)
    if wide.any():
        raise FloeError(
            f"{path}: '{table}': face {int(np.argmax(wide))} has more than four corners; only "
            "triangles and quadrilaterals have hat functions here"
        )
    faces = np.concatenate([faces, np.full((len(faces), max(0, 4 - faces.shape[1])), -1)], axis=1)
    first, second = (_values(data, name, path) for name in names)
    kinds = [variables[name].text("standard_name") for name in names]
    units = [variables[name].text("units").lower() for name in names]
    if all("degree" in unit for unit in units):
        if kinds[0] == "latitude" or "north" in units[0]:
            first, second = second, first
        x, y = from_lonlat(plane, first, second)
        faces = _near_map(first, second, x, y, faces)
    elif all(unit in ("m", "metre", "meter") for unit in units):
        x, y = (first, second) if kinds[0] != "projection_y_coordinate" else (second, first)
        own = cf.projection(variables, _mapped(variables, topology, path), path)
        x, y = _between(own, plane, x, y)
    else:
        raise FloeError(f"{path}: '{names[0]}' has units '{units[0]}', not m or degrees")
    return _mesh(x, y, faces[:, :4], crs, within, path)


def _mapped(variables: dict[str, cf.Variable], topology: cf.Variable, path: Path) -> cf.Variable:
    """A variable that names the projection of a mesh's nodes."""
    for item in (topology, *variables.values()):
        if item.text("grid_mapping"):
            return item
    raise FloeError(
        f"{path}: '{topology.name}' has nodes in metres but no grid_mapping says of what"
    )


def _between(own: pyproj.CRS, plane: pyproj.CRS, x: Array, y: Array) -> tuple[Array, Array]:
    """Places of one projection in another; as they are where both are the same."""
    if own == plane:
        return x, y
    unit = metres_per_unit(own)
    turned = pyproj.Transformer.from_crs(own, plane, always_xy=True).transform(x / unit, y / unit)
    return np.asarray(turned[0], float), np.asarray(turned[1], float)


def _structured(
    data: xr.Dataset,
    variables: dict[str, cf.Variable],
    variable: str,
    plane: pyproj.CRS,
    crs: str,
    within: Rectangle | None,
    path: Path,
) -> Grid | Mesh:
    """Cells of a structured grid: axes of their own, or two-dimensional places."""
    flat = {
        kind: next((v for v in cf.by_standard_name(variables, kind) if len(v.dims) == 2), None)
        for kind in ("longitude", "latitude")
    }
    lon2, lat2 = flat["longitude"], flat["latitude"]
    item = _horizontal(variables, variable, path)
    if item is not None and cf.layout(variables, item, path).places:
        item = None
    if item is None and lon2 is not None and lat2 is not None:
        shape = data[lon2.name].shape
        lon, lat = (_values(data, item.name, path).ravel() for item in (lon2, lat2))
        x, y = from_lonlat(plane, lon, lat)
        faces = _near_map(lon, lat, x, y, _ring(shape, False))
        return _mesh(x, y, faces, crs, within, path, layout=shape)
    if item is None:
        raise FloeError(f"{path}: no variable lies on longitude and latitude, or projected x and y")
    layout = cf.layout(variables, item, path)
    _monotone(data, layout.x, path)
    _monotone(data, layout.y, path)
    source = source_grid(variables, item, layout, data, path)
    assert isinstance(source, Source)  # curvilinear ones went the other way
    scale = layout.scale or (metres_per_unit(source.crs) if source.crs else 1.0)
    x, y = np.meshgrid(*(_values(data, name, path) * scale for name in (layout.x, layout.y)))
    faces = _ring(x.shape, source.periodic)
    if source.crs is None:
        px, py = from_lonlat(plane, x.ravel(), y.ravel())
        faces = _near_map(x.ravel(), y.ravel(), px, py, faces)
    elif source.crs == plane and _even(x[0]) and _even(y[:, 0]):
        return Grid(x[0], y[:, 0], crs)
    else:
        px, py = _between(source.crs, plane, x.ravel(), y.ravel())
    return _mesh(px, py, faces, crs, within, path, layout=x.shape)


def _horizontal(variables: dict[str, cf.Variable], name: str, path: Path) -> cf.Variable | None:
    """The variable of a name, or the first on a horizontal grid of axes of their own."""
    if name:
        return cf.named(variables, name, path, "the target")
    for item in variables.values():
        kinds = {cf.dimension_kind(variables, dim) for dim in item.dims}
        if {"latitude", "longitude"} <= kinds or {"projected x", "projected y"} <= kinds:
            return item
    return None


def _monotone(data: xr.Dataset, name: str, path: Path) -> None:
    axis = np.asarray(data[name].values, float)
    steps = np.diff(axis)
    if not ((steps > 0).all() or (steps < 0).all()):
        wrong = int(np.argmax(np.sign(steps) != np.sign(steps[0]))) + 1
        raise FloeError(f"{path}: axis '{name}' is not monotone at index {wrong} ({axis[wrong]:g})")


def _even(axis: Array) -> bool:
    steps = np.diff(axis)
    return bool((steps > 0).all() and np.ptp(steps) <= 1e-6 * steps[0])


def _ring(shape: tuple[int, ...], periodic: bool) -> Index:
    """Quadrilaterals between the cells' centres of a structured grid, (faces, 4)."""
    number = np.arange(shape[0] * shape[1]).reshape(shape)
    if periodic:
        number = np.concatenate([number, number[:, :1]], axis=1)
    ring = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    return np.stack([part.ravel() for part in ring], axis=1)
