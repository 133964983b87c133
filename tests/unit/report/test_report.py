# SPDX-License-Identifier: GPL-2.0-or-later
"""The report as a page: complete, self-contained, escaped, free of numbers that are none."""

from __future__ import annotations

import base64
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from floeflow.core.errors import FloeError
from floeflow.diagnostics.run_cost import stages, total_seconds
from floeflow.report.report import read_numbers, render
from floeflow.report.report_text import duration, number, scene_keys, with_unit
from floeflow.report.study_page import Study, Table, draw, write_study
from floeflow.report.summary import facts, warnings
from floeflow.scene.effects import EFFECTS
from floeflow.state import read_dataset, read_state, write_state
from support.pages import report_of
from support.synthetic import Run, make_run

VOID = {"meta", "img", "br", "link", "hr", "input"}
CHAPTERS = ["Ice", "Motion and deformation", "Bonds and floes", "Column"]
CHAPTERS += ["Budgets with residuals", "Cost and accuracy", "Effects", "How to repeat it"]
HOSTILE = '<script>alert(1)</script> & "co" {{ 7 * 7 }}'


class Page(HTMLParser):
    """Tags, attributes and visible text of a page; unbalanced tags are a fault."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.texts: list[tuple[str, str]] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, {name: value or "" for name, value in attrs}))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, {name: value or "" for name, value in attrs}))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] not in ("style", "script") and data.strip():
            self.texts.append((self.open[-1], data.strip()))

    def within(self, tag: str) -> list[str]:
        """Texts whose innermost tag is this one."""
        return [text for name, text in self.texts if name == tag]

    def every(self, tag: str) -> list[dict[str, str]]:
        """Attributes of all tags of a name."""
        return [attrs for name, attrs in self.tags if name == tag]

    @property
    def text(self) -> str:
        """All visible text."""
        return " ".join(text for _, text in self.texts)


@pytest.fixture(scope="module")
def page(run: Run) -> Page:
    return Page(report_of(run))


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, str]:
    """Hostile words, hardly an effect, no ice."""
    run = make_run(tmp_path_factory.mktemp("bare"), ("wind",), 1, elements=False, title=HOSTILE)
    state = read_state(run.state(1))
    state.attrs["provenance"] = '{"machine": "<img src=x onerror=alert(1)>"}'
    write_state(state, run.state(1))
    return run, report_of(run)


def test_sections_come_in_order(page: Page):
    assert [text for text in page.within("h2") if text != "Before you read on"] == CHAPTERS
    targets = {link["href"].removeprefix("#") for link in page.every("a")}
    ids = [attrs["id"] for _, attrs in page.tags if "id" in attrs]
    assert len(ids) == len(set(ids))
    assert targets <= set(ids)


def test_the_map_stands_before_every_table(run: Run, page: Page):
    names = [name for name, _ in page.tags]
    assert names.index("canvas") < names.index("table")
    html = (run.folder / "report.html").read_text(encoding="utf-8")
    assert html.index('id="player"') < html.index('id="effects"')


def test_page_stands_alone(page: Page):
    assert [link["href"] for link in page.every("link")] == ["data:,"]
    assert not [script for script in page.every("script") if "src" in script]
    sources = [image["src"] for image in page.every("img")]
    assert len(sources) > 15
    for source in sources:
        kind, data = source.split(";base64,")
        assert kind in ("data:image/png", "data:image/svg+xml")
        head = base64.b64decode(data)[:6]
        assert head.startswith(b"\x89PNG" if kind.endswith("png") else b"<?xml")
    styles = re.findall(r"url\(|@import|https?://", render_styles(page))
    assert not styles
    assert not [attrs for _, attrs in page.tags if any(name.startswith("on") for name in attrs)]


def render_styles(page: Page) -> str:
    """Everything in the page's attributes but the pictures."""
    kept = (v for _, attrs in page.tags for k, v in attrs.items() if not v.startswith("data:"))
    return " ".join(kept)


