# SPDX-License-Identifier: GPL-2.0-or-later
"""The report: one self-contained HTML page that a colleague can be sent.

Words come from ``wording``, pictures from ``gallery``, the page from ``templates/report.html.j2``,
which escapes every text. The page needs no JavaScript and no network.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.diagnostics import run_cost as expense
from floeflow.report import report_figures as gallery
from floeflow.report import report_text as wording
from floeflow.report.figures.frame import Frame
from floeflow.scene import Scene

TEMPLATE = Path(__file__).with_name("templates") / "report.html.j2"


@dataclass(frozen=True)
class Material:
    """What a report is made of.

    Parameters
    ----------
    diagnostics : xarray.Dataset
        ``diagnostics.nc``.
    numbers : mapping
        ``diagnostics.json``.
    first_state, last_state : xarray.Dataset
        States at start and end.
    first_grid, last_grid : xarray.Dataset
        Gridded output at start and end; None without the effect grid_output.
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
    """

    diagnostics: xr.Dataset
    numbers: Mapping[str, Any]
    first_state: xr.Dataset
    last_state: xr.Dataset
    first_grid: xr.Dataset | None
    last_grid: xr.Dataset | None
    mask: xr.Dataset
    packing: xr.Dataset
    benchmarks: Sequence[Path]
    estimates: Mapping[str, Any]
    inputs: Sequence[str] = ()
    studies: Sequence[Mapping[str, Any]] = ()


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
    easel = gallery.Easel(figures, scene.report.dpi)
    frame = Frame(scene.domain, material.mask["land"])
    headline, budgets = material.numbers["headline"], material.numbers["budgets"]
    cost = expense.stages(material.benchmarks, material.numbers)
    total = expense.total_seconds(cost)
    there, absent = wording.effect_lists(scene)
    first, last = material.first_state, material.last_state
    keys = wording.scene_keys(scene)
    return render(
        {
            "title": scene.report.title or scene.name,
            "text": scene.report.text,
            "scene": scene,
            "when": gallery.moments(scene, first, last),
            "length": wording.duration(float(headline["seconds"])),
            "headline": headline,
            "cards": wording.cards(headline, total),
            "changed": [key for key in keys if key.differs],
            "keys": keys,
            "packing": wording.packing_figures(material.packing),
            "effects": there,
            "absent": absent,
            "inputs": material.inputs,
            "estimates": material.estimates,
            "element_maps": list(
                gallery.element_pictures(easel, scene, frame, first, last, material.packing)
            ),
            "grid_maps": list(
                gallery.grid_pictures(easel, scene, frame, material.first_grid, material.last_grid)
            )
            if material.first_grid is not None and material.last_grid is not None
            else [],
            "series": list(gallery.series_pictures(easel, scene, material.diagnostics)),
            "budgets": budgets,
            "budget_bars": list(gallery.budget_pictures(easel, budgets)),
            "stages": cost,
            "total": total,
            "cost_bars": list(gallery.cost_pictures(easel, cost)),
            "provenance": wording.provenance(scene, last.attrs, headline),
            "states": material.numbers["states"],
            "studies": material.studies,
        }
    )


def render(context: Mapping[str, Any]) -> str:
    """Fill the template; every value is escaped, an undefined one is a fault."""
    environment = jinja2.Environment(
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = wording.number
    environment.filters["unit"] = wording.pretty_unit
    return environment.from_string(TEMPLATE.read_text(encoding="utf-8")).render(context)


def read_numbers(path: Path) -> dict[str, Any]:
    """Read ``diagnostics.json``.

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
