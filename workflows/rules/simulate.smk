# SPDX-License-Identifier: GPL-2.0-or-later
"""Coupling windows: dynamics and column, one launch for each chunk of windows."""


rule windows:
    input:
        scene=ancient(scene_file),
        state=state_before,
        forcing=user_forcing,
        plugin=SCENES.plugin,
        cells=made("cells", "preprocess/cells.nc", "remap"),
        mask=sea_mask,
    output:
        state="results/{scene}/state/{chunk}.nc",
        series="results/{scene}/series/{chunk}.nc",
        elements="results/{scene}/elements/{chunk}.nc",
        cost="results/{scene}/cost/{chunk}.json",
    log:
        "results/{scene}/log/windows/{chunk}.log",
    benchmark:
        "results/{scene}/benchmarks/windows/{chunk}.tsv"
    wildcard_constraints:
        chunk=r"[0-9]*[1-9][0-9]*",
    # They use all cores, one chunk after the other: gridding waits, and then runs side by side.
    priority: 10
    threads: 2
    resources:
        mpi=launcher_asked,
        tasks=ranks_asked,
        mem_mb=memory_asked("windows"),
        mem_mb_per_cpu=memory_of_a_rank,
        runtime=minutes_asked("windows"),
    params:
        scene_keys=keys_of("dynamics", "column", "remesh", "forcing", "keep"),
        library=library_digest("windows"),
        made_with=made_with,
        windows=chunk_windows,
    message:
        "Windows {params.windows[0]} to {wildcards.chunk}: dynamics and column"
    script:
        "../../simulate/windows.py"
