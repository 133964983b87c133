# SPDX-License-Identifier: GPL-2.0-or-later
"""What a variant shares with the base run: preprocessing whose keys are the same, by hard links.

The stage hashes that decide whether a stage runs again decide here too: a file is linked where the
keys of its stage, and of all stages before it, are the same.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from floeflow.scene import Scene, stage_hash

# Files of a stage, its log, and the stages that they depend on.
SHARED = (
    ("preprocess/land.nc", "land", ("land",)),
    ("preprocess/mask.nc", "mask", ("land", "mask")),
    ("preprocess/packing.nc", "packing", ("land", "mask", "packing")),
    ("preprocess/bonds.nc", "bonds", ("land", "mask", "packing", "bonds")),
)
FORCING = (("forcing/{window}.nc", "forcing"), ("forcing/analytic_{window}.nc", "analytic"))


def shared_files(one: Scene, other: Scene) -> Iterator[tuple[str, str]]:
    """Files, with their logs, that runs of two scenes have in common, relative to their folders."""

    def same(stages: tuple[str, ...]) -> bool:
        return all(stage_hash(one, stage) == stage_hash(other, stage) for stage in stages)

    for path, log, stages in SHARED:
        if same(stages):
            yield path, f"log/{log}.log"
    if same(("forcing",)):
        for number in range(1, min(one.time.windows, other.time.windows) + 1):
            for path, log in FORCING:
                window = f"{number:04d}"
                yield path.format(window=window), f"log/{log}/{window}.log"


def link_shared(base: Scene, variant: Scene, results: Path = Path("results")) -> int:
    """Link what a variant shares with the base run, where it is not there yet.

    Returns
    -------
    int
        Number of files linked.
    """
    linked = 0
    for names in shared_files(base, variant):
        for name in names:
            source, target = results / base.name / name, results / variant.name / name
            if source.is_file() and not target.exists():
                target.parent.mkdir(parents=True, exist_ok=True)
                os.link(source, target)
                linked += 1
    return linked
