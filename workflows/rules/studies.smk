# SPDX-License-Identifier: GPL-2.0-or-later
"""On request: runs of studies, which are scenes of their own, and the pages of what they showed.

.venv/bin/snakemake --profile workflows/profiles/local --config scene=PATH -- ablation accuracy ensemble

The hard cases are tests: `make stability` runs them, and then the rule that draws their records.
"""


rule variant:
    input:
        scene=ancient(scene_file),
        state=made("initial", "state/0000.nc"),
        cells=made("cells", "preprocess/cells.nc", "remap"),
        forcing=user_forcing,
        plugin=SCENES.plugin,
        mask=sea_mask,
        base=base_record,
    output:
        record="results/{scene}/record.json",
    log:
        "results/{scene}/log/variant.log",
    benchmark:
        "results/{scene}/benchmarks/variant.tsv"
    wildcard_constraints:
        scene=r"[a-z0-9][a-z0-9_-]*\+[a-z0-9_-]+",
    resources:
        mem_mb=memory_asked("variant"),
        runtime=minutes_asked("variant"),
    params:
        scene_keys=keys_of("dynamics", "column", "remesh", "forcing", "initial", "grid"),
        library=library_digest("windows"),
        made_with=made_with,
        windows=all_windows,
        variant=variant_of,
    message:
        "Study: {wildcards.scene}"
    script:
        "../../studies/variant.py"


rule ablation:
    input:
        f"{RESULTS}/ablation.html",


rule ablation_page:
    input:
        scene=ancient(scene_file),
        records=study_records("ablation"),
    output:
        page=report(
            "results/{scene}/ablation.html",
            caption="../captions/study.rst",
            category="Studies",
            labels={"scene": "{scene}", "study": "ablation"},
        ),
        table="results/{scene}/ablation/ablation.table.json",
        digest="results/{scene}/ablation/digest.json",
        figures=directory("results/{scene}/ablation/figures"),
    log:
        "results/{scene}/log/ablation.log",
    benchmark:
        "results/{scene}/benchmarks/ablation.tsv"
    resources:
        mem_mb=memory_asked("study"),
        runtime=minutes_asked("study"),
    params:
        scene_keys=keys_of("report"),
        library=library_digest("studies"),
        study_keys=keys_of(*STUDY_STAGES),
    message:
        "Ablation: real change and saving of each effect beside the estimate"
    script:
        "../../studies/ablation_page.py"


rule accuracy:
    input:
        f"{RESULTS}/accuracy.html",


rule accuracy_page:
    input:
        scene=ancient(scene_file),
        records=study_records("accuracy"),
        mask=made("mask", "preprocess/mask.nc"),
    output:
        page=report(
            "results/{scene}/accuracy.html",
            caption="../captions/study.rst",
            category="Studies",
            labels={"scene": "{scene}", "study": "accuracy"},
        ),
        data="results/{scene}/accuracy/accuracy.nc",
        table="results/{scene}/accuracy/accuracy.table.json",
        digest="results/{scene}/accuracy/digest.json",
        figures=directory("results/{scene}/accuracy/figures"),
    log:
        "results/{scene}/log/accuracy.log",
    benchmark:
        "results/{scene}/benchmarks/accuracy.tsv"
    resources:
        mem_mb=memory_asked("study"),
        runtime=minutes_asked("study"),
    params:
        scene_keys=keys_of("report"),
        library=library_digest("studies"),
        study_keys=keys_of(*STUDY_STAGES),
    message:
        "Accuracy: error against cost, orders, recommendations"
    script:
        "../../studies/accuracy_page.py"


rule ensemble:
    input:
        f"{RESULTS}/ensemble.html",


rule ensemble_page:
    input:
        scene=ancient(scene_file),
        records=study_records("ensemble"),
    output:
        page=report(
            "results/{scene}/ensemble.html",
            caption="../captions/study.rst",
            category="Studies",
            labels={"scene": "{scene}", "study": "ensemble"},
        ),
        table="results/{scene}/ensemble/ensemble.table.json",
        digest="results/{scene}/ensemble/digest.json",
        figures=directory("results/{scene}/ensemble/figures"),
    log:
        "results/{scene}/log/ensemble.log",
    benchmark:
        "results/{scene}/benchmarks/ensemble.tsv"
    resources:
        mem_mb=memory_asked("study"),
        runtime=minutes_asked("study"),
    params:
        scene_keys=keys_of("report"),
        library=library_digest("studies"),
        study_keys=keys_of(*STUDY_STAGES),
    message:
        "Ensemble: what settings cost and change where ice breaks, with intervals"
    script:
        "../../studies/ensemble_page.py"


rule stability_page:
    input:
        records="results/stability/records.json",
    output:
        page="results/stability/stability.html",
        table="results/stability/table.md",
        digest="results/stability/digest.json",
        figures=directory("results/stability/figures"),
    log:
        "results/stability/log/page.log",
    benchmark:
        "results/stability/benchmarks/page.tsv"
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        library=library_digest("studies"),
    message:
        "Stability: what the hard cases showed"
    script:
        "../../studies/stability_page.py"
