# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``grid``: the fields of all chunks in one CF file with a time axis."""

from pathlib import Path

from floeflow.diagnostics.cf_output import join_files
from floeflow.workflow.job import Snakemake, run_script


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    parts = [Path(path) for path in snakemake.input.fields]
    join_files(parts, Path(str(snakemake.output.grid)))


if __name__ == "__main__":
    run_script(main, snakemake)