def test_each_picture_has_words_and_a_file(run: Run, page: Page):
    names = {figure["id"] for figure in page.every("figure")}
    files = {path.stem for path in (run.folder / "figures").iterdir()}
    assert names == files
    assert [image["alt"] for image in page.every("img") if not image["alt"].endswith(".")] == []
    expected = {
        "elements_thickness_start",
        "elements_thickness_end",
        "elements_bonds",
        "elements_displacement",
        "elements_concentration_end",
        "series_bonds",
        "budget_momentum_x",
        "budget_column_energy",
        "cost_stages",
    }
    assert expected <= names


def test_headline_numbers_stand_in_cards_with_their_sources(run: Run, page: Page):
    numbers = read_numbers(run.folder / "diagnostics.json")["headline"]
    values = page.within("dd")
    assert with_unit(numbers["ice_volume_end"], ((1e9, "km³"),)) in values
    alive, start = number(numbers["bonds_end"]), number(numbers["bonds_start"])
    assert alive in values
    broken = number(numbers["bonds_broken"])
    assert [text for text in values if text.startswith(f"of {start} at the start; {broken} broke")]
    assert page.within("dt")[:5] == [
        "Ice area inside the scene",
        "Ice volume inside the scene",
        "Mean net drift",
        "Bonds alive",
        "Budgets that close",
    ]
    data = read_dataset(run.folder / "diagnostics.nc")
    sources = [text for text in values if text.endswith("in diagnostics.nc")]
    assert len(sources) == 4
    for text in sources:
        assert set(text.removesuffix(" in diagnostics.nc").split(", ")) <= set(data.variables)


def test_bonds_of_start_broken_frozen_and_remade_give_those_of_the_end(run: Run):
    numbers = read_numbers(run.folder / "diagnostics.json")["headline"]
    formed = numbers.get("bonds_refrozen", 0) + numbers.get("bonds_remade", 0)
    assert numbers["bonds_start"] - numbers["bonds_broken"] + formed == numbers["bonds_end"]
    assert numbers["bonds_broken"] > 0


def test_assumptions_stand_on_the_first_screen(page: Page, bare: tuple[Run, str]):
    told = [text for text in page.within("li") if "rule" in text or "no observation" in text]
    assert (
        "Ice thickness at the start is no observation but a rule: 2 m times concentration." in told
    )
    assert len(told) == 2
    run, _ = bare
    notes = ["'ice' of a.nc, 1.0 days from the start", "'sst' of a.nc, 1.0 days from the start"]
    notes.append("the hole around the pole, north of 87.0 N, is filled to its rim's mean")
    open_one = {"verdict": "open", "label": "Ice volume", "relative": 0.25}
    said = warnings(run.scene, [*notes, "'ice' of b.nc, 0.0 days from the start"], {}, [open_one])
    assert said.count("Mask of another day: a.nc, 1.0 days from the start.") == 1
    assert not [line for line in said if "b.nc" in line]
    assert "Mask: the hole around the pole, north of 87.0 N, is filled to its rim's mean." in said
    assert "Budget open: Ice volume, 25 % of its turnover unexplained." in said


@pytest.mark.parametrize(
    "rule, says",
    [
        ("constant", "a rule: 2 m."),
        ("concentration", "a rule: 2 m times concentration."),
        ("climatology", "a rule: a table by place and month, times concentration."),
    ],
)
def test_the_rule_of_the_first_thickness_is_told(run: Run, rule: str, says: str):
    asked = {"thickness_rule": rule, "lead_ice": 0.1, "thickness_distribution": "gamma"}
    mask = run.scene.mask.model_copy(update=asked)
    said = warnings(run.scene.model_copy(update={"mask": mask}), [], {}, [])
    assert said[0].endswith(says)
    assert any("bear 0.1 m of young ice at the start" in line for line in said)
    assert "Within each element thickness has a gamma distribution at the start." in said


