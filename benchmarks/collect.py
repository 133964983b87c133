# SPDX-License-Identifier: GPL-2.0-or-later
"""All benchmarks in one table, and accuracy against cost of every study that lies there.

Usage: python benchmarks/collect.py [--results results]
Reads ``results/benchmarks/*.json`` and ``results/*/accuracy/accuracy.nc``, writes
``results/benchmarks/summary.md``.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from floeflow.analysis.studies.measures import KEPT
from floeflow.report.study_page import Table, as_markdown
from floeflow.state import read_dataset


def benchmark_rows(folder: Path) -> Iterator[list[object]]:
    """One row for each timed case."""
    for path in sorted(folder.glob("*.json")):
        for record in json.loads(path.read_text()):
            seconds = record["seconds"]
            ratio = record.get("ratio_median")
            yield [
                path.stem,
                record["name"],
                record["n"],
                record["ranks"],
                float(np.median(seconds)),
                record.get("peer") or "",
                ratio if ratio is not None else "",
                record.get("git", ""),
            ]


def accuracy_rows(results: Path) -> Iterator[list[object]]:
    """One row for each stable run of a study: cost and error."""
    for path in sorted(results.glob("*/accuracy/accuracy.nc")):
        data = read_dataset(path)
        norms = [str(name) for name in data["norm"].values]
        for k in np.flatnonzero(data["stable"].values == 1):
            errors = [100.0 * float(data["error"].values[k, norms.index(n)]) for n in KEPT]
            level = float(data["level"].values[k])
            yield [
                data.attrs["scene"],
                str(data["setting"].values[k]),
                level if np.isfinite(level) else str(data["run"].values[k]),
                float(data["work"].values[k]),
                float(data["element_steps"].values[k]),
                *errors,
            ]


def summary(results: Path) -> str:
    """Both tables as Markdown."""
    head = ("benchmark", "case", "size", "ranks", "seconds", "peer", "ratio", "version")
    times = Table("Benchmarks", head, list(benchmark_rows(results / "benchmarks")))
    head = (
        "scene",
        "setting",
        "level",
        "work (1)",
        "element-steps (1)",
        *(f"{n} (%)" for n in KEPT),
    )
    cost = Table("Accuracy against cost", head, list(accuracy_rows(results)))
    parts = [f"# {table.title}\n\n{as_markdown(table)}\n" for table in (times, cost)]
    return "\n".join(parts)


def main() -> None:
    """Write and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=Path, default=Path("results"))
    results = parser.parse_args().results
    text = summary(results)
    path = results / "benchmarks/summary.md"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    print(text, path, sep="\n")


if __name__ == "__main__":
    main()
