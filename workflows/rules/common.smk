# SPDX-License-Identifier: GPL-2.0-or-later
"""What all rules share: scenes by name, hashes of what a stage reads, and input functions."""

from pathlib import Path

from floeflow.analysis.estimate.resources import job_memory, job_minutes, job_ranks
from floeflow.analysis.studies.plans import STUDIES, study_variants
from floeflow.core.polygon_names import files_of_polygons
from floeflow.diagnostics.study_summaries import valid_summaries
from floeflow.forcings.files import users_files
from floeflow.masks.polygon_inputs import polygon_inputs
from floeflow.workflow.library import library_digest
from floeflow.workflow.scenes import Scenes

SCENES = Scenes(config, workflow)
RESULTS = f"results/{SCENES.default}"
# Stages whose scene keys the runs of a study depend on.
STUDY_STAGES = ("mask", "packing", "bonds", "dynamics", "column", "estimate")


def scene_hashes(name, *stages):
    """Hash of the scene keys that these stages read: a changed plot key reruns no window."""
    return "-".join(SCENES.hash(name, stage) for stage in stages)


def keys_of(*stages):
    """Params function: hash of the keys that these stages read of the wildcard's scene."""

    def keys(wildcards):
        return scene_hashes(wildcards.scene, *stages)

    return keys


def scene_file(wildcards):
    """The resolved scene; its age means nothing, hashes tell what a stage reads of it."""
    return SCENES.file(wildcards.scene)


def made(stage, name, effect=None):
    """Input function: a file of preprocessing, of the scene that owns it, where it is needed."""

    def path(wildcards):
        if effect and effect not in SCENES.scene(wildcards.scene).effects:
            return []
        return f"results/{SCENES.owner(wildcards.scene, stage)}/{name}"

    return path


def mask_file(wildcards):
    """The user's ice mask or labelled image of floes, shoreline and region; none for uniform ice."""
    mask = SCENES.scene(wildcards.scene).mask
    ice = mask.labels.file or ("" if mask.uniform else mask.file)
    return [path for path in (ice, *polygon_inputs(mask)) if path]


def size_polygons(wildcards):
    """The user's polygons with sizes of elements, where the scene names them."""
    return files_of_polygons(SCENES.scene(wildcards.scene).packing.size.polygons)


def land_file(wildcards):
    """Land of the 1 km mask, where the scene asks for it."""
    wanted = SCENES.scene(wildcards.scene).mask.land == "global_land_mask"
    return made("land", "preprocess/land.nc")(wildcards) if wanted else []


def sea_mask(wildcards):
    """The mask, in which the sea is, where the scene has a mixed layer or rims."""
    wanted = {"mixed_layer", "rims"} & set(SCENES.scene(wildcards.scene).effects)
    return made("mask", "preprocess/mask.nc")(wildcards) if wanted else []


def sea_file(wildcards):
    """File with the temperature of the sea, where it is not the mask's own."""
    scene = SCENES.scene(wildcards.scene)
    return scene.sea.file if "mixed_layer" in scene.effects and scene.sea.file else []


def wall_mesh(wildcards):
    """Mesh of a wall, where the scene has one."""
    scene = SCENES.scene(wildcards.scene)
    return scene.walls.mesh if "walls" in scene.effects and scene.walls.mesh else []


def user_forcing(wildcards):
    """Forcing files of the user; formulae need none."""
    return list(users_files(SCENES.scene(wildcards.scene)))


def chosen_by(wildcards):
    """Who chose the effects: the scene, or the estimates."""
    return SCENES.run(wildcards.scene).chosen_by


def made_with(wildcards):
    """Plugin and code with which the run began."""
    return SCENES.run(wildcards.scene).made_with


def chunk_windows(wildcards):
    """Windows of a chunk."""
    return SCENES.run(wildcards.scene).chunks[wildcards.chunk]


def state_before(wildcards):
    """State at a chunk's start."""
    before = SCENES.run(wildcards.scene).before(wildcards.chunk)
    return f"results/{wildcards.scene}/state/{before}.nc"


def start_of_run(wildcards):
    """State 0, where the chunk is the first."""
    state = state_before(wildcards)
    first = SCENES.run(wildcards.scene).before(wildcards.chunk) == "0000"
    return [state] if first else []


def of_chunks(pattern):
    """Input function: a file of each chunk."""

    def paths(wildcards):
        chunks = SCENES.run(wildcards.scene).chunks
        return expand(pattern, scene=wildcards.scene, chunk=chunks)

    return paths


def grid_file(wildcards):
    """Gridded output, where the scene has it."""
    wanted = "grid_output" in SCENES.scene(wildcards.scene).effects
    return f"results/{wildcards.scene}/grid.nc" if wanted else []


