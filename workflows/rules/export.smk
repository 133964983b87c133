# SPDX-License-Identifier: GPL-2.0-or-later
"""On request only, no part of the report: files for OVITO, MDAnalysis and ParaView.

snakemake --profile workflows/profiles/local --config scene=PATH -- trajectory mesh
"""


rule trajectory:
    input:
        f"{RUN.folder}/trajectory/elements.lammpsdump",
        f"{RUN.folder}/trajectory/drift.nc",


rule mesh:
    input:
        f"{RUN.folder}/mesh/elements.pvd",


rule trajectory_files:
    input:
        states=[
            "results/{scene}/state/0000.nc",
            *group_ends("results/{scene}/state/{window}.nc"),
        ],
    output:
        trajectory="results/{scene}/trajectory/elements.lammpsdump",
        drift="results/{scene}/trajectory/drift.nc",
    log:
        "results/{scene}/log/trajectory.log",
    benchmark:
        "results/{scene}/benchmarks/trajectory.tsv"
    resources:
        mem_mb=4000,
        runtime=30,
    params:
        scene_keys=keys_of("trajectory"),
        windows=RUN.windows,
    message:
        "Trajectory: the elements through all states, and their drift"
    script:
        "../../postprocess/trajectory_files.py"


rule mesh_files:
    input:
        packing="results/{scene}/preprocess/packing.nc",
        states=[
            "results/{scene}/state/0000.nc",
            *group_ends("results/{scene}/state/{window}.nc"),
        ],
    output:
        meshes=[
            f"results/{{scene}}/mesh/{window}.vtu" for window in ["0000", *RUN.windows]
        ],
        series="results/{scene}/mesh/elements.pvd",
    log:
        "results/{scene}/log/mesh.log",
    benchmark:
        "results/{scene}/benchmarks/mesh.tsv"
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        scene_keys=keys_of("mesh"),
        windows=RUN.windows,
    message:
        "Mesh: the elements' cells at all window boundaries"
    script:
        "../../postprocess/mesh_files.py"
