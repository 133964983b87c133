# SPDX-License-Identifier: GPL-2.0-or-later
"""Coupling windows: dynamics and column, one launch for each group of windows."""


rule window:
    input:
        state=previous_state,
        forcing=group_forcing,
        plugin=str(PLUGIN),
        cells=cells_input,
    output:
        state="results/{scene}/state/{window}.nc",
        series="results/{scene}/series/{window}.nc",
        cost="results/{scene}/cost/{window}.json",
    log:
        "results/{scene}/log/window/{window}.log",
    benchmark:
        "results/{scene}/benchmarks/window/{window}.tsv"
    wildcard_constraints:
        window=r"[0-9]*[1-9][0-9]*",
    threads: 2
    resources:
        mem_mb=4000,
        runtime=240,
    params:
        scene_keys=keys_of("dynamics", "column", "cure"),
        windows=group_windows,
    message:
        "Windows {params.windows}: dynamics and column on {threads} ranks"
    script:
        "../../simulate/window.py"
