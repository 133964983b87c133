# SPDX-License-Identifier: GPL-2.0-or-later
"""From states to grids, diagnostics and the report."""


rule grid:
    input:
        state="results/{scene}/state/{window}.nc",
        mask="results/{scene}/preprocess/mask.nc",
    output:
        grid="results/{scene}/grid/{window}.nc",
    log:
        "results/{scene}/log/grid/{window}.log",
    benchmark:
        "results/{scene}/benchmarks/grid/{window}.tsv"
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        scene_keys=keys_of("grid"),
    message:
        "Grid: state {wildcards.window} on the scene's grid"
    script:
        "../../postprocess/grid.py"


rule diagnostics:
    input:
        states=[
            "results/{scene}/state/0000.nc",
            *group_ends("results/{scene}/state/{window}.nc"),
        ],
        series=group_ends("results/{scene}/series/{window}.nc"),
        cost=group_ends("results/{scene}/cost/{window}.json"),
        grids=grid_inputs,
    output:
        dataset="results/{scene}/diagnostics.nc",
        headline="results/{scene}/diagnostics.json",
    log:
        "results/{scene}/log/diagnostics.log",
    benchmark:
        "results/{scene}/benchmarks/diagnostics.tsv"
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        scene_keys=keys_of("diagnostics"),
        windows=RUN.windows,
    message:
        "Diagnostics: series, budgets and their residuals"
    script:
        "../../postprocess/diagnostics.py"


rule report:
    input:
        diagnostics="results/{scene}/diagnostics.nc",
        headline="results/{scene}/diagnostics.json",
        first_state="results/{scene}/state/0000.nc",
        last_state=f"results/{{scene}}/state/{RUN.ends[-1]}.nc",
        grids=grid_inputs,
        mask="results/{scene}/preprocess/mask.nc",
        packing="results/{scene}/preprocess/packing.nc",
        estimates="results/{scene}/effects.json",
        benchmarks=stage_benchmarks,
    output:
        report="results/{scene}/report.html",
        figures=directory("results/{scene}/figures"),
    log:
        "results/{scene}/log/report.log",
    benchmark:
        "results/{scene}/benchmarks/report.tsv"
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        scene_keys=keys_of("report"),
        studies=finished_studies,
    message:
        "Report: maps, series, budgets and cost of the scene"
    script:
        "../../postprocess/report.py"
