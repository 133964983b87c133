# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``window``: a group of coupling windows."""

from __future__ import annotations

import logging
from pathlib import Path

from floeflow.core.lock import hold_alone
from floeflow.coupling import resume
from floeflow.coupling.job import Job
from floeflow.coupling.launch import fixed_hashes, run_ranks, warn_of_step
from floeflow.state import read_state
from floeflow.workflow.job import Snakemake, run_script, scene_folder, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    folder = scene_folder(snakemake)
    windows = list(snakemake.params.windows)
    warn_of_step(scene)
    log = folder / "log/window" / f"{windows[-1]}.ranks.log"
    fixed = fixed_hashes(scene, snakemake.input.plugin, snakemake.threads)
    state_path = Path(snakemake.input.state)
    lock = folder / resume.WORK / f"{windows[0]}.lock"
    with hold_alone(lock, f"window {windows[0]} of {folder}"):
        forcing = [str(path) for path in snakemake.input.forcing]
        start = read_state(state_path)
        _, todo, paths = resume.resume(start, windows, forcing, folder, fixed)
        if len(todo) < len(windows):
            done = windows[: len(windows) - len(todo)]
            logging.info("windows %s are there already, from the same origin", ", ".join(done))
            work = resume.work_folder(folder, done[-1])
            state_path = work / resume.PARTS["state"]
        if todo:
            values = scene.model_dump(mode="json")
            cells = str(snakemake.input.cells or "")
            job = Job(values, str(state_path), todo, paths, str(folder), fixed, cells)
            run_ranks(job, snakemake.threads, log)
        resume.publish(folder, windows)


if __name__ == "__main__":
    run_script(main, snakemake)
