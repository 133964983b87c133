# SPDX-License-Identifier: GPL-2.0-or-later
"""`floeflow check`: what was found for each quantity; and the check's process of its own."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from PIL import Image
from typer.testing import CliRunner

from floeflow.analysis import reading_process
from floeflow.analysis.input_check import find_inputs, say
from floeflow.cli import app
from floeflow.core.errors import FloeError
from floeflow.scene import load_scene
from floeflow.scene.load import build_scene
from floeflow.workflow import input_guard

UNITS = "hours since 1981-12-31"


def lonlat(fields: dict[str, tuple[float, dict[str, str]]], hours: np.ndarray) -> xr.Dataset:
    lat, lon = np.arange(60.0, 90.1, 1.0), np.arange(0.0, 360.0, 2.0)
    coords = {
        "time": ("time", hours, {"units": UNITS}),
        "lat": ("lat", lat, {"units": "degrees_north"}),
        "lon": ("lon", lon, {"units": "degrees_east"}),
    }
    shape = (hours.size, lat.size, lon.size)
    data = {n: (tuple(coords), np.full(shape, v), attrs) for n, (v, attrs) in fields.items()}
    return xr.Dataset(data, coords)


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    ice = {"standard_name": "sea_ice_area_fraction", "units": "%"}
    lonlat({"ice": (80.0, ice)}, np.array([6.0])).to_netcdf(tmp_path / "ice.nc")
    wind = {"u10": (3.0, {"units": "m s-1"}), "v10": (4.0, {"units": "m s-1"})}
    wind |= {"avg_sdswrf": (50.0, {"units": "W m-2"})}
    lonlat(wind, np.arange(0.0, 49.0)).to_netcdf(tmp_path / "wind.nc")
    scene = {
        "effects": ["wind", "ocean_drag"],
        "domain": {"x_min": -5e5, "x_max": 5e5, "y_min": -5e5, "y_max": 5e5, "spacing": 1e5},
        "mask": {"file": str(tmp_path / "ice.nc"), "land": "none", "refine": 1},
        "forcing": {"source": "file", "file": str(tmp_path / "wind.nc"),
                    "fallback": {"ocean": "gyre"}},
        "time": {"windows": 1},
    }  # fmt: skip
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(scene))
    return path


def test_all_that_was_found_is_told(scene_file: Path, tmp_path: Path) -> None:
    picture = tmp_path / "maps" / "inputs.png"
    done = CliRunner().invoke(app, ["check", str(scene_file), "--plot", str(picture)])
    assert done.exit_code == 0, done.output
    said = done.output
    for line in (
        f"mask concentration: 'ice' of {tmp_path / 'ice.nc'}",
        "    units '%'",
        "    one record, 0.2 days from the scene's start",
        "    longitude and latitude, 31 x 180",
        "    covers 100.0 % of the scene, interpolated",
        "mask land: none",
        f"wind: 'u10', 'v10' of {tmp_path / 'wind.nc'}",
        "    1981-12-31 00:00:00 to 1982-01-02 00:00:00, 49 records",
        "ocean: no file has it; gyre stands in",
    ):
        assert line in said.splitlines()
    pixels = np.asarray(Image.open(picture).convert("L"))
    assert pixels.std() > 10


def test_floes_of_an_image_and_polygons_are_told(tmp_path: Path) -> None:
    """So that a wrong pixel or place is seen before a run, and a shoreline is known to be read."""
    numbers = np.zeros((20, 30), np.uint8)
    numbers[2:8, 3:9], numbers[12:18, 20:28] = 3, 9
    Image.fromarray(numbers).save(tmp_path / "floes.png")
    x0, y0 = -1.0e5, -1.0e6
    land = [[-5.17, 81.045], [-4.88, 81.049], [-4.91, 81.094], [-5.17, 81.045]]
    shore = tmp_path / "shore.geojson"
    shore.write_text(json.dumps({"type": "Polygon", "coordinates": [land]}))
    scene = build_scene({
        "name": "floes",
        "effects": ["wind", "grid_output"],
        "domain": {"x_min": x0, "x_max": x0 + 3e4, "y_min": y0, "y_max": y0 + 2e4, "spacing": 1e4},
        "mask": {"land": "none", "shoreline": str(shore), "region": "greenland_sea",
                 "labels": {"file": str(tmp_path / "floes.png"), "pixel": 1000.0}},
        "packing": {"generator": "floes", "elements": 40},
        "time": {"windows": 1},
    })  # fmt: skip
    said = say(find_inputs(scene)).splitlines()
    assert f"mask: floes of {tmp_path / 'floes.png'}" in said
    # 36 and 48 of 600 pixels.
    told = "    2 numbers on 30 by 20 pixels of 1000 m over the scene; 14 % of them are ice"
    assert told in said
    assert f"shoreline: {shore}" in said and "ice only in: greenland_sea" in said


def test_a_uniform_mask_and_the_sea_are_told(scene_file: Path, tmp_path: Path) -> None:
    """No mask file is read where the mask is uniform; the mixed layer's start is found too."""
    sea = {"sst": (-1.5, {"units": "degC", "standard_name": "sea_surface_temperature"})}
    lonlat(sea, np.array([6.0])).to_netcdf(tmp_path / "sea.nc")
    keys = yaml.safe_load(scene_file.read_text())
    keys["mask"] = {"file": "nowhere.nc", "land": "none", "uniform": 0.9}
    keys["effects"] += ["thermodynamics", "mixed_layer"]
    keys["forcing"]["fallback"]["weather"] = "weather"
    keys["sea"] = {"file": str(tmp_path / "sea.nc")}
    said = say(find_inputs(build_scene(keys | {"name": "u"})))
    assert "mask: concentration 0.9 on all water, no file" in said
    assert f"sea surface temperature: 'sst' of {tmp_path / 'sea.nc'}" in said
    assert "has none; column.ocean_salinity stands in" in said


