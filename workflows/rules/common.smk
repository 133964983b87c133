# SPDX-License-Identifier: GPL-2.0-or-later
"""What all rules share: the run, its groups of windows, and the inputs that depend on them."""

import sys
from pathlib import Path

from floeflow.scene import stage_hash
from floeflow.workflow.open_run import PLUGIN, open_scene
from floeflow.diagnostics.study_summaries import valid_digests
from floeflow.analysis.studies.plans import STUDIES, study_variants

RUN = open_scene(config, workflow)
EFFECTS = RUN.scene.effects
GRIDDED = "grid_output" in EFFECTS
# Stages whose scene keys the runs of a study depend on.
STUDY_STAGES = ("mask", "packing", "bonds", "dynamics", "column", "estimate")
HARD_CASES_FOLDER = Path(workflow.basedir) / "tests/stability"
HARD_CASES = sorted(
    path.stem.removeprefix("test_") for path in HARD_CASES_FOLDER.glob("test_*.py")
)


def keys_of(*stages):
    """Hash of the scene keys that these stages read: a changed plot key reruns no window."""
    return "-".join(stage_hash(RUN.scene, stage) for stage in stages)


def previous_state(wildcards):
    """State before the group of windows that ends with this one."""
    return f"results/{wildcards.scene}/state/{RUN.before(wildcards.window)}.nc"


def group_forcing(wildcards):
    """Forcing of each window of the group."""
    windows = RUN.groups[wildcards.window]
    return [f"results/{wildcards.scene}/forcing/{window}.nc" for window in windows]


def group_windows(wildcards):
    """Names of the group's windows."""
    return RUN.groups[wildcards.window]


def forcing_source(wildcards):
    """The user's forcing file, or the analytic one of this window."""
    if RUN.scene.forcing.source == "file":
        return RUN.scene.forcing.file
    return f"results/{wildcards.scene}/forcing/analytic_{wildcards.window}.nc"


def group_ends(pattern):
    """Files of this kind for each group of windows."""
    return [pattern.replace("{window}", end) for end in RUN.ends]


def land_input(wildcards):
    """Land of the 1 km mask, where the scene asks for it."""
    wanted = RUN.scene.mask.land == "global_land_mask"
    return f"results/{wildcards.scene}/preprocess/land.nc" if wanted else []


def bonds_input(wildcards):
    """Bond table, where the scene has bonds."""
    return (
        f"results/{wildcards.scene}/preprocess/bonds.nc" if "bonds" in EFFECTS else []
    )


def cells_input(wildcards):
    """Fresh cells, where the scene remaps."""
    return (
        f"results/{wildcards.scene}/preprocess/cells.nc" if "remap" in EFFECTS else []
    )


def wall_mesh(wildcards):
    """Mesh of a wall, where the scene has one."""
    wanted = "walls" in EFFECTS and RUN.scene.walls.mesh
    return RUN.scene.walls.mesh if wanted else []


def grid_inputs(wildcards):
    """Gridded output at all ends of groups, where the scene has it."""
    ends = ["0000", *RUN.ends] if GRIDDED else []
    return [f"results/{wildcards.scene}/grid/{end}.nc" for end in ends]


def extra_targets():
    """Files besides the report that the scene's effects bring."""
    names = ["elements.lammpsdump", "drift.nc"]
    wanted = "trajectory_output" in EFFECTS
    return [f"{RUN.folder}/trajectory/{name}" for name in names if wanted]


def stage_benchmarks(wildcards):
    """What Snakemake measured of the stages before and after the windows."""
    stages = ["mask", "packing", "initial", "diagnostics"]
    if land_input(wildcards):
        stages.insert(0, "land")
    if bonds_input(wildcards):
        stages.insert(-2, "bonds")
    if cells_input(wildcards):
        stages.insert(-2, "cells")
    windows = [f"window/{window}" for window in RUN.ends]
    grids = [f"grid/{window}" for window in ["0000", *RUN.ends] if GRIDDED]
    forcing = [f"forcing/{window}" for window in RUN.windows]
    names = [*stages, *forcing, *windows, *grids]
    return [f"results/{wildcards.scene}/benchmarks/{name}.tsv" for name in names]


def study_records(study):
    """Records of all runs of a study."""
    names = study_variants(study, RUN.scene)
    return [f"{RUN.folder}/{study}/{name}.json" for name in names]


def variant_text(wildcards):
    """What a run changes in the scene: another change runs it again."""
    variants = study_variants(wildcards.study, RUN.scene)
    return variants[wildcards.variant].as_text()


def base_record(wildcards):
    """The base run, with which all others share their preprocessing and are compared."""
    folder = f"results/{wildcards.scene}/{wildcards.study}"
    return [] if wildcards.variant == "base" else f"{folder}/base.json"


def ablation_records(wildcards):
    """Records of all runs of the ablation study."""
    return study_records("ablation")


def accuracy_records(wildcards):
    """Records of all runs of the accuracy study."""
    return study_records("accuracy")


def finished_studies(wildcards):
    """Studies that the report shows: those that are there and hold for this scene."""
    return valid_digests(Path(RUN.folder), keys_of(*STUDY_STAGES))
