# SPDX-License-Identifier: GPL-2.0-or-later
"""Plans against held-out scenes: predicted time and error beside those of real runs.

Usage: python benchmarks/plan.py [--out FILE]
The scenes of ``benchmarks/held_out`` were fixed before the models were fitted. Each runs as it
stands and with all knobs (but the elements) at their finest. Time is the wall time of all jobs, one
after the other: it wants idle cores.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from floeflow.bench import Record, write_records
from floeflow.config import Scene, load_scene
from floeflow.errors import FloeError
from floeflow.estimate.conditions import conditions
from floeflow.estimate.cost import coefficients, run_seconds
from floeflow.plan.precision import error_model, knob_errors, total_error
from floeflow.state import read_dataset
from floeflow.studies.accuracy_table import REFERENCE
from floeflow.studies.compare import read_ends
from floeflow.studies.measures import KEPT
from floeflow.studies.nested import Outcome, read_outcome, run_scene
from floeflow.studies.norms import errors, on_grid, relative
from floeflow.studies.plans import study_variants
from floeflow.studies.share import link_shared
from floeflow.studies.variants import BASE, variant_keys, write_variant

HELD_OUT = Path(__file__).with_name("held_out")
RANKS = {"beaufort_more": 1, "loose_floes": 2, "kara_ridges": 1}


def run(path: Path, scene: Scene, ranks: int) -> dict[str, tuple[Scene, Outcome]]:
    """Run a held-out scene as it stands and at its finest."""
    found: dict[str, tuple[Scene, Outcome]] = {}
    folder = Path("results") / scene.name / "accuracy"
    for name in (BASE, REFERENCE):
        file = folder / "scenes" / f"{name}.yaml"
        variant = study_variants("accuracy", scene)[name]
        own = write_variant(variant_keys(path, scene, "accuracy", variant), file)
        if name == REFERENCE:
            link_shared(found[BASE][0], own)
        fault = run_scene(file, own, folder / "log" / f"{name}.workflow.log", ranks)
        if fault:
            raise FloeError(f"{own.name}: {fault}")
        found[name] = own, read_outcome(own, fault)
    return found


def seconds_of(scene: Scene) -> float:
    """Wall time of all jobs of a run, one after the other, as Snakemake measured them."""
    tables = sorted((Path("results") / scene.name / "benchmarks").rglob("*.tsv"))
    found = [table.read_text().splitlines() for table in tables]
    return sum(float(lines[1].split("\t")[lines[0].split("\t").index("s")]) for lines in found)


def measured_error(scene: Scene, runs: dict[str, tuple[Scene, Outcome]]) -> float:
    """Largest relative error of the scene as it stands, of the norms that a plan keeps."""
    results = Path("results")
    ends = {name: read_ends(results / own.name) for name, (own, _) in runs.items()}
    mask = read_dataset(results / runs[BASE][0].name / "preprocess/mask.nc")
    grids = {name: on_grid(scene, each, mask) for name, each in ends.items()}
    found = relative(*errors(ends[REFERENCE], ends[BASE], (grids[REFERENCE], grids[BASE])))
    return max(found[norm] for norm in KEPT)


def compare(path: Path) -> dict[str, object]:
    """Predicted and measured time and error of a held-out scene."""
    scene, ranks = load_scene(path), RANKS[path.stem]
    c = conditions(scene)
    runs = run(path, scene, ranks)
    own = runs[BASE][0]
    guess = run_seconds(c, own, own.effects, ranks, coefficients())
    error = total_error(knob_errors(scene, c, error_model()), but=("element_size",))
    return {
        "scene": scene.name,
        "ranks": ranks,
        "elements": runs[BASE][1].elements,
        "steps": runs[BASE][1].steps,
        "seconds": seconds_of(own),
        "predicted_seconds": guess,
        "error": measured_error(scene, runs),
        "predicted_error": error,
    }


def main() -> None:
    """Run, print a table, write records."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("results/benchmarks/plan.json"))
    given = parser.parse_args()
    rows = [compare(path) for path in sorted(HELD_OUT.glob("*.yaml"))]
    print("scene            ranks     time   predicted  ratio    error   predicted  ratio")
    records = []
    for row in rows:
        time, error = (
            (float(str(row[name])), float(str(row[f"predicted_{name}"])))
            for name in ("seconds", "error")
        )
        print(
            f"{row['scene']:16} {row['ranks']:5} {time[0]:8.3g} s {time[1]:8.3g} s"
            f" {time[1] / time[0]:6.2f} {100 * error[0]:7.2g} % {100 * error[1]:7.2g} %"
            f" {error[1] / error[0]:6.2f}"
        )
        extra = {key: value for key, value in row.items() if key not in ("scene", "seconds")}
        n, ranks = int(str(row["elements"])), int(str(row["ranks"]))
        records.append(Record(f"plan {row['scene']}", n, ranks, [time[0]], extra=extra))
    write_records(records, given.out)
    print(given.out)


if __name__ == "__main__":
    main()
