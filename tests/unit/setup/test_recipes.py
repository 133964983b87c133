# SPDX-License-Identifier: GPL-2.0-or-later
"""The contributor's recipes, done as their pages say, from outside of the package."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from floeflow.analysis.documents import effects_page
from floeflow.analysis.estimate.dimensionless_numbers import NUMBERS
from floeflow.column.params import Settings
from floeflow.column.schemes import SCHEMES, advance_columns
from floeflow.core import extensions, readers
from floeflow.core.errors import FloeError
from floeflow.diagnostics import collect
from floeflow.diagnostics.diagnostics import diagnose
from floeflow.dynamics.forces import FORCES
from floeflow.dynamics.motion import engine_forcing, engine_params
from floeflow.forcings.fixed_fields import FIXED
from floeflow.forcings.window import window_forcing
from floeflow.masks.mask import make_mask
from floeflow.report import report_figures
from floeflow.scene import load_scene, parse_scene, stage_hash
from floeflow.scene.effects import EFFECTS, ledger_sums
from floeflow.workflow.library import library_digest
from support.synthetic import make_run
from unit.column.test_schemes import COLD, check, start, weather

PAGES = ("effect", "contact_law", "reader", "column_process", "diagnostic", "figure")
Install = Callable[[str, str], ModuleType]


def block(project: Path, page: str, language: str = "python") -> str:
    """The only block of a page in a language."""
    text = (project / f"docs/contributing/{page}.md").read_text()
    (found,) = re.findall(rf"^```{language}\n(.*?)^```", text, re.M | re.S)
    return str(found)


def forget() -> None:
    for cached in (
        extensions.modules,
        extensions.load_extensions,
        extensions.extension_digest,
    ):
        cached.cache_clear()


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Install a module as a package with an entry point, as pip would; gone after the test."""
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.setattr(readers, "_ADDED", [])
    monkeypatch.setattr(collect, "ADDED", {})
    monkeypatch.setattr("floeflow.diagnostics.diagnostics.ADDED", collect.ADDED)
    monkeypatch.setattr(report_figures, "ADDED", [])
    names: list[str] = []

    def put(name: str, text: str) -> None:
        (site / f"{name}.py").write_text(text)
        info = site / f"{name}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(f"[{extensions.GROUP}]\nmine = {name}\n")
        names.append(name)
        forget()

    yield put
    for name in names:
        sys.modules.pop(name, None)
    monkeypatch.undo()
    forget()


# A field of its own, and keywords from the scene.
WAVES = """
import numpy as np

from floeflow.analysis.estimate.dimensionless_numbers import number_of
from floeflow.core.grids import scene_grid
from floeflow.dynamics.engine.params import Force
from floeflow.dynamics.forces import force
from floeflow.forcings.fixed_fields import fixed
from floeflow.scene.effects import Effect, add_effect

waves = {"plugin": ("swell",), "forcing": ("wave_height",)}
add_effect(Effect("swell", "Swell pushes the ice.", "a paper", **waves))


@number_of("swell")
def number(c):
    '''H / h: height of the waves over the thickness of the ice.'''
    return 2.0 / c.thickness


@force("swell")
def push(scene):
    return Force("swell", (("swell_drag", 0.1),), ("wave_height",))


@fixed("wave_height", "m")
def height(scene):
    return np.full(scene_grid(scene.domain).shape, 2.0)
"""

# A disc in a wind of 10 m/s, from rest to its terminal speed, by the effects of a scene.
DRIFT = """
import json
from pathlib import Path

from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine
from floeflow.dynamics.motion import engine_params
from floeflow.scene import parse_scene
from support.rafts import discs, uniform

scene = parse_scene(b"effects: [wind, ocean_drag, swell]\\npacking: {elements: 100}\\n", "a")
params = engine_params(scene, 100.0)
with Engine(MPI.COMM_SELF, params, Path("log")) as engine:
    engine.load(discs([0.0], [0.0], 1000.0))
    engine.set_forcing(uniform((10.0, 0.0)))
    engine.run(5000)
    found = engine.diagnostics() | {
        "speed": float(engine.elements()["u"][0]),
        "air": params.wind_stress_factor,
        "water": params.ocean_stress_factor,
        "radius": 1000.0,
        "seconds": 5000 * 100.0,
    }
print(json.dumps(found))
"""


