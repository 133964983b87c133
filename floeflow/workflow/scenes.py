# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes of a workflow by name: what a rule's wildcard ``{scene}`` stands for.

The main process resolves a scene when a rule first asks for it: it validates the keys and input
files, makes the effects concrete, takes the scene's lock and writes ``results/<scene>/scene.yaml``.
Jobs only read that file. A scene ``<base>+<study>-<variant>`` is the base scene with the changes of
a study's variant. All refusals are one sentence and exit code 1.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from floeflow.analysis.resolve import resolve_scene
from floeflow.analysis.studies.plans import study_variants
from floeflow.analysis.studies.variants import variant_scene
from floeflow.core.atomic_write import write_text
from floeflow.core.errors import FloeError, unexpected
from floeflow.core.lock import claim_scene, clear_stale_locks, join_run, run_id
from floeflow.core.mesh_check import check_mesh_file
from floeflow.core.plugin import plugin_path
from floeflow.scene import Scene
from floeflow.scene.checks import scene_warnings
from floeflow.scene.hashes import chain_hash, stage_hash
from floeflow.scene.load import read_keys, read_resolved
from floeflow.scene.windows import window_chunks, window_name
from floeflow.workflow.clock import check_clock, clock_sentence
from floeflow.workflow.faults import UNKNOWN, say_last, take_faults
from floeflow.workflow.forecast import Forecast, forecast
from floeflow.workflow.foreign_results import check_results
from floeflow.workflow.input_guard import check_inputs
from floeflow.workflow.library import made_with
from floeflow.workflow.manifest import write_manifest
from floeflow.workflow.partitions import partition_minutes, within
from floeflow.workflow.ranks import check_ranks

DEFAULT_SCENE = "config/scenes/arctic_1981.yaml"
SHIPPED = Path("config/scenes")
CONFIG_KEYS = ("scene",)
# Says what starts MPI programs in a cluster's job; goes from the workflow to its jobs.
MPI_VARIABLE, DEFAULT_MPI = "FLOEFLOW_MPI", "srun --mpi=pmix"
# Carries the name of the default scene to its jobs: its file may be edited while they run.
NAME_VARIABLE = "FLOEFLOW_SCENE"
# Ways to call Snakemake that only look.
LOOKING = {"--lint", "-l", "--summary", "-S", "--detailed-summary", "-D", "--dag", "--rulegraph"}
LOOKING |= {"--filegraph", "--d3dag", "--list-rules", "--list", "--list-target-rules", "--lt"}
LOOKING |= {"--report"}

RESULTS = Path("results")
# Separates the base scene from the variant in a scene's name.
PLUS = "+"


@dataclass(frozen=True)
class Run:
    """A resolved scene and how its run is cut into jobs.

    Parameters
    ----------
    scene : Scene
        With concrete effects.
    chunks : dict
        Windows of each chunk, by the chunk's name.
    chosen_by : str
        ``auto`` where the effects come from ``effects: auto``, else ``scene``.
    made_with : str
        Plugin and code of windows when the run began, see `made_with`.
    """

    scene: Scene
    chunks: dict[str, list[str]]
    chosen_by: str = "scene"
    made_with: str = ""

    @property
    def windows(self) -> list[str]:
        """Names of all windows, in order."""
        return [window for chunk in self.chunks.values() for window in chunk]

    @property
    def last(self) -> str:
        """Name of the last window."""
        return list(self.chunks)[-1]

    def before(self, chunk: str) -> str:
        """Name of the window before a chunk.

        Parameters
        ----------
        chunk : str
            Name of the chunk.

        Returns
        -------
        str
            That of the start, 0000, before the first chunk.
        """
        return window_name(int(self.chunks[chunk][0]) - 1)


