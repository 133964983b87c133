# SPDX-License-Identifier: GPL-2.0-or-later
"""On request: the hard cases at length, and one page of what they showed.

snakemake --profile workflows/profiles/local -- stability
"""


rule stability:
    input:
        "results/stability/stability.html",


rule hard_case:
    input:
        plugin=str(PLUGIN),
        test=f"{HARD_CASES_FOLDER}/test_{{case}}.py",
    output:
        record="results/stability/{case}.json",
    log:
        "results/stability/log/{case}.log",
    benchmark:
        "results/stability/benchmarks/{case}.tsv"
    wildcard_constraints:
        case="|".join(HARD_CASES),
    resources:
        mem_mb=4000,
        runtime=120,
    params:
        python=sys.executable,
    message:
        "Hard case: {wildcards.case}"
    shell:
        # A case that fails is a row of the table; one that leaves no record is a fault.
        "{params.python} -m pytest -q {input.test} --figures --record {output.record}"
        " > {log} 2>&1 || test -s {output.record}"


rule stability_page:
    input:
        records=expand("results/stability/{case}.json", case=HARD_CASES),
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
    message:
        "Stability: what the hard cases showed"
    script:
        "../../studies/stability_page.py"
