# SPDX-License-Identifier: GPL-2.0-or-later
"""What a whole run is expected to take, printed before its first job, and after its last one."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from floeflow.analysis.estimate.expected import Expected, expectation, expected, outcome
from floeflow.analysis.estimate.resources import job_ranks
from floeflow.scene import Scene
from floeflow.workflow.ranks import RULE, asked_ranks


@dataclass(frozen=True)
class Forecast:
    """Of a run that has begun at ``began`` (s, of a clock that only goes forward)."""

    found: Expected
    ranks: int
    began: float

    def first_line(self) -> str:
        """What is expected."""
        return expectation(self.found, self.ranks)

    def last_line(self, folder: Path) -> str:
        """What the run took, with the files under its folder.

        Parameters
        ----------
        folder : Path
            ``results/<scene>``.

        Returns
        -------
        str
            Time and size beside what was expected.
        """
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
        return outcome(self.found, time.monotonic() - self.began, size)


def forecast(scene: Scene, chunks: Iterable[str], workflow: Any) -> Forecast | None:
    """Of the scene's run; None where not all of its windows are about to run.

    Parameters
    ----------
    scene : Scene
        The scene.
    chunks : iterable of str
        Names of its chunks.
    workflow : snakemake.workflow.Workflow
        About to run its jobs.

    Returns
    -------
    Forecast or None
        Expected seconds and bytes, from this moment on.
    """
    about = {
        job.wildcards["chunk"]
        for job in workflow.dag.needrun_jobs()
        if job.rule.name == RULE and job.wildcards["scene"] == scene.name
    }
    if about != set(chunks):
        return None
    ranks = rank_count(scene, workflow)
    return Forecast(expected(scene, ranks), ranks, time.monotonic())


def rank_count(scene: Scene, workflow: Any) -> int:
    """MPI ranks of a window: on one machine its threads, as many as there are cores for.

    Parameters
    ----------
    scene : Scene
        With the ranks of a job.
    workflow : object
        Of Snakemake.

    Returns
    -------
    int
        At least 1.
    """
    if not workflow.local_exec:
        return job_ranks(scene)
    settings = workflow.resource_settings
    asked, cores = asked_ranks(settings), getattr(settings, "cores", None)
    many = int(asked) if str(asked).isdigit() else 2
    return min(many, cores) if isinstance(cores, int) else many
