# SPDX-License-Identifier: GPL-2.0-or-later
"""From the ice mask to the state at the start: land, mask, packing, bonds."""


rule land:
    input:
        scene=ancient(scene_file),
    output:
        land="results/{scene}/preprocess/land.nc",
    log:
        "results/{scene}/log/land.log",
    benchmark:
        "results/{scene}/benchmarks/land.tsv"
    resources:
        mem_mb=memory_asked("land"),
        runtime=minutes_asked("land"),
    params:
        scene_keys=keys_of("land"),
        library=library_digest("land"),
    message:
        "Land: share of each mask cell on the 1 km land mask"
    script:
        "../../preprocess/land.py"


rule mask:
    input:
        scene=ancient(scene_file),
        source=mask_file,
        land=land_file,
        sea=sea_file,
    output:
        mask="results/{scene}/preprocess/mask.nc",
    log:
        "results/{scene}/log/mask.log",
    benchmark:
        "results/{scene}/benchmarks/mask.tsv"
    resources:
        mem_mb=memory_asked("mask"),
        runtime=minutes_asked("mask"),
    params:
        scene_keys=keys_of("mask"),
        library=library_digest("mask"),
    message:
        "Mask: ice concentration and thickness of {input.source} on the scene's grid"
    script:
        "../../preprocess/mask.py"


rule estimate:
    input:
        scene=ancient(scene_file),
        source=mask_file,
    output:
        estimates="results/{scene}/effects.json",
    log:
        "results/{scene}/log/estimate.log",
    benchmark:
        "results/{scene}/benchmarks/estimate.tsv"
    resources:
        mem_mb=memory_asked("estimate"),
        runtime=minutes_asked("estimate"),
    params:
        scene_keys=keys_of("estimate"),
        library=library_digest("estimate"),
        chosen_by=chosen_by,
    message:
        "Estimate: what each effect would change and cost"
    script:
        "../../preprocess/estimate.py"


rule packing:
    input:
        scene=ancient(scene_file),
        mask=made("mask", "preprocess/mask.nc"),
        walls=wall_mesh,
        sizes=size_polygons,
    output:
        packing="results/{scene}/preprocess/packing.nc",
    log:
        "results/{scene}/log/packing.log",
    benchmark:
        "results/{scene}/benchmarks/packing.tsv"
    resources:
        mem_mb=memory_asked("packing"),
        runtime=minutes_asked("packing"),
    params:
        scene_keys=keys_of("packing"),
        library=library_digest("packing"),
    message:
        "Packing: elements over the ice, their cells and radii"
    script:
        "../../preprocess/packing.py"


rule cells:
    input:
        scene=ancient(scene_file),
        mask=made("mask", "preprocess/mask.nc"),
        packing=made("packing", "preprocess/packing.nc"),
    output:
        cells="results/{scene}/preprocess/cells.nc",
    log:
        "results/{scene}/log/cells.log",
    benchmark:
        "results/{scene}/benchmarks/cells.tsv"
    resources:
        mem_mb=memory_asked("cells"),
        runtime=minutes_asked("cells"),
    params:
        scene_keys=keys_of("cells"),
        library=library_digest("cells"),
    message:
        "Cells: the sea around the ice, for remapping"
    script:
        "../../preprocess/cells.py"


rule bonds:
    input:
        scene=ancient(scene_file),
        packing=made("packing", "preprocess/packing.nc"),
    output:
        bonds="results/{scene}/preprocess/bonds.nc",
    log:
        "results/{scene}/log/bonds.log",
    benchmark:
        "results/{scene}/benchmarks/bonds.tsv"
    resources:
        mem_mb=memory_asked("bonds"),
        runtime=minutes_asked("bonds"),
    params:
        scene_keys=keys_of("bonds"),
        library=library_digest("bonds"),
    message:
        "Bonds: glue lines between neighbours"
    script:
        "../../preprocess/bonds.py"


rule initial:
    input:
        scene=ancient(scene_file),
        packing=made("packing", "preprocess/packing.nc"),
        bonds=made("bonds", "preprocess/bonds.nc", "bonds"),
        mask=sea_mask,
        mesh=wall_mesh,
    output:
        state="results/{scene}/state/0000.nc",
    log:
        "results/{scene}/log/initial.log",
    benchmark:
        "results/{scene}/benchmarks/initial.tsv"
    resources:
        mem_mb=memory_asked("initial"),
        runtime=minutes_asked("initial"),
    params:
        scene_keys=keys_of("initial", "mask"),
        library=library_digest("initial"),
    message:
        "State 0: elements and bonds at the start"
    script:
        "../../preprocess/initial.py"
