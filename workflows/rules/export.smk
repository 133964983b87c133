# SPDX-License-Identifier: GPL-2.0-or-later
"""On request only, no part of the report: files for OVITO, MDAnalysis and ParaView, and movies.

.venv/bin/snakemake --profile workflows/profiles/local --config scene=PATH -- trajectory mesh coast zarr movies
"""


rule trajectory:
    input:
        f"{RESULTS}/trajectory/elements.lammpsdump",
        f"{RESULTS}/trajectory/drift.nc",


rule mesh:
    input:
        f"{RESULTS}/mesh",


rule trajectory_files:
    input:
        scene=ancient(scene_file),
        first="results/{scene}/state/0000.nc",
        elements=of_chunks("results/{scene}/elements/{chunk}.nc"),
    output:
        trajectory="results/{scene}/trajectory/elements.lammpsdump",
        places="results/{scene}/trajectory/elements.xtc",
        drift="results/{scene}/trajectory/drift.nc",
    log:
        "results/{scene}/log/trajectory.log",
    benchmark:
        "results/{scene}/benchmarks/trajectory.tsv"
    resources:
        mem_mb=memory_asked("trajectory"),
        runtime=minutes_asked("trajectory"),
    params:
        scene_keys=keys_of("trajectory"),
        library=library_digest("trajectory"),
    message:
        "Trajectory: the elements through all windows, and their drift"
    script:
        "../../postprocess/trajectory_files.py"


rule mesh_files:
    input:
        first="results/{scene}/state/0000.nc",
        elements=of_chunks("results/{scene}/elements/{chunk}.nc"),
        states=of_chunks("results/{scene}/state/{chunk}.nc"),
        packing=made("packing", "preprocess/packing.nc"),
        grid=grid_file,
    output:
        meshes=directory("results/{scene}/mesh"),
    log:
        "results/{scene}/log/mesh.log",
    benchmark:
        "results/{scene}/benchmarks/mesh.tsv"
    resources:
        mem_mb=memory_asked("mesh"),
        runtime=minutes_asked("mesh"),
    params:
        scene_keys=keys_of("mesh"),
        library=library_digest("mesh"),
    message:
        "Mesh: cells, discs and grid at all window boundaries, and the bonds"
    script:
        "../../postprocess/mesh_files.py"


rule zarr:
    input:
        f"{RESULTS}/grid.zarr",


rule grid_zarr:
    input:
        grid="results/{scene}/grid.nc",
    output:
        store=directory("results/{scene}/grid.zarr"),
    log:
        "results/{scene}/log/zarr.log",
    benchmark:
        "results/{scene}/benchmarks/zarr.tsv"
    resources:
        mem_mb=memory_asked("grid"),
        runtime=minutes_asked("grid"),
    params:
        library=library_digest("fields"),
    message:
        "Zarr: the fields of all windows as a Zarr store"
    script:
        "../../postprocess/grid_zarr.py"


rule coast:
    input:
        f"{RESULTS}/mesh/coast.stl",
        f"{RESULTS}/mesh/coast.vtu",


rule coast_files:
    input:
        mask=made("mask", "preprocess/mask.nc"),
        packing=made("packing", "preprocess/packing.nc"),
    output:
        wall="results/{scene}/mesh/coast.stl",
        view="results/{scene}/mesh/coast.vtu",
    log:
        "results/{scene}/log/coast.log",
    benchmark:
        "results/{scene}/benchmarks/coast.tsv"
    resources:
        mem_mb=memory_asked("coast"),
        runtime=minutes_asked("coast"),
    params:
        scene_keys=keys_of("mesh"),
        library=library_digest("coast"),
    message:
        "Coast: land as a wall mesh, simplified to the size of the elements"
    script:
        "../../postprocess/coast_files.py"


rule movies:
    input:
        f"{RESULTS}/movies",


rule movie_files:
    input:
        scene=ancient(scene_file),
        grid="results/{scene}/grid.nc",
        mask=made("mask", "preprocess/mask.nc"),
    output:
        movies=report(
            directory("results/{scene}/movies"),
            patterns=["{field}.mp4"],
            caption="../captions/movie.rst",
            category="Movies",
            labels={"scene": "{scene}", "field": "{field}"},
        ),
    log:
        "results/{scene}/log/movies.log",
    benchmark:
        "results/{scene}/benchmarks/movies.tsv"
    resources:
        mem_mb=memory_asked("report"),
        runtime=minutes_asked("report"),
    params:
        scene_keys=keys_of("report"),
        library=library_digest("report"),
    message:
        "Movies: thickness, drift, damage and deformation, a picture a window"
    script:
        "../../postprocess/movie_files.py"
