# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``estimate``: what each effect would change and cost."""

import json
from pathlib import Path

from floeflow.analysis.estimate.summary import estimates
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    text = json.dumps(
        estimates(scene_of(snakemake), snakemake.params.chosen_by), indent=1, allow_nan=False
    )
    Path(str(snakemake.output.estimates)).write_text(text + "\n")


if __name__ == "__main__":
    run_script(main, snakemake)
