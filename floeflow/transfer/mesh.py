# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes of triangles and quadrilaterals that fields go to, and the hat functions of their nodes.

The hats are those of linear and bilinear finite elements: 1 at the node, 0 at all others, and they
add up to 1 within a face. Curvilinear grids are meshes of quadrilaterals between their cells'
centres; cells of an MPAS mesh are the nodes of its triangles.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from floeflow.core.errors import FloeError
from floeflow.transfer.stencil import LEAST_HAT, Array, Index, Stencil, check_places, sort_pairs

NEWTON_ROUNDS = 20
_GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)


@dataclass(frozen=True)
class Mesh:
    """A mesh of triangles and convex quadrilaterals in the plane.

    Parameters
    ----------
    x, y : ndarray
        Nodes (m), (nodes,); those of no face may be anywhere, or nowhere (NaN, infinite).
    faces : ndarray of int
        Nodes of each face in a ring of either direction, (faces, 4); -1 ends a triangle's.
    area : ndarray, optional
        Area that each node stands for (m2), (nodes,); the integral of its hat, if not given.
    crs : str
        Projection of the nodes; empty where not said.
    layout : tuple of int
        Shape of a field, where the nodes are those of a structured grid, row by row.

    Raises
    ------
    FloeError
        For faces that name no node, or are no convex polygons, by their number.
    """

    x: Array
    y: Array
    faces: Index
    area: Array = field(default_factory=lambda: np.zeros(0))
    crs: str = ""
    layout: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if self.x.shape != self.y.shape or self.x.ndim != 1:
            raise FloeError("mesh: 'x' and 'y' must be (nodes,)")
        faces = self.faces
        if faces.ndim != 2 or faces.shape[1] != 4 or not len(faces):
            raise FloeError(f"mesh: 'faces' has shape {faces.shape}, not (faces, 4)")
        wrong = (faces < -1) | (faces >= len(self.x)) | ((faces == -1) & (np.arange(4) < 3))
        if wrong.any():
            raise FloeError(f"mesh: face {int(np.argmax(wrong.any(axis=1)))} names no node")
        bad = ~(np.isfinite(self.x) & np.isfinite(self.y))
        corner = self._corners()
        if bad[corner].any():
            node = corner[bad[corner]][0]
            raise FloeError(f"mesh: node {node} of a face lies at {self.x[node]}, {self.y[node]}")
        good = good_faces(self.x, self.y, faces)
        if not good.all():
            raise FloeError(f"mesh: face {int(np.argmin(good))} has no area or is not convex")
        if not self.area.size:
            object.__setattr__(self, "area", self._hat_areas())
        if self.area.shape != self.x.shape or not (self.area >= 0.0).all():
            raise FloeError("mesh: 'area' must be (nodes,) and not negative")

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a field on the nodes."""
        return self.layout or (len(self.x),)

    def places(self) -> tuple[Array, Array]:
        """Nodes, x and y (m), (nodes,) each."""
        return self.x, self.y

    def _corners(self) -> Index:
        """Nodes of the faces, a triangle's last one twice, (faces, 4)."""
        return np.where(self.faces >= 0, self.faces, self.faces[:, 2:3])

    def _hat_areas(self) -> Array:
        """Integral of each node's hat (m2), exact, (nodes,)."""
        area = np.zeros(len(self.x))
        corner = self._corners()
        for triangle in (True, False):
            rows = np.flatnonzero((self.faces[:, 3] < 0) == triangle)
            x, y = self.x[corner[rows]], self.y[corner[rows]]
            if triangle:
                cross = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0])
                cross -= (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
                shares = np.repeat(np.abs(cross)[:, None] / 6.0, 3, axis=1)
            else:
                shares = np.zeros((len(rows), 4))
                for s in _GAUSS:
                    for t in _GAUSS:
                        hats, ds, dt = _bilinear(s, t)
                        jacobian = (x @ ds) * (y @ dt) - (x @ dt) * (y @ ds)
                        shares += 0.25 * np.abs(jacobian)[:, None] * hats
            for k in range(shares.shape[1]):
                np.add.at(area, corner[rows, k], shares[:, k])
        return area

    @cached_property
    def _tree(self) -> shapely.STRtree:
        corner = self._corners()
        rings = np.stack([self.x[corner], self.y[corner]], axis=-1)
        return shapely.STRtree(np.asarray(shapely.polygons(rings)))

    @cached_property
    def _scale(self) -> Array:
        """Longest side or diagonal from each node (m): the reach of its hat, (nodes,)."""
        corner, scale = self._corners(), np.zeros(len(self.x))
        for a in range(4):
            for b in range(a):
                i, j = corner[:, a], corner[:, b]
                away = np.hypot(self.x[i] - self.x[j], self.y[i] - self.y[j])
                np.maximum.at(scale, i, away)
                np.maximum.at(scale, j, away)
        return scale

    def pairs(self, x: Array, y: Array, reach: int = 1) -> Stencil:
        """Find the nodes of each element's face.

        Parameters
        ----------
        x, y : ndarray
            Element centres (m), (n,); a slice of the elements will do. Those outside the mesh
            find no node; one on an edge belongs to the first of its faces.
        reach : int
            Hats of a mesh reach to the neighbouring nodes: 1.

        Returns
        -------
        Stencil
            Pairs sorted by node, with the hat's value (1) and the place of the element relative to
            the node (in the node's length).

        Raises
        ------
        FloeError
            For places that are not finite, lengths that differ, or a reach other than 1.
        """
        if reach != 1:
            raise FloeError(f"remap: hats of a mesh have a reach of 1, not {reach}")
        check_places(x, y, self)
        element, face = self._tree.query(shapely.points(x, y), predicate="intersects")
        order = np.lexsort((face, element))
        element, face = element[order], face[order]
        first = np.flatnonzero(np.diff(element, prepend=-1))
        element, face = element[first], face[first]
        hats = self._hats(x[element], y[element], face)
        corner = self._corners()[face]
        used = np.flatnonzero((hats > LEAST_HAT).ravel())
        node, element = corner.ravel()[used], np.repeat(element, 4)[used]
        scale = self._scale[node]
        xi, eta = (x[element] - self.x[node]) / scale, (y[element] - self.y[node]) / scale
        return sort_pairs(node, element, (hats.ravel()[used], xi, eta), len(self.x), len(x))

    def _hats(self, x: Array, y: Array, face: Index) -> Array:
        """Hats of the faces' corners at places within them, (places, 4)."""
        corner = self._corners()[face]
        hats = np.zeros((len(x), 4))
        flat = np.flatnonzero(self.faces[face, 3] < 0)
        hats[flat, :3] = _barycentric(x[flat], y[flat], self.x[corner[flat]], self.y[corner[flat]])
        quad = np.flatnonzero(self.faces[face, 3] >= 0)
        s, t = _invert(x[quad], y[quad], self.x[corner[quad]], self.y[corner[quad]])
        hats[quad] = _bilinear(s, t)[0].T
        hats = np.clip(hats, 0.0, 1.0)
        return np.asarray(hats / hats.sum(axis=1, keepdims=True))


def _barycentric(x: Array, y: Array, cx: Array, cy: Array) -> Array:
    """Barycentric coordinates of places in triangles, (places, 3)."""
    ux, uy = cx[:, 1] - cx[:, 0], cy[:, 1] - cy[:, 0]
    vx, vy = cx[:, 2] - cx[:, 0], cy[:, 2] - cy[:, 0]
    px, py = x - cx[:, 0], y - cy[:, 0]
    cross = ux * vy - uy * vx
    b, c = (px * vy - py * vx) / cross, (ux * py - uy * px) / cross
    return np.stack([1.0 - b - c, b, c], axis=1)


def _bilinear(s: Array | float, t: Array | float) -> tuple[Array, Array, Array]:
    """Hats of a quadrilateral's corners and their derivatives by s and t, (4, ...)."""
    s, t = np.asarray(s, float), np.asarray(t, float)
    hats = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t])
    ds, dt = np.stack([t - 1, 1 - t, t, -t]), np.stack([s - 1, -s, s, 1 - s])
    return hats, ds, dt


