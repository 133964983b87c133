# SPDX-License-Identifier: GPL-2.0-or-later
"""FloeFlow: from an ice mask to a diagnostic report.

snakemake --profile workflows/profiles/local --config scene=config/scenes/smoke.yaml
"""

from snakemake.utils import min_version

min_version("9.0")


include: "workflows/rules/common.smk"


wildcard_constraints:
    scene=r"[a-z0-9][a-z0-9_-]*",
    window=r"[0-9]+",


include: "workflows/rules/preprocess.smk"
include: "workflows/rules/dynamics.smk"
include: "workflows/rules/postprocess.smk"
include: "workflows/rules/export.smk"
include: "workflows/rules/studies.smk"
include: "workflows/rules/ablation.smk"
include: "workflows/rules/accuracy.smk"
include: "workflows/rules/stability.smk"


rule all:
    default_target: True
    input:
        f"{RUN.folder}/report.html",
        extra_targets(),


onsuccess:
    print(RUN.closing_line())
