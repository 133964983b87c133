# SPDX-License-Identifier: GPL-2.0-or-later
"""The command ``floeflow compare``: a run beside observations and beside other runs.

Writes ``results/<scene>/comparison``: a page, a data file, and a digest that the scene's report
shows from then on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.analysis.observations import figures
from floeflow.analysis.observations.drift_errors import (
    METHODS,
    Drifts,
    LeadErrors,
    at_boundaries,
    lead_errors,
    window_drifts,
)
from floeflow.analysis.observations.fields import (
    EdgeErrors,
    ThicknessPairs,
    edge_errors,
    observed_shares,
    thickness_pairs,
)
from floeflow.analysis.observations.free_ice import FreeIce
from floeflow.analysis.observations.point_files import Points, read_points
from floeflow.analysis.observations.run_files import FinishedRun, open_run
from floeflow.analysis.observations.side_by_side import run_table
from floeflow.core.errors import FloeError
from floeflow.core.grids import from_lonlat, scene_crs
from floeflow.diagnostics.collect import cell_area
from floeflow.diagnostics.study_summaries import DIGEST
from floeflow.report.study_page import Drawing, Study, Table, draw, write_study
from floeflow.scene.hashes import stage_hash
from floeflow.state import write_dataset

Array = NDArray[np.float64]
Rows = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]

FOLDER = "comparison"
# Stages whose keys make a run another one.
STAGES = ("mask", "packing", "bonds", "dynamics", "column", "estimate")
DAY = 86400.0
LONGEST = 10 * DAY


@dataclass(frozen=True)
class Observed:
    """Files of the user.

    Parameters
    ----------
    buoys, thickness : sequence of Path
        Tables; see `floeflow.analysis.observations.point_files`.
    concentration : Path or None
        A gridded file with times.
    variable, crs : str
        Of the concentration, where the file does not tell.
    """

    buoys: Sequence[Path] = ()
    thickness: Sequence[Path] = ()
    concentration: Path | None = None
    variable: str = ""
    crs: str = ""


@dataclass
class Findings:
    """What goes to page and data file."""

    cards: list[str] = field(default_factory=list)
    drawings: list[Drawing] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    rows: Rows = field(default_factory=dict)


def compare(folder: Path, observed: Observed, others: Sequence[Path] = ()) -> str:
    """Compare a run with observations and other runs, and say where the page lies.

    Parameters
    ----------
    folder : Path
        ``results/<scene>`` of a run that has ended.
    observed : Observed
        The user's files.
    others : sequence of Path
        Folders of other runs.

    Raises
    ------
    FloeError
        In one sentence, for a run or a file that cannot be used, or where nothing is to compare.
    """
    run = open_run(folder)
    found, into = Findings(), folder / FOLDER
    if not (observed.buoys or observed.thickness or observed.concentration or others):
        raise FloeError(
            "compare: name at least one of --buoys, --concentration, --thickness and --with"
        )
    if observed.buoys:
        add_buoys(run, observed.buoys, into, found)
    if observed.concentration is not None:
        add_concentration(run, observed, into, found)
    if observed.thickness:
        add_thickness(run, observed.thickness, into, found)
    if others:
        runs = [run, *(open_run(other) for other in others)]
        found.tables.append(run_table(runs))
        found.drawings.append(draw(into, "runs", figures.RUNS_CAPTION, figures.runs_figure(runs)))
        found.cards.append(f"{len(runs)} runs stand side by side.")
    study = Study(
        title=f"Comparison: {run.scene.report.title or run.scene.name}",
        lead="The run beside observations and other runs that were given to floeflow compare.",
        cards=found.cards,
        drawings=found.drawings,
        tables=found.tables,
    )
    start = f"seconds since {run.scene.time.start:%Y-%m-%d %H:%M:%S}"
    for name, (_, _, attrs) in found.rows.items():
        if name.endswith("_time"):
            attrs |= {"standard_name": "time", "units": start, "calendar": "standard"}
    if found.rows:
        write_dataset(xr.Dataset(found.rows), into / "comparison.nc")
    keys = "-".join(stage_hash(run.scene, stage) for stage in STAGES)
    write_study(study, into / "comparison.html", into / DIGEST, keys)
    return "\n".join([*found.cards, f"Comparison: {into / 'comparison.html'}"])


def buoy_places(run: FinishedRun, points: Points) -> dict[str, NDArray[np.complex128]]:
    """Places of each buoy at the run's boundaries (m, complex), by its name.

    Parameters
    ----------
    run : FinishedRun
        That is compared.
    points : Points
        Fixes of the buoys.

    Returns
    -------
    dict of ndarray
        (boundaries,) each; NaN where a buoy is not known.
    """
    scene = run.scene
    times = scene.time.window * np.arange(scene.time.windows + 1, dtype=np.float64)
    x, y = from_lonlat(scene_crs(scene.domain), points.lon, points.lat)
    found = {}
    for name in np.unique(points.id):
        own = points.id == name
        places = at_boundaries(points.seconds[own], x[own], y[own], times)
        if np.isfinite(places).any():
            found[str(name)] = places
    return found


def add_buoys(run: FinishedRun, paths: Sequence[Path], into: Path, found: Findings) -> None:
    """Errors of drift at buoys.

    Parameters
    ----------
    run : FinishedRun
        That is compared.
    paths : sequence of Path
        Files of fixes.
    into : Path
        Folder for figures and tables.
    found : Findings
        What the page will say; added to.

    Raises
    ------
    FloeError
        For a file that cannot be read, or has no fixes within the run.
    """
    places: dict[str, NDArray[np.complex128]] = {}
    for path in paths:
        new = buoy_places(run, read_points(path, run.scene.time.start))
        if not new:
            raise FloeError(f"{path}: no buoy has fixes within the run, 12 hours apart at most")
        places |= {
            f"{name} ({path.name})" if name in places else name: v for name, v in new.items()
        }
    tracks = list(places.values())
    seen = np.flatnonzero(np.isfinite(np.stack(tracks)).any(axis=0))
    carriers = run.carriers(int(seen[0]), int(seen[-1]))
    window = run.scene.time.window
    free = FreeIce(run).displacement if "wind" in run.scene.effects else None
    errors = lead_errors(tracks, carriers, free, max(1, round(LONGEST / window)))
    drifts = window_drifts(tracks, carriers)
    found.cards += _drift_cards(errors, drifts, len(places), window)
    growth, pairs = figures.buoys_figure(errors, window), figures.displacements_figure(drifts)
    found.drawings += [
        draw(into, "buoys", figures.BUOYS_CAPTION, growth),
        draw(into, "displacements", figures.DISPLACEMENTS_CAPTION, pairs),
    ]
    found.tables.append(_drift_table(errors, window))
    said = {"units": "m", "long_name": "root mean square distance to the buoys"}
    found.rows |= {
        "lead": (("lead",), errors.lead * window, {"units": "s", "long_name": "lead time"}),
        "forecast": (("forecast",), np.array(METHODS), {}),
        "drift_error": (("forecast", "lead"), errors.rms, said),
        "drift_starts": (("lead",), errors.count, {"units": "1", "long_name": "virtual buoys"}),
    }
    for name, values in (("observed", drifts.observed), ("run", drifts.run)):
        for axis, part in (("x", values.real), ("y", values.imag)):
            said = {"units": "m", "long_name": f"displacement in a window along {axis}, {name}"}
            found.rows[f"displacement_{name}_{axis}"] = (("displacement",), part, said)


def _drift_cards(errors: LeadErrors, drifts: Drifts, buoys: int, window: float) -> list[str]:
    first = errors.rms[:, 0] / 1e3
    hours = errors.lead[0] * window / 3600.0
    said = [
        f"Drift of {buoys} buoys: after {hours:g} hours the run is {first[0]:.3g} km off (root "
        f"mean square of {errors.count[0]:.0f} starts), persistence {first[1]:.3g} km"
        + (f", free drift {first[2]:.3g} km." if np.isfinite(first[2]) else ".")
    ]
    r = drifts.correlation
    if np.isfinite(r):
        angle = np.degrees(np.angle(r))
        said.append(
            f"Displacements in a window: correlation {abs(r):.2f}, the run {angle:+.0f}° to the "
            f"left, {drifts.ratio:.2f} times as far."
        )
    return said


def _drift_table(errors: LeadErrors, window: float) -> Table:
    rows = [
        (
            f"{errors.lead[k] * window / DAY:g}",
            int(errors.count[k]),
            *(float(value) / 1e3 for value in errors.rms[:, k]),
            float(errors.skill("persistence")[k]),
            float(errors.skill("free_drift")[k]),
            float(errors.along[0, k]) / 1e3,
            float(errors.along[1, k]) / 1e3,
        )
        for k in range(errors.lead.size)
    ]
    head = (
        *("Lead (days)", "Starts", "Run (km)", "Persistence (km)", "Free drift (km)"),
        *("Skill against persistence", "Skill against free drift"),
        *("Mean along (km)", "Mean to the left (km)"),
    )
    note = (
        "Root mean square distances to the buoys. Skill is 1 - MSE / MSE of the other: 1 is "
        "perfect, below 0 the other is nearer. Virtual buoys start at every boundary, so starts "
        "overlap and are not independent. Along and to the left: of the way the buoy went."
    )
    return Table("Drift error against lead time", head, rows, note)


def add_concentration(run: FinishedRun, observed: Observed, into: Path, found: Findings) -> None:
    """Errors of the ice edge.

    Parameters
    ----------
    run : FinishedRun
        That is compared.
    observed : Observed
        Concentration on a grid.
    into : Path
        Folder for figures and tables.
    found : Findings
        What the page will say; added to.

    Raises
    ------
    FloeError
        For a file that cannot be read, or shares no time with the run.
    """
    assert observed.concentration is not None
    seen = observed_shares(run.scene, observed.concentration, observed.variable, observed.crs)
    area = cell_area(run.grid, run.folder / "grid.nc")
    errors = edge_errors(run.scene, run.grid, area, seen)
    last = errors.integrated[-1] / 1e9
    found.cards.append(
        f"Ice edge at {errors.seconds.size} times: at the last one run and observation differ on "
        f"{last:.3g} thousand km² ({errors.over[-1] / 1e9:.3g} too much, "
        f"{errors.under[-1] / 1e9:.3g} too little), {errors.displacement[-1] / 1e3:.3g} km along "
        f"the edge; the first observation kept as it is on {errors.persistence[-1] / 1e9:.3g}."
    )
    found.drawings.append(
        draw(into, "edge", figures.EDGE_CAPTION, figures.edge_figure(errors, run.scene.time.start))
    )
    found.rows |= _edge_rows(errors)


def _edge_rows(errors: EdgeErrors) -> Rows:
    said = {
        "over": ("m2", "area where only the run has at least 15 % of ice"),
        "under": ("m2", "area where only the observation has at least 15 % of ice"),
        "persistence": ("m2", "integrated ice-edge error of the first observation kept"),
        "displacement": ("m", "integrated ice-edge error over the length of the observed edge"),
        "bias": ("1", "mean concentration of the run minus observed, where either has ice"),
        "rms": ("1", "root mean square of the difference of concentration"),
    }
    rows: Rows = {"edge_time": (("edge",), errors.seconds, {})}
    for name, (unit, text) in said.items():
        attrs = {"units": unit, "long_name": text}
        rows[f"edge_{name}"] = (("edge",), getattr(errors, name), attrs)
    return rows


def add_thickness(run: FinishedRun, paths: Sequence[Path], into: Path, found: Findings) -> None:
    """Thickness at places.

    Parameters
    ----------
    run : FinishedRun
        That is compared.
    paths : sequence of Path
        Files of thickness (m) at places and times.
    into : Path
        Folder for figures and tables.
    found : Findings
        What the page will say; added to.

    Raises
    ------
    FloeError
        For a file that cannot be read, or shares no place and time with the run.
    """
    parts = [
        thickness_pairs(run.scene, run.grid, read_points(path, run.scene.time.start, True))
        for path in paths
    ]
    pairs = ThicknessPairs(
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("seconds", "observed", "run")
        )
    )
    correlation = pairs.correlation
    tail = f", correlation {correlation:.2f}" if np.isfinite(correlation) else ""
    found.cards.append(
        f"Ice thickness at {pairs.observed.size} places and times: the run is {pairs.bias:+.2f} m "
        f"off on average, root mean square {pairs.rms:.2f} m{tail}."
    )
    found.drawings.append(
        draw(into, "thickness", figures.THICKNESS_CAPTION, figures.thickness_figure(pairs))
    )
    found.rows["thickness_time"] = (("thickness",), pairs.seconds, {})
    for name, values in (("observed", pairs.observed), ("run", pairs.run)):
        said = {"units": "m", "long_name": f"ice thickness, {name}"}
        found.rows[f"thickness_{name}"] = (("thickness",), values, said)
