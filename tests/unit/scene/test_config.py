# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene: every fault is one sentence that names the key; nothing in a scene is executed."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from floeflow.analysis.documents import documents
from floeflow.core.errors import FloeError
from floeflow.scene import STAGE_KEYS, Scene, load_scene, parse_scene, stage_hash
from floeflow.scene.docs import keys
from floeflow.scene.hashes import stage_values


def parse(text: str) -> Scene:
    return parse_scene(text.encode(), "some")


def fault(text: str | bytes) -> str:
    raw = text if isinstance(text, bytes) else text.encode()
    with pytest.raises(FloeError) as caught:
        parse_scene(raw, "some")
    return str(caught.value)


def test_an_empty_scene_is_the_default_scene():
    assert parse("") == Scene(name="some", effects=parse("").effects)


def test_the_name_comes_from_the_file_where_none_is_given(tmp_path: Path):
    path = tmp_path / "bay.yaml"
    path.write_text("seed: 3\n")
    assert load_scene(path).name == "bay"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "dynamics: {yong_modulus: 1}",
            "unknown key 'dynamics.yong_modulus'; did you mean 'dynamics.young_modulus'?",
        ),
        ("pakcing: {}", "unknown key 'pakcing'; did you mean 'packing'?"),
        ("seed: 1\nseed: 2", "key 'seed' is given twice (line 2)"),
        ("time: {windows: 1, windows: 2}", "key 'windows' is given twice (line 1)"),
        (
            "dynamics: {young_modulus: -1}",
            "dynamics.young_modulus: input should be greater than or equal to 1000 Pa (got -1)",
        ),
        ("mask: {uniform: 2}", "mask.uniform: input should be less than or equal to 1 (got 2)"),
        (
            "forcing: {cyclone: {wind_speed: -5}}",
            "forcing.cyclone.wind_speed: input should be greater than or equal to 0 m/s (got -5)",
        ),
        ("dynamics: {young_modulus: .nan}", "dynamics.young_modulus: input should be a finite"),
        ("dynamics: {young_modulus: .inf}", "dynamics.young_modulus: input should be a finite"),
        ("dynamics: 3", "dynamics: input should be a valid dictionary"),
        ("effects: [wnd]", "effects: unknown effect 'wnd'; did you mean 'wind'?"),
        ("effects: [wind, wind]", "effects: 'wind' is listed twice"),
        ("name: ../up", "name: '../up' is not a plain name"),
        ("name: a b", "name: 'a b' is not a plain name"),
        ("name: $(touch x)", "name: '$(touch x)' is not a plain name"),
        ("name: 'a\n'", "is not a plain name"),
        ("- 1", "a scene is a mapping"),
        ("a: [", "line 1:"),
        ("domain: {x_min: 5.0e+6}", "domain.x_min (5e+06 m) must lie below x_max (4e+06 m)"),
        ("domain: {spacing: 30000.0}", "domain.spacing (30000 m) must divide the scene's width"),
        ("domain: {spacing: 1000.0}", "mask cells; at most"),
        (
            "forcing: {source: file}",
            "forcing.source is 'file' but forcing.file and forcing.files name none",
        ),
        ("forcing: {file: x.nc}", "forcing.file is given but forcing.source is 'analytic'"),
        ("forcing: {step: 7000.0}", "forcing.step (7000 s) must divide time.window (86400 s)"),
        ("time: {start: 2000-01-01T00:00:00+01:00}", "time.start: give UTC"),
    ],
)
def test_a_fault_is_one_sentence_that_names_the_key(text: str, sentence: str):
    said = fault(text)
    assert sentence in said
    assert "\n" not in said


def test_a_scene_executes_nothing(tmp_path: Path):
    witness = tmp_path / "witness"
    said = fault(f"x: !!python/object/apply:os.system ['touch {witness}']")
    assert "could not determine a constructor" in said
    assert not witness.exists()


def test_other_encodings_and_binary_are_refused():
    assert "is not UTF-8" in fault("name: x".encode("utf-16"))
    assert fault(bytes(range(256)))


def test_a_missing_scene_is_named(tmp_path: Path):
    with pytest.raises(FloeError, match=r"none\.yaml: the scene cannot be read: No such file"):
        load_scene(tmp_path / "none.yaml")


@given(st.binary(max_size=200))
def test_any_bytes_give_a_scene_or_one_sentence(raw: bytes):
    try:
        scene = parse_scene(raw, "some")
    except FloeError as error:
        assert str(error)
    else:
        assert isinstance(scene, Scene)


def test_effects_come_in_the_order_of_the_registry():
    assert parse("effects: [bonds, wind]").effects == ("wind", "bonds")


def test_generated_documents_are_up_to_date():
    for path, text in documents().items():
        assert path.read_text() == text, f"{path.name}: run floeflow docs --write"


def test_the_default_file_is_the_default_scene(project: Path):
    path = project / "config/default.yaml"
    scene = load_scene(path)
    assert scene == parse_scene(b"", scene.name)


def test_every_key_has_a_line_of_help():
    for key in keys():
        assert key.text.endswith("."), key.path


def test_a_changed_key_changes_the_hash_of_its_stages_only():
    plain, plot = parse(""), parse("report: {dpi: 200}")
    changed = {stage for stage in STAGE_KEYS if stage_hash(plain, stage) != stage_hash(plot, stage)}
    assert changed == {"report"}


@pytest.mark.parametrize(
    ("keys", "stages"),
    [
        ("state: {precision: single}", {"initial", "dynamics"}),
        ("grid: {transfer: nearest}", {"grid"}),
        ("remap: {order: 1}", {"remesh"}),
    ],
)
def test_ways_to_do_a_thing_are_read_where_it_is_done(keys: str, stages: set[str]):
    plain, other = parse(""), parse(keys)
    assert {s for s in STAGE_KEYS if stage_hash(plain, s) != stage_hash(other, s)} == stages


def test_more_windows_change_no_hash():
    plain, longer = parse(""), parse("time: {windows: 50}")
    stages = set(STAGE_KEYS) - {"estimate"}  # what is estimated grows with the run
    assert all(stage_hash(plain, stage) == stage_hash(longer, stage) for stage in stages)


def test_every_key_is_read_by_a_stage():
    # Keys that no stage reads: they say what is run, not what it gives.
    outside = {"name", "time.windows", "workflow.windows_per_job", "state.keep"}
    read = {path for paths in STAGE_KEYS.values() for path in paths}
    for key in keys():
        block = key.path.partition(".")[0]
        assert key.path in outside or key.path in read or block in read, key.path


def test_stage_keys_name_keys_that_exist():
    scene = parse("")
    for stage in STAGE_KEYS:
        assert None not in stage_values(scene, stage).values(), stage


def test_without_thermodynamics_the_column_has_no_keys():
    scene = parse("effects: [wind]")
    assert stage_values(scene, "column")["column"] is None


def test_the_shipped_scenes_are_valid(project: Path):
    scenes = sorted((project / "config/scenes").glob("*.yaml"))
    assert scenes
    for path in scenes:
        assert load_scene(path).name == path.stem


def test_the_readme_example_is_a_valid_scene(project: Path):
    text = (project / "config/README.md").read_text()
    example = text.split("```yaml\n")[1].split("```")[0]
    assert parse(example).name == yaml.safe_load(example)["name"]
