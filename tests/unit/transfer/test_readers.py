# SPDX-License-Identifier: GPL-2.0-or-later
"""Grids and meshes of other programs: places, planes carried to them, and what is refused."""

import meshio
import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.transfer import MLS, Grid, Mesh, build_weights
from floeflow.transfer.readers import read_target

CRS = "EPSG:3413"
PLANE = pyproj.CRS(CRS)
TO_LONLAT = pyproj.Transformer.from_crs(PLANE, PLANE.geodetic_crs, always_xy=True)


def elements(n=3000, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(-5e5, 5e5, n), rng.uniform(-12e5, -2e5, n)


def plane_error(target):
    """Error of a plane at the nodes that have a fit, and their number."""
    x, y = elements()
    weights = build_weights(x, y, np.ones(len(x)), target)
    fits = weights.status == MLS
    node_x, node_y = (axis.reshape(target.shape) for axis in target.places())
    exact = 1.0 + 1e-6 * node_x - 2e-6 * node_y
    error = weights.apply(1.0 + 1e-6 * x - 2e-6 * y) - exact
    return np.abs(error[fits]).max(), int(fits.sum())


def lattice(nx=8, ny=7):
    """Nodes of a lattice, moved about, in projected metres; faces are the squares."""
    rng = np.random.default_rng(1)
    x, y = np.meshgrid(np.linspace(-4e5, 4e5, nx), np.linspace(-11e5, -3e5, ny))
    x, y = x + rng.uniform(-1e4, 1e4, x.shape), y + rng.uniform(-1e4, 1e4, x.shape)
    k = np.arange(nx * ny).reshape(ny, nx)
    quads = np.stack([k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]], axis=-1).reshape(-1, 4)
    return x, y, quads


def ugrid(x, y, faces, start=1, names=("lon", "lat"), units=("degrees_east", "degrees_north")):
    mesh = xr.Dataset(
        {
            "mesh": ((), np.int32(0), {
                "cf_role": "mesh_topology",
                "topology_dimension": 2,
                "node_coordinates": " ".join(names),
                "face_node_connectivity": "face_nodes",
            }),
            names[0]: (("node",), x, {"units": units[0]}),
            names[1]: (("node",), y, {"units": units[1]}),
            "face_nodes": (("face", "corner"), np.where(faces < 0, -999, faces + start), {
                "start_index": start
            }),
        }
    )  # fmt: skip
    mesh["face_nodes"].encoding = {"_FillValue": -999, "dtype": "int32"}
    return mesh


def mixed_faces(quads):
    """Half of the squares cut into triangles."""
    a, b, c, d = quads[: len(quads) // 2].T
    none = np.full_like(a, -1)
    parts = [np.stack([a, b, c, none], 1), np.stack([a, c, d, none], 1), quads[len(quads) // 2 :]]
    return np.concatenate(parts)


def test_meshio(tmp_path):
    x, y, quads = lattice()
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    faces = mixed_faces(quads)
    cells = [("triangle", faces[faces[:, 3] < 0][:, :3]), ("quad", faces[faces[:, 3] >= 0])]
    for name in ("mesh.vtu", "mesh.vtk"):
        meshio.Mesh(points, cells).write(tmp_path / name)
        target = read_target(tmp_path / name, CRS)
        assert isinstance(target, Mesh) and target.shape == (56,)
        error, fits = plane_error(target)
        assert error < 1e-11 and fits == 56


@pytest.mark.parametrize("start", [0, 1])
def test_ugrid_in_degrees(tmp_path, start):
    x, y, quads = lattice()
    lon, lat = TO_LONLAT.transform(x.ravel(), y.ravel())
    ugrid(lon, lat, mixed_faces(quads), start).to_netcdf(tmp_path / "u.nc")
    target = read_target(tmp_path / "u.nc", CRS)
    np.testing.assert_allclose(target.x, x.ravel(), atol=1e-3)
    assert len(target.faces) == len(mixed_faces(quads))
    error, fits = plane_error(target)
    assert error < 1e-11 and fits == 56


def test_mpas(tmp_path):
    """Cells of a sphere at the pole, and one triangle of the far side of the earth."""
    x, y, quads = lattice()
    lon, lat = TO_LONLAT.transform(x.ravel(), y.ravel())
    lon, lat = np.append(lon, [0, 120, 240]), np.append(lat, [-90, -90, -90])
    a, b, c, d = quads.T
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1), [[56, 57, 58]]])
    outside = np.concatenate([triangles + 1, [[1, 2, 0]]])
    xr.Dataset(
        {
            "lonCell": ("nCells", np.radians(np.mod(lon, 360))),
            "latCell": ("nCells", np.radians(lat)),
            "areaCell": ("nCells", np.full(59, 1.3e10 / 6371e3**2)),
            "cellsOnVertex": (("nVertices", "vertexDegree"), outside.astype(np.int32)),
        },
        attrs={"on_a_sphere": "YES", "sphere_radius": 1.0},
    ).to_netcdf(tmp_path / "mpas.nc")
    target = read_target(tmp_path / "mpas.nc", CRS)
    assert target.shape == (59,) and len(target.faces) == len(triangles) - 1
    np.testing.assert_allclose(target.area, 1.3e10, rtol=1e-12)
    error, fits = plane_error(target)
    assert error < 1e-11 and fits == 56
    near = read_target(tmp_path / "mpas.nc", CRS, within=(-4e5, 0.0, -11e5, -3e5))
    assert 0 < len(near.faces) < len(target.faces)
    with pytest.raises(FloeError, match="none of its faces lies on the map"):
        read_target(tmp_path / "mpas.nc", CRS, within=(2e6, 3e6, 2e6, 3e6))


