# SPDX-License-Identifier: GPL-2.0-or-later
"""A private Slurm for the tests of this folder, and ``smoke`` run through it once."""

from __future__ import annotations

import importlib.util
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from support.kills import start_over
from support.runner import Done, make_place
from support.slurm import Cluster, PrivateSlurm

PROGRAMS = ("slurmctld", "slurmd", "munged", "sbatch", "srun")
PLUGINS = ("snakemake_executor_plugin_slurm", "snakemake_executor_plugin_cluster_generic")


@pytest.fixture(scope="session")
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PrivateSlurm]:
    """Two nodes of two cores; skipped, with the reason, where it cannot be."""
    if os.getuid() != 0:
        pytest.skip("a private Slurm must be started as root")
    places = f"{os.environ['PATH']}:/usr/sbin"
    if missing := [name for name in PROGRAMS if not shutil.which(name, path=places)]:
        pytest.skip(
            f"Slurm is not installed, there is no {', '.join(missing)} (make test-cluster installs "
            "it where it can)"
        )
    if missing := [name for name in PLUGINS if not importlib.util.find_spec(name)]:
        pytest.skip(f"Snakemake lacks {', '.join(missing)} (make setup-cluster)")
    started = PrivateSlurm(tmp_path_factory.mktemp("slurm"))
    try:
        started.start()
        yield started
    finally:
        started.stop()


@pytest.fixture(scope="session")
def smoke(slurm: PrivateSlurm, tmp_path_factory: pytest.TempPathFactory) -> Done:
    """The whole of ``smoke`` through sbatch, each rule a job, its windows on two ranks."""
    place = make_place(tmp_path_factory.mktemp("smoke") / "place")
    scene = place.scene()
    done = Cluster(slurm, place).run("cluster-generic", scene)
    assert done.returncode == 0, done.stdout
    return Done(place, scene, done.stdout)


@pytest.fixture
def undone(smoke: Done, slurm: PrivateSlurm, tmp_path: Path) -> Iterator[Callable[[], Cluster]]:
    """Make a copy of the finished run whose windows are undone; ends what a test leaves running."""
    made = []

    def make() -> Cluster:
        place = make_place(tmp_path / "copy", like=smoke.place)
        start_over(place)
        shutil.rmtree(place.folder / ".snakemake/slurm_logs", ignore_errors=True)
        made.append(Cluster(slurm, place))
        return made[-1]

    yield make
    for cluster in made:
        cluster.end()
