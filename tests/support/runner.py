# SPDX-License-Identifier: GPL-2.0-or-later
"""Run the real workflow in a folder of its own, as a user would from a terminal."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import yaml

from floeflow.state.snapshots import read_snapshots

PROJECT = Path(__file__).resolve().parents[2]
# What a run reads of the project, by relative path.
READ = ("data", "build", "config")
# Nothing to read, and one text of all that is written.
STREAMS: dict[str, Any] = {
    "stdin": subprocess.DEVNULL,
    "stdout": subprocess.PIPE,
    "stderr": subprocess.STDOUT,
    "text": True,
}


@dataclass
class Place:
    """A working folder of the workflow."""

    folder: Path

    def command(self, scene: Path, ranks: int, *more: str) -> list[str]:
        """Snakemake's command line, as ``make run`` has it."""
        snakemake = Path(sys.executable).with_name("snakemake")
        return [
            str(snakemake),
            *("--snakefile", str(PROJECT / "Snakefile")),
            *("--profile", str(PROJECT / "workflows/profiles/local")),
            *("--directory", str(self.folder)),
            *("--cores", str(ranks), "--set-threads", f"windows={ranks}"),
            *[option for option in more if option.startswith("-")],
            *("--config", f"scene={scene}", "--"),
            *[target for target in more if not target.startswith("-")],
        ]

    def scene(self, base: str = "smoke", /, file: str = "", **changes: object) -> Path:
        """Write a shipped scene with changes, given as block={key: value} or key=value.

        The file has the scene's name, or another that is given.
        """
        data = yaml.safe_load((PROJECT / f"config/scenes/{base}.yaml").read_text())
        data.setdefault("name", base)
        for name, change in changes.items():
            if isinstance(change, dict):
                data[name] = {**data.get(name, {}), **change}
            else:
                data[name] = change
        path = self.folder / (file or f"{data['name']}.yaml")
        path.write_text(yaml.safe_dump(data))
        return path

    def run(self, scene: Path, *more: str, ranks: int = 2) -> subprocess.CompletedProcess[str]:
        """Run to the end, on a core for each rank; standard error is joined to standard output."""
        return subprocess.run(self.command(scene, ranks, *more), check=False, **STREAMS)

    def planned(self, scene: Path, *targets: str) -> dict[str, int]:
        """Jobs that Snakemake would run, by rule."""
        done = self.run(scene, "-n", *targets)
        assert done.returncode == 0, done.stdout
        table = re.search(r"Job stats:\njob +count\n[- ]+\n(.*?)\n\n", done.stdout, re.S)
        if table is None:
            assert "Nothing to be done" in done.stdout
            return {}
        rows = (row.split() for row in table[1].splitlines())
        return {row[0]: int(row[1]) for row in rows if row[0] not in ("all", "total")}

    def rules(self, scenes: dict[str, dict[str, object]]) -> dict[str, set[str]]:
        """Rules behind scenes, each given by its name and changes, as one call tells them.

        Of the first all that a run makes by default, of the others their reports.
        """
        shipped = self.folder / "config"
        if shipped.is_symlink():
            shipped.unlink()
            (shipped / "scenes").mkdir(parents=True)
        paths = [
            self.scene(file=f"config/scenes/{name}.yaml", name=name, **changes)
            for name, changes in scenes.items()
        ]
        reports = [f"results/{name}/report.html" for name in list(scenes)[1:]]
        return self.pending(paths[0], "all", *reports)

    def pending(self, scene: Path, *targets: str) -> dict[str, set[str]]:
        """Rules that would run for targets, by the scene whose files they make."""
        done = self.run(scene, "--summary", *targets)
        assert done.returncode == 0, done.stdout
        rows = [line.split("\t") for line in done.stdout.splitlines() if line.count("\t") == 5]
        assert rows[0][2::3] == ["rule", "plan"]
        found: dict[str, set[str]] = {}
        for path, _, rule, *_, plan in rows[1:]:
            if plan != "no update":
                found.setdefault(path.split("/")[1], set()).add(rule)
        return found

    def start(self, scene: Path, *more: str) -> subprocess.Popen[str]:
        """Start in a session of its own, so that all of it can be killed."""
        return subprocess.Popen(self.command(scene, 2, *more), start_new_session=True, **STREAMS)

    def results(self, name: str = "smoke") -> Path:
        """Results of a scene."""
        return self.folder / "results" / name


@dataclass
class Done:
    """A finished run."""

    place: Place
    scene: Path
    output: str

    @property
    def results(self) -> Path:
        """Its results."""
        return self.place.results()


def bits(results: Path) -> dict[int, str]:
    """A digest for each window of what it left: the elements with their ice.

    Of names and bytes alone: the provenance of a state tells how its run was cut into chunks.
    """
    snapshots = read_snapshots(sorted((results / "elements").glob("*.nc")))
    return {int(part.attrs["window"]): digest(part) for part in snapshots}


def digest(data: xr.Dataset) -> str:
    """SHA-256 of the names and bytes of a dataset's variables."""
    found = hashlib.sha256()
    for name in sorted(map(str, data.data_vars)):
        found.update(name.encode())
        found.update(np.ascontiguousarray(data[name].values).tobytes())
    return found.hexdigest()


def make_place(folder: Path, like: Place | None = None) -> Place:
    """Make a working folder, empty or a copy of another with all its results."""
    if like is None:
        folder.mkdir(parents=True, exist_ok=True)
        for name in READ:
            (folder / name).symlink_to(PROJECT / name)
    else:
        shutil.copytree(like.folder, folder, symlinks=True)
    return Place(folder)


def read_until(process: subprocess.Popen[str], words: str) -> str:
    """Read a process's output up to the line that holds these words, and return that line."""
    assert process.stdout is not None
    seen = []
    for line in process.stdout:
        seen.append(line)
        if words in line:
            return line
    raise AssertionError(f"ended without '{words}':\n" + "".join(seen))


def drain(process: subprocess.Popen[str]) -> str:
    """Read until the last process that writes to this output has ended."""
    assert process.stdout is not None
    rest = process.stdout.read()
    process.wait()
    return rest


def kill_all(process: subprocess.Popen[str]) -> None:
    """``kill -9`` a run with all its children, ranks included."""
    os.killpg(process.pid, signal.SIGKILL)
    drain(process)


def kill_alone(process: subprocess.Popen[str]) -> None:
    """``kill -9`` Snakemake only; its job lives on."""
    os.kill(process.pid, signal.SIGKILL)
    process.wait()


@contextlib.contextmanager
def paused(process: subprocess.Popen[str]) -> Iterator[None]:
    """Hold a run and its jobs where they are, so that what is tried meanwhile finds them alive."""
    os.killpg(process.pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.killpg(process.pid, signal.SIGCONT)
