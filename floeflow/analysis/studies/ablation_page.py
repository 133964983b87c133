# SPDX-License-Identifier: GPL-2.0-or-later
"""Page of the ablation study: what each effect changes and costs, measured beside estimated."""

from floeflow.analysis.estimate.choose import OUTPUT
from floeflow.analysis.studies.ablation_table import Ablation
from floeflow.report.study_page import Table, measured
from floeflow.scene import Scene

LEAD = (
    "Each effect of the scene was left out once, and the results compared with the run that has "
    "them all. Influence is the largest change of positions, ice volume and ice area, relative to "
    "what happens in the run; the estimate was made before any run."
)
HEAD = (
    *("effect", "positions (km)", "volume (m)", "area (%)"),
    *("influence (%)", "estimated (%)", "work saved (%)", "estimated (%)", "run saved (%)"),
    *("element-steps", "advice"),
)


def effect_table(study: Ablation) -> Table:
    """The effects, the most influential first.

    Parameters
    ----------
    study : Ablation
        What was measured.
    """
    rows = sorted(study.rows, key=lambda row: -row.share)
    cells = [
        (
            row.name,
            row.drift / 1e3,
            row.volume,
            100 * row.area,
            "failed" if row.fault else 100 * row.share,
            100 * row.estimated_share,
            measured(100 * row.saving, 100 * study.noise),
            100 * row.estimated_saving,
            measured(100 * row.run_saving, 100 * study.run_noise),
            row.element_steps,
            row.fault or row.advice,
        )
        for row in rows
    ]
    note = (
        "Work: CPU time of element model and column; run: all CPU time, programs' start included. "
        "After ±: by how much runs of the same scene differ. "
        "Element-steps: without the effect, relative to the base run."
    )
    return Table("Effects, measured and estimated", HEAD, cells, note)


def sentences(study: Ablation, scene: Scene) -> list[str]:
    """What the study says, in words.

    Parameters
    ----------
    study : Ablation
        What was measured.
    scene : Scene
        Its keys.

    Returns
    -------
    list of str
        With units.
    """
    said = [
        f"Rank correlation of estimated and measured influence: {study.rank:.2f} "
        f"({sum(row.name not in OUTPUT for row in study.rows)} effects).",
        f"Chaos alone (a nudge of 1e-9) has an influence of {100 * study.floor:.2g} %; "
        f"the work of the same run differs by {100 * study.noise:.2g} %.",
        f"The base run took {study.cpu_seconds:.3g} s of CPU time, "
        f"{study.work_seconds:.3g} s of it work (element model and column).",
    ]
    if study.lean:
        gone = [name for name in scene.effects if name not in study.lean]
        saved = measured(100 * study.lean_saving, 100 * study.noise)
        said.append(
            f"Without what the estimate calls not needed ({', '.join(gone)}) the run saves "
            f"{saved} % of its work (the cost model says "
            f"{100 * study.lean_profile:.3g} %) and moves the results by "
            f"{100 * study.lean_share:.3g} %."
        )
    return said
