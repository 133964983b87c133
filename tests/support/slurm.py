# SPDX-License-Identifier: GPL-2.0-or-later
"""A private Slurm of two nodes on this host, and the workflow run through it."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from support.runner import PROJECT, STREAMS, Place, kill_all

SCRIPT = PROJECT / "setup/private_slurm.sh"
# Looks at jobs often, as these are short; sacct has no accounting to ask here.
QUICK = {
    "slurm": ("--slurm-init-seconds-before-status-checks=1", "--slurm-status-command=squeue"),
    "cluster-generic": ("--max-status-checks-per-second=5", "--seconds-between-status-checks=1"),
}


@dataclass(frozen=True)
class PrivateSlurm:
    """The daemons of a folder.

    Parameters
    ----------
    folder : Path
        Holds their files.
    """

    folder: Path

    def start(self) -> None:
        """Start the daemons; returns when both nodes are idle."""
        done = subprocess.run([SCRIPT, "start", self.folder], check=False, **STREAMS)
        assert done.returncode == 0, done.stdout

    def stop(self) -> None:
        """End them, with their jobs."""
        subprocess.run([SCRIPT, "stop", self.folder], check=True)

    @property
    def environment(self) -> dict[str, str]:
        """Under which Slurm's commands talk to these daemons."""
        shell = f"source {self.folder}/env.sh && env -0"
        found = subprocess.run(["bash", "-c", shell], check=True, capture_output=True, text=True)
        pairs = (pair.partition("=") for pair in found.stdout.split("\0") if pair)
        return {name: value for name, _, value in pairs}

    def __call__(self, *words: object) -> str:
        """What one of Slurm's commands says."""
        done = subprocess.run(
            list(map(str, words)), check=True, capture_output=True, text=True, env=self.environment
        )
        return done.stdout

    def jobs(self, state: str) -> list[int]:
        """Ids of jobs in a state."""
        return [int(word) for word in self("squeue", "-h", "-o", "%i", "-t", state).split()]

    def job(self, number: int) -> dict[str, str]:
        """What the controller knows of a job."""
        return fields(self("scontrol", "show", "job", "--oneliner", number))

    def completed(self, folder: Path) -> list[dict[str, str]]:
        """The job completion file: jobs of a working folder that are over, in order."""
        path = self.folder / "completed.txt"
        lines = path.read_text().splitlines() if path.is_file() else []
        return [job for job in map(fields, lines) if job["WorkDir"] == str(folder)]


def fields(line: str) -> dict[str, str]:
    """Words like ``Name=value`` of a line."""
    return dict(re.findall(r"(\w+)=(\S*)", line))


@dataclass(frozen=True)
class Cluster:
    """A working folder, and the Slurm that runs its jobs."""

    slurm: PrivateSlurm
    place: Place
    started: list[subprocess.Popen[str]] = field(default_factory=list)

    def command(self, profile: str, scene: Path, target: str = "", more: Sequence[str] = ()):
        """Snakemake's command line, as docs/how-to/cluster.md has it."""
        return [
            str(Path(sys.executable).with_name("snakemake")),
            *("--snakefile", str(PROJECT / "Snakefile")),
            *("--profile", str(PROJECT / "workflows/profiles" / profile)),
            *("--directory", str(self.place.folder)),
            *("--latency-wait", "10"),
            *QUICK[profile],
            *more,
            *("--config", f"scene={scene}"),
            *(("--", target) if target else ()),
        ]

    def run(
        self, profile: str, scene: Path, target: str = "", more: Sequence[str] = ()
    ) -> subprocess.CompletedProcess[str]:
        """Run to the end."""
        command = self.command(profile, scene, target, more)
        return subprocess.run(command, check=False, env=self.slurm.environment, **STREAMS)

    def start(
        self,
        profile: str,
        scene: Path,
        target: str = "",
        more: Sequence[str] = (),
        launcher: str = "",
    ) -> subprocess.Popen[str]:
        """Start in a session of its own, with another launcher of ranks where one is named."""
        chosen = {"FLOEFLOW_MPI": launcher} if launcher else {}
        run = subprocess.Popen(
            self.command(profile, scene, target, more),
            start_new_session=True,
            env=self.slurm.environment | chosen,
            **STREAMS,
        )
        self.started.append(run)
        return run

    def end(self) -> None:
        """End what is left of the runs that were started, and their jobs."""
        for run in self.started:
            if run.poll() is None:
                kill_all(run)
        mine = [
            int(word)
            for word in self.slurm("squeue", "-h", "-o", "%i").split()
            if self.slurm.job(int(word))["WorkDir"] == str(self.place.folder)
        ]
        if mine:
            self.slurm("scancel", *mine)

    def logs(self) -> str:
        """What Slurm kept of its jobs' words."""
        found = sorted((self.place.folder / ".snakemake/slurm_logs").rglob("*.log"))
        return "\n".join(path.read_text(errors="replace") for path in found)
