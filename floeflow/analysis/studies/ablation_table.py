# SPDX-License-Identifier: GPL-2.0-or-later
"""What an ablation study found: measured change and saving of each effect beside the estimate."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

from scipy.stats import spearmanr

from floeflow.analysis.estimate.choose import OUTPUT, Estimate
from floeflow.analysis.estimate.conditions import conditions
from floeflow.analysis.estimate.cost import WORK, coefficients, cost_share, saved_share
from floeflow.analysis.studies.compare import work
from floeflow.analysis.studies.variants import BASE
from floeflow.scene import Scene

Record = Mapping[str, Any]


@dataclass(frozen=True)
class Row:
    """One effect.

    Parameters
    ----------
    name : str
        The effect.
    drift, volume, area : float
        Measured change by leaving it out: positions (m, rms), ice volume per sea area (m), share of
        the sea under ice.
    share, estimated_share : float
        Influence, measured and estimated: the largest change relative to what happens in the run.
    saving, estimated_saving : float
        Share of the work (CPU time of element model and column) that went, and that the cost model
        said.
    run_saving : float
        Share of the whole run's CPU time that went.
    element_steps : float
        Element-steps relative to the base run.
    advice : str
        Of the estimate.
    fault : str
        The sentence with which the run without it failed.
    """

    name: str
    drift: float
    volume: float
    area: float
    share: float
    estimated_share: float
    saving: float
    estimated_saving: float
    run_saving: float
    element_steps: float
    advice: str
    fault: str = ""


@dataclass(frozen=True)
class Ablation:
    """The study.

    Parameters
    ----------
    rows : sequence of Row
        One for each effect, in the registry's order.
    floor : float
        Influence of a nudge of one part in 1e9: what is below it is chaos.
    noise, run_noise : float
        Spread over repeats of the work and of the whole run's CPU time, relative.
    rank : float
        Spearman's rank correlation of estimated and measured influence over all effects that may
        change results; NaN for fewer than three.
    lean : sequence of str
        Effects of the lean run; empty where the scene names nothing that it does not need.
    lean_saving, lean_profile : float
        Share of the work that the lean run saves, and that the cost model says.
    lean_share : float
        Influence of all that the lean run leaves out.
    cpu_seconds, work_seconds : float
        CPU time of the base run, whole and in element model and column.
    """

    rows: Sequence[Row]
    floor: float
    noise: float
    run_noise: float
    rank: float
    lean: Sequence[str]
    lean_saving: float
    lean_profile: float
    lean_share: float
    cpu_seconds: float
    work_seconds: float

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return asdict(self)


def share_of(record: Record) -> float:
    """Influence: the largest of the changes relative to what happens in the base run.

    Parameters
    ----------
    record : Record
        Of a run of the study.

    Returns
    -------
    float
        1.
    """
    results = record["results"]
    if not results:
        return float("inf")
    found, scale = results["differences"], results["scales"]
    return max(abs(found[name]) / scale[name] for name in ("drift", "volume", "area"))


def ablation_table(
    scene: Scene, records: Iterable[Record], estimates: Iterable[Estimate]
) -> Ablation:
    """Lay measured beside estimated.

    Parameters
    ----------
    scene : Scene
        The scene of the study.
    records : iterable of mapping
        Of all runs of the study.
    estimates : iterable of Estimate
        Of the scene.
    """
    by_name = {record["variant"]: record for record in records}
    base = by_name[BASE]
    repeats = [r for r in by_name.values() if r["group"] == "repeat"]
    times = [work(r) for r in (base, *repeats)]
    whole = [r["cpu_seconds"] for r in (base, *repeats)]
    usual = median(times), median(whole)
    c, fit = conditions(scene), coefficients()
    guesses = {row.name: row for row in estimates}
    rows = [
        _row(
            record,
            base,
            usual,
            guesses[record["group"]],
            cost_share(c, scene, record["group"], base["effects"], fit, WORK),
        )
        for record in by_name.values()
        if record["group"] in guesses
    ]
    ranked = [row for row in rows if row.name not in OUTPUT]
    lean = by_name.get("lean")
    return Ablation(
        rows,
        floor=max((share_of(r) for r in repeats), default=0.0),
        noise=(max(times) - min(times)) / usual[0],
        run_noise=(max(whole) - min(whole)) / usual[1],
        rank=_rank([r.estimated_share for r in ranked], [r.share for r in ranked]),
        lean=lean["effects"] if lean else [],
        lean_saving=1.0 - work(lean) / usual[0] if lean else 0.0,
        lean_profile=saved_share(c, scene, base["effects"], lean["effects"], fit, WORK)
        if lean
        else 0.0,
        lean_share=share_of(lean) if lean else 0.0,
        cpu_seconds=usual[1],
        work_seconds=usual[0],
    )


def _row(
    record: Record, base: Record, usual: tuple[float, float], guess: Estimate, cost: float
) -> Row:
    found = record["results"]["differences"] if record["results"] else {}
    nothing = float("nan")
    return Row(
        name=guess.name,
        drift=found.get("drift", nothing),
        volume=found.get("volume", nothing),
        area=found.get("area", nothing),
        share=share_of(record),
        estimated_share=guess.share,
        saving=1.0 - work(record) / usual[0] if record["results"] else float("nan"),
        estimated_saving=cost,
        run_saving=1.0 - record["cpu_seconds"] / usual[1],
        element_steps=record["element_steps"] / base["element_steps"],
        advice=guess.advice,
        fault=record["fault"],
    )


def _rank(one: Sequence[float], other: Sequence[float]) -> float:
    return float(spearmanr(one, other).statistic) if len(one) > 2 else float("nan")