def structured(x, y, crs=CRS, units="m"):
    data = xr.Dataset(
        {"siconc": (("y", "x"), np.zeros((len(y), len(x))), {"grid_mapping": "crs"})},
        coords={
            "x": ("x", x, {"standard_name": "projection_x_coordinate", "units": units}),
            "y": ("y", y, {"standard_name": "projection_y_coordinate", "units": units}),
        },
    )
    data["crs"] = ((), 0, pyproj.CRS(crs).to_cf())
    return data


def test_projected_grids(tmp_path):
    x, y = np.linspace(-4e5, 4e5, 9), np.linspace(-11e5, -3e5, 9)
    structured(x / 1e3, y / 1e3, units="km").to_netcdf(tmp_path / "even.nc")
    target = read_target(tmp_path / "even.nc", CRS)
    assert isinstance(target, Grid) and target.crs == CRS
    np.testing.assert_allclose(target.x, x)
    for name, data, shape in (
        ("uneven", structured(x + 1e4 * np.sin(np.arange(9.0)), y), (9, 9)),
        ("down", structured(x, y[::-1]), (9, 9)),
        ("other", structured(x, y, "EPSG:3411"), (9, 9)),
    ):
        data.to_netcdf(tmp_path / f"{name}.nc")
        target = read_target(tmp_path / f"{name}.nc", CRS)
        assert isinstance(target, Mesh) and target.shape == shape
        error, fits = plane_error(target)
        assert error < 1e-11 and fits == 81
    down = read_target(tmp_path / "down.nc", CRS)
    np.testing.assert_allclose(down.y.reshape(9, 9)[0], y[-1])


def test_longitude_and_latitude(tmp_path):
    """A global grid of the Arctic, rows to the pole; and the same with two-dimensional places."""
    lon, lat = np.arange(0.0, 360.0, 10.0), np.arange(60.0, 90.1, 3.0)
    xr.Dataset(
        {"t": (("lat", "lon"), np.zeros((11, 36)))},
        coords={
            "lon": ("lon", lon, {"units": "degrees_east"}),
            "lat": ("lat", lat, {"units": "degrees_north"}),
        },
    ).to_netcdf(tmp_path / "global.nc")
    target = read_target(tmp_path / "global.nc", CRS)
    assert target.shape == (11, 36)
    # The row at the pole is one point, so its cells are no quadrilaterals.
    assert len(target.faces) == 9 * 36
    assert plane_error(target)[0] < 1e-11
    x, y, _ = lattice()
    places = TO_LONLAT.transform(x, y)
    xr.Dataset(
        {
            name: (("j", "i"), values, {"standard_name": name, "units": "degrees"})
            for name, values in zip(("longitude", "latitude"), places, strict=True)
        }
    ).to_netcdf(tmp_path / "curved.nc")
    target = read_target(tmp_path / "curved.nc", CRS)
    assert target.shape == (7, 8)
    error, fits = plane_error(target)
    assert error < 1e-11 and fits == 56


def refused(path, match, crs=CRS, **more):
    with pytest.raises(FloeError, match=match) as caught:
        read_target(path, crs, **more)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_wrong_files_are_refused_in_a_sentence(tmp_path):
    x, y = np.linspace(-4e5, 4e5, 5), np.linspace(-11e5, -3e5, 5)
    path = tmp_path / "a.nc"
    refused(path, "there is no such file")
    structured(x, y).to_netcdf(path)
    refused(path, "no projection .crs. is given", crs="")
    refused(path, "'EPSG:4326' is not a projection in metres", crs="EPSG:4326")
    refused(path, "'nonsense' names no coordinate system", crs="nonsense")
    refused(path, "asks for variable 'sicon', which is not there", variable="sicon")
    structured(x, y, units="degrees").to_netcdf(path)
    refused(path, "coordinate 'x' has units 'degrees', not m or km")
    structured(x, y).drop_vars("crs").to_netcdf(path)
    refused(path, "variable 'siconc' lies on projected coordinates but has no grid_mapping")
    structured(x, y[[0, 2, 1, 3, 4]]).to_netcdf(path)
    refused(path, "axis 'y' is not monotone at index 2")
    xr.Dataset({"a": ("b", [1.0])}).to_netcdf(path)
    refused(path, "no variable lies on longitude and latitude")
    nodes = ugrid(*(np.array([0.0, 1, 1, 0, 0.5]), np.array([80.0, 80, 81, 81, 82])),
                  np.array([[0, 1, 2, 4, 3]]))  # fmt: skip
    nodes.to_netcdf(path)
    refused(path, "'face_nodes': face 0 has more than four corners")
    bad = ugrid(x, y, np.array([[0, 1, 2, 3]]), names=("nx", "ny"), units=("m", "m"))
    bad.to_netcdf(path)
    refused(path, "'mesh' has nodes in metres but no grid_mapping")
    vtu = tmp_path / "b.vtu"
    refused(vtu, "there is no such file")
    vtu.write_text("nothing")
    refused(vtu, "meshio cannot read it")
    points = np.array([[0.0, 80, 0], [10, 80, 0], [10, 85, 0]])
    meshio.Mesh(points, [("triangle", np.array([[0, 1, 2]]))]).write(vtu)
    refused(vtu, "points look like degrees, but metres of EPSG:3413 are needed")
    meshio.Mesh(points, [("line", np.array([[0, 1]]))]).write(vtu)
    refused(vtu, "has no triangles or quadrilaterals")
