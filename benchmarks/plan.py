# SPDX-License-Identifier: GPL-2.0-or-later
"""Plans against held-out scenes: predicted time and error beside those of real runs.

Usage: python benchmarks/plan.py [--out FILE]
The scenes of ``benchmarks/held_out`` were fixed before the models were fitted. Each runs as it
stands and with all knobs (but the elements) at their finest. Time is the wall time of all jobs, one
after the other: it wants idle cores.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from floeflow.analysis.estimate.conditions import conditions
from floeflow.analysis.estimate.cost import coefficients, run_seconds
from floeflow.analysis.plan.pack import fitted_to_pack
from floeflow.analysis.plan.precision import error_model, knob_errors, total_error
from floeflow.analysis.studies.accuracy_table import REFERENCE
from floeflow.analysis.studies.compare import read_ends
from floeflow.analysis.studies.measures import KEPT
from floeflow.analysis.studies.nested import Outcome, read_outcome, run_scene, targets
from floeflow.analysis.studies.norms import errors, on_grid, relative
from floeflow.analysis.studies.plans import study_variants
from floeflow.analysis.studies.share import link_shared
from floeflow.analysis.studies.variants import BASE, variant_keys, write_variant
from floeflow.core.errors import FloeError
from floeflow.core.records import Record, write_records
from floeflow.diagnostics.run_cost import read_benchmark
from floeflow.scene import Scene, load_scene
from floeflow.state import read_dataset

HELD_OUT = Path(__file__).with_name("held_out")
RANKS = {"beaufort_more": 1, "loose_floes": 2, "kara_ridges": 1}


def run(path: Path, scene: Scene, ranks: int) -> dict[str, tuple[Scene, Outcome]]:
    """Run a held-out scene as it stands, to its report, and at its finest."""
    folder = Path("results") / scene.name / "accuracy"
    file = folder / "scenes" / f"{REFERENCE}.yaml"
    variant = study_variants("accuracy", scene)[REFERENCE]
    finest = write_variant(variant_keys(path, scene, "accuracy", variant), file)
    found: dict[str, tuple[Scene, Outcome]] = {}
    for name, source, own in ((BASE, path, scene), (REFERENCE, file, finest)):
        if name == REFERENCE:
            link_shared(scene, own)
        log = folder / "log" / f"{name}.workflow.log"
        wanted = [f"results/{scene.name}/report.html"] if name == BASE else targets(own)
        fault = run_scene(source, own, log, ranks, wanted)
        if fault:
            raise FloeError(f"{own.name}: {fault}")
        found[name] = own, read_outcome(own, fault)
    return found


def seconds_of(scene: Scene) -> float:
    """Wall time of all jobs of a run, one after the other, as Snakemake measured them."""
    tables = sorted((Path("results") / scene.name / "benchmarks").rglob("*.tsv"))
    return sum(read_benchmark(table)[0] for table in tables)


def measured_errors(scene: Scene, runs: dict[str, tuple[Scene, Outcome]]) -> dict[str, float]:
    """Relative error of the scene as it stands, in the norms that a plan keeps."""
    results = Path("results")
    ends = {name: read_ends(results / own.name) for name, (own, _) in runs.items()}
    mask = read_dataset(results / runs[BASE][0].name / "preprocess/mask.nc")
    grids = {name: on_grid(scene, each, mask) for name, each in ends.items()}
    found = relative(*errors(ends[REFERENCE], ends[BASE], (grids[REFERENCE], grids[BASE])))
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
    runs = run(path, scene, ranks)
    own, outcome = runs[BASE]
    by_knob = knob_errors(scene, c, error_model())
    # Both runs have the same elements.
    guess = {norm: total_error(by_knob, (norm,), but=("element_size",)) for norm in KEPT}
    return Row(
        scene,
        ranks,
        outcome,
        seconds_of(own),
        run_seconds(c, own, own.effects, ranks, fit),
        measured_errors(scene, runs),
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
