# SPDX-License-Identifier: GPL-2.0-or-later
"""Every hostile input file of the table ends in one sentence: of the check, or of the stage."""

from __future__ import annotations

import json
import os
import signal
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import netCDF4
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from floeflow.analysis import reading_process
from floeflow.analysis.file_checks import check_files
from floeflow.cli import app
from floeflow.core.errors import FloeError, answer
from floeflow.core.grids import mask_grid
from floeflow.core.polygon_file import read_polygons
from floeflow.forcings.files import unzip
from floeflow.masks.mask import make_mask
from floeflow.masks.mask_file import check_mask_file
from floeflow.packings.sizes import relative_size
from floeflow.scene import parse_scene
from floeflow.scene.blocks import Sizes

HERE = Path(__file__).parent
TABLE = yaml.safe_load((HERE / "inputs.yaml").read_text())
FILES = yaml.safe_load((HERE / "files.yaml").read_text())


def write_map(path: Path, case: dict[str, Any]) -> None:
    """A good map of concentration, but for what the case changes."""
    lat = np.array(case.get("lat", [60.0, 90.0]))
    axes = {"time": ([0.0], "days since 1981-12-31"), "lat": (lat, "degrees_north")}
    axes["lon"] = (np.arange(-180.0, 180.0, 5.0), "degrees_east")
    names = {"time": "time", "lat": "latitude", "lon": "longitude"}
    with netCDF4.Dataset(path, "w") as data:
        for name, (values, units) in axes.items():
            data.createDimension(name, len(values))
            axis = data.createVariable(name, "f8", (name,))
            axis[:] = values
            axis.setncatts({"units": units, "standard_name": names[name]})
        ice = data.createVariable("ice", "f4", tuple(axes))
        ice[:] = case.get("values", 0.9)
        ice.setncatts({"units": "1", "standard_name": "sea_ice_area_fraction"})
        for name, attributes in case.get("attributes", {}).items():
            for key, value in attributes.items():
                data[name].setncattr(key, np.array(value) if isinstance(value, list) else value)


@pytest.mark.parametrize("case", TABLE, ids=[case["says"] for case in TABLE])
def test_a_hostile_file_is_refused_in_a_sentence(case: dict[str, Any], tmp_path: Path):
    path = tmp_path / case.get("file", "map.nc")
    if "bytes" in case:
        path.write_bytes(case["bytes"].encode())
    elif "file" not in case:
        write_map(path, case)
    scene = parse_scene(b"effects: [wind]\nmask: {land: none}\ndomain: {spacing: 5.0e+5}\n", "a")
    mask = scene.mask.model_copy(update={"file": str(path)})
    scene = scene.model_copy(update={"mask": mask})
    with pytest.raises(FloeError) as refusal:
        check_mask_file(scene)
        make_mask(scene, None)
    said = str(refusal.value)
    assert case["says"] in said and len(said) < 500 and said.isprintable()


@pytest.mark.parametrize("case", FILES, ids=[case["says"] for case in FILES])
def test_every_file_of_a_scene_is_looked_at_before_its_first_job(
    case: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.geojson").write_text(case.get("holds", ""))
    scene = parse_scene(case["scene"].encode(), "a")
    mask = scene.mask.model_copy(update={"uniform": 0.9, "file": "", "land": "none"})
    with pytest.raises(FloeError) as refusal:
        check_files(scene.model_copy(update={"mask": mask}))
    said = str(refusal.value)
    assert case["says"] in said and len(said) < 500 and said.isprintable()


def test_a_check_is_made_again_where_a_file_of_polygons_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    text = b"mask: {region: a.json, shoreline: b.shp}\npacking: {size: {polygons: c.json}}"
    for name in ("a.json", "b.shp", "b.prj", "c.json"):
        (tmp_path / name).write_text(name)
    there = [name for name, _, _ in reading_process.files_behind(parse_scene(text, "a"))]
    assert there == ["b.shp", "b.prj", "a.json", "c.json"]


def spoil(start: int, filling: bytes) -> Callable[[bytearray], None]:
    """Overwrite an archive from a place on."""

    def change(raw: bytearray) -> None:
        raw[start : start + len(filling)] = filling

    return change


@pytest.mark.parametrize("change", [spoil(60, b"\xff" * 300), spoil(0, b"no archive")])
def test_a_damaged_archive_is_refused(change: Callable[[bytearray], None], tmp_path: Path):
    path = tmp_path / "era5.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("data.nc", bytes(range(256)) * 20)
    raw = bytearray(path.read_bytes())
    change(raw)
    path.write_bytes(raw)
    with pytest.raises(FloeError, match=r"era5.zip: cannot be unpacked"):
        unzip(path, tmp_path / "out")
    assert not list(tmp_path.glob("out/*/*"))


def test_polygons_of_a_pipe_are_not_waited_for(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe.geojson")
    with pytest.raises(FloeError, match="is no file of polygons"):
        read_polygons(tmp_path / "pipe.geojson", "EPSG:6931")
    os.mkfifo(tmp_path / "land.prj")
    (tmp_path / "land.shp").write_bytes(bytes(200))
    with pytest.raises(FloeError, match=r"needs land.prj beside it"):
        read_polygons(tmp_path / "land.shp", "EPSG:6931")


def test_a_size_of_polygons_is_a_number(tmp_path: Path):
    """JSON's true would count as 1."""
    corners = [[-150, 70], [-140, 70], [-140, 75], [-150, 70]]
    shape = {"type": "Polygon", "coordinates": [corners]}
    feature = {"type": "Feature", "properties": {"size": True}, "geometry": shape}
    (tmp_path / "sizes.geojson").write_text(json.dumps(feature))
    grid = mask_grid(parse_scene(b"", "a").domain, 1)
    land = np.zeros(grid.shape, bool)
    keys = Sizes(polygons=str(tmp_path / "sizes.geojson"))
    with pytest.raises(FloeError, match=r"needs a property 'size' above 0 .* \(got True\)"):
        relative_size(grid, ~land, land, keys, 1e5, "EPSG:6931")


@pytest.mark.parametrize("command", [["check"], ["effects"], ["plan", "--error", "0.1"]])
@pytest.mark.parametrize("effects", ["[wind]", "auto"])
def test_commands_leave_the_first_look_to_a_process_that_may_be_ended(
    command: list[str], effects: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """What they would read in their own process might have a loop in it."""
    scene = tmp_path / "a.yaml"
    scene.write_text(f"effects: {effects}\nmask: {{uniform: 0.9, land: none}}\n")
    ended = SimpleNamespace(returncode=-signal.SIGXCPU, stderr="")
    monkeypatch.setattr(reading_process.subprocess, "run", lambda *_, **__: ended)
    done = CliRunner().invoke(app, [command[0], str(scene), *command[1:]])
    assert done.exit_code == 1
    assert "s of processor time: a file is damaged" in done.stderr


def test_a_fault_of_a_command_is_told_with_its_log(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert answer(divide_by_zero) == 1
    said = capsys.readouterr().err
    (log,) = tmp_path.glob("floeflow-*.log")
    assert said.startswith("floeflow: ZeroDivisionError: ") and str(log) in said
    assert said.count("\n") == 1 and "Traceback" in log.read_text()
    # Without a place for the log the sentence stands alone.
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    assert answer(divide_by_zero) == 1
    assert capsys.readouterr().err.endswith("please report it\n")


def divide_by_zero() -> float:
    """A fault of a program."""
    return 1 / 0
