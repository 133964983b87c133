# SPDX-License-Identifier: GPL-2.0-or-later
"""Page of the accuracy study: error against cost, orders of convergence, recommendations."""

import math
from collections.abc import Sequence

from floeflow.analysis.studies.accuracy_plan import KEPT as SAME
from floeflow.analysis.studies.accuracy_plan import TOGETHER
from floeflow.analysis.studies.accuracy_table import Accuracy
from floeflow.analysis.studies.measures import KEPT, NORMS
from floeflow.analysis.studies.numerical_settings import numerical_settings
from floeflow.analysis.studies.recommend import Combination, most_accurate, quieted, recommend
from floeflow.report.study_page import Table
from floeflow.scene import Scene

LEAD = (
    "Each numerical setting was varied alone, and all together; the error of a setting's runs is "
    "against the limit of its series (Richardson, where it converges, else its finest run), that "
    "of the runs that vary all against the finest of them. Errors are relative to what happens in "
    "the run."
)
TARGETS = (0.01, 0.05, 0.2)


def recommendations(study: Accuracy, scene: Scene) -> list[tuple[float, bool, Combination | None]]:
    """Cheapest combination for each target error: of all settings, and with the scene's elements.

    Where a pack breaks, elements of another size break elsewhere: no size then keeps the error.

    Parameters
    ----------
    study : Accuracy
        What was measured.
    scene : Scene
        Its keys.

    Returns
    -------
    list of tuple of float, bool and Combination or None
        Target (1), whether the scene's elements are kept, and the setting or None.
    """
    points = quieted(study.points, study.noise)
    every = [setting.name for setting in numerical_settings(scene)]
    kept = [name for name in every if name not in SAME]
    return [
        (target, names is kept, recommend(points, names, target))
        for names in (every, kept)
        for target in TARGETS
    ]


def recommendation_table(study: Accuracy, scene: Scene) -> Table:
    """Settings for 1, 5 and 20 % error.

    Parameters
    ----------
    study : Accuracy
        What was measured.
    scene : Scene
        Its keys.

    Returns
    -------
    Table
        One row for each target.
    """
    varied = numerical_settings(scene)
    points = quieted(study.points, study.noise)
    rows = []
    for target, same, found in recommendations(study, scene):
        names = [setting.name for setting in varied if not (same and setting.name in SAME)]
        elements = "the scene's" if same else "any"
        if found is None:
            best = most_accurate(points, names, math.inf)
            least = f"least {100 * best.error:.2g}" if best else "none"
            rows.append([100 * target, elements, least, "", *[""] * len(varied)])
        else:
            levels = [setting.told(found.levels.get(setting.name, 1.0)) for setting in varied]
            rows.append([100 * target, elements, 100 * found.error, found.work, *levels])
    note = (
        "A level is the factor by which a setting is coarser (above 1) or finer than in the scene. "
        f"The error is the largest of {', '.join(KEPT)}; with the scene's elements, that of all "
        "other settings."
    )
    head = (
        "wanted (%)",
        "elements",
        "predicted (%)",
        "work",
        *(setting.name for setting in varied),
    )
    return Table("Cheapest setting for an error", head, rows, note)


def order_table(study: Accuracy) -> Table:
    """Orders of convergence, observed beside expected.

    Parameters
    ----------
    study : Accuracy
        What was measured.
    """
    by_setting: dict[str, dict[str, object]] = {}
    for row in study.orders:
        cells = by_setting.setdefault(row.setting, {"expected": row.expected or "–"})
        shown: object = row.observed
        if math.isfinite(row.observed) and not row.converges:
            shown = f"({row.observed:.2f})"
        cells[row.norm] = shown
    norms = [name for name in NORMS if any(name in cells for cells in by_setting.values())]
    rows = [
        [setting, cells["expected"], *(cells.get(name, "–") for name in norms)]
        for setting, cells in by_setting.items()
    ]
    note = "In brackets: no convergence (order below 0.3 or above 5)."
    return Table("Order of convergence", ("setting", "expected", *norms), rows, note)


def run_table(study: Accuracy) -> Table:
    """All runs.

    Parameters
    ----------
    study : Accuracy
        What was measured.
    """
    head = ("run", "level", "work", "CPU", "element-steps", *NORMS)
    rows: list[Sequence[object]] = []
    for p in study.points:
        errors: list[object] = [
            100 * p.errors[n] if n in p.errors else "–" if p.stable else "unstable" for n in NORMS
        ]
        name = "base (all settings)" if p.setting == TOGETHER and p.run == "base" else p.run
        name = f"{p.setting} default" if p.level == 1.0 else name
        rows.append([name, p.level, p.work, p.cpu, p.element_steps, *errors])
    note = "Work, CPU and element-steps relative to the default run; errors in per cent."
    return Table("All runs", head, rows, note)