def gone_after(monkeypatch: pytest.MonkeyPatch, *names: str) -> None:
    """Names that a test adds to the registries are gone after it."""
    for registry in (EFFECTS, NUMBERS, FORCES, FIXED):
        for name in names:
            monkeypatch.setitem(registry, name, None)
            monkeypatch.delitem(registry, name)


def test_each_thing_to_add_has_a_page(project: Path):
    text = (project / "CONTRIBUTING.md").read_text()
    for page in PAGES:
        assert f"(docs/contributing/{page}.md)" in text
        assert (project / f"docs/contributing/{page}.md").is_file()


def test_pages_name_what_is_there(project: Path):
    """Names in the code of the pages of effects and laws exist where they are said to be."""
    for page, file, names in (
        ("effect", "tests/unit/dynamics/test_grounding.py", r"`(test_\w+)`"),
        ("contact_law", "liggghts_models/laws/laws.h", r"`(FLOE_\w+_LAWS)`"),
    ):
        text = (project / f"docs/contributing/{page}.md").read_text()
        found = set(re.findall(names, text))
        assert found and all(name in (project / file).read_text() for name in found), page
    assert "grounding" in EFFECTS


def test_an_effect_from_outside_is_known_everywhere(
    project: Path, tmp_path: Path, install: Install, monkeypatch: pytest.MonkeyPatch
):
    """One entry with its number, as the page says, and nothing else."""
    gone_after(monkeypatch, "swell")
    with pytest.raises(FloeError, match="unknown effect 'swell'"):
        parse_scene(b"effects: [ocean_drag, swell]", "a")
    install("my_effects", block(project, "effect"))

    text = "effects: [wind{}]\npacking: {{elements: 100}}\n"
    plain, scene = (parse_scene(text.format(more).encode(), "a") for more in ("", ", swell"))
    assert scene.effects == ("wind", "swell")
    assert stage_hash(scene, "dynamics") != stage_hash(plain, "dynamics")
    params = engine_params(scene)
    assert params.fix_style().endswith(" swell yes") and "wind_u" in params.external
    assert "swell" not in engine_params(plain).fix_style()
    assert ledger_sums(scene.effects)[-3:] == ("impulse_swell_x", "impulse_swell_y", "work_swell")
    assert "ρ_w g a² / (4 τ_a D): push of the swell over that of the wind" in effects_page()


def test_an_effect_from_outside_brings_a_field_keywords_and_a_number(
    tmp_path: Path, install: Install, monkeypatch: pytest.MonkeyPatch
):
    gone_after(monkeypatch, "swell", "wave_height")
    install("my_waves", WAVES)
    text = "effects: [wind{}]\npacking: {{elements: 100}}\n"
    plain, scene = (parse_scene(text.format(more).encode(), "a") for more in ("", ", swell"))
    assert stage_hash(scene, "forcing") != stage_hash(plain, "forcing")
    forcing = window_forcing(scene, 1, tmp_path)
    assert forcing["wave_height"].attrs["units"] == "m"
    assert forcing["wave_height"].dims == ("y", "x") and (forcing["wave_height"] == 2.0).all()
    assert "wave_height" not in window_forcing(plain, 1, tmp_path)
    params = engine_params(scene)
    assert "swell_drag 0.1" in params.fix_style() and "wave_height" in params.external
    assert engine_forcing(scene, forcing, params.external).fields["wave_height"].mean() == 2.0
    assert "H / h: height of the waves over the thickness of the ice" in effects_page()


