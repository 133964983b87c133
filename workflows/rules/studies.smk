# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of a study: variants of the scene, each through a workflow of its own."""

from floeflow.studies.plans import STUDIES, study_variants


def study_records(study):
    """Records of all runs of a study."""
    names = study_variants(study, RUN.scene)
    return [f"{RUN.folder}/{study}/{name}.json" for name in names]


def variant_changes(wildcards):
    """What a run changes in the scene: another change runs it again."""
    variants = study_variants(wildcards.study, RUN.scene)
    return variants[wildcards.variant].as_text()


def base_record(wildcards):
    """The base run, with which all others share their preprocessing and are compared."""
    folder = f"results/{wildcards.scene}/{wildcards.study}"
    return [] if wildcards.variant == "base" else f"{folder}/base.json"


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
        scene_keys=keys_of("mask", "packing", "bonds", "dynamics", "column", "estimate"),
        changes=variant_changes,
    message:
        "Study {wildcards.study}: {wildcards.variant}"
    script:
        "../../floeflow/studies/variant.py"
