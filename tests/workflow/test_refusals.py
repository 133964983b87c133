# SPDX-License-Identifier: GPL-2.0-or-later
"""Hostile and broken scenes and files: a sentence, exit code 1, nothing lost, nothing executed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from floeflow.workflow.scenes import Scenes
from support.runner import Place

pytestmark = pytest.mark.workflow


def listing(folder: Path) -> dict[str, int]:
    return {
        str(path.relative_to(folder)): path.stat().st_size
        for path in sorted(folder.rglob("*"))
        if path.is_file() and ".snakemake" not in path.parts and "__pycache__" not in path.parts
    }


def refusal(place: Place, scene: Path) -> str:
    """Output of a run that must be refused before any job and must change no file."""
    before = listing(place.folder)
    done = place.run(scene, ranks=1)
    assert done.returncode == 1, done.stdout
    assert "Traceback" not in done.stdout
    said = [line for line in done.stdout.splitlines() if line.startswith("floeflow: ")]
    assert len(said) == 1, done.stdout
    assert listing(place.folder) == before
    return said[0].removeprefix("floeflow: ")


@pytest.fixture
def said(
    place: Place, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[[Path], str]:
    """What the Snakefile says of a scene, asked in this process."""
    monkeypatch.chdir(place.folder)
    run = SimpleNamespace(
        is_main_process=True, basedir=".", output_settings=SimpleNamespace(dryrun=False)
    )

    def ask(scene: Path) -> str:
        before = listing(place.folder)
        with pytest.raises(SystemExit) as leave:
            Scenes({"scene": str(scene)}, run)
        error = capsys.readouterr().err
        assert leave.value.code == 1 and error.startswith("floeflow: ") and error.count("\n") == 1
        assert listing(place.folder) == before
        return error.removeprefix("floeflow: ")

    return ask


def test_a_scene_is_no_configfile_and_executes_nothing(place: Place, said: Callable[[Path], str]):
    # As a Snakemake configfile this would run: those are templates with Python in them.
    scene = place.folder / "evil.yaml"
    scene.write_text(
        "__use_yte__: true\n"
        "?if __import__('os').system('touch witness'): x\n"
        "title: !!python/object/apply:os.system ['touch witness']\n"
    )
    assert "evil.yaml: line 3: could not determine a constructor" in refusal(place, scene)
    scene.write_text("__use_yte__: true\nx: ?__import__('os').system('touch witness')\n")
    assert "evil.yaml" in said(scene)
    scene.write_text('__use_yte__: true\n\'?__import__("os").system("touch witness")\': 1\n')
    assert "unknown key" in said(scene)
    assert not list(place.folder.rglob("witness"))


def test_a_scene_s_faults_stop_the_run_before_any_job(place: Place, said: Callable[[Path], str]):
    wrong = place.scene(dynamics={"yong_modulus": 1.0})
    assert "did you mean 'dynamics.young_modulus'?" in refusal(place, wrong)
    missing = place.folder / "none.yaml"
    assert "none.yaml: the scene cannot be read" in said(missing)
    path = place.folder / "up.yaml"
    path.write_text("name: ../../up\n")
    assert "is not a plain name" in said(path)


def test_missing_and_broken_inputs_are_named_before_any_job(
    place: Place, said: Callable[[Path], str]
):
    assert "data/none.nc" in said(place.scene(mask={"file": "data/none.nc"}))
    (place.folder / "broken.nc").write_bytes(b"CDF\x01 is not all of it")
    assert "broken.nc" in refusal(place, place.scene(mask={"file": "broken.nc"}))
    words = said(place.scene(mask={"concentration": "icee"}))
    assert "icee" in words and "'ice'" in words
    assert "wind.nc" in said(place.scene(forcing={"source": "file", "file": "wind.nc"}))


def test_an_unknown_configuration_value_is_refused(place: Place):
    scene = place.scene()
    (place.folder / "other.yaml").write_text("scen: x\n")
    done = place.run(scene, f"--configfile={place.folder / 'other.yaml'}")
    assert done.returncode == 1
    assert "floeflow: --config scen=...: only scene=PATH is known" in done.stdout


@pytest.mark.parametrize("damage", ["cut", "flip"])
def test_a_damaged_state_stops_the_window_and_is_kept(copy: Callable[[], Place], damage: str):
    place = copy()
    state = place.results() / "state/0000.nc"
    raw = bytearray(state.read_bytes())
    if damage == "cut":
        raw = raw[: len(raw) // 2]
    else:
        raw[len(raw) // 2] ^= 1
    # A new file, so that the run that was copied keeps its own.
    state.unlink()
    state.write_bytes(raw)
    (place.results() / "state/0003.nc").unlink()
    done = place.run(place.scene(), "results/smoke/state/0003.nc")
    assert done.returncode == 1
    said = [line for line in done.stdout.splitlines() if line.startswith("floeflow: ")]
    assert len(said) == 1 and done.stdout.splitlines()[-1] == said[0], done.stdout
    assert said[0].startswith("floeflow: results/smoke/state/0000.nc: ")
    assert said[0].endswith("(log: results/smoke/log/windows/0003.log)")
    assert "Traceback" not in done.stdout
    assert state.read_bytes() == bytes(raw)
