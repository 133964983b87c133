# SPDX-License-Identifier: GPL-2.0-or-later
"""Plans against held-out scenes: predicted time and error beside those of real runs.

Usage: python benchmarks/plan.py [--out FILE]
The scenes of ``benchmarks/held_out`` were fixed before the models were fitted. Each runs as it
stands and with all settings (but the elements) at their finest. Time is the wall time of all jobs,
one after the other: it wants idle cores.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from floeflow.analysis.estimate.conditions import conditions
from floeflow.analysis.estimate.cost import coefficients, run_seconds
from floeflow.analysis.plan.pack import fitted_to_pack
from floeflow.analysis.plan.precision import error_model, setting_errors, total_error
from floeflow.analysis.studies.accuracy_table import REFERENCE
from floeflow.analysis.studies.compare import read_ends
from floeflow.analysis.studies.measures import KEPT
from floeflow.analysis.studies.norms import errors, on_grid, relative
from floeflow.analysis.studies.outcome import Outcome, read_outcome
from floeflow.analysis.studies.variants import run_name
from floeflow.core.errors import FloeError
from floeflow.core.records import Record, write_records
from floeflow.diagnostics.run_cost import read_benchmark
from floeflow.scene import Scene, load_scene
from floeflow.scene.docs import PROJECT
from floeflow.scene.windows import window_name
from floeflow.state import read_dataset

HELD_OUT = Path(__file__).with_name("held_out")
RESULTS = Path("results")
RANKS = {"beaufort_more": 1, "loose_floes": 2, "kara_ridges": 1}


def run(path: Path, scene: Scene, ranks: int) -> tuple[Outcome, dict]:
    """Run a held-out scene as it stands, to its report, and at its finest; the latter's record."""
    folder = RESULTS / scene.name
    finest = RESULTS / run_name(scene.name, "accuracy", REFERENCE) / "record.json"
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(PROJECT / "Snakefile")]
    # One job at a time, with nothing beside it: jobs are timed.
    command += ["--cores", str(ranks), "--rerun-incomplete", "--set-threads", f"windows={ranks}"]
    command += ["--config", f"scene={path}", "--", str(folder / "report.html"), str(finest)]
    if subprocess.run(command, check=False).returncode:
        raise FloeError(f"{scene.name}: did not run to its end (Snakemake's words are above)")
    record = json.loads(finest.read_text())
    if record["fault"]:
        raise FloeError(f"{scene.name} at its finest: {record['fault']}")
    costs = sorted((folder / "cost").glob("*.json"))
    return read_outcome(scene.name, "", costs, folder / "cpu"), record


def seconds_of(scene: Scene) -> float:
    """Wall time of all jobs of a run, one after the other, as Snakemake measured them."""
    tables = sorted((RESULTS / scene.name / "benchmarks").rglob("*.tsv"))
    return sum(read_benchmark(table)[0] for table in tables)


def measured_errors(scene: Scene, finest: dict) -> dict[str, float]:
    """Relative error of the scene as it stands, in the norms that a plan keeps."""
    folder = RESULTS / scene.name
    last = folder / f"state/{window_name(scene.time.windows)}.nc"
    own, reference = (
        read_ends(folder / "state/0000.nc", last),
        read_ends(*map(Path, finest["ends"])),
    )
    mask = read_dataset(folder / "preprocess/mask.nc")
    grids = on_grid(scene, reference, mask), on_grid(scene, own, mask)
    found = relative(*errors(reference, own, grids))
    return {norm: found[norm] for norm in KEPT}


@dataclass(frozen=True)
class Row:
    """A held-out scene: what it took and how far off it is, beside what the plan says."""

    scene: Scene
    ranks: int
    outcome: Outcome
    seconds: float
    predicted_seconds: float
    errors: dict[str, float]
    predicted_errors: dict[str, float]


def compare(path: Path) -> Row:
    """Predicted and measured time and errors of a held-out scene."""
    scene, ranks = load_scene(path), RANKS[path.stem]
    c = conditions(scene)
    fit = fitted_to_pack(scene, c, coefficients())
    outcome, finest = run(path, scene, ranks)
    by_setting = setting_errors(scene, c, error_model())
    # Both runs have the same elements.
    guess = {norm: total_error(by_setting, (norm,), but=("element_size",)) for norm in KEPT}
    return Row(
        scene,
        ranks,
        outcome,
        seconds_of(scene),
        run_seconds(c, scene, scene.effects, ranks, fit),
        measured_errors(scene, finest),
        guess,
    )


def as_text(row: Row) -> str:
    """Lines of the table."""
    times = row.seconds, row.predicted_seconds
    errors = max(row.errors.values()), max(row.predicted_errors.values())
    lines = [
        f"{row.scene.name:16} {row.ranks:5} {times[0]:8.3g} s {times[1]:8.3g} s"
        f" {times[1] / times[0]:6.2f} {100 * errors[0]:7.2g} % {100 * errors[1]:7.2g} %"
        f" {errors[1] / errors[0]:6.2f}"
    ]
    for norm, found in row.errors.items():
        lines.append(f"{norm:>51} {100 * found:7.2g} % {100 * row.predicted_errors[norm]:7.2g} %")
    return "\n".join(lines)


def main() -> None:
    """Run, print a table, write records."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("results/benchmarks/plan.json"))
    given = parser.parse_args()
    rows = [compare(path) for path in sorted(HELD_OUT.glob("*.yaml"))]
    print("scene            ranks     time   predicted  ratio     error predicted  ratio")
    records = []
    for row in rows:
        print(as_text(row))
        extra = {
            "steps": row.outcome.steps,
            "predicted_seconds": row.predicted_seconds,
            "errors": row.errors,
            "predicted_errors": row.predicted_errors,
        }
        name, n = f"plan {row.scene.name}", row.outcome.elements
        records.append(Record(name, n, row.ranks, [row.seconds], extra=extra))
    write_records(records, given.out)
    print(given.out)


if __name__ == "__main__":
    main()