class Scenes:
    """The scenes that a workflow knows, resolved once each.

    Parameters
    ----------
    config : dict
        Snakemake's ``--config``; only ``scene=PATH`` is known.
    workflow : snakemake.workflow.Workflow
        The running workflow.
    """

    def __init__(self, config: dict[str, Any], workflow: Any) -> None:
        self._runs: dict[str, Run] = {}
        self._passed: set[str] = set()
        self._hashes: dict[tuple[str, str], str] = {}
        self._files: dict[str, str | list[str]] = {}
        self._limits: dict[str, int | None] = {}
        self._forecast: Forecast | None = None
        self._main = bool(workflow.is_main_process)
        self._workflow = workflow
        looking = LOOKING & {argument.partition("=")[0] for argument in sys.argv}
        self._writes = self._main and not (workflow.output_settings.dryrun or looking)
        with refused_in_a_sentence("the scene"):
            self._plugin = plugin_path(Path(workflow.basedir))
            self._made_with = made_with(self._plugin) if self._main else ""
            for name in config:
                if name not in CONFIG_KEYS:
                    raise FloeError(f"--config {name}=...: only scene=PATH is known")
            # Jobs read the path from the same place.
            self._path = Path(str(config.setdefault("scene", DEFAULT_SCENE)))
            self.default = self._default_name()
            self.run(self.default)
            if self._main and not looking:
                check_ranks(getattr(workflow, "resource_settings", None))

    @property
    def plugin(self) -> str:
        """Path of the LIGGGHTS plugin."""
        return str(self._plugin)

    def _default_name(self) -> str:
        if self._main or NAME_VARIABLE not in os.environ:
            name = read_keys(self._path).get("name", self._path.stem)
            os.environ[NAME_VARIABLE] = str(name)
        return os.environ[NAME_VARIABLE]

    def launcher(self) -> str:
        """What starts the ranks of a cluster's job; empty on one machine, where it is mpirun.

        To be asked for when jobs are made: Snakemake knows its executor only then.
        """
        if self._main and self._workflow.local_exec:
            os.environ.pop(MPI_VARIABLE, None)
        elif self._main:
            os.environ.setdefault(MPI_VARIABLE, DEFAULT_MPI)
        return os.environ.get(MPI_VARIABLE, "")

    def within_limits(self, minutes: int, rule: str) -> int:
        """Time that a job may ask for: on a cluster, what its partition allows.

        Parameters
        ----------
        minutes : int
            That are wanted.
        rule : str
            Name of the rule.

        Returns
        -------
        int
            minutes.
        """
        if not self._main or self._workflow.local_exec:
            return minutes
        if not self._limits:
            self._limits["partition"] = partition_minutes(sys.argv)
        if rule not in self._limits:
            self._limits[rule] = minutes
            return within(minutes, self._limits["partition"], rule)
        return min(minutes, self._limits["partition"] or minutes)

    def run(self, name: str) -> Run:
        """The run of a scene's name.

        Parameters
        ----------
        name : str
            Of the scene.

        Returns
        -------
        Run
            The same object for the same name.
        """
        if name not in self._runs:
            with refused_in_a_sentence(name):
                self._runs[name] = self._resolve(name) if self._main else self._read(name)
        return self._runs[name]

    def scene(self, name: str) -> Scene:
        """The scene of a name.

        Parameters
        ----------
        name : str
            Of the scene.

        Returns
        -------
        Scene
            With all its keys.
        """
        return self.run(name).scene

    def hash(self, name: str, stage: str) -> str:
        """Hash of the keys that a stage reads of a scene, which thousands of jobs ask for.

        Parameters
        ----------
        name : str
            Of the scene.
        stage : str
            Of the workflow.

        Returns
        -------
        str
            16 hexadecimal digits.
        """
        if (name, stage) not in self._hashes:
            self._hashes[name, stage] = stage_hash(self.scene(name), stage)
        return self._hashes[name, stage]

    def owner(self, name: str, stage: str) -> str:
        """Scene whose file of a stage of preprocessing this scene uses.

        That of the base scene, where a variant changes no key that the stage or those before read.

        Parameters
        ----------
        name : str
            Of the scene.
        stage : str
            Of preprocessing.

        Returns
        -------
        str
            Name of the scene.
        """
        base = name.partition(PLUS)[0]
        same = base == name or chain_hash(self.scene(base), stage) != chain_hash(
            self.scene(name), stage
        )
        return name if same else base

    def file(self, name: str) -> str | list[str]:
        """Path of a resolved scene; none in a dry run that has nothing written yet.

        Parameters
        ----------
        name : str
            Of the scene.

        Returns
        -------
        str or list of str
            Path, or an empty list.
        """
        if name not in self._files:
            self.run(name)
            path = RESULTS / name / "scene.yaml"
            there = self._writes or path.is_file()
            self._files[name] = path.as_posix() if there else []
        return self._files[name]

    def say_expectation(self) -> None:
        """Say what the default scene's run is expected to take, where all of it is about to run.

        To be called when all jobs are known and none has begun.
        """
        run = self.run(self.default)
        with refused_in_a_sentence(self.default):
            self._forecast = forecast(run.scene, run.chunks, self._workflow)
        if self._forecast:
            print(self._forecast.first_line(), flush=True)

    def closing_line(self) -> str:
        """Say where the report of the default scene lies, or that there is none yet.

        A finished run gets its manifest here, and is compared with what was expected of it.
        """
        report = RESULTS / self.default / "report.html"
        run = self.run(self.default)
        if (
            self._writes
            and report.is_file()
            and (report.parent / "state" / f"{run.last}.nc").is_file()
        ):
            with refused_in_a_sentence(self.default):
                workflow = Path(self._workflow.basedir)
                write_manifest(run.scene, report.parent, self._plugin, run.last, workflow)
        if not report.is_file():
            return f"Results: {report.parent}/"
        took = f"{self._forecast.last_line(report.parent)}\n" if self._forecast else ""
        return f"{took}Report: {report.resolve()}"

    def say_faults(self) -> None:
        """Say last, and once, what jobs could not do."""
        told = take_faults(RESULTS, run_id())
        folder = RESULTS / self.default
        say_last(told or [clock_sentence(folder) or UNKNOWN.format(folder / "log")])

    def _read(self, name: str) -> Run:
        folder = RESULTS / name
        # Held until the job ends, and asked for before Snakemake removes what the job is to write.
        join_run(folder)
        scene = read_resolved(folder / "scene.yaml")
        try:
            chosen = json.loads((folder / "resolved.json").read_text())
        except (OSError, ValueError):
            raise FloeError(f"{folder}/resolved.json: cannot be read as JSON") from None
        return _run(scene, str(chosen["chosen_by"]), str(chosen.get("made_with", "")))

    def _resolve(self, name: str) -> Run:
        base, _, variant = name.partition(PLUS)
        if variant and name != self.default:
            run = _run(self._variant(base, variant), made_with=self._made_with)
        else:
            path = self._path_of(name)
            scene = resolve_scene(path)
            for warning in scene_warnings(scene):
                print(f"floeflow: warning: {warning}", file=sys.stderr, flush=True)
            if "walls" in scene.effects and scene.walls.mesh:
                check_mesh_file(Path(scene.walls.mesh))
            check_inputs(scene, self._passed, self._writes)
            if self._writes:
                check_clock(RESULTS / name)
                # Held until the process ends.
                claim_scene(RESULTS / name)
                clear_stale_locks(RESULTS / name)
            run = _run(scene, "auto" if scene.auto else "scene", self._made_with)
        check_results(run.scene, RESULTS / name, ["0000", *run.chunks])
        if self._writes:
            write_resolved(run, RESULTS / name)
        return run

    def _path_of(self, name: str) -> Path:
        if name == self.default:
            return self._path
        path = SHIPPED / f"{name}.yaml"
        if not path.is_file():
            raise FloeError(
                f"scene '{name}' is not known: it is neither that of --config scene={self._path} "
                f"nor {path}"
            )
        return path

    def _variant(self, base: str, name: str) -> Scene:
        study, _, variant = name.partition("-")
        variants = study_variants(study, self.scene(base))
        if variant not in variants:
            raise FloeError(f"scene '{base}' has no variant '{variant}' in a study '{study}'")
        keys = read_keys(self._path_of(base))
        return variant_scene(keys, self.scene(base), study, variants[variant])


