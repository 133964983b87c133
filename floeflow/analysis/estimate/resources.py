# SPDX-License-Identifier: GPL-2.0-or-later
"""What a job asks of a cluster: ranks, memory and time, from the keys of its scene alone.

Every job asks, so no file is read: the ice is taken to fill the domain densely. Memory was measured
rule by rule (peak resident memory, ``cpu/*.json`` of a run) with 5,000, 20,000 and 100,000 elements
of the Arctic, one window of an hour, two ranks; what is asked is that and a margin. Long runs and
other effects were not measured. Time is the cost model's with a margin for slower machines and for
what the model does not know. A job that comes again asks for twice as much.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from floeflow.analysis.estimate.cost import Sizes, coefficients, sizes, stage_seconds

if TYPE_CHECKING:
    from floeflow.scene import Scene

# With fewer elements a rank waits for its neighbours; more ranks than these are asked by hand.
ELEMENTS_A_RANK, MOST_RANKS = 2500, 64
# A program without elements and the Snakemake around it; a rank without elements, which compiles
# (677 MB with 5,500 elements, 523 without compiling). MB.
PROGRAM_MB, RANK_MB = 700, 700
LEAST_MINUTES, MARGIN = 10, 8


@dataclass(frozen=True)
class Outline:
    """A pack that fills its domain, as the cost model asks for it.

    Parameters
    ----------
    elements : int
        Number of elements.
    element_size : float
        Side of a square of an element's area, m.
    concentration, bond_concentration, coast_share : float
        Dense ice, all of it bonded where the scene has bonds.
    """

    elements: int
    element_size: float
    concentration: float = 1.0
    bond_concentration: float = 0.0
    coast_share: float = 0.1


@dataclass(frozen=True)
class Memory:
    """Memory of a rule's job beside that of its programs.

    Parameters
    ----------
    fixed : float
        MB.
    element, cell : float
        kB for each element, and for each cell of the mask.
    """

    fixed: float = 0.0
    element: float = 0.0
    cell: float = 0.0


MEMORY = {
    "land": Memory(fixed=1000.0, cell=1.0),
    "mask": Memory(cell=1.0),
    "estimate": Memory(cell=1.0),
    "packing": Memory(element=4.0, cell=1.0),
    "cells": Memory(element=4.0, cell=1.0),
    "bonds": Memory(element=4.0),
    "initial": Memory(element=8.0, cell=1.0),
    "windows": Memory(element=10.0, cell=1.0),
    "variant": Memory(element=10.0, cell=1.0),
    "fields": Memory(element=4.0, cell=2.0),
    "grid": Memory(cell=2.0),
    "tendencies": Memory(element=4.0, cell=2.0),
    "diagnostics": Memory(fixed=500.0, element=4.0),
    "report": Memory(fixed=500.0, element=6.0, cell=2.0),
    "trajectory": Memory(fixed=500.0, element=4.0),
    "mesh": Memory(fixed=500.0, element=4.0),
    "coast": Memory(fixed=500.0, cell=2.0),
    "study": Memory(fixed=3000.0),
}
# Which parts of the cost model a rule's time is made of.
STAGES = {
    "land": ("land",),
    "mask": ("mask",),
    "packing": ("packing",),
    "cells": ("packing",),
    "bonds": ("packing",),
    "initial": ("packing",),
    "report": ("report",),
}


def outline(scene: Scene) -> Outline:
    """The scene's pack, before its mask is read.

    Parameters
    ----------
    scene : Scene
        Its keys; no file is read.
    """
    domain = scene.domain
    area = (domain.x_max - domain.x_min) * (domain.y_max - domain.y_min)
    # Half of a domain is land or open water: elements are smaller by that, and steps shorter.
    return Outline(scene.packing.elements, math.sqrt(0.5 * area / scene.packing.elements))


def job_ranks(scene: Scene) -> int:
    """MPI ranks of a window's job on a cluster: at least two, which Slurm's plugin asks for.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    return min(MOST_RANKS, max(2, scene.packing.elements // ELEMENTS_A_RANK))


def job_memory(scene: Scene, rule: str, ranks: int = 0, attempt: int = 1) -> int:
    """Memory of a job, MB.

    Parameters
    ----------
    scene : Scene
        The scene.
    rule : str
        A key of `MEMORY`.
    ranks : int
        MPI ranks, each of which holds the state; 0 for a rule without.
    attempt : int
        From 1 on.
    """
    need, s = MEMORY[rule], _sizes(scene)
    data = (need.element * s.elements + need.cell * s.mask_cells) / 1000.0
    each = RANK_MB + data if ranks else data
    whole = PROGRAM_MB + need.fixed + max(ranks, 1) * each
    return 2 ** (attempt - 1) * 50 * math.ceil(whole / 50)


def job_minutes(scene: Scene, rule: str, windows: int = 0, ranks: int = 1, attempt: int = 1) -> int:
    """Time limit of a job, minutes.

    Parameters
    ----------
    scene : Scene
        The scene.
    rule : str
        A key of `MEMORY`.
    windows : int
        Coupling windows that the job works on.
    ranks : int
        MPI ranks.
    attempt : int
        From 1 on.
    """
    s, fit = _sizes(scene), coefficients()
    stages = stage_seconds(s, scene.effects, fit)
    share = windows / s.windows
    if rule in ("windows", "variant"):
        work = stages["dynamics"] + stages.get("column", 0.0)
        seconds = fit["launch"] + share * (stages["window"] + work / ranks)
    elif rule in ("fields", "grid"):
        seconds = share * stages.get("grid", 0.0)
    elif rule == "tendencies":
        seconds = stages.get(rule, 0.0)
    elif rule in ("diagnostics", "trajectory", "mesh", "study"):
        seconds = stages["window"]
    else:
        seconds = sum(stages[stage] for stage in STAGES.get(rule, ()))
    return math.ceil(2 ** (attempt - 1) * (LEAST_MINUTES + MARGIN * seconds / 60.0))


def _sizes(scene: Scene) -> Sizes:
    return sizes(outline(scene), scene, scene.effects, coefficients())