def _invert(x: Array, y: Array, cx: Array, cy: Array) -> tuple[Array, Array]:
    """Coordinates of places in quadrilaterals, by Newton's method from the middle."""
    s, t = np.full(len(x), 0.5), np.full(len(x), 0.5)
    for _ in range(NEWTON_ROUNDS):
        hats, ds, dt = _bilinear(s, t)
        rx, ry = x - (cx.T * hats).sum(0), y - (cy.T * hats).sum(0)
        xs, xt = (cx.T * ds).sum(0), (cx.T * dt).sum(0)
        ys, yt = (cy.T * ds).sum(0), (cy.T * dt).sum(0)
        cross = xs * yt - xt * ys
        step_s, step_t = (rx * yt - ry * xt) / cross, (ry * xs - rx * ys) / cross
        s, t = np.clip(s + step_s, 0.0, 1.0), np.clip(t + step_t, 0.0, 1.0)
        if len(s) == 0 or max(np.abs(step_s).max(), np.abs(step_t).max()) < 1e-14:
            break
    return s, t


def good_faces(x: Array, y: Array, faces: Index) -> NDArray[np.bool_]:
    """Whether faces are convex, have an area, and lie at finite places, (faces,).

    Parameters
    ----------
    x : ndarray
        Nodes, (nodes,), m or degrees.
    y : ndarray
        Nodes, (nodes,), m or degrees.
    faces : Index
        Nodes of each face, (faces, 4), -1 in place of a fourth one.

    Returns
    -------
    ndarray
        False for a face that is refused.
    """
    corner = np.where(faces >= 0, faces, faces[:, 2:3])
    fx, fy = x[corner], y[corner]
    sides = np.where(faces[:, 3:] >= 0, 4, 3)
    k = np.arange(4)
    before, after = (k - 1) % sides, (k + 1) % sides
    with np.errstate(invalid="ignore", over="ignore"):
        ax, ay = (f - np.take_along_axis(f, before, 1) for f in (fx, fy))
        bx, by = (np.take_along_axis(f, after, 1) - f for f in (fx, fy))
        cross = ax * by - ay * bx
    left, right = ((np.where(k < sides, s * cross, 1.0) > 0.0).all(axis=1) for s in (1.0, -1.0))
    finite = (np.isfinite(fx) & np.isfinite(fy)).all(axis=1)
    return np.asarray((left | right) & finite)