def write_resolved(run: Run, folder: Path) -> None:
    """Write ``scene.yaml`` with all keys, and ``resolved.json``, each only where it changed.

    Parameters
    ----------
    run : Run
        Scene, and how it was made.
    folder : Path
        Of the results.
    """
    keys = run.scene.model_dump(mode="json")
    head = "# All keys of the scene, effects made concrete. Written by the workflow: do not edit.\n"
    how = {"chosen_by": run.chosen_by, "made_with": run.made_with}
    texts = {
        "scene.yaml": head + yaml.safe_dump(keys, sort_keys=False, allow_unicode=True),
        "resolved.json": json.dumps(how) + "\n",
    }
    for name, text in texts.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            write_text(text, path)


def _run(scene: Scene, chosen_by: str = "scene", made_with: str = "") -> Run:
    chunks = window_chunks(scene.time.windows, scene.workflow.windows_per_job)
    return Run(scene, chunks, chosen_by, made_with)


@contextlib.contextmanager
def refused_in_a_sentence(name: str) -> Iterator[None]:
    """End the program with one sentence and exit code 1 where the body fails.

    A fault of the program itself is told in a sentence too, with the file that has its traceback.

    Parameters
    ----------
    name : str
        Of the scene file.
    """
    try:
        yield
    except FloeError as error:
        _leave(str(error))
    except Exception as error:
        _leave(f"{name}: {unexpected(error)}")


def _leave(sentence: str) -> None:
    print(f"floeflow: {sentence}", file=sys.stderr, flush=True)
    sys.exit(1)
