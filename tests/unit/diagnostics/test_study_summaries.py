# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies in the report: those that are there and hold for the scene as it is, and no others."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from floeflow.analysis.studies.hard_cases import write_document
from floeflow.core.errors import FloeError
from floeflow.diagnostics.study_summaries import read_summary, valid_summaries
from floeflow.report.study_page import Study, Table, draw, write_study


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scene's results with an ablation of the keys "now"."""
    place = tmp_path / "scene"
    figure = Figure()
    figure.subplots().plot([1, 2])
    drawings = [draw(place / "ablation/figures", "shares", "A <figure>.", figure)]
    table = Table("Effects", ("effect", "share (%)"), [["wind", 12.3456]])
    more = Table("All", ("run",), [["base"]])
    study = Study("Ablation of <X>", "Lead.", ["Said."], drawings, [table], (), [more])
    write_study(study, place / "ablation.html", place / "ablation/digest.json", "now")
    return place


def test_a_study_of_the_scene_as_it_is_is_shown(folder: Path):
    path = folder / "ablation/digest.json"
    found = valid_summaries(folder, "now")
    assert list(found) == [str(path)]
    digest = read_summary(path)
    assert digest["tables"][0]["rows"] == [["wind", "12.3"]]
    assert len(digest["tables"]) == 1  # the others stand on the page alone
    assert "All" in (folder / "ablation.html").read_text()


def test_a_study_of_other_keys_is_not(folder: Path):
    assert valid_summaries(folder, "then") == {}


def test_hard_cases_hold_for_any_scene(folder: Path):
    path = folder.parent / "stability/digest.json"
    write_study(Study("Hard cases", "", [], [], []), folder / "s.html", path, "")
    assert str(path) in valid_summaries(folder, "then")


def test_hard_cases_become_a_document(folder: Path):
    page, images = folder / "docs/cases.md", folder / "docs/images"
    with pytest.raises(FloeError, match="were not run"):
        write_document(folder / "none", page, images)
    (folder / "ablation/table.md").write_text("| wind |")
    write_document(folder / "ablation", page, images)
    text = page.read_text()
    assert "- Said." in text and "| wind | 12.3 |" in text and text.endswith("| wind |")
    assert "![shares](images/shares.png)" in text
    assert (images / "shares.png").read_bytes().startswith(b"\x89PNG")


def test_a_new_study_changes_what_the_report_depends_on(folder: Path):
    before = valid_summaries(folder, "now")
    path = folder / "ablation/digest.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "lead": "Other."}))
    after = valid_summaries(folder, "now")
    assert before.keys() == after.keys() and before != after


@pytest.mark.parametrize("text", ["", "[1]", "{"])
def test_a_damaged_digest_is_not_shown(folder: Path, text: str):
    (folder / "ablation/digest.json").write_text(text)
    assert valid_summaries(folder, "now") == {}
