# SPDX-License-Identifier: GPL-2.0-or-later
"""Every faulty scene of the table ends in one sentence before any job, exit code 1."""

from __future__ import annotations

import os
import struct
import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml

from floeflow.core.errors import FloeError
from floeflow.core.mesh_check import check_mesh_file
from floeflow.scene.checks import scene_warnings
from floeflow.scene.load import parse_scene
from floeflow.workflow import scenes
from floeflow.workflow.scenes import Scenes

TABLE = yaml.safe_load(Path(__file__).with_name("scenes.yaml").read_text())
LOOKING = SimpleNamespace(
    is_main_process=True, basedir=".", output_settings=SimpleNamespace(dryrun=True)
)


def long(text: str) -> str:
    """The case's text, its marks of length filled in."""
    text = text.replace("{many}", ", ".join(["w"] * 20_000))
    head, mark, tail = text.partition("{long}")
    return head + 5000 * tail[:1] + tail[1:] if mark else text


def said(path: Path, capsys: pytest.CaptureFixture[str], config: dict[str, Any]) -> str:
    """What the workflow prints where it refuses a scene."""
    with pytest.raises(SystemExit) as leave:
        Scenes({"scene": str(path), **config}, LOOKING)
    assert leave.value.code == 1
    error = capsys.readouterr().err
    assert error.startswith("floeflow: ") and error.count("\n") == 1 and len(error) < 1000
    return error


@pytest.fixture(autouse=True)
def plugin(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Any file: nothing here runs."""
    (tmp_path / "libfloe.so").touch()
    monkeypatch.setenv("FLOEFLOW_PLUGIN", str(tmp_path / "libfloe.so"))


@pytest.mark.parametrize("case", TABLE, ids=[str(case["scene"])[:40] for case in TABLE])
def test_a_faulty_scene_is_refused_in_a_sentence(
    case: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    path = tmp_path / "scene.yaml"
    path.write_text(long(case["scene"]) + "\n")
    assert case["says"] in said(path, capsys, {})


@pytest.mark.parametrize(
    ("raw", "says"),
    [
        ("seed: 7\n".encode("utf-16"), "byte 1 is not UTF-8 text"),
        ("report: {title: Glück}\n".encode("latin-1"), "byte 19 is not UTF-8 text"),
        (b"\xef\xbb\xbfseed: 7\r\nsede: 7\r\n", "unknown key 'sede'"),
    ],
)
def test_scenes_of_other_encodings(
    raw: bytes, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """Byte-order marks and line ends of other systems are none of a scene's faults."""
    (tmp_path / "scene.yaml").write_bytes(raw)
    assert says in said(tmp_path / "scene.yaml", capsys, {})


def test_a_scene_that_is_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """A pipe would be waited for, and a device read, for ever."""
    os.mkfifo(tmp_path / "pipe.yaml")
    assert "it is no file, but a pipe" in said(tmp_path / "pipe.yaml", capsys, {})
    assert "it is no file, but a pipe or a device" in said(Path("/dev/zero"), capsys, {})
    assert "it is no file, but a folder" in said(tmp_path, capsys, {})
    (tmp_path / "loop.yaml").symlink_to("loop.yaml")
    assert "Too many levels of symbolic links" in said(tmp_path / "loop.yaml", capsys, {})
    for name in ("my scene", "größe", "-dash", "x" * 65):
        (tmp_path / f"{name}.yaml").write_text("seed: 1\n")
        assert "is not a plain name" in said(tmp_path / f"{name}.yaml", capsys, {})


def test_a_fault_of_the_program_is_told_with_its_log(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    path = tmp_path / "scene.yaml"
    path.write_text("seed: 1\n")
    monkeypatch.setattr(scenes, "resolve_scene", lambda _: 1 / 0)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    words = said(path, capsys, {})
    assert "ZeroDivisionError" in words and "fault of the program" in words
    (log,) = tmp_path.glob("floeflow-*.log")
    assert str(log) in words and "Traceback" in log.read_text()


def test_a_scene_edited_during_a_run_stays_what_its_jobs_began_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FLOEFLOW_SCENE", "")
    monkeypatch.setenv("FLOEFLOW_RUN", "")
    monkeypatch.setattr(scenes, "check_inputs", lambda *_: None)
    path = tmp_path / "mine.yaml"
    path.write_text("effects: [wind]\nseed: 7\n")
    began = Scenes({"scene": str(path)}, LOOKING)
    scenes.write_resolved(began.run("mine"), scenes.RESULTS / "mine")
    path.write_text("name: other\nseed: [[")
    job = Scenes(
        {"scene": str(path)},
        SimpleNamespace(
            is_main_process=False, basedir=".", output_settings=LOOKING.output_settings
        ),
    )
    assert job.default == "mine" and job.scene("mine").seed == 7


def test_unknown_configuration_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert "--config scen=...: only scene=PATH is known" in said(
        tmp_path / "scene.yaml", capsys, {"scen": "x"}
    )


def test_meshes_that_would_hang_or_fill_the_memory_are_refused(tmp_path: Path):
    with pytest.raises(FloeError, match="is not a file, so no mesh"):
        check_mesh_file(tmp_path)
    os.mkfifo(tmp_path / "pipe.stl")
    with pytest.raises(FloeError, match="pipe.stl: is not a file"):
        check_mesh_file(tmp_path / "pipe.stl")
    (tmp_path / "short.stl").write_bytes(bytes(80) + struct.pack("<I", 4_000_000_000) + bytes(50))
    with pytest.raises(FloeError, match="holds 4000000000 triangles, but ends before"):
        check_mesh_file(tmp_path / "short.stl")
    with pytest.raises(FloeError, match="cannot be read: No such file"):
        check_mesh_file(tmp_path / "none.stl")


def test_an_angle_in_radians_is_asked_about():
    scene = parse_scene(b"dynamics: {friction_angle: 0.6}", "a")
    assert scene_warnings(scene) == [
        "dynamics.friction_angle is 0.6 degrees; was it meant in radians?"
    ]
    assert scene_warnings(parse_scene(b"", "a")) == []


def test_no_value_ends_the_quotes_of_make(project: Path, tmp_path: Path):
    """What `make` would run for a hostile SCENE keeps it in one word."""
    evil = f"x' & touch {tmp_path}/F; '"
    done = subprocess.run(
        ["make", "-n", "run", f"SCENE={evil}", "RANKS=2"],
        cwd=project,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "touch" not in done.stdout and '"scene=$SCENE"' in done.stdout
    assert not (tmp_path / "F").exists()
