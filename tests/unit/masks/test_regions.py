# SPDX-License-Identifier: GPL-2.0-or-later
"""Uniform ice, regions that cut it, shorelines of the user's."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pyproj
import pytest

from floeflow.core.errors import FloeError
from floeflow.core.grids import mask_grid, scene_crs, to_lonlat
from floeflow.masks.mask import make_mask
from floeflow.masks.polygon_inputs import polygon_inputs
from floeflow.masks.regions import SEAS, region_cells
from floeflow.scene import Scene, parse_scene
from floeflow.scene.blocks import Domain


def scene_of(**mask: object) -> Scene:
    keys = {"name": "t", "mask": {"uniform": 0.8, "land": "none", "refine": 1} | mask}
    return parse_scene(json.dumps(keys).encode(), "t")


def square(path: Path, x: float, y: float, half: float) -> str:
    """GeoJSON of a square on the map."""
    side = np.linspace(-1, 1, 200)
    one, last = np.ones(200), side[::-1]
    sides = [(side, -one), (one, side), (last, one), (-one, last)]
    corners = np.concatenate([np.stack(pair, axis=1) for pair in sides]) * half + [x, y]
    corners[-1] = corners[0]
    lon, lat = to_lonlat(scene_crs(Domain()), *corners.T)
    ring = np.stack([lon, lat], axis=1).tolist()
    path.write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))
    return str(path)


def test_uniform_ice_needs_no_file() -> None:
    mask = make_mask(scene_of(), None)
    assert (mask["siconc"].values == 0.8).all()
    assert mask["sithick"].values == pytest.approx(1.6)


def test_a_region_keeps_ice_inside_alone(tmp_path: Path) -> None:
    mask = make_mask(scene_of(region=square(tmp_path / "a.json", 1.5e6, -1.5e6, 1e6)), None)
    x, y = np.meshgrid(mask["x"], mask["y"])
    inside = (abs(x - 1.5e6) < 1e6) & (abs(y + 1.5e6) < 1e6)
    np.testing.assert_array_equal(mask["siconc"].values > 0, inside)
    assert (mask["land"].values == 0).all()


@pytest.mark.parametrize(
    ("place", "half", "sentence"),
    [(6e6, 3e5, "lies wholly outside of the scene"), (1e3, 1e2, "is narrower than the mask's")],
)
def test_a_shoreline_without_land_in_the_scene_is_refused(
    tmp_path: Path, place: float, half: float, sentence: str
) -> None:
    path = square(tmp_path / "far.json", place, place, half)
    with pytest.raises(FloeError, match=rf"^mask\.shoreline: '.*far\.json' {sentence}"):
        make_mask(scene_of(shoreline=path), None)


def test_a_shoreline_is_land(tmp_path: Path) -> None:
    mask = make_mask(scene_of(shoreline=square(tmp_path / "a.json", 0.0, 0.0, 6e5)), None)
    x, y = np.meshgrid(mask["x"], mask["y"])
    inside = (abs(x) < 6e5) & (abs(y) < 6e5)
    np.testing.assert_array_equal(mask["land"].values > 0, inside)
    assert (mask["siconc"].values[inside] == 0).all()


@pytest.mark.parametrize("name", SEAS)
def test_named_seas_lie_where_their_box_says(name: str) -> None:
    west, east, south, north = SEAS[name]
    crs = "EPSG:6931" if south > 0 else "EPSG:6932"
    domain = Domain(crs=crs, x_min=-6e6, x_max=6e6, y_min=-6e6, y_max=6e6)
    grid = mask_grid(domain, 1)
    lon, lat = to_lonlat(scene_crs(domain), *grid.mesh())
    inside = (np.mod(lon - west, 360.0) < east - west) & (lat > south) & (lat < north)
    found = region_cells(name, grid, crs)
    # Cells beside the sides may go either way.
    assert (found != inside).sum() <= 0.02 * inside.sum() + 2
    assert found.sum() >= 50


def test_what_is_no_region_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FloeError, match="did you mean 'barents_sea'"):
        make_mask(scene_of(region="barent_sea"), None)
    with pytest.raises(FloeError, match="neither a named sea nor a file of polygons"):
        make_mask(scene_of(region="x"), None)
    with pytest.raises(FloeError, match="'weddell_sea' lies"):
        make_mask(scene_of(region="weddell_sea"), None)
    with pytest.raises(FloeError, match="no.json: cannot be read"):
        make_mask(scene_of(shoreline=str(tmp_path / "no.json")), None)
    bow = [[-150, 75], [-130, 80], [-130, 75], [-150, 80], [-150, 75]]
    (tmp_path / "bow.json").write_text(json.dumps({"type": "Polygon", "coordinates": [bow]}))
    with pytest.raises(FloeError, match=r"bow.json: feature 1: its ring crosses itself"):
        make_mask(scene_of(region=str(tmp_path / "bow.json")), None)
    with pytest.raises(FloeError, match="mask.uniform is ice without a file"):
        scene_of(land="mask")


def test_ice_ends_at_the_planes_of_walls() -> None:
    """Cells whose centre lies behind a plane hold none; the notes say how much that was."""
    keys = {
        "name": "t",
        "effects": ["friction", "walls"],
        "domain": {"x_min": 0.0, "x_max": 1e6, "y_min": 0.0, "y_max": 1e6, "spacing": 1e5},
        "mask": {"uniform": 0.8, "land": "none", "refine": 1},
        "walls": {"rim": ["left", "top"], "planes": [[7.0e5, 0.0, -1.0, 0.0, 0.0, 0.0]]},
    }
    mask = make_mask(parse_scene(json.dumps(keys).encode(), "t"), None)
    assert (mask["siconc"].values == np.where(mask["x"].values < 7e5, 0.8, 0.0)).all()
    assert (mask["sithick"].values > 0).sum() == 70
    assert "30 % of the ice lies behind" in mask.attrs["notes"]
    keys["effects"] = ["friction"]
    free = make_mask(parse_scene(json.dumps(keys).encode(), "t"), None)
    assert (free["siconc"].values == 0.8).all() and free.attrs["notes"] == ""


def write_shapefile(path: Path, rings: list[np.ndarray], crs: str) -> None:
    """One polygon of closed rings, clockwise around land, and its projection."""
    corners = np.concatenate(rings).astype("<f8")
    start = np.cumsum([0, *(len(ring) for ring in rings)])[:-1].astype("<i4")
    box = np.concatenate([corners.min(axis=0), corners.max(axis=0)]).astype("<f8")
    counts = struct.pack("<2i", len(rings), len(corners))
    record = struct.pack("<i", 5) + box.tobytes() + counts + start.tobytes() + corners.tobytes()
    words = len(record) // 2
    header = struct.pack(">i5ii", 9994, 0, 0, 0, 0, 0, 54 + words)
    header += struct.pack("<2i", 1000, 5) + box.tobytes() + bytes(32)
    path.write_bytes(header + struct.pack(">2i", 1, words) + record)
    path.with_suffix(".prj").write_text(pyproj.CRS.from_user_input(crs).to_wkt("WKT1_ESRI"))


@pytest.mark.parametrize("crs", ["EPSG:3413", "EPSG:4326"])
def test_a_shapefile_is_a_shoreline_in_its_own_projection(tmp_path: Path, crs: str) -> None:
    """Land with a lake in it; inner rings run the other way round."""
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = np.column_stack([np.sin(angle), np.cos(angle)])
    circle[-1] = circle[0]
    rings = [1.5e6 * circle + [6e5, 0.0], 7e5 * circle[::-1] + [6e5, 0.0]]
    own = pyproj.Transformer.from_crs("EPSG:6931", crs, always_xy=True)
    path = tmp_path / "shore.shp"
    moved = [np.column_stack(own.transform(*ring.T)) for ring in rings]
    # A ring around the pole has no inside in longitude and latitude: that one is drawn elsewhere.
    if crs == "EPSG:4326":
        rings = [ring + [1.5e6, 0.0] for ring in rings]
        moved = [np.column_stack(own.transform(*ring.T)) for ring in rings]
    write_shapefile(path, moved, crs)
    mask = make_mask(scene_of(shoreline=str(path)), None)
    x, y = np.meshgrid(mask["x"], mask["y"])
    away = np.hypot(x - rings[0][:, 0].mean(), y)
    clear = np.minimum(abs(away - 1.5e6), abs(away - 7e5)) > 1e4
    inside = (away < 1.5e6) & (away > 7e5)
    np.testing.assert_array_equal((mask["land"].values > 0)[clear], inside[clear])
    assert polygon_inputs(scene_of(shoreline=str(path)).mask) == [
        str(path), str(path.with_suffix(".prj")),
    ]  # fmt: skip


def test_bad_shapefiles_are_refused(tmp_path: Path) -> None:
    def fault(path: Path) -> str:
        with pytest.raises(FloeError) as found:
            make_mask(scene_of(shoreline=str(path)), None)
        return str(found.value)

    path = tmp_path / "shore.shp"
    square = np.array([[0, 60], [0, 70], [10, 70], [10, 60], [0, 60]], float)
    write_shapefile(path, [square], "EPSG:4326")
    whole = path.read_bytes()
    path.write_bytes(whole[:-40])
    assert fault(path).endswith("record 1 is cut off")
    path.write_bytes(whole[:108] + struct.pack("<i", 3) + whole[112:])
    assert "is of type 3, not a polygon" in fault(path)
    path.write_bytes(b"PK" + whole[2:])
    assert fault(path) == f"{path}: this is no shapefile"
    write_shapefile(path, [square[::-1]], "EPSG:4326")
    assert "no ring that runs clockwise" in fault(path)
    write_shapefile(path, [square + [400.0, 0.0]], "EPSG:4326")
    assert "no places in the projection" in fault(path)
    path.with_suffix(".prj").write_text("here")
    assert fault(path).endswith("names no projection that is known")
    path.with_suffix(".prj").unlink()
    assert "needs shore.prj beside it" in fault(path)
