# SPDX-License-Identifier: GPL-2.0-or-later
"""The report: one self-contained HTML page that a colleague can be sent.

Words come from ``summary`` and ``report_text``, pictures from ``report_figures``, the map with its
slider from ``map_player``, the page from ``templates/report.html.j2``, which escapes every text.
The page needs no network; without JavaScript all but the slider is there.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2
import xarray as xr
from markupsafe import Markup

from floeflow.core.errors import FloeError
from floeflow.diagnostics import run_cost
from floeflow.report import report_figures, report_text, summary
from floeflow.report.figures.frame import Frame
from floeflow.report.map_player import make_player, with_tendencies
from floeflow.report.report_figures import Picture
from floeflow.scene import Scene

TEMPLATES = Path(__file__).with_name("templates")


@dataclass(frozen=True)
class Material:
    """What a report is made of.

    Parameters
    ----------
    diagnostics : xarray.Dataset
        ``diagnostics.nc``.
    numbers : mapping
        ``diagnostics.json``.
    analyses : xarray.Dataset
        ``analyses.nc``.
    first_state, last_state : xarray.Dataset
        States at start and end.
    grid : xarray.Dataset or None
        Gridded output at all boundaries; None without the effect grid_output.
    mask, packing : xarray.Dataset
        As their contracts say.
    benchmarks : sequence of Path
        Snakemake's benchmark files.
    estimates : mapping
        ``effects.json``: what each effect was expected to change and cost.
    inputs : sequence of str
        What was read from the user's files, or stood in for them.
    studies : sequence of mapping
        Digests of the studies that were made for the scene as it is.
    partial : str
        A sentence that says how far a run came that has not ended; empty for a whole run.
    tendencies : xarray.Dataset or None
        What changed the ice of the cells in each window; None without thermodynamics.
    """

    diagnostics: xr.Dataset
    numbers: Mapping[str, Any]
    analyses: xr.Dataset
    first_state: xr.Dataset
    last_state: xr.Dataset
    grid: xr.Dataset | None
    mask: xr.Dataset
    packing: xr.Dataset
    benchmarks: Sequence[Path]
    estimates: Mapping[str, Any]
    inputs: Sequence[str] = ()
    studies: Sequence[Mapping[str, Any]] = ()
    partial: str = ""
    tendencies: xr.Dataset | None = None


@dataclass(frozen=True)
class Chapter:
    """A part of the page: numbers with their sources, and pictures."""

    id: str
    title: str
    text: str
    facts: Sequence[summary.Fact]
    pictures: Sequence[Picture]


# Chapters and how the names of their figures begin; the first that fits takes a figure.
CHAPTERS = (
    (
        "column",
        "Column",
        "What froze and melted: terms of the budgets of ice, snow, heat, water and salt.",
        ("budget_ice_volume", "budget_snow", "budget_column"),
    ),
    (
        "bonds",
        "Bonds and floes",
        "",
        ("elements_bonds", "series_bonds", "bonds_", "floe_"),
    ),
    (
        "motion",
        "Motion and deformation",
        "",
        ("elements_speed", "elements_displacement", "series_speed", "series_displacement")
        + ("series_energy", "series_walls", "motion_"),
    ),
    (
        "ice",
        "Ice",
        "Each element is drawn as its cell of the tessellation, carried and turned with it; coast "
        "elements are dark grey, land light grey. Maps of one quantity share their colour scale.",
        ("elements_", "series_", "ice_", "packing_"),
    ),
)


def make_chapters(
    pictures: Sequence[Picture], facts: Mapping[str, Sequence[summary.Fact]]
) -> tuple[list[Chapter], list[Picture]]:
    """Deal pictures to chapters, in the order in which a page has them; and those left over.

    Parameters
    ----------
    pictures : sequence of Picture
        In their order.
    facts : mapping of sequence of summary.Fact
        Numbers of each chapter.

    Returns
    -------
    tuple of list of Chapter and list of Picture
        Chapters with content; pictures of no chapter.
    """
    left, found = list(pictures), []
    for name, title, text, begins in CHAPTERS:
        own = [picture for picture in left if picture.name.startswith(begins)]
        left = [picture for picture in left if picture not in own]
        if own or facts.get(name):
            found.append(Chapter(name, title, text, facts.get(name, ()), own))
    order = ("ice", "motion", "bonds", "column")
    return sorted(found, key=lambda chapter: order.index(chapter.id)), left


def build_report(scene: Scene, material: Material, figures: Path) -> str:
    """Draw the figures and return the page.

    Parameters
    ----------
    scene : Scene
        The scene.
    material : Material
        Data of the run.
    figures : Path
        Folder for the PNG files; made if it is not there.

    Returns
    -------
    str
        HTML.
    """
    figures.mkdir(parents=True, exist_ok=True)
    easel = report_figures.Easel(figures, scene.report.dpi)
    frame = Frame(scene.domain, material.mask["land"])
    headline, budgets = material.numbers["headline"], material.numbers["budgets"]
    cost = run_cost.stages(material.benchmarks, material.numbers)
    total = run_cost.total_seconds(cost)
    there, absent = report_text.effect_lists(scene)
    first, last = material.first_state, material.last_state
    keys = report_text.scene_keys(scene)
    pictures = [
        *report_figures.element_pictures(easel, scene, frame, first, last, material.packing),
        *report_figures.series_pictures(easel, scene, material.diagnostics),
        *report_figures.analysis_pictures(easel, scene, material.analyses),
        *report_figures.packing_pictures(easel, material.packing),
        *report_figures.budget_pictures(easel, budgets),
    ]
    facts = summary.facts(headline, scene)
    facts["motion"] += summary.motion_facts(material.analyses)
    facts["bonds"] += summary.break_facts(material.analyses)
    chapters, bars = make_chapters(pictures, facts)
    notes = str(material.mask.attrs.get("notes", "")).splitlines()
    return render(
        {
            "style": Markup(read_template("report.css")),
            "script": Markup(read_template("map.js")),
            "player": _player(scene, frame, material),
            "partial": material.partial,
            "sentence": summary.sentence(scene, headline),
            "warnings": summary.warnings(scene, notes, headline, budgets),
            "chapters": chapters,
            "title": scene.report.title or scene.name,
            "text": scene.report.text,
            "scene": scene,
            "headline": headline,
            "cards": summary.cards(headline, budgets, total),
            "changed": [key for key in keys if key.differs],
            "keys": keys,
            "packing": report_text.packing_figures(material.packing),
            "effects": there,
            "absent": absent,
            "inputs": material.inputs,
            "estimates": material.estimates,
            "budgets": budgets,
            "budget_bars": bars,
            "stages": cost,
            "total": total,
            "cost_bars": list(report_figures.cost_pictures(easel, cost)),
            "provenance": report_text.provenance(scene, last.attrs, headline),
            "states": material.numbers["states"],
            "studies": material.studies,
        }
    )


def _player(scene: Scene, frame: Frame, material: Material) -> dict[str, Any] | None:
    """What the template needs for the map, its data as JSON that no text can end early."""
    if material.grid is None:
        return None
    grid = with_tendencies(material.grid, material.tendencies)
    player = make_player(grid, frame, scene.time.start, scene.time.window)
    if player is None:
        return None
    left, right, bottom, top = player["extent"]
    data = {key: player[key] for key in ("layers", "arrows", "times", "rows", "columns", "extent")}
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    width, height = right - left, top - bottom
    return player | {
        "data": Markup(text),
        "width": width,
        "height": height,
        "view": f"{left:.6g} {-top:.6g} {width:.6g} {height:.6g}",
        "bar_x": left + 0.03 * width,
        "bar_y": -bottom - 0.03 * height,
    }


def read_template(name: str) -> str:
    """The text of a template or of what goes into the page as it stands.

    Parameters
    ----------
    name : str
        Of a file in ``templates``.

    Returns
    -------
    str
        As it is in the package.
    """
    return (TEMPLATES / name).read_text(encoding="utf-8")


def render(context: Mapping[str, Any]) -> str:
    """Fill the template; every value is escaped, an undefined one is a fault.

    Parameters
    ----------
    context : mapping
        Names that the template fills in.

    Returns
    -------
    str
        The page, HTML.
    """
    environment = jinja2.Environment(
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = report_text.number
    environment.filters["unit"] = report_text.pretty_unit
    return environment.from_string(read_template("report.html.j2")).render(context)


def read_numbers(path: Path) -> dict[str, Any]:
    """Read ``diagnostics.json``.

    Parameters
    ----------
    path : Path
        Of ``diagnostics.json``.

    Returns
    -------
    dict
        As the file has it.

    Raises
    ------
    FloeError
        Where it is missing or not what the diagnostics write.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        raise FloeError(f"{path}: cannot be read as JSON") from None
    if not isinstance(data, dict) or not {"headline", "budgets", "states"} <= set(data):
        raise FloeError(f"{path}: holds no headline numbers, budgets and states")
    return data
