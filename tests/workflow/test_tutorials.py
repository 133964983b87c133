# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorials run from top to bottom as a reader types them: files are saved, commands given."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from support.runner import PROJECT

pytestmark = pytest.mark.workflow

FOLDER = PROJECT / "docs/tutorials"
# A file that the reader saves, or commands after a prompt.
PART = re.compile(
    r"[Ss]ave\s+this\s+as\s+`(?P<path>[\w./]+)`[^`]*?:\n\n```\w+\n(?P<text>.*?)^```"
    r"|^```console\n(?P<commands>.*?)^```",
    re.M | re.S,
)
# What the pages promise, by page.
SAID = {
    "first_scene": (r"Report: .*first/report.html", r"^7 times$", r"fastest cell: \d+ cm/s"),
    "own_data": (
        r"^wind: 'u10', 'v10' of my_era5.nc", r"ice: \d+\.\d km3 at the start",
        r"grown a day: \S+ km3, \S+ km3", r"mean displacement: [1-9]\d* km",
    ),
    "deformation": (r"% a day$", r"triangles of \d+ km", r"scale +\d+ km: +\d+\.\d+ % a day from"),
    "liggghts": (r"^[1-9]\d* bonds broke", r"farthest disc: \d", r"^drift 0\.4\d* m/s"),
}  # fmt: skip
LEFT = {
    "first_scene": "results/first/report.html",
    "own_data": "inputs.png",
    "deformation": "deformation.png",
    "liggghts": "broken.txt",
}


def follow(page: Path, folder: Path) -> str:
    """Do what a page says in a folder like a checkout; all that its commands print."""
    said = []
    for part in PART.finditer(page.read_text(encoding="utf-8")):
        if part["path"]:
            (folder / part["path"]).write_text(part["text"])
            continue
        for command in re.findall(r"^\$ (.*)$", part["commands"], re.M):
            done = subprocess.run(
                ["bash", "-euc", command], cwd=folder, capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, (command, done.stdout[-3000:], done.stderr[-3000:])
            said += [done.stdout, done.stderr]
    return "\n".join(said)


def test_every_tutorial_is_followed():
    assert {page.stem for page in FOLDER.glob("*.md")} == set(SAID) == set(LEFT)


@pytest.mark.parametrize("name", SAID)
def test_a_tutorial_does_what_it_says(name: str, tmp_path: Path):
    for entry in PROJECT.iterdir():
        if entry.name not in ("results", "config", ".git", ".snakemake"):
            (tmp_path / entry.name).symlink_to(entry)
    shutil.copytree(PROJECT / "config", tmp_path / "config")
    said = follow(FOLDER / f"{name}.md", tmp_path)
    for words in SAID[name]:
        assert re.search(words, said, re.M), (words, said[-3000:])
    assert (tmp_path / LEFT[name]).stat().st_size > 100
