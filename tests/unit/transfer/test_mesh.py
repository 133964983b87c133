# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes of triangles and quadrilaterals: hats, areas, planes, places on edges, files."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.core.errors import FloeError
from floeflow.transfer import (
    MLS,
    Grid,
    Mesh,
    build_weights,
    curvilinear,
    load_weights,
    save_weights,
)


def mixed():
    """A 4 x 4 lattice, moved about, of quadrilaterals whose right half is cut into triangles."""
    rng = np.random.default_rng(0)
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(5.0), np.arange(5.0)))
    x, y = x + rng.uniform(-0.2, 0.2, 25), y + rng.uniform(-0.2, 0.2, 25)
    faces = []
    for j in range(4):
        for i in range(4):
            a, b, c, d = 5 * j + i, 5 * j + i + 1, 5 * j + i + 6, 5 * j + i + 5
            faces += [(a, b, c, d)] if i < 2 else [(a, c, b, -1), (a, c, d, -1)]
    return Mesh(x, y, np.array(faces))


def inside(mesh, n, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.3, 3.7, n), rng.uniform(0.3, 3.7, n)


def test_hats_add_up_and_reproduce_places():
    mesh = mixed()
    x, y = inside(mesh, 500)
    s = mesh.pairs(x, y)
    node = np.repeat(np.arange(25), np.diff(s.start))
    for nodal, exact in ((np.ones(25), np.ones(500)), (mesh.x, x), (mesh.y, y)):
        found = np.bincount(s.element, s.hat * nodal[node], 500)
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-12)
    assert (s.hat > 0).all() and (s.hat <= 1).all()


def test_node_areas_are_those_of_the_mesh():
    mesh = mixed()
    corners = mesh.faces
    area = 0.0
    for face in corners:
        ring = face[face >= 0]
        x, y = mesh.x[ring], mesh.y[ring]
        area += abs(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    assert mesh.area.sum() == pytest.approx(area, rel=1e-14)
    even = curvilinear(np.arange(4.0), np.arange(3.0))
    assert even.area.reshape(3, 4)[1].tolist() == pytest.approx([0.5, 1.0, 1.0, 0.5])


def test_planes_are_exact_on_a_mesh(tmp_path):
    mesh = mixed()
    x, y = inside(mesh, 300)
    weights = build_weights(x, y, np.random.default_rng(2).uniform(0.1, 2, 300), mesh)
    save_weights(weights, tmp_path / "mesh.nc")
    again = load_weights(tmp_path / "mesh.nc")
    mls = weights.status == MLS
    assert mls.sum() >= 20
    field = 3.0 + 2.0 * x - 5.0 * y
    np.testing.assert_allclose(
        again.apply(field)[mls], (3 + 2 * mesh.x - 5 * mesh.y)[mls], rtol=0, atol=2e-11
    )
    assert again.apply(field).tobytes() == weights.apply(field).tobytes()


def test_structured_grid_as_a_mesh_agrees_with_the_grid():
    grid = Grid(np.arange(6.0), np.arange(5.0))
    rng = np.random.default_rng(3)
    x, y = rng.uniform(0, 5, 200), rng.uniform(0, 4, 200)
    mesh = curvilinear(grid.x, grid.y)
    assert mesh.shape == grid.shape
    a, b = (build_weights(x, y, np.ones(200), target) for target in (grid, mesh))
    field = np.sin(x) * y
    np.testing.assert_allclose(b.apply(field), a.apply(field), rtol=1e-10)


@settings(deadline=None, derandomize=True, max_examples=100)
@given(st.lists(st.tuples(st.integers(-2, 10), st.integers(-2, 10)), max_size=8))
def test_places_on_nodes_edges_and_outside(rows):
    """Elements on a lattice of half spacings of the mesh: each has at most one face's nodes."""
    mesh = curvilinear(np.arange(5.0), np.arange(5.0))
    x, y = 0.5 * np.array(rows, float).reshape(-1, 2).T
    s = mesh.pairs(x, y)
    total = np.bincount(s.element, s.hat, len(x))
    within = (x >= 0) & (x <= 4) & (y >= 0) & (y <= 4)
    np.testing.assert_allclose(total, within, atol=1e-12)
    weights = build_weights(x, y, np.ones(len(x)), mesh)
    assert np.isfinite(weights.matrix.data).all()


def test_wrong_meshes_are_named():
    x, y = np.array([0.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0, 1.0])
    with pytest.raises(FloeError, match="face 0 has no area or is not convex"):
        Mesh(x, y, np.array([[0, 2, 1, 3]]))
    with pytest.raises(FloeError, match="face 1 names no node"):
        Mesh(x, y, np.array([[0, 1, 2, 3], [0, 1, 7, -1]]))
    with pytest.raises(FloeError, match=r"'faces' has shape \(1, 3\)"):
        Mesh(x, y, np.array([[0, 1, 2]]))
    with pytest.raises(FloeError, match="node 1 of a face lies at nan"):
        Mesh(np.array([0.0, np.nan, 1.0, 0.0]), y, np.array([[0, 1, 2, 3]]))
    with pytest.raises(FloeError, match="axis 'y' is not monotone"):
        curvilinear(np.arange(3.0), np.array([0.0, 2.0, 1.0]))
    with pytest.raises(FloeError, match="a reach of 1, not 2"):
        curvilinear(x[:2], np.arange(2.0)).pairs(x, y, 2)