@pytest.mark.parametrize(
    "effects, told", [((), True), (("mixed_layer",), False), (("remap",), False)]
)
def test_water_that_cannot_freeze_is_told(run: Run, effects: tuple[str, ...], told: bool):
    scene = run.scene.model_copy(update={"effects": ("wind", *effects)})
    numbers = {"unclaimed_water_end": 1.0e11, "ocean_area": 1.0e12}
    line = "10 % of the sea at the end belongs to no element and makes no ice."
    assert (line in warnings(scene, [], numbers, [])) == told


def test_solves_that_did_not_converge_are_told(run: Run):
    solved = {"temperature_solves": 2000.0, "temperature_rescued": 50.0}
    clean = {**solved, "temperature_unconverged": 0.0}
    assert warnings(run.scene, [], clean, []) == warnings(run.scene, [], {}, [])
    said = warnings(run.scene, [], {**clean, "temperature_unconverged": 7.0}, [])
    assert any(line.startswith("7 of 2,000 solves for the temperatures") for line in said)
    moved = dict.fromkeys(("mean_drift_km", "largest_drift_km", "mean_speed", "largest_speed"), 0.0)
    (fact,) = facts({**moved, **clean}, run.scene)["ice"]
    assert (fact.value, fact.unit) == (2.5, "%")
    assert facts({**moved, **clean, "temperature_rescued": 0.0}, run.scene)["ice"] == []


def test_budgets_state_residual_verdict_and_thresholds(page: Page):
    cells = page.within("td")
    assert "1e−8" in cells and "1e−12" in cells
    assert "Momentum along x" in page.within("th")
    # Three explain the words, one counts them, one for each of ten budgets.
    assert len([span for span in page.every("span") if "verdict" in span["class"]]) == 14


def test_no_number_is_none(page: Page, bare: tuple[Run, str]):
    for text in (page.text, Page(bare[1]).text):
        assert not re.search(r"\b(nan|NaN|inf|None|null)\b", text)


def test_hostile_words_are_escaped(bare: tuple[Run, str]):
    _, html = bare
    page = Page(html)
    # The page has the map's data and its program, and no other script.
    assert html.count("<script") == html.count("</script>") == 2
    assert "<script>alert" not in html
    assert page.within("h1") == [HOSTILE]
    assert page.within("title")[0].startswith(HOSTILE)
    assert "&lt;img src=x" in html and "<img src=x" not in html


def test_no_ice_and_absent_effects_are_said(bare: tuple[Run, str]):
    run, html = bare
    page = Page(html)
    assert "There is no ice in this scene" in page.text
    assert "Bonds alive" not in page.within("dt")
    names = {figure["id"] for figure in page.every("figure")}
    assert not [name for name in names if "bond" in name or "snow" in name or "column" in name]
    absent = html[html.index("so not simulated") :].split("</p>")[0]
    assert re.findall(r"<code>(\w+)</code>", absent) == [e for e in EFFECTS if e != "wind"]
    assert not [key for key in scene_keys(run.scene) if key.path.startswith("column.")]


def test_keys_that_differ_are_those_of_the_scene(run: Run):
    differ = {key.path: key for key in scene_keys(run.scene) if key.differs}
    assert set(differ) == {
        "name",
        "effects",
        "seed",
        "domain.x_min",
        "domain.x_max",
        "domain.y_min",
        "domain.y_max",
        "domain.spacing",
        "packing.elements",
        "time.windows",
        "time.window",
        "forcing.cyclone.wind_speed",
        "workflow.windows_per_job",
        "state.keep",
        "report.title",
        "report.text",
        "report.dpi",
    }
    speed = differ["forcing.cyclone.wind_speed"]
    assert (speed.value, speed.default, speed.unit) == ("12", "15", "m/s")
    assert differ["domain.x_min"].value == "−1,600,000"


