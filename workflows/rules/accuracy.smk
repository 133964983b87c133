# SPDX-License-Identifier: GPL-2.0-or-later
"""On request: error against cost of the scene, knob by knob and all together.

snakemake --profile workflows/profiles/local --config scene=PATH -- accuracy
"""


rule accuracy:
    input:
        f"{RUN.folder}/accuracy.html",


rule accuracy_page:
    input:
        records=accuracy_records,
    output:
        page="results/{scene}/accuracy.html",
        data="results/{scene}/accuracy/accuracy.nc",
        table="results/{scene}/accuracy/accuracy.table.json",
        digest="results/{scene}/accuracy/digest.json",
        figures=directory("results/{scene}/accuracy/figures"),
    log:
        "results/{scene}/log/accuracy.log",
    benchmark:
        "results/{scene}/benchmarks/accuracy.tsv"
    resources:
        mem_mb=4000,
        runtime=20,
    params:
        scene_keys=keys_of("report"),
        study_keys=keys_of(*STUDY_STAGES),
    message:
        "Accuracy: error against cost, orders, recommendations"
    script:
        "../../studies/accuracy_page.py"