def test_what_is_wrong_is_one_sentence(scene_file: Path, tmp_path: Path) -> None:
    (tmp_path / "wind.nc").unlink()
    done = CliRunner().invoke(app, ["check", str(scene_file)])
    assert done.exit_code == 1
    assert "wind.nc: there is no such file" in (done.output + str(done.stderr))


def test_the_guard_says_what_the_checks_say(
    scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scene = load_scene(scene_file)
    input_guard.check_inputs(scene, set())
    passed = list((tmp_path / input_guard.PASSED).iterdir())
    assert len(passed) == 1
    # What passed is not read again as long as nothing changes.
    with monkeypatch.context() as patch:
        patch.setattr(reading_process.subprocess, "run", None)
        input_guard.check_inputs(scene, set())
    lonlat({"u10": (3.0, {"units": "m s-1"})}, np.arange(0.0, 49.0)).to_netcdf(tmp_path / "new.nc")
    (tmp_path / "new.nc").replace(tmp_path / "wind.nc")
    with pytest.raises(FloeError, match=r"^.*wind.nc: has no wind: no standard_names east"):
        input_guard.check_inputs(scene, set())


def test_one_check_does_for_all_scenes_of_the_same_files(
    scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in a dry run, which writes nothing down."""
    monkeypatch.chdir(tmp_path)
    scene, passed = load_scene(scene_file), set[str]()
    input_guard.check_inputs(scene, passed, remember=False)
    assert len(passed) == 1 and not (tmp_path / "results").exists()
    monkeypatch.setattr(reading_process.subprocess, "run", None)
    member = scene.model_copy(update={"name": "member", "seed": 7})
    input_guard.check_inputs(member, passed, remember=False)
    longer = scene.time.model_copy(update={"windows": scene.time.windows + 1})
    other = scene.model_copy(update={"time": longer})
    with pytest.raises(TypeError):
        input_guard.check_inputs(other, passed, remember=False)


def test_a_reader_that_is_brought_down(
    scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by a damaged file in a C library: the sentence names the signal."""
    monkeypatch.chdir(tmp_path)
    crash = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"
    real = reading_process.subprocess.run

    def run(command: list[str], **more: object) -> object:
        return real([command[0], "-c", crash], **more)  # type: ignore[call-overload]

    monkeypatch.setattr(reading_process.subprocess, "run", run)
    with pytest.raises(FloeError, match=f"ended the reader \\({signal.SIGSEGV.name}\\)"):
        input_guard.check_inputs(load_scene(scene_file), set(), remember=False)
    assert not (tmp_path / "results").exists()
