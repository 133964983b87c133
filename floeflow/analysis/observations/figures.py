# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of comparisons."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

import numpy as np
from matplotlib.figure import Figure

from floeflow.analysis.observations.drift_errors import METHODS, Drifts, LeadErrors
from floeflow.analysis.observations.fields import EdgeErrors, ThicknessPairs
from floeflow.analysis.observations.run_files import FinishedRun
from floeflow.analysis.observations.side_by_side import labels
from floeflow.report.figures.series import (
    AREA_UNITS,
    VOLUME_UNITS,
    WALL_STYLES,
    pick_unit,
    time_axis,
)
from floeflow.report.figures.style import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    VERMILION,
    look,
    new_figure,
    style_axes,
)

SIZE = (6.0, 3.3)
BUOYS_CAPTION = (
    "Root mean square distance of virtual buoys to the buoys against lead time: of the run, of the "
    "displacement of the window before (persistence) and of free drift under the run's wind and "
    "current."
)
DISPLACEMENTS_CAPTION = "Displacements in single windows, run against buoy, both components."
EDGE_CAPTION = (
    "Integrated ice-edge error (Goessling et al. 2016): area where run and observation differ in "
    "whether there is at least 15 % of ice, with its parts, beside the first observation kept as "
    "it is."
)
THICKNESS_CAPTION = "Ice thickness of the run's cells against what was observed in them."
RUNS_CAPTION = "Ice area, ice volume and mean net drift of the runs."


def buoys_figure(errors: LeadErrors, window: float) -> Figure:
    """Errors against lead time.

    Parameters
    ----------
    errors : LeadErrors
        Root mean square by lead time (m).
    window : float
        Length of a window (s).

    Returns
    -------
    Figure
        Axes in km, and hours or days.
    """
    unit, word = time_axis(float(errors.lead[-1]) * window)
    lead = errors.lead * window / unit
    with look():
        figure = new_figure(*SIZE)
        axes = figure.add_subplot()
        styles = ((BLUE, "o-"), (VERMILION, "s--"), (GREEN, "^:"))
        for method, values, (colour, mark) in zip(METHODS, errors.rms, styles, strict=True):
            name = method.replace("_", " ")
            axes.plot(lead, values / 1e3, mark, color=colour, label=name, markersize=4)
        style_axes(axes, f"Lead time ({word})", "Distance to the buoy (km)")
        axes.set_ylim(0)
        axes.legend(fontsize=8.5)
    return figure


def displacements_figure(drifts: Drifts) -> Figure:
    """Displacements of run and buoy.

    Parameters
    ----------
    drifts : Drifts
        Of run and buoys (m).
    """
    with look():
        figure = new_figure(6.0, 5.4)
        axes = figure.add_subplot()
        for part, axis, colour, mark in (("real", "x", BLUE, "."), ("imag", "y", VERMILION, "x")):
            seen, ours = (getattr(each, part) / 1e3 for each in (drifts.observed, drifts.run))
            label = f"along {axis}"
            axes.plot(seen, ours, mark, color=colour, markersize=3, alpha=0.6, label=label)
        both = np.concatenate([drifts.observed, drifts.run])
        most = 1.05 * float(np.abs(both).max(initial=0.0)) / 1e3 or 1.0
        axes.plot([-most, most], [-most, most], "-", color=FAINT, linewidth=0.8)
        style_axes(axes, "Displacement of the buoy (km)", "Displacement of the run (km)")
        axes.set_aspect("equal")
        axes.legend(fontsize=8.5)
    return figure


def edge_figure(errors: EdgeErrors, start: datetime) -> Figure:
    """Integrated ice-edge error with time.

    Parameters
    ----------
    errors : EdgeErrors
        Areas (m2) with time.
    start : datetime
        Of the scene.

    Returns
    -------
    Figure
        One curve each.
    """
    unit, word = time_axis(float(np.abs(errors.seconds).max()))
    at = errors.seconds / unit
    scale, name = pick_unit(AREA_UNITS, errors.integrated, errors.persistence)
    mark = "o" if at.size < 40 else ""
    with look():
        figure = new_figure(*SIZE)
        axes = figure.add_subplot()
        for values, label, colour, dash in (
            (errors.integrated, "run", INK, "-"),
            (errors.over, "run: too much", BLUE, "--"),
            (errors.under, "run: too little", VERMILION, "-."),
            (errors.persistence, "first observation kept", FAINT, ":"),
        ):
            axes.plot(at, values / scale, dash + mark, color=colour, label=label, markersize=4)
        style_axes(axes, f"Time since {start:%Y-%m-%d %H:%M} ({word})", f"Ice-edge error ({name})")
        axes.set_ylim(0)
        axes.legend(fontsize=8.5)
    return figure


def thickness_figure(pairs: ThicknessPairs) -> Figure:
    """Run against observation.

    Parameters
    ----------
    pairs : ThicknessPairs
        Thickness of run and observation (m) at the same places.
    """
    most = 1.05 * float(max(pairs.observed.max(), pairs.run.max()))
    with look():
        figure = new_figure(5.0, 4.6)
        axes = figure.add_subplot()
        axes.plot(pairs.observed, pairs.run, ".", color=BLUE, alpha=0.6, markersize=4)
        axes.plot([0.0, most], [0.0, most], "-", color=FAINT, linewidth=0.8)
        style_axes(axes, "Observed thickness (m)", "Thickness of the run (m)")
        axes.set_xlim(0.0, most)
        axes.set_ylim(0.0, most)
        axes.set_aspect("equal")
    return figure


def runs_figure(runs: Sequence[FinishedRun]) -> Figure:
    """Series of the runs, one over the other.

    Parameters
    ----------
    runs : sequence of FinishedRun
        Runs that have ended.
    """
    data = [run.diagnostics for run in runs]
    unit, word = time_axis(max(float(each["boundary_time"].values[-1]) for each in data))
    shown = (
        ("ice_area", "Ice area", AREA_UNITS),
        ("ice_volume", "Ice volume", VOLUME_UNITS),
        ("mean_displacement", "Mean net drift", ((1e3, "km"),)),
    )
    with look():
        figure = new_figure(6.0, 6.0)
        panels = figure.subplots(3, 1, sharex=True)
        for axes, (name, text, units) in zip(panels, shown, strict=True):
            scale, said = pick_unit(units, *(each[name].values for each in data))
            for each, label, (colour, dash) in zip(data, labels(runs), WALL_STYLES, strict=False):
                at = each["boundary_time"].values / unit
                axes.plot(at, each[name].values / scale, dash, color=colour, label=label)
            last = axes is panels[-1]
            style_axes(
                axes, f"Time since each run's start ({word})" if last else "", f"{text} ({said})"
            )
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure
