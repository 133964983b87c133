# SPDX-License-Identifier: GPL-2.0-or-later
"""From snapshots of the elements to grids, diagnostics and the report."""


rule fields:
    input:
        scene=ancient(scene_file),
        start=start_of_run,
        elements="results/{scene}/elements/{chunk}.nc",
        mask=made("mask", "preprocess/mask.nc"),
        forcing=user_forcing,
    output:
        fields="results/{scene}/fields/{chunk}.nc",
    log:
        "results/{scene}/log/fields/{chunk}.log",
    benchmark:
        "results/{scene}/benchmarks/fields/{chunk}.tsv"
    wildcard_constraints:
        chunk=r"[0-9]*[1-9][0-9]*",
    resources:
        mem_mb=memory_asked("fields"),
        runtime=minutes_asked("fields"),
    params:
        scene_keys=keys_of("grid"),
        library=library_digest("fields"),
    message:
        "Fields: windows up to {wildcards.chunk} on the scene's grid"
    script:
        "../../postprocess/fields.py"


rule grid:
    input:
        fields=of_chunks("results/{scene}/fields/{chunk}.nc"),
    output:
        grid="results/{scene}/grid.nc",
    log:
        "results/{scene}/log/grid.log",
    benchmark:
        "results/{scene}/benchmarks/grid.tsv"
    resources:
        mem_mb=memory_asked("grid"),
        runtime=minutes_asked("grid"),
    params:
        library=library_digest("fields"),
    message:
        "Grid: the fields of all windows in one file"
    script:
        "../../postprocess/grid.py"


rule tendencies:
    input:
        scene=ancient(scene_file),
        grid="results/{scene}/grid.nc",
        elements=of_chunks("results/{scene}/elements/{chunk}.nc"),
        mask=made("mask", "preprocess/mask.nc"),
    output:
        tendencies="results/{scene}/tendencies.nc",
    log:
        "results/{scene}/log/tendencies.log",
    benchmark:
        "results/{scene}/benchmarks/tendencies.tsv"
    resources:
        mem_mb=memory_asked("tendencies"),
        runtime=minutes_asked("tendencies"),
    params:
        scene_keys=keys_of("grid"),
        library=library_digest("fields"),
    message:
        "Tendencies: growth, melt and motion of the ice on the grid"
    script:
        "../../postprocess/tendencies.py"


rule diagnostics:
    input:
        scene=ancient(scene_file),
        first="results/{scene}/state/0000.nc",
        elements=of_chunks("results/{scene}/elements/{chunk}.nc"),
        series=of_chunks("results/{scene}/series/{chunk}.nc"),
        cost=of_chunks("results/{scene}/cost/{chunk}.json"),
        grid=grid_file,
        last=last_state,
        forcing=user_forcing,
    output:
        dataset="results/{scene}/diagnostics.nc",
        headline="results/{scene}/diagnostics.json",
        analyses="results/{scene}/analyses.nc",
    log:
        "results/{scene}/log/diagnostics.log",
    benchmark:
        "results/{scene}/benchmarks/diagnostics.tsv"
    resources:
        mem_mb=memory_asked("diagnostics"),
        runtime=minutes_asked("diagnostics"),
    params:
        scene_keys=keys_of("diagnostics"),
        library=library_digest("diagnostics"),
    message:
        "Diagnostics: series, budgets and analyses of the ice"
    script:
        "../../postprocess/diagnostics.py"


rule report:
    input:
        scene=ancient(scene_file),
        diagnostics="results/{scene}/diagnostics.nc",
        headline="results/{scene}/diagnostics.json",
        analyses="results/{scene}/analyses.nc",
        first_state="results/{scene}/state/0000.nc",
        last_state=last_state,
        grid=grid_file,
        tendencies=tendencies_file,
        mask=made("mask", "preprocess/mask.nc"),
        packing=made("packing", "preprocess/packing.nc"),
        estimates="results/{scene}/effects.json",
        benchmarks=stage_benchmarks,
    output:
        report=report(
            "results/{scene}/report.html",
            caption="../captions/report.rst",
            category="Report",
            labels={"scene": "{scene}"},
        ),
        figures=report(
            directory("results/{scene}/figures"),
            patterns=["{figure}.png", "{figure}.svg"],
            caption="../captions/figure.rst",
            category="Figures",
            labels={"scene": "{scene}", "figure": "{figure}"},
        ),
    log:
        "results/{scene}/log/report.log",
    benchmark:
        "results/{scene}/benchmarks/report.tsv"
    resources:
        mem_mb=memory_asked("report"),
        runtime=minutes_asked("report"),
    params:
        scene_keys=keys_of("report"),
        library=library_digest("report"),
        studies=finished_studies,
    message:
        "Report: maps, series, budgets and cost of the scene"
    script:
        "../../postprocess/report.py"