def test_cost_adds_up_in_the_order_of_the_data(run: Run, tmp_path: Path):
    head = "s\th:m:s\tmax_rss\n"
    for name, row in (
        ("fields/0002", "2.0\t0:00:02\t50.5"),
        ("fields/0003", "3.0\t0:00:03\t60.5"),
        ("mask", "1.5\t0:00:01\t-"),
    ):
        path = tmp_path / f"{name}.tsv"
        path.parent.mkdir(exist_ok=True)
        path.write_text(head + row + "\n")
    numbers = read_numbers(run.folder / "diagnostics.json")
    found = stages(sorted(tmp_path.rglob("*.tsv")), numbers)
    names = [stage.name for stage in found]
    assert names == ["mask", "windows", "setup", "dynamics", "column", "exchange", "fields"]
    fields = found[-1]
    assert (fields.jobs, fields.seconds, fields.memory) == (2, 5.0, 60.5)
    inner = sum(stage.seconds for stage in found if stage.inner)
    assert inner == pytest.approx(found[1].seconds)
    assert total_seconds(found) == pytest.approx(1.5 + 5.0 + inner)


def test_benchmark_that_is_none_is_named(run: Run, tmp_path: Path):
    path = tmp_path / "mask.tsv"
    path.write_text("seconds\n3\n")
    with pytest.raises(FloeError, match="mask.tsv: is not a benchmark"):
        stages([path], read_numbers(run.folder / "diagnostics.json"))


@pytest.mark.parametrize("text", ["", "[]", '{"headline": {}}'])
def test_headline_file_that_is_none_is_named(tmp_path: Path, text: str):
    path = tmp_path / "diagnostics.json"
    path.write_text(text)
    with pytest.raises(FloeError, match="diagnostics.json: "):
        read_numbers(path)


def test_same_run_same_page(bare: tuple[Run, str]):
    run, html = bare
    assert report_of(run) == html


def test_studies_have_a_section_where_there_are_any(bare: tuple[Run, str], tmp_path: Path):
    run, html = bare
    assert HOSTILE not in Page(html).within("h3")
    table = Table("Effects <b>", ("effect", "share (%)"), [["wind", 12.3456]], "A note.")
    figure = Figure()
    figure.subplots().plot([1, 2])
    drawing = draw(tmp_path / "figures", "a_study", "A figure.", figure)
    study = Study(HOSTILE, "Lead.", ["Said."], [drawing], [table])
    write_study(study, tmp_path / "page.html", tmp_path / "digest.json", "")
    shown = report_of(run, [tmp_path / "digest.json"])
    assert HOSTILE in Page(shown).within("h3")
    assert 'id="a_study" class="wide"' in shown and drawing.uri in shown
    assert "Effects &lt;b&gt;" in shown and "12.3" in shown and HOSTILE not in shown


def test_missing_value_is_a_fault_not_a_gap():
    with pytest.raises(Exception, match="undefined"):
        render({"title": "x"})


@pytest.mark.parametrize(
    "value, digits, text",
    [
        (0.0, 4, "0"),
        (1234.5678, 4, "1,235"),
        (-0.012345, 3, "−0.0123"),
        (2.0e9, 4, "2e9"),
        (-1.25e-9, 3, "−1.25e−9"),
        (12, 4, "12"),
        (-4_000_000, 4, "−4,000,000"),
        (836363.6, 3, "836,364"),
        (float("nan"), 4, "–"),
        (float("-inf"), 4, "–"),
        (None, 4, "–"),
        (0.5, 2, "0.5"),
    ],
)
def test_numbers_as_they_are_read(value: float | None, digits: int, text: str):
    assert number(value, digits) == text


@pytest.mark.parametrize(
    "seconds, text",
    [
        (432000.0, "5 days"),
        (86400.0, "1 day"),
        (129600.0, "36 hours"),
        (3600.0, "1 hour"),
        (24.7, "24.7 s"),
        (0.0, "0 s"),
    ],
)
def test_durations(seconds: float, text: str):
    assert duration(seconds) == text
