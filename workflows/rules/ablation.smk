# SPDX-License-Identifier: GPL-2.0-or-later
"""On request: what each effect of the scene really changes and saves, beside its estimate.

snakemake --profile workflows/profiles/local --config scene=PATH -- ablation
"""


rule ablation:
    input:
        f"{RUN.folder}/ablation.html",


rule ablation_page:
    input:
        records=ablation_records,
    output:
        page="results/{scene}/ablation.html",
        table="results/{scene}/ablation/ablation.table.json",
        digest="results/{scene}/ablation/digest.json",
        figures=directory("results/{scene}/ablation/figures"),
    log:
        "results/{scene}/log/ablation.log",
    benchmark:
        "results/{scene}/benchmarks/ablation.tsv"
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        scene_keys=keys_of("report"),
        study_keys=keys_of(*STUDY_STAGES),
    message:
        "Ablation: real change and saving of each effect beside the estimate"
    script:
        "../../studies/ablation_page.py"
