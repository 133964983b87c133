# SPDX-License-Identifier: GPL-2.0-or-later
"""From the ice mask to the state at the start: land, mask, packing, bonds, forcing."""


rule land:
    output:
        land="results/{scene}/preprocess/land.nc",
    log:
        "results/{scene}/log/land.log",
    benchmark:
        "results/{scene}/benchmarks/land.tsv"
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        scene_keys=keys_of("land"),
    message:
        "Land: share of each mask cell on the 1 km land mask"
    script:
        "../../preprocess/land.py"


rule mask:
    input:
        source=RUN.scene.mask.file,
        land=land_input,
    output:
        mask="results/{scene}/preprocess/mask.nc",
    log:
        "results/{scene}/log/mask.log",
    benchmark:
        "results/{scene}/benchmarks/mask.tsv"
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        scene_keys=keys_of("mask"),
    message:
        "Mask: ice concentration and thickness of {input.source} on the scene's grid"
    script:
        "../../preprocess/mask.py"


rule estimate:
    input:
        source=RUN.scene.mask.file,
    output:
        estimates="results/{scene}/effects.json",
    log:
        "results/{scene}/log/estimate.log",
    benchmark:
        "results/{scene}/benchmarks/estimate.tsv"
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        scene_keys=keys_of("estimate"),
    message:
        "Estimate: what each effect would change and cost"
    script:
        "../../preprocess/estimate.py"


rule packing:
    input:
        mask="results/{scene}/preprocess/mask.nc",
    output:
        packing="results/{scene}/preprocess/packing.nc",
    log:
        "results/{scene}/log/packing.log",
    benchmark:
        "results/{scene}/benchmarks/packing.tsv"
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        scene_keys=keys_of("packing"),
    message:
        "Packing: elements over the ice, their cells and radii"
    script:
        "../../preprocess/packing.py"


rule cells:
    input:
        mask="results/{scene}/preprocess/mask.nc",
        packing="results/{scene}/preprocess/packing.nc",
    output:
        cells="results/{scene}/preprocess/cells.nc",
    log:
        "results/{scene}/log/cells.log",
    benchmark:
        "results/{scene}/benchmarks/cells.tsv"
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        scene_keys=keys_of("cells"),
    message:
        "Cells: the sea around the ice, for remapping"
    script:
        "../../preprocess/cells.py"


rule bonds:
    input:
        packing="results/{scene}/preprocess/packing.nc",
    output:
        bonds="results/{scene}/preprocess/bonds.nc",
    log:
        "results/{scene}/log/bonds.log",
    benchmark:
        "results/{scene}/benchmarks/bonds.tsv"
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        scene_keys=keys_of("bonds"),
    message:
        "Bonds: glue lines between neighbours"
    script:
        "../../preprocess/bonds.py"


rule analytic:
    output:
        forcing="results/{scene}/forcing/analytic_{window}.nc",
    log:
        "results/{scene}/log/analytic/{window}.log",
    benchmark:
        "results/{scene}/benchmarks/analytic/{window}.tsv"
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        scene_keys=keys_of("forcing"),
    message:
        "Forcing: cyclone, gyre and weather of window {wildcards.window}"
    script:
        "../../preprocess/analytic.py"


rule forcing:
    input:
        source=forcing_source,
    output:
        forcing="results/{scene}/forcing/{window}.nc",
    log:
        "results/{scene}/log/forcing/{window}.log",
    benchmark:
        "results/{scene}/benchmarks/forcing/{window}.tsv"
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        scene_keys=keys_of("forcing"),
    message:
        "Forcing: {input.source} on the scene's grid, window {wildcards.window}"
    script:
        "../../preprocess/forcing.py"


rule initial:
    input:
        packing="results/{scene}/preprocess/packing.nc",
        bonds=bonds_input,
        mesh=wall_mesh,
    output:
        state="results/{scene}/state/0000.nc",
    log:
        "results/{scene}/log/initial.log",
    benchmark:
        "results/{scene}/benchmarks/initial.tsv"
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        scene_keys=keys_of("initial", "mask"),
    message:
        "State 0: elements and bonds at the start"
    script:
        "../../preprocess/initial.py"
