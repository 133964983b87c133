# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a study, self-contained HTML, and its digest for the report of the scene."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import jinja2
from matplotlib.figure import Figure

from floeflow.core.atomic_write import write_text
from floeflow.report.figures.style import as_svg, write_png
from floeflow.report.report_text import DASH, number

TEMPLATE = Path(__file__).with_name("templates") / "study.html.j2"
DPI = 130


@dataclass(frozen=True)
class Table:
    """A table: title, heads, rows of cells; numbers are rounded, text is left as it is."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[object]]
    note: str = ""


@dataclass(frozen=True)
class Drawing:
    """A figure as it goes into the page, and into the report over its whole width."""

    name: str
    caption: str
    uri: str
    wide: bool = True


def draw(folder: Path, name: str, caption: str, figure: Figure) -> Drawing:
    """Write a figure as PNG into a folder, and return it as SVG for the page.

    Parameters
    ----------
    folder : Path
        Made where it is missing.
    name : str
        Of the file, without ending.
    caption : str
        One sentence.
    figure : Figure
        That is drawn.

    Returns
    -------
    Drawing
        For the page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_png(figure, folder / f"{name}.png", DPI)
    text = base64.b64encode(as_svg(figure)).decode()
    return Drawing(name, caption, f"data:image/svg+xml;base64,{text}")


@dataclass(frozen=True)
class Study:
    """What a study says.

    Parameters
    ----------
    title, lead : str
        Heads of the page.
    cards : sequence of str
        Sentences.
    drawings, tables : sequence
        Also in the scene's report.
    more_drawings, more_tables : sequence
        On the page alone.
    """

    title: str
    lead: str
    cards: Sequence[str]
    drawings: Sequence[Drawing]
    tables: Sequence[Table]
    more_drawings: Sequence[Drawing] = ()
    more_tables: Sequence[Table] = ()


def render_study(study: Study) -> str:
    """Fill the template; every value is escaped.

    Parameters
    ----------
    study : Study
        Tables and figures of the page.

    Returns
    -------
    str
        The page, HTML.
    """
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["cell"] = cell
    page = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    return page.render(study=study)


def write_study(study: Study, page: Path, digest: Path, keys: str) -> None:
    """Write the page, and the digest with the hash of the scene keys that it holds for.

    Parameters
    ----------
    study : Study
        Sentences, figures and tables.
    page : Path
        HTML file.
    digest : Path
        JSON file.
    keys : str
        Hash of the scene's keys.
    """
    write_text(render_study(study), page)
    tables = [
        asdict(replace(table, rows=[[cell(value) for value in row] for row in table.rows]))
        for table in study.tables
    ]
    found = {
        "keys": keys,
        "title": study.title,
        "lead": study.lead,
        "cards": list(study.cards),
        "drawings": [asdict(drawing) for drawing in study.drawings],
        "tables": tables,
    }
    write_text(json.dumps(found, indent=1) + "\n", digest)


def cell(value: object) -> str:
    """A table's cell as text.

    Parameters
    ----------
    value : object
        Number, text or other.

    Returns
    -------
    str
        Numbers with three digits.
    """
    return number(value, 3) if isinstance(value, int | float) else str(value)


def measured(value: float, half: float, digits: int = 0) -> str:
    """A measured value with half of its interval, in no finer digits than that has.

    Parameters
    ----------
    value, half : float
        In one unit.
    digits : int
        More digits than the first of `half`.

    Returns
    -------
    str
        Value ± half of the interval; a dash where either is not finite.
    """
    if not (math.isfinite(value) and math.isfinite(half)):
        return DASH
    places = 3 if half <= 0.0 else min(max(0, digits - math.floor(math.log10(half))), 3)
    return f"{value:.{places}f} ± {max(half, 10.0**-places):.{places}f}".replace("-", "−")


def as_markdown(table: Table) -> str:
    """A table as Markdown, for the documents.

    Parameters
    ----------
    table : Table
        Title, head, rows and note.

    Returns
    -------
    str
        Lines, the head first.
    """
    lines = [table.head, ["---"] * len(table.head), *([cell(c) for c in r] for r in table.rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
