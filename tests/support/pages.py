# SPDX-License-Identifier: GPL-2.0-or-later
"""Reports of runs that never ran, made by the scripts of the rules."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

from support.scripts import load_script
from support.synthetic import Run

ESTIMATES = {
    "chosen_by": "auto",
    "estimates": [
        {
            "name": "wind",
            "named": True,
            "number": 3.0,
            "meaning": "wind over current",
            "share": 0.5,
            "cost": 0.1,
            "advice": "needed",
            "reason": "It moves positions.",
        },
        {
            "name": "grid_output",
            "named": False,
            "number": None,
            "meaning": "none",
            "share": 0.0,
            "cost": 0.1,
            "advice": "output",
            "reason": "It changes no result.",
        },
    ],
}


def report_of(run: Run, studies: Sequence[Path] = ()) -> str:
    """The page of a run; it lies as ``report.html`` in the run's folder as well."""
    folder, last = run.folder, run.windows[-1]
    scene = str(run.scene_file)
    made = {
        "diagnostics": str(folder / "diagnostics.nc"),
        "headline": str(folder / "diagnostics.json"),
        "analyses": str(folder / "analyses.nc"),
    }
    files = run.files
    load_script("postprocess/diagnostics").main(
        SimpleNamespace(
            input=SimpleNamespace(
                scene=scene,
                first=str(files.first),
                elements=list(map(str, files.elements)),
                series=list(map(str, files.series)),
                cost=list(map(str, files.cost)),
                grid=str(files.grid),
                last=str(run.state(last)),
            ),
            output=SimpleNamespace(
                dataset=made["diagnostics"],
                headline=made["headline"],
                analyses=made["analyses"],
            ),
        )
    )
    given = SimpleNamespace(
        input=SimpleNamespace(
            scene=scene,
            first_state=str(run.state(0)),
            last_state=str(run.state(last)),
            tendencies="",
            grid=str(run.grid),
            mask=str(folder / "preprocess" / "mask.nc"),
            packing=str(folder / "preprocess" / "packing.nc"),
            benchmarks=sorted(str(path) for path in (folder / "benchmarks").rglob("*.tsv")),
            estimates=str(folder / "effects.json"),
            **made,
        ),
        output=SimpleNamespace(report=str(folder / "report.html"), figures=str(folder / "figures")),
        params=SimpleNamespace(studies={str(path): "" for path in studies}),
    )
    Path(given.input.estimates).write_text(json.dumps(ESTIMATES))
    load_script("postprocess/report").main(given)
    return (folder / "report.html").read_text(encoding="utf-8")
