# SPDX-License-Identifier: GPL-2.0-or-later
"""What a day of the Arctic would take on many cores: counts, and a model of latency and bandwidth.

Nobody measured it: speeds are those of one machine (docs/scaling.md), the network's are assumed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt

ELEMENTS = (1e5, 1e6, 1e7)
CORES = tuple(2**k for k in range(11))


@dataclass(frozen=True)
class Machine:
    """A cluster.

    Parameters
    ----------
    latency : float
        Of a message, s.
    bandwidth : float
        Of a core's share of its node's network, bytes/s.
    step_rate : float
        Element-steps per second of a core, with every effect of the Arctic scene.
    """

    latency: float = 2.0e-6
    bandwidth: float = 1.0e9
    step_rate: float = 2.7e6


@dataclass(frozen=True)
class Day:
    """A day of the Arctic with every effect, one window.

    Parameters
    ----------
    steps, elements : float
        Steps of a day with so many elements; smaller elements need more, by the root.
    samples : int
        Samples of the series, at each of which every rank gets all elements.
    column_seconds : float
        Of a core, for an element.
    whole_seconds : float
        For an element, of what every rank does for all elements or one rank does for all ranks:
        set-up, states in and out, forcing, the sea, remapping.
    sample_seconds : float
        For an element and sample, of putting gathered elements in order on every rank.
    sample_bytes, pair_bytes : float
        Of an element in a sample; of an element's bonds and contacts at the end.
    ghosts : float
        Ghosts of a rank over the root of its elements.
    ghost_bytes : float
        Sent for a ghost in a step.
    imbalance : float
        Elements of the busiest rank over their mean.
    """

    steps: float = 1464.0
    elements: float = 6242.0
    samples: int = 24
    column_seconds: float = 2.6e-4
    whole_seconds: float = 2.2e-4
    sample_seconds: float = 5.0e-7
    sample_bytes: float = 137.0
    pair_bytes: float = 400.0
    ghosts: float = 4.6
    ghost_bytes: float = 72.0
    imbalance: float = 1.2


def day_seconds(n: float, ranks: int, machine: Machine, day: Day) -> dict[str, float]:
    """Seconds of a day by what takes them.

    Returns
    -------
    dict of float
        ``steps``: forces and motion; ``neighbours``: messages of each step; ``samples``: all
        elements to all ranks; ``column``; ``whole``: what does not get faster with ranks.
    """
    steps = day.steps * math.sqrt(n / day.elements)
    share = n / ranks
    several = ranks > 1
    # Four neighbours, and one sum over all ranks that asks whether lists must be made anew.
    messages = 4 + 2 * math.ceil(math.log2(ranks)) if several else 0
    halo = day.ghosts * math.sqrt(share) * day.ghost_bytes if several else 0.0
    moved = (day.samples * day.sample_bytes + day.pair_bytes) * n if several else 0.0
    return {
        "steps": steps * share * day.imbalance**several / machine.step_rate,
        "neighbours": steps * (messages * machine.latency + halo / machine.bandwidth),
        "samples": day.samples * day.sample_seconds * n + moved / machine.bandwidth,
        "column": share * day.column_seconds,
        "whole": n * day.whole_seconds,
    }


def total(seconds: dict[str, float], without: Iterable[str] = ()) -> float:
    """Sum over all parts but some."""
    left_out = set(without)
    return sum(value for name, value in seconds.items() if name not in left_out)


def draw(path: Path, machine: Machine | None = None, day: Day | None = None) -> None:
    """Draw predicted time over cores, whole and of the parts that ranks share."""
    machine, day = machine or Machine(), day or Day()
    figure, axes = plt.subplots(figsize=(7.0, 5.0), layout="constrained")
    for n, colour in zip(ELEMENTS, ("tab:blue", "tab:orange", "tab:red"), strict=True):
        each = [day_seconds(n, cores, machine, day) for cores in CORES]
        axes.loglog(CORES, [total(e) for e in each], "-o", color=colour, ms=3, label=f"{n:.0e}")
        shared = [total(e, ("whole", "samples")) for e in each]
        axes.loglog(CORES, shared, "--", color=colour, lw=1)
    axes.set(xlabel="cores", ylabel="seconds for a day of the Arctic (predicted)")
    axes.set_title("Solid: as it is; dashed: if ranks shared all work", fontsize="medium")
    axes.set_xticks(CORES, [str(cores) for cores in CORES])
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.legend(title="elements")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=100, metadata={"Software": None})
    plt.close(figure)