def has_tendencies(effects):
    """Whether a scene's run ends with tendencies on the grid."""
    return {"grid_output", "thermodynamics"} <= set(effects)


def tendencies_file(wildcards):
    """Tendencies on the grid, where the scene has them."""
    effects = SCENES.scene(wildcards.scene).effects
    return f"results/{wildcards.scene}/tendencies.nc" if has_tendencies(effects) else []


def last_state(wildcards):
    """State at the end of the run."""
    return f"results/{wildcards.scene}/state/{SCENES.run(wildcards.scene).last}.nc"


def default_targets():
    """The report of the scene that the command line names, and what its effects bring beside it."""
    effects = SCENES.scene(SCENES.default).effects
    names = ["report.html"]
    if "trajectory_output" in effects:
        names += ["trajectory/elements.lammpsdump", "trajectory/drift.nc"]
    if has_tendencies(effects):
        names += ["tendencies.nc"]
    return [f"{RESULTS}/{name}" for name in names]


def stage_benchmarks(wildcards):
    """What Snakemake measured of the stages before and after the windows."""
    run = SCENES.run(wildcards.scene)
    stages = ["mask", "packing", "initial", "diagnostics"]
    stages += ["land"] if run.scene.mask.land == "global_land_mask" else []
    stages += ["bonds"] if "bonds" in run.scene.effects else []
    stages += ["cells"] if "remap" in run.scene.effects else []
    chunked = ["windows"]
    if "grid_output" in run.scene.effects:
        stages, chunked = [*stages, "grid"], [*chunked, "fields"]
    stages += ["tendencies"] if has_tendencies(run.scene.effects) else []
    names = [*stages, *expand("{rule}/{chunk}", rule=chunked, chunk=run.chunks)]
    return expand(
        "results/{scene}/benchmarks/{name}.tsv", scene=wildcards.scene, name=names
    )


def ranks_asked(wildcards):
    """MPI ranks of a window's job on a cluster; on one machine they are its threads."""
    return job_ranks(SCENES.scene(wildcards.scene))


def launcher_asked(wildcards):
    """What starts these ranks on a cluster: FLOEFLOW_MPI; nothing on one machine."""
    return SCENES.launcher()


def windows_asked(wildcards):
    """Number of windows that a job works on: those of its chunk, else all."""
    run = SCENES.run(wildcards.scene)
    return len(run.chunks.get(getattr(wildcards, "chunk", ""), run.windows))


def memory_asked(stage):
    """Resource function: memory of a rule's job, more when it comes again."""

    def memory(wildcards, threads, attempt):
        scene, ranks = SCENES.scene(wildcards.scene), 1 if stage == "variant" else 0
        if stage == "windows":
            # On a cluster a rank is a task of one thread.
            ranks = threads if threads > 1 else job_ranks(scene)
        return job_memory(scene, stage, ranks, attempt)

    return memory


def memory_of_a_rank(wildcards, attempt):
    """Memory for each of a window's ranks, whatever their number."""
    scene = SCENES.scene(wildcards.scene)
    return job_memory(scene, "windows", 2, attempt) // 2


def minutes_asked(stage):
    """Resource function: time limit of a rule's job, more when it comes again."""

    def minutes(wildcards, attempt):
        scene = SCENES.scene(wildcards.scene)
        ranks = job_ranks(scene) if stage == "windows" else 1
        asked = job_minutes(scene, stage, windows_asked(wildcards), ranks, attempt)
        return SCENES.within_limits(asked, stage)

    return minutes


def variant_of(wildcards):
    """What a run of a study changes in its base scene: another change runs it again."""
    base, _, name = wildcards.scene.partition("+")
    study, _, variant = name.partition("-")
    return study_variants(study, SCENES.scene(base))[variant].as_text()


def all_windows(wildcards):
    """Windows of a run of a study, which is one chunk."""
    return SCENES.run(wildcards.scene).windows


def base_record(wildcards):
    """The base run of the study, with which all others are compared."""
    base, _, name = wildcards.scene.partition("+")
    study, _, variant = name.partition("-")
    return [] if variant == "base" else f"results/{base}+{study}-base/record.json"


def study_records(study):
    """Input function: records of all runs of a study."""

    def records(wildcards):
        names = study_variants(study, SCENES.scene(wildcards.scene))
        return expand(
            "results/{scene}+{study}-{variant}/record.json",
            scene=wildcards.scene,
            study=study,
            variant=names,
        )

    return records


def finished_studies(wildcards):
    """Studies that the report shows: those that are there and hold for this scene."""
    folder = Path("results") / wildcards.scene
    return valid_summaries(folder, scene_hashes(wildcards.scene, *STUDY_STAGES))