@pytest.mark.slow
@pytest.mark.mpi
def test_a_force_is_an_entry_a_header_and_a_name(
    project: Path, tmp_path: Path, install: Install, monkeypatch: pytest.MonkeyPatch
):
    """The plugin is built with the page's header, and ice drifts as its force says."""
    gone_after(monkeypatch, "swell")
    install("my_effects", block(project, "effect"))
    models, build = tmp_path / "models", tmp_path / "build"
    shutil.copytree(project / "liggghts_models", models)
    (models / "laws/swell.h").write_text(block(project, "effect", "cpp"))
    page = (project / "docs/contributing/effect.md").read_text()
    named, listed = re.findall(r"^    (#(?:include|define) .*)\n", page, re.M)
    lists = models / "laws/forces.h"
    before = '#include "seabed.h"\n\n#define FLOE_FORCES(FORCE) FORCE(SeabedFriction)\n'
    assert before in lists.read_text()
    after = f'#include "seabed.h"\n{named}\n\n{listed}\n'
    lists.write_text(lists.read_text().replace(before, after))
    for words in (["-S", models, "-B", build], ["--build", build, "--target", "floe"]):
        subprocess.run(["cmake", *words], check=True, capture_output=True, text=True)
    paths = [*sys.path, str(project / "tests")]
    environment = {
        **os.environ,
        "FLOEFLOW_PLUGIN": str(build / "libfloe.so"),
        "PYTHONPATH": os.pathsep.join(filter(None, paths)),
    }
    done = subprocess.run(
        [sys.executable, "-c", DRIFT], env=environment, cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    push = 0.25 * 1026.0 * 9.81 * 0.1**2 * 2.0 / (np.pi * found["radius"])  # N/m2
    stress = found["air"] * 100.0 + push
    assert found["speed"] == pytest.approx(np.sqrt(stress / found["water"]), rel=1e-6)
    given = push * np.pi * found["radius"] ** 2 * found["seconds"]
    assert found["impulse_swell_x"] == pytest.approx(given, rel=1e-9)
    change = found["work_wind"] + found["work_ocean"] + found["work_swell"]
    assert found["kinetic"] == pytest.approx(change, rel=1e-6)


def test_a_reader_from_outside_makes_a_mask(
    project: Path, tmp_path: Path, install: Install, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    values = np.full((80, 80), 0.25)
    values[:, 40:] = 0.75
    np.savetxt("north.ice", values)
    Path("mine.yaml").write_text(
        "effects: [wind]\n"
        "domain: {x_min: -1.0e+6, x_max: 1.0e+6, y_min: -1.0e+6, y_max: 1.0e+6}\n"
        "mask: {file: north.ice, crs: 'EPSG:6931', land: none, refine: 1}\n"
    )
    scene = load_scene("mine.yaml")
    with pytest.raises(FloeError, match="north.ice"):
        make_mask(scene, None)
    before = library_digest("mask")
    install("my_readers", block(project, "reader"))
    mask = make_mask(scene, None)
    assert float(mask["siconc"][10, 2]) == pytest.approx(0.25)
    assert float(mask["siconc"][10, -3]) == pytest.approx(0.75)
    # Its bytes are in the digests of jobs.
    assert library_digest("mask") != before


def test_an_extension_that_fails_is_named(install: Install, tmp_path: Path):
    install("my_broken", "import no_such_module\n")
    (tmp_path / "a.nc").write_bytes(b"")
    with pytest.raises(FloeError, match="the extension my_broken cannot be imported"):
        readers.open_raw(tmp_path / "a.nc")


def test_a_diagnostic_from_outside_is_in_the_run(project: Path, tmp_path: Path, install: Install):
    run = make_run(tmp_path / "run", windows=1)
    install("my_numbers", block(project, "diagnostic"))
    data, _ = diagnose(run.files, run.scene.effects, run.scene.domain)
    found = data["thick_ice_area"]
    assert found.attrs == {"units": "m2", "long_name": "area of ice thicker than 2 m"}
    assert found.dims == ("boundary",)
    assert (found <= data["ice_area"]).all() and (found >= 0.0).all()


def test_a_figure_from_outside_is_in_the_report(project: Path, tmp_path: Path, install: Install):
    run = make_run(tmp_path / "run", windows=1)
    data, _ = diagnose(run.files, run.scene.effects, run.scene.domain)
    easel = report_figures.Easel(tmp_path, 50)
    plain = {picture.name for picture in report_figures.series_pictures(easel, run.scene, data)}
    install("my_figures", block(project, "figure"))
    drawn = {picture.name for picture in report_figures.series_pictures(easel, run.scene, data)}
    assert drawn - plain == {"series_fastest"}
    assert b"largest speed (cm/s)" in (tmp_path / "series_fastest.svg").read_bytes()


def test_a_column_process_from_outside_keeps_the_budgets(
    project: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("floeflow.column.schemes.SCHEMES", dict(SCHEMES))
    exec(compile(block(project, "column_process"), "column_process.md", "exec"), {})
    ends = {}
    for scheme in ("zero_layer", "windy"):
        settings = Settings(scheme=scheme, processes=("vertical", "snow"), step=3600.0)
        first = start(settings, [0.9, 0.5], [1.5, 0.3])
        after, terms = advance_columns(first, weather(COLD, settings, 2), (0.0, 86400.0), settings)
        check(first, after, terms, 86400.0)
        ends[scheme] = after["snow_volume"].sum(axis=1)
    np.testing.assert_allclose(ends["zero_layer"] - ends["windy"], 1e-3, rtol=1e-9)
