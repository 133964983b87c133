# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``variant``: one run of a study."""

from __future__ import annotations

from pathlib import Path

from floeflow.analysis.studies.variant import run_variant
from floeflow.analysis.studies.variants import Variant
from floeflow.diagnostics.diagnostics import write_json
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    variant = Variant.from_text(snakemake.params.variant)
    study = str(snakemake.wildcards.study)
    record = run_variant(Path(snakemake.config["scene"]), scene, study, variant)
    write_json(record, Path(str(snakemake.output.record)))


if __name__ == "__main__":
    run_script(main, snakemake)
