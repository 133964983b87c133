# SPDX-License-Identifier: GPL-2.0-or-later
"""Polygon meshes as VTK files for ParaView, and meshes to read: the only module with meshio.

meshio's last release is of 2024, so it may have to be replaced; what is asked of it is in a few
functions here. Polygons go in blocks of one number of corners, the form in which meshio takes them.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
from numpy.typing import NDArray

from floeflow.core.atomic_write import write_atomically
from floeflow.core.errors import FloeError
from floeflow.core.mesh_check import check_mesh_file

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def write_polygons(
    path: Path, start: Index, x: Array, y: Array, cell_data: Mapping[str, NDArray[np.generic]]
) -> None:
    """Write polygons as an unstructured VTK mesh (``.vtu``), whole or not at all.

    Parameters
    ----------
    path : Path
        The file; its folder is made.
    start : ndarray
        First corner of each polygon, and the end, (polygon + 1,). Three corners at least.
    x, y : ndarray
        Corners of the open rings (m), (corner,).
    cell_data : mapping
        Fields by name, (polygon,) or (polygon, 3).

    Raises
    ------
    FloeError
        Where there is no polygon, or the file cannot be written.
    """
    corners = np.diff(start)
    if not len(corners):
        raise FloeError(f"{path}: there is no polygon to write")
    blocks, rows = [], []
    for count in np.unique(corners):
        row = np.flatnonzero(corners == count)
        rows.append(row)
        blocks.append(("polygon", start[row][:, None] + np.arange(count)))
    mesh = meshio.Mesh(
        np.stack([x, y, np.zeros_like(x)], axis=1),
        blocks,
        cell_data={name: [values[row] for row in rows] for name, values in cell_data.items()},
    )
    with write_atomically(path) as temporary:
        mesh.write(temporary, file_format="vtu")


def write_lines(path: Path, points: Array, cell_data: Mapping[str, NDArray[np.generic]]) -> None:
    """Write straight lines as an unstructured VTK mesh (``.vtu``), whole or not at all.

    Parameters
    ----------
    path : Path
        The file; its folder is made.
    points : ndarray
        Both ends of each line (m), (line, 2, 2).
    cell_data : mapping
        Fields by name, (line,).

    Raises
    ------
    FloeError
        Where the file cannot be written.
    """
    count = len(points)
    flat = np.zeros((2 * count, 3))
    flat[:, :2] = points.reshape(-1, 2)
    ends = np.arange(2 * count).reshape(count, 2)
    mesh = meshio.Mesh(
        flat, [("line", ends)], cell_data={name: [values] for name, values in cell_data.items()}
    )
    with write_atomically(path) as temporary:
        mesh.write(temporary, file_format="vtu")


def write_points(
    path: Path, x: Array, y: Array, point_data: Mapping[str, NDArray[np.generic]]
) -> None:
    """Write points as an unstructured VTK mesh (``.vtu``) of vertices, whole or not at all.

    Parameters
    ----------
    path : Path
        The file; its folder is made.
    x, y : ndarray
        Places (m), (point,).
    point_data : mapping
        Fields by name, (point,) or (point, 3).

    Raises
    ------
    FloeError
        Where the file cannot be written.
    """
    mesh = meshio.Mesh(
        np.stack([x, y, np.zeros_like(x)], axis=1),
        [("vertex", np.arange(len(x))[:, None])],
        point_data=dict(point_data),
    )
    with write_atomically(path) as temporary:
        mesh.write(temporary, file_format="vtu")


def write_cells(
    path: Path, x: Array, y: Array, cell_data: Mapping[str, NDArray[np.generic]]
) -> None:
    """Write the cells of a grid as quadrilaterals of a VTK mesh (``.vtu``), whole or not at all.

    Parameters
    ----------
    path : Path
        The file; its folder is made.
    x, y : ndarray
        Edges of columns and rows, ascending (m), (columns + 1,) and (rows + 1,).
    cell_data : mapping
        Fields by name, (rows * columns,) or (rows * columns, k), row by row.

    Raises
    ------
    FloeError
        Where the file cannot be written.
    """
    place_x, place_y = (each.ravel() for each in np.meshgrid(x, y))
    corner = np.arange(place_x.size).reshape(len(y), len(x))
    quads = [corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]]
    mesh = meshio.Mesh(
        np.stack([place_x, place_y, np.zeros_like(place_x)], axis=1),
        [("quad", np.stack([each.ravel() for each in quads], axis=1))],
        cell_data={name: [values] for name, values in cell_data.items()},
    )
    with write_atomically(path) as temporary:
        mesh.write(temporary, file_format="vtu")


def read_faces(path: Path) -> tuple[Array, Array, Index]:
    """Read the triangles and quadrilaterals of a mesh in any format of meshio.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    tuple of ndarray
        Points x and y (m), (points,), and points of each face, (faces, 4), -1 ending a triangle's.

    Raises
    ------
    FloeError
        For a file that is missing, that meshio does not read, or that has other faces or none.
    """
    if not path.is_file():
        raise FloeError(f"{path}: there is no such file")
    try:
        # meshio ends the process where it does not know a format, and raises what it likes else.
        mesh = meshio.read(path)
    except (Exception, SystemExit) as error:
        raise FloeError(f"{path}: meshio cannot read it ({type(error).__name__})") from None
    parts = []
    for block in mesh.cells:
        if block.dim != 2:
            continue
        corners = np.asarray(block.data, dtype=np.int64)
        if block.type not in ("triangle", "quad", "polygon") or corners.shape[1] > 4:
            raise FloeError(f"{path}: has faces of kind '{block.type}', not triangle or quad")
        short = np.full((len(corners), 4 - corners.shape[1]), -1)
        parts.append(np.concatenate([corners, short], axis=1))
    if not parts:
        raise FloeError(f"{path}: has no triangles or quadrilaterals")
    x, y = (np.asarray(mesh.points[:, axis], dtype=np.float64) for axis in (0, 1))
    return x, y, np.concatenate(parts)


def write_triangles(path: Path, points: Array, triangles: Index) -> None:
    """Write a triangle mesh in the format that the file's ending names, whole or not at all.

    Parameters
    ----------
    path : Path
        The file, ``.stl`` or ``.vtu``; its folder is made.
    points : ndarray
        Corners (m), (n, 3).
    triangles : ndarray
        Rows of each triangle's corners, (m, 3).

    Raises
    ------
    FloeError
        Where the file cannot be written.
    """
    with write_atomically(path) as temporary:
        meshio.write(temporary, meshio.Mesh(points, [("triangle", triangles)]), path.suffix[1:])


def read_triangles(path: Path) -> tuple[Array, Index]:
    """Read a triangle mesh (STL, or another format that meshio knows by its name).

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    tuple of ndarray
        Corners (m), (n, 3), and the rows of each triangle's corners, (m, 3).

    Raises
    ------
    FloeError
        Where it cannot be read, has no triangles or other cells, or is not finite.
    """
    check_mesh_file(path)
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            mesh = meshio.read(path)
        cells = {block.type for block in mesh.cells}
        points = np.asarray(mesh.points, dtype=float).reshape(-1, 3)
        triangles = np.asarray(mesh.get_cells_type("triangle"), dtype=np.int64).reshape(-1, 3)
    except OSError as error:
        raise FloeError(f"{path}: the mesh cannot be read: {error.strerror}") from None
    except (Exception, SystemExit):  # meshio ends the process where it knows no format
        raise FloeError(f"{path}: is not a triangle mesh that can be read") from None
    other = cells - {"triangle"}
    if len(triangles) == 0 or other:
        found = ", ".join(sorted(other)) or "nothing"
        raise FloeError(f"{path}: a wall is a mesh of triangles and nothing else; found {found}")
    if not np.isfinite(points).all():
        raise FloeError(f"{path}: a corner of the mesh is not finite")
    return points, triangles


def write_series(path: Path, files: Sequence[str], times: Sequence[float]) -> None:
    """Write a ParaView collection (``.pvd``): meshes and their times, whole or not at all.

    Parameters
    ----------
    path : Path
        The file.
    files : sequence of str
        Paths of the meshes from the folder of this file.
    times : sequence of float
        Their times (s).

    Raises
    ------
    FloeError
        Where it cannot be written.
    """
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for file, time in zip(files, times, strict=True):
        ElementTree.SubElement(collection, "DataSet", timestep=repr(time), part="0", file=file)
    ElementTree.indent(root)
    with write_atomically(path) as temporary:
        ElementTree.ElementTree(root).write(temporary, xml_declaration=True)
