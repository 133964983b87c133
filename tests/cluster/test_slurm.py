# SPDX-License-Identifier: GPL-2.0-or-later
"""The workflow on a real Slurm: ranks over nodes, limits, lost nodes, kills, queues."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from floeflow.state import read_state
from support.held_ranks import Gate, wait_for_end
from support.runner import Done, bits, digest, drain, kill_alone, read_until
from support.slurm import Cluster, PrivateSlurm

pytestmark = [pytest.mark.cluster, pytest.mark.workflow]

TARGET = "results/smoke/state/0003.nc"
SBATCH = "cluster-generic"


# Snakemake says so when Slurm has told it that the first job is over.
AGAIN = "Trying to restart job"
FIRST_KEPT = "windows 0001 to 0001 are there already"


@pytest.fixture
def gate(tmp_path: Path) -> Gate:
    """Holds the ranks of a window's job after its first window."""
    return Gate(tmp_path / "gate")


def same_end(cluster: Cluster, smoke: Done) -> bool:
    """Whether a run has the windows and the last state of the undisturbed one, bit for bit."""
    there = cluster.place.results()
    ends = [read_state(results / "state/0003.nc") for results in (there, smoke.results)]
    return bits(there) == bits(smoke.results) and digest(ends[0]) == digest(ends[1])


def windows_jobs(cluster: Cluster) -> list[dict[str, str]]:
    """Jobs of windows that are over, as Slurm's job completion file has them."""
    done = cluster.slurm.completed(cluster.place.folder)
    return [job for job in done if job["Name"] == "windows"]


def windows_log(cluster: Cluster) -> str:
    """Log of the last job that worked on the windows."""
    return (cluster.place.results() / "log/windows/0003.log").read_text()


def test_slurm_ran_every_rule_and_the_windows_on_two_tasks(smoke: Done, slurm: PrivateSlurm):
    assert (smoke.results / "report.html").is_file()
    done = slurm.completed(smoke.place.folder)
    assert {job["JobState"] for job in done} == {"COMPLETED"}
    rules = {"land", "mask", "packing", "bonds", "initial", "estimate", "windows", "fields"}
    assert {job["Name"] for job in done} == rules | {"grid", "tendencies", "diagnostics", "report"}
    (windows,) = [job for job in done if job["Name"] == "windows"]
    assert windows["ProcCnt"] == "2"
    state = read_state(smoke.results / "state/0003.nc")
    assert '"ranks": "2"' in state.attrs["provenance"]


def test_one_machine_gives_the_bits_of_the_cluster(smoke: Done, undone):
    cluster = undone()
    done = cluster.place.run(smoke.scene, TARGET)
    assert done.returncode == 0, done.stdout
    assert same_end(cluster, smoke)


def test_ranks_of_slurm_s_own_plugin_lie_on_two_nodes(smoke: Done, undone):
    cluster = undone()
    done = cluster.run("slurm", smoke.scene, TARGET, ["--set-resources", "windows:nodes=2"])
    assert done.returncode == 0, done.stdout
    (job,) = cluster.slurm.completed(cluster.place.folder)
    assert (job["JobState"], job["NodeCnt"], job["NodeList"]) == ("COMPLETED", "2", "floe[1-2]")
    assert same_end(cluster, smoke)


def test_a_job_over_its_time_comes_again_with_more(smoke: Done, undone, gate: Gate):
    cluster = undone()
    limit = ["--set-resources", "windows:runtime=1+9*(attempt-1)"]
    # It hangs as if the file system did, however fast it came so far.
    run = cluster.start(SBATCH, smoke.scene, TARGET, limit, gate.hanging)
    read_until(run, AGAIN)
    gate.open()
    said = drain(run)
    assert run.returncode == 0, said
    first, second = windows_jobs(cluster)
    assert (first["JobState"], first["TimeLimit"]) == ("TIMEOUT", "1")
    assert (second["JobState"], second["TimeLimit"]) == ("COMPLETED", "10")
    assert same_end(cluster, smoke)


def test_a_window_ends_with_its_node_and_goes_on_elsewhere(smoke: Done, undone, gate: Gate):
    cluster = undone()
    run = cluster.start(SBATCH, smoke.scene, TARGET, launcher=gate.launcher)
    rank, job = gate.arrived()
    node = cluster.slurm.job(job)["NodeList"]
    cluster.slurm("scontrol", "update", f"nodename={node}", "state=down", "reason=tried")
    try:
        read_until(run, AGAIN)
        wait_for_end(rank)
        gate.open()
        said = drain(run)
    finally:
        cluster.slurm("scontrol", "update", f"nodename={node}", "state=resume")
    assert run.returncode == 0, said
    first, second = windows_jobs(cluster)
    assert first["JobState"] == "NODE_FAIL"
    assert second["JobState"] == "COMPLETED" and second["NodeList"] != node
    assert FIRST_KEPT in windows_log(cluster)
    assert same_end(cluster, smoke)


def test_a_cancelled_window_goes_on(smoke: Done, undone, gate: Gate):
    cluster = undone()
    run = cluster.start(SBATCH, smoke.scene, TARGET, launcher=gate.launcher)
    rank, job = gate.arrived()
    cluster.slurm("scancel", job)
    read_until(run, AGAIN)
    wait_for_end(rank)
    gate.open()
    said = drain(run)
    assert run.returncode == 0, said
    assert [job["JobState"] for job in windows_jobs(cluster)] == ["CANCELLED", "COMPLETED"]
    assert FIRST_KEPT in windows_log(cluster)
    assert same_end(cluster, smoke)


def test_a_window_left_in_the_queue_by_a_killed_run_writes_nothing(smoke: Done, undone):
    cluster = undone()
    for node in ("floe1", "floe2"):
        cluster.slurm("scontrol", "update", f"nodename={node}", "state=drain", "reason=tried")
    try:
        run = cluster.start(SBATCH, smoke.scene, TARGET)
        read_until(run, "Submitted job")
        second = cluster.run(SBATCH, smoke.scene, TARGET)
        assert second.returncode == 1
        assert f"another run holds this scene (process {run.pid})" in second.stdout
        kill_alone(run)
        (left,) = cluster.slurm.jobs("PENDING")
        again = cluster.start(SBATCH, smoke.scene, TARGET)
        read_until(again, "Submitted job")
    finally:
        for node in ("floe1", "floe2"):
            cluster.slurm("scontrol", "update", f"nodename={node}", "state=resume")
    said = drain(again)
    assert again.returncode == 0, said
    states = {int(job["JobId"]): job["JobState"] for job in windows_jobs(cluster)}
    assert states.pop(left) == "FAILED"
    assert list(states.values()) == ["COMPLETED"]
    assert re.search(r"results/smoke: this job is of an earlier run .* nothing was", cluster.logs())
    assert same_end(cluster, smoke)


def test_a_window_that_outlives_its_run_is_waited_for(smoke: Done, undone, gate: Gate):
    cluster = undone()
    run = cluster.start(SBATCH, smoke.scene, TARGET, launcher=gate.launcher)
    _, job = gate.arrived()
    kill_alone(run)
    again = cluster.start(SBATCH, smoke.scene, TARGET)
    line = read_until(again, "a job of an earlier run still writes this scene")
    assert f"Slurm job {job}" in line
    gate.open()
    said = drain(again)
    assert again.returncode == 0, said
    # The second run took what the first one's job had finished meanwhile.
    states = [done["JobState"] for done in windows_jobs(cluster)]
    assert states[0] == "COMPLETED" and set(states) == {"COMPLETED"}
    assert same_end(cluster, smoke)
