# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of a study: variants of the scene, each through a workflow of its own."""


rule variant:
    input:
        source=RUN.scene.mask.file,
        plugin=str(PLUGIN),
        base=base_record,
    output:
        record="results/{scene}/{study}/{variant}.json",
    log:
        "results/{scene}/{study}/log/{variant}.log",
    benchmark:
        "results/{scene}/{study}/benchmarks/{variant}.tsv"
    wildcard_constraints:
        study="|".join(STUDIES),
        variant=r"[a-z0-9_-]+",
    resources:
        mem_mb=4000,
        runtime=240,
    params:
        scene_keys=keys_of(*STUDY_STAGES),
        variant=variant_text,
    message:
        "Study {wildcards.study}: {wildcards.variant}"
    script:
        "../../studies/variant.py"
