# SPDX-License-Identifier: GPL-2.0-or-later
"""Two or more runs side by side: their headline numbers in one table."""

from __future__ import annotations

from collections.abc import Sequence

from floeflow.analysis.observations.run_files import FinishedRun
from floeflow.report.report_text import DASH, number
from floeflow.report.study_page import Table

NUMBERS = (
    ("elements", "Elements at the end", 1.0, ""),
    ("ice_area_end", "Ice area at the end", 1e9, "10³ km²"),
    ("ice_volume_end", "Ice volume at the end", 1e9, "km³"),
    ("snow_volume_end", "Snow volume at the end", 1e9, "km³"),
    ("mean_drift_km", "Mean net drift", 1.0, "km"),
    ("largest_drift_km", "Farthest element", 1.0, "km"),
    ("mean_speed", "Mean speed", 1e-2, "cm/s"),
    ("largest_speed", "Largest speed", 1.0, "m/s"),
    ("bonds_start", "Bonds at the start", 1.0, ""),
    ("bonds_broken", "Bonds broken", 1.0, ""),
    ("bonds_refrozen", "Bonds that froze", 1.0, ""),
    ("bonds_end", "Bonds at the end", 1.0, ""),
    ("dynamics_seconds", "Seconds in the element model", 1.0, "s"),
)


def labels(runs: Sequence[FinishedRun]) -> list[str]:
    """A name for each run: its folder's, with the one above where they are alike.

    Parameters
    ----------
    runs : sequence of FinishedRun
        Runs that have ended.
    """
    names = [run.folder.resolve().name for run in runs]
    if len(set(names)) == len(names):
        return names
    found = []
    for number_of, run in enumerate(runs, start=1):
        parts = run.folder.resolve().parts
        above = parts[-3] if len(parts) > 2 else str(number_of)
        found.append(f"{above}/{parts[-1]}")
    return found if len(set(found)) == len(found) else [str(run.folder) for run in runs]


def run_table(runs: Sequence[FinishedRun]) -> Table:
    """Headline numbers of all runs; a difference is told of two.

    Parameters
    ----------
    runs : sequence of FinishedRun
        Runs that have ended.
    """
    rows = []
    for key, label, size, unit in NUMBERS:
        values = [run.numbers.get(key) for run in runs]
        if all(value is None for value in values):
            continue
        told = [DASH if value is None else number(value / size, 4) for value in values]
        if len(runs) == 2:
            one, two = values
            apart = None if one is None or two is None or not one else 100.0 * (two - one) / one
            told.append(DASH if apart is None else f"{number(apart, 3)} %")
        rows.append((f"{label} ({unit})" if unit else label, *told))
    head = ["Quantity", *labels(runs), *(["Second against first"] if len(runs) == 2 else [])]
    note = "" if _same_time(runs) else "The runs are not of the same time: look at the dates first."
    return Table("Runs side by side", head, rows, note)


def _same_time(runs: Sequence[FinishedRun]) -> bool:
    times = {(run.scene.time.start, run.scene.time.windows * run.scene.time.window) for run in runs}
    return len(times) == 1
