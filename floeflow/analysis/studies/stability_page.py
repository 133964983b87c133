# SPDX-License-Identifier: GPL-2.0-or-later
"""Page of the hard cases: what each one showed, in one table and two figures."""

import json
import logging
from pathlib import Path
from typing import Any

from floeflow.analysis.studies.stability_figure import residual_figure, stability_map
from floeflow.core.atomic_write import write_text
from floeflow.report.study_page import Study, Table, as_markdown, cell, draw, write_study
from floeflow.workflow import job as stage

LEAD = (
    "Each hard case must stay finite, lose nothing, make no energy and keep its bounds. Why each "
    "is hard and what must hold in it is told in docs/stability.md."
)
Shown = dict[str, Any]
ENDS = ("passed", "skipped", "expected failure", "failed")


def case_table(shown: list[Shown]) -> Table:
    """Row for each test: case, what it shows, outcome, figures."""
    rows = []
    for entry in shown:
        figures = {name: v for name, v in entry["figures"].items() if isinstance(v, int | float)}
        said = ", ".join(f"{name.replace('_', ' ')} {cell(v)}" for name, v in figures.items())
        what = entry["what"].splitlines()[0].rstrip(".")
        place = entry["test"].partition("[")[2].rstrip("]")
        rows.append(
            (entry["module"], f"{what} ({place})" if place else what, entry["outcome"], said)
        )
    return Table("Hard cases", ("case", "what", "outcome", "figures"), rows)


def summary(shown: list[Shown]) -> Table:
    """Row for each case: its tests, how they ended, the largest part of the energy missed."""
    rows = []
    for module in sorted({entry["module"] for entry in shown}):
        own = [entry for entry in shown if entry["module"] == module]
        ended = [sum(entry["outcome"] == word for entry in own) for word in ENDS]
        missed = [abs(e["figures"]["residual"]) for e in own if "residual" in e["figures"]]
        rows.append([module, len(own), *ended, 100 * max(missed) if missed else "–"])
    return Table("Cases", ("case", "tests", *ENDS, "largest energy residual (%)"), rows)


def sentences(shown: list[Shown]) -> list[str]:
    """How many there are and how they ended."""
    modules = {entry["module"] for entry in shown}
    ended: dict[str, int] = {}
    for entry in shown:
        ended[entry["outcome"]] = ended.get(entry["outcome"], 0) + 1
    said = ", ".join(f"{count} {name}" for name, count in sorted(ended.items()))
    out = [f"{len(modules)} cases with {len(shown)} tests: {said}."]
    for name, packs in (
        ("default_over_largest", "bonded packs"),
        ("unbonded_default_over_largest", "packs that contacts alone hold"),
    ):
        shares = [round(100.0 * e["figures"][name]) for e in shown if name in e["figures"]]
        if shares:
            least, most = min(shares), max(shares)
            said = f"{most}" if least == most else f"{least} to {most}"
            out.append(f"The default step is {said} % of the largest stable one in {packs}.")
    return out


def residuals(shown: list[Shown]) -> dict[str, float]:
    """Energy not accounted for, by case and test."""
    return {
        f"{entry['module']}: {entry['test'].removeprefix('test_').replace('_', ' ')}": value
        for entry in shown
        if (value := entry["figures"].get("residual")) is not None
    }


def main(snakemake: stage.Snakemake) -> None:
    """Rule ``stability_page``."""
    shown = [e for path in snakemake.input.records for e in json.loads(Path(path).read_text())]
    folder = Path(str(snakemake.output.figures))
    caption = "Energy that no term of the budget accounts for; dashed: what may be missed."
    drawings = [draw(folder, "residuals", caption, residual_figure(residuals(shown)))]
    for entry in shown:
        if found := entry["figures"].get("map"):
            figure = stability_map(found["panels"], found["dampings"], found["default"])
            caption = (
                "Largest time step at which no energy grows, over the critical one, of packs that "
                "bonds hold together and of packs of contacts pressed into a frame."
            )
            drawings.append(draw(folder, "stability_map", caption, figure))
    table = case_table(shown)
    out = snakemake.output
    study = Study("Hard cases", LEAD, sentences(shown), drawings, [summary(shown)], (), [table])
    write_study(study, Path(out.page), Path(out.digest), keys="")
    write_text(as_markdown(table) + "\n", Path(out.table))
    for entry in shown:
        if entry["outcome"] == "failed":
            logging.error("%s: %s failed", entry["module"], entry["test"])


if "snakemake" in globals():
    stage.run(main, globals()["snakemake"])
