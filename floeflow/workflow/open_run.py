# SPDX-License-Identifier: GPL-2.0-or-later
"""The front door: what the Snakefile does before any rule is read.

Validates the scene and its input files, takes the scene's lock, clears locks that a killed run
left, and cuts the run into groups of windows. All refusals are one sentence and exit code 1.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from floeflow.analysis.resolve import resolve_scene
from floeflow.core.errors import FloeError
from floeflow.core.lock import claim_scene, clear_stale_locks
from floeflow.scene import Scene
from floeflow.scene.windows import window_groups, window_name

DEFAULT_SCENE = "config/scenes/arctic_1981.yaml"
CONFIG_KEYS = ("scene",)
# Ways to call Snakemake that only look.
LOOKING = {"--lint", "-l", "--summary", "-S", "--detailed-summary", "-D", "--dag", "--rulegraph"}
LOOKING |= {"--filegraph", "--d3dag", "--list-rules", "--list", "--list-target-rules", "--lt"}

RESULTS = Path("results")
PLUGIN = Path("build/liggghts_models/libfloe.so")


@dataclass(frozen=True)
class Run:
    """A validated scene and how its run is cut into jobs."""

    scene: Scene
    path: str
    folder: str
    groups: dict[str, list[str]]

    @property
    def windows(self) -> list[str]:
        """Names of all windows, in order."""
        return [window for group in self.groups.values() for window in group]

    @property
    def ends(self) -> list[str]:
        """Names of the windows that end a group: the declared outputs."""
        return list(self.groups)

    def closing_line(self) -> str:
        """Say where the report lies, or that there is none yet."""
        report = Path(self.folder) / "report.html"
        return f"Report: {report.resolve()}" if report.is_file() else f"Results: {self.folder}/"

    def before(self, end: str) -> str:
        """Name of the window before the group that ends with `end`."""
        return window_name(int(self.groups[end][0]) - 1)


def open_scene(config: dict[str, Any], workflow: Any) -> Run:
    """Validate what the run was given and claim its scene.

    Parameters
    ----------
    config : dict
        Snakemake's ``--config``; only ``scene=PATH`` is known.
    workflow : snakemake.workflow.Workflow
        The running workflow.

    Returns
    -------
    Run
        The scene, its results folder and its groups of windows.
    """
    try:
        return _open_scene(config, workflow)
    except FloeError as error:
        print(f"floeflow: {error}", file=sys.stderr, flush=True)
        sys.exit(1)


def _open_scene(config: dict[str, Any], workflow: Any) -> Run:
    for name in config:
        if name not in CONFIG_KEYS:
            raise FloeError(f"--config {name}=...: only scene=PATH is known")
    # Jobs read the path from the same place.
    path = str(config.setdefault("scene", DEFAULT_SCENE))
    scene = resolve_scene(path)
    folder = RESULTS / scene.name
    groups = window_groups(scene.time.windows, scene.workflow.windows_per_job)
    if workflow.is_main_process:
        _check_inputs(scene)
        if _will_write(workflow):
            # Held until the process ends.
            claim_scene(folder)
            clear_stale_locks(folder)
    return Run(scene, path, folder.as_posix(), groups)


def _check_inputs(scene: Scene) -> None:
    from floeflow.forcings.inputs import check_forcing_file, check_mask_file

    if not PLUGIN.is_file():
        raise FloeError(f"{PLUGIN}: the LIGGGHTS plugin is not built; 'make setup' builds it")
    check_mask_file(scene)
    if scene.forcing.source == "file":
        check_forcing_file(scene)


def _will_write(workflow: Any) -> bool:
    looking = LOOKING & {argument.partition("=")[0] for argument in sys.argv}
    return not (workflow.output_settings.dryrun or looking)
