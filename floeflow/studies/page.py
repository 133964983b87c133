# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a study: self-contained HTML, as the report of a run."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2
from matplotlib.figure import Figure

from floeflow.postprocess.figures.style import as_svg, write_png
from floeflow.postprocess.wording import number

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
    """A figure as it goes into the page."""

    name: str
    caption: str
    uri: str


def draw(folder: Path, name: str, caption: str, figure: Figure) -> Drawing:
    """Write a figure as PNG into a folder, and return it as SVG for the page."""
    folder.mkdir(parents=True, exist_ok=True)
    write_png(figure, folder / f"{name}.png", DPI)
    text = base64.b64encode(as_svg(figure)).decode()
    return Drawing(name, caption, f"data:image/svg+xml;base64,{text}")


def render_study(
    title: str,
    lead: str,
    cards: Sequence[str],
    drawings: Sequence[Drawing],
    tables: Sequence[Table],
) -> str:
    """Fill the template; every value is escaped."""
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["cell"] = cell
    page = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    return page.render(title=title, lead=lead, cards=cards, drawings=drawings, tables=tables)


def cell(value: object) -> str:
    """A table's cell as text."""
    return number(value, 3) if isinstance(value, int | float) else str(value)


def as_markdown(table: Table) -> str:
    """A table as Markdown, for the documents."""
    lines = [table.head, ["---"] * len(table.head), *([cell(c) for c in r] for r in table.rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
