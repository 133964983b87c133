# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``variant``: one run of a study, compared with the base run, or a setting's members."""

import json
import os
from pathlib import Path

from floeflow.analysis.studies.ensemble_plan import STUDY
from floeflow.analysis.studies.ensemble_run import run_members
from floeflow.analysis.studies.run import run_variant
from floeflow.analysis.studies.variants import Variant
from floeflow.coupling.chunk import Chunk
from floeflow.diagnostics.diagnostics import write_json
from floeflow.workflow.job import Snakemake, run_script, scene_folder, scene_of
from floeflow.workflow.library import check_made_with


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    given, folder = snakemake.input, scene_folder(snakemake)
    check_made_with(Path(given.plugin), snakemake.params.made_with)
    os.environ["FLOEFLOW_PLUGIN"] = str(Path(given.plugin).resolve())
    chunk = Chunk(
        scene=scene_of(snakemake),
        folder=folder,
        windows=tuple(snakemake.params.windows),
        state=Path(given.state),
        plugin=Path(given.plugin),
        ranks=1,
        cells=Path(str(given.cells)) if given.cells else None,
        library=snakemake.params.library,
        mask=Path(str(given.mask)) if given.mask else None,
    )
    base = json.loads(Path(str(given.base)).read_text()) if given.base else None
    variant = Variant.from_text(snakemake.params.variant)
    if chunk.scene.name.partition("+")[2].startswith(f"{STUDY}-"):
        record = run_members(variant, chunk, base)
    else:
        record = run_variant(variant, chunk, base, folder / "cpu")
    write_json(record, Path(str(snakemake.output.record)))


if __name__ == "__main__":
    run_script(main, snakemake)