def curvilinear(x: Array, y: Array, crs: str = "", area: Array | None = None) -> Mesh:
    """Mesh of a structured grid, whose nodes are its cells' centres.

    Parameters
    ----------
    x, y : ndarray
        Centres of the cells (m), (ny, nx) or, for straight but uneven axes, (nx,) and (ny,).
    crs : str
        Projection of the places.
    area : ndarray, optional
        Areas of the cells (m2), (ny, nx).

    Returns
    -------
    Mesh
        Nodes in the order of the rows; fields have the shape of `x`.

    Raises
    ------
    FloeError
        For axes that are not monotone, or cells that are folded.
    """
    if x.ndim == 1 and y.ndim == 1:
        for name, axis in (("x", x), ("y", y)):
            if len(axis) < 2 or not ((np.diff(axis) > 0).all() or (np.diff(axis) < 0).all()):
                raise FloeError(f"grid: axis '{name}' is not monotone, or has fewer than 2 nodes")
        x, y = np.meshgrid(x, y)
    if x.shape != y.shape or x.ndim != 2 or min(x.shape) < 2:
        raise FloeError(f"grid: 'x' has shape {x.shape} and 'y' {y.shape}; both must be (ny, nx)")
    number = np.arange(x.size).reshape(x.shape)
    ring = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    faces = np.stack([part.ravel() for part in ring], axis=1)
    own = np.zeros(0) if area is None else area.ravel()
    return Mesh(x.ravel(), y.ravel(), faces, own, crs, x.shape)
