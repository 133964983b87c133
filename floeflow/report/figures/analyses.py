# SPDX-License-Identifier: GPL-2.0-or-later
"""Analyses of ice and motion: wind factor, deformation over scales, thickness, edge, floe sizes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import datetime

import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, MaxNLocator
from numpy.typing import NDArray

from floeflow.diagnostics.deformation import curvature
from floeflow.report.figures.break_events import break_figures
from floeflow.report.figures.floe_sizes import floe_figures
from floeflow.report.figures.fracture import fracture_figures
from floeflow.report.figures.series import AREA_UNITS, pick_unit, time_axis
from floeflow.report.figures.style import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    SPEED,
    THICKNESS,
    VERMILION,
    look,
    new_figure,
    style_axes,
)

Array = NDArray[np.float64]
Made = tuple[str, str, Figure]
DAY = 86400.0
ONE, TWO = (6.0, 3.1), (6.0, 5.6)
# Bins with more than this thickness (m) are not drawn one by one.
THICKEST = 6.0
# Fewer times are no series.
LONG = 10
SEASONS = {"all": (INK, "o", "-"), "winter": (BLUE, "s", "--"), "summer": (VERMILION, "^", ":")}


def analysis_figures(data: xr.Dataset, start: datetime) -> Iterator[Made]:
    """Draw what ``analyses.nc`` holds.

    Parameters
    ----------
    data : xarray.Dataset
        As from `floeflow.diagnostics.analyses`.
    start : datetime
        Of the scene.

    Yields
    ------
    tuple of str, str and Figure
        Name, caption, figure.
    """
    # What is needed, and how much of it: a few points or samples are no figure.
    makers: tuple[tuple[str, int, Callable[[xr.Dataset, datetime], Made]], ...] = (
        ("thickness_area", 2, _thickness),
        ("extent", LONG, _edge),
        # Tall ones stand beside tall ones in the page's two columns.
        ("deformation_total", 5, _deformation),
        ("wind_drift_area", 1, _wind),
        ("scaling_exponent", 1, _scaling),
        ("rate_count", 1000, _rates),
        ("velocity_correlation_along", 6, _lags),
    )
    for needed, least, make in makers:
        if needed in data.variables and _amount(data[needed]) >= least:
            yield make(data, start)
    yield from break_figures(data, start)
    yield from fracture_figures(data)
    yield from floe_figures(data)


def _amount(values: xr.DataArray) -> float:
    """Samples of a distribution, else points along the first dimension."""
    if values.name == "rate_count":
        return float(values[0].sum())
    return float(np.isfinite(values.values.reshape(len(values), -1)).any(axis=1).sum())


def _time(data: xr.Dataset, name: str, start: datetime) -> tuple[Array, str]:
    seconds = data[name].values
    unit, word = time_axis(float(seconds[-1]) if seconds.size else 0.0)
    return seconds / unit, f"Time since {start:%Y-%m-%d %H:%M} ({word})"


def _thickness(data: xr.Dataset, start: datetime) -> Made:
    at, axis = _time(data, "thickness_time", start)
    area, bounds = data["thickness_area"].values, data["thickness_bounds"].values
    width = bounds[0, 1] - bounds[0, 0]
    total = area.sum(axis=1, keepdims=True)
    density = np.divide(area, total * width, out=np.zeros_like(area), where=total > 0)
    shown = bounds[:, 1] <= THICKEST
    middle = 0.5 * (bounds[shown, 0] + bounds[shown, 1])
    with look():
        long = at.size >= LONG
        figure = new_figure(*(TWO if long else ONE))
        lines, *rest = figure.subplots(2 if long else 1, 1, squeeze=False).ravel().tolist()
        for row, label, colour, dash in ((0, "start", FAINT, "--"), (-1, "end", BLUE, "-")):
            values = density[row][shown]
            lines.plot(middle, values, dash, color=colour, label=label, drawstyle="steps-mid")
        style_axes(lines, "Ice thickness (m)", "Share of the ice area (1/m)")
        lines.set_ylim(0)
        lines.legend()
        for time in rest:
            mesh = time.pcolormesh(
                at,
                middle,
                np.where(density > 0, density, np.nan)[:, shown].T,
                cmap=THICKNESS.cmap,
                norm=LogNorm(0.003, max(1.0, float(density[:, shown].max(initial=0.0)))),
                shading="nearest",
                rasterized=True,
            )
            time.set_xlabel(axis)
            time.set_ylabel("Ice thickness (m)")
            figure.colorbar(mesh, ax=time, label="Share (1/m)", pad=0.01)
    thick = float(area[-1, ~shown].sum() / area[-1].sum()) if area[-1].sum() > 0 else 0.0
    caption = (
        "Distribution of ice thickness by area: at start and end"
        f"{', and at all window boundaries' if long else ''}. "
        "Each category of each element counts with its mean thickness, so that dips mark the "
        "categories' bounds; "
        f"{100.0 * thick:.1f} % of the area at the end is thicker than {THICKEST:g} m."
    )
    return "ice_thickness_distribution", caption, figure


def _edge(data: xr.Dataset, start: datetime) -> Made:
    at, axis = _time(data, "edge_time", start)
    extent, margin = data["extent"].values, data["marginal_area"].values
    scale, unit = pick_unit(AREA_UNITS, extent)
    with look():
        figure = new_figure(6.0, 4.6)
        areas, leads = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        areas.plot(at, extent / scale, "-", color=BLUE, label="extent (15 % and more)")
        areas.plot(at, margin / scale, "--", color=VERMILION, label="marginal zone (15 to 80 %)")
        style_axes(areas, "", f"Area ({unit})")
        areas.set_ylim(0, 1.25 * float(np.max(extent, initial=0.0)) / scale or 1.0)
        areas.legend(ncols=2, loc="upper center", fontsize=8.5)
        leads.plot(at, 100.0 * data["lead_fraction"].values, "-", color=GREEN)
        style_axes(leads, axis, "Open water in\nthe pack (%)")
        leads.set_ylim(0)
    caption = (
        "Ice extent and marginal ice zone on the scene's grid, and the open share of the sea of "
        "cells with at least 70 % ice. Areas are those of the cells' sea; leads narrower than an "
        "element are part of its open water."
    )
    return "ice_edge", caption, figure


def _wind(data: xr.Dataset, start: datetime) -> Made:
    counts = data["wind_drift_area"].values
    wind, drift = data["wind"].values, data["drift"].values
    factor, turning = data["wind_factor"].values, np.degrees(data["wind_turning"].values)
    periods = [str(name) for name in data["period"].values]
    monthly = len(periods) > 3
    kinds = ((0, "pack, 80 % ice and more", BLUE, "o-"), (1, "loose ice", VERMILION, "s--"))
    # Months in which hardly any ice was of a kind say nothing of it.
    weight = data["wind_weight"].values
    share = weight[1:] / np.maximum(weight[1:].sum(axis=1, keepdims=True), 1.0)
    known = share > 0.02
    with look():
        figure = new_figure(6.0, 6.2 if monthly else 3.3)
        panels = figure.subplots(
            3 if monthly else 1, 1, squeeze=False, height_ratios=(3, 2, 2) if monthly else None
        )
        cloud, *rest = panels.ravel().tolist()
        top = max(int(np.flatnonzero(counts.sum(axis=1))[-1]) + 2, 5) if counts.any() else 5
        share_of = counts / max(counts.sum(), 1.0)
        mesh = cloud.pcolormesh(
            wind,
            drift,
            np.where(share_of > 0, 100.0 * share_of, np.nan).T,
            cmap=SPEED.cmap,
            norm=LogNorm(1e-3, max(100.0 * float(share_of.max(initial=0.0)), 1e-2)),
            shading="nearest",
            rasterized=True,
        )
        figure.colorbar(mesh, ax=cloud, label="% of the ice", pad=0.01)
        line = np.array([0.0, wind[min(top, wind.size) - 1]])
        if np.isfinite(factor[0, 0]):
            slope = factor[0, 0] * np.cos(np.radians(turning[0, 0]))
            text = f"pack: {100 * factor[0, 0]:.2g} % of the wind"
            cloud.plot(line, slope * line, "-", color=BLUE, label=text)
        free = data["free_drift_along"].values
        if np.isfinite(free).all():
            cloud.plot(wind, free, "--", color=INK, label="free drift")
        cloud.set_xlim(0.0, line[1])
        seen = np.flatnonzero(counts.sum(axis=0) > 1e-5 * counts.sum())
        low, high = (drift[seen[0]], drift[seen[-1]]) if seen.size else (-0.1, 0.3)
        cloud.set_ylim(min(float(low), 0.0) - 0.02, max(float(high), 0.05) + 0.02)
        style_axes(cloud, "Wind speed at 10 m (m/s)", "Drift along\nthe wind (m/s)")
        cloud.legend(loc="upper left", fontsize=8.5)
        for axes, values, label in zip(
            rest,
            (100.0 * factor, turning),
            ("Drift over wind (%)", "Turning angle (°)"),
            strict=False,
        ):
            x = np.arange(len(periods) - 1)
            for kind, word, colour, mark in kinds:
                shown = np.where(known[:, kind], values[1:, kind], np.nan)
                axes.plot(x, shown, mark, color=colour, label=word, markersize=4)
            style_axes(axes, "", label)
            labels = [name[2:] if name.endswith("-01") else name[5:] for name in periods[1:]]
            axes.set_xticks(x, labels)
        if rest:
            rest[0].set_ylim(0)
            rest[0].legend(ncols=2, fontsize=8.5)
            rest[1].set_xlabel("Month")
    first = _sentence(data)
    caption = (
        f"Drift against the wind at 10 m, means over a window. {first}Free drift: the balance of "
        "wind, ocean drag and Coriolis force of the run's mean ice without current and "
        "neighbours. Angles are counted to the left of the wind. Observed: 1.5 to 2.5 % in free "
        "drift (Leppäranta 2011), less in pack ice."
    )
    return "motion_wind", caption, figure


def _sentence(data: xr.Dataset) -> str:
    factor, turning = data["wind_factor"].values[0], np.degrees(data["wind_turning"].values[0])
    explained = data["wind_explained"].values[0]
    said = [
        f"{name}: {100 * factor[k]:.2f} %, {turning[k]:+.0f}°, {100 * explained[k]:.0f} % of the "
        "variance"
        for k, name in enumerate(("pack (80 % ice and more)", "loose ice"))
        if np.isfinite(factor[k])
    ]
    return f"Complex regression of the run, {'; '.join(said)}. " if said else ""


def _deformation(data: xr.Dataset, start: datetime) -> Made:
    at, axis = _time(data, "interval_time", start)
    size = float(np.nanmean(data["deformation_scale"].values[:, 0])) / 1e3
    with look():
        figure = new_figure(*ONE)
        axes = figure.add_subplot()
        for name, word, colour, dash in (
            ("total", "total", INK, "-"),
            ("shear", "shear", BLUE, "--"),
            ("divergence", "divergence (absolute)", VERMILION, ":"),
        ):
            values = 100.0 * DAY * data[f"deformation_{name}"].values
            axes.plot(at, values, dash, color=colour, label=word, marker=".", markersize=4)
        style_axes(axes, axis, "Deformation (% per day)")
        axes.set_ylim(0)
        figure.legend(loc="outside upper right", ncols=3, fontsize=8.5)
    caption = (
        f"Mean deformation of triangles of neighbouring elements (about {size:.3g} km), from "
        f"displacements over {_interval(data, start)}."
    )
    return "motion_deformation", caption, figure


def _interval(data: xr.Dataset, start: datetime) -> str:
    times = data["interval_time"].values
    steps = np.diff(times) if len(times) > 1 else times
    days = float(steps.min()) / DAY
    return f"{days:.3g} days" if days >= 1.0 else f"{24.0 * days:.3g} hours"


def _scaling(data: xr.Dataset, start: datetime) -> Made:
    order, moments = data["order"].values, data["deformation_moment"].values
    count, scale = data["deformation_count"].values, data["deformation_scale"].values
    weight = np.where(np.isfinite(scale), count, 0.0)
    safe = np.maximum(weight.sum(axis=0), 1e-9)
    length = np.nansum(weight * np.nan_to_num(scale), axis=0) / safe / 1e3
    raised = np.nan_to_num(moments) ** order
    mean = (weight[..., None] * raised).sum(axis=0) / safe[:, None]
    exponent, error = data["scaling_exponent"].values, data["scaling_error"].values
    low, high = (float(data[f"scaling_{name}"].values[0]) / 1e3 for name in ("low", "high"))
    seasons = [str(name) for name in data["season"].values]
    with look():
        figure = new_figure(*TWO)
        sizes, curve = figure.subplots(2, 1)
        for q, colour, mark in ((1.0, INK, "o"), (2.0, BLUE, "s"), (3.0, VERMILION, "^")):
            k = int(np.flatnonzero(order == q)[0])
            good = (safe > 1.0) & (mean[:, k] > 0)
            values = mean[good, k] * DAY**q
            sizes.loglog(length[good], values, mark, color=colour, markersize=4, label=f"q = {q:g}")
            used = (length[good] >= 0.999 * low) & (length[good] <= 1.001 * high)
            if used.any() and np.isfinite(exponent[0, k]):
                x, y = np.log(length[good][used]), np.log(values[used])
                middle = np.exp(y.mean() - exponent[0, k] * (x - x.mean()))
                sizes.loglog(length[good][used], middle, "-", color=colour, linewidth=1.2)
        sizes.axvspan(low, high, color=FAINT, alpha=0.12, linewidth=0)
        sizes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        sizes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
        style_axes(sizes, "Scale (km)", "Moment (per day)$^q$")
        sizes.legend(ncols=3, fontsize=8.5)
        for row, name in enumerate(seasons):
            colour, mark, dash = SEASONS[name]
            curve.errorbar(
                order,
                exponent[row],
                error[row],
                color=colour,
                marker=mark,
                linestyle=dash,
                markersize=4,
                capsize=2,
                label="run" if name == "all" else name,
            )
        fine = np.linspace(0.0, 3.0, 61)
        # Marsan et al. 2004, equation 9 and figure 4: RGPS, winter of 1997.
        curve.plot(
            fine, 0.13 * fine**2 + 0.07 * fine, color=FAINT, label="RGPS (Marsan et al. 2004)"
        )
        style_axes(curve, "Order q of the moment", "Exponent β(q)")
        curve.set_xlim(0.0)
        curve.set_ylim(min(0.0, float(np.nanmin(exponent, initial=0.0))))
        curve.legend(fontsize=8.5)
    first = int(np.flatnonzero(order == 1.0)[0])
    told = ", ".join(
        f"{'run' if name == 'all' else name} {exponent[row, first]:.2f} ± {error[row, first]:.2f}"
        for row, name in enumerate(seasons)
        if np.isfinite(exponent[row, first])
    )
    a, b = curvature(order, exponent[0])
    bent = f", β(q) ≈ {a:.2f} q² + {b:.2f} q" if np.isfinite(a) else ""
    caption = (
        f"Moments of total deformation over {_interval(data, start)} against the size of the boxes "
        "over which gradients are averaged, and their exponents, ⟨ε^q⟩ ~ L^−β(q). "
        f"Fit from {low:.3g} to {high:.3g} km (shaded). β(1): {told}{bent}; RGPS 0.20 and "
        "0.13 q² + 0.07 q in winter, steeper in summer. Exponents are diagnostics, no bars to "
        f"reach. {data.attrs['deformation']}"
    )
    return "motion_scaling", caption, figure


def _rates(data: xr.Dataset, start: datetime) -> Made:
    counts, bounds = data["rate_count"].values, data["rate_bounds"].values * DAY
    middle, width = np.sqrt(bounds[:, 0] * bounds[:, 1]), bounds[:, 1] - bounds[:, 0]
    styles = (("opening", BLUE, "-"), ("closing", VERMILION, "--"), ("shear", INK, ":"))
    with look():
        figure = new_figure(*ONE)
        axes = figure.add_subplot()
        for piece, thick in ((0, 1.8), (1, 0.9)):
            for k, (word, colour, dash) in enumerate(styles):
                number = counts[piece, k]
                if number.sum() < 50:
                    continue
                density = np.where(number > 2, number / number.sum() / width, np.nan)
                label = f"{word}, {'triangles' if piece == 0 else 'boxes'}"
                axes.loglog(middle, density, dash, color=colour, linewidth=thick, label=label)
        style_axes(axes, "Rate (per day)", "Probability density (days)")
        axes.legend(fontsize=7.5, ncols=2)
    caption = (
        "Distributions of opening, closing and shear of triangles of neighbours (thick) and of "
        f"boxes of four spacings (thin), from displacements over {_interval(data, start)}. Heavy "
        "tails are straight lines here. Boxes average over rates of opposite sign."
    )
    return "motion_rates", caption, figure


def _lags(data: xr.Dataset, start: datetime) -> Made:
    unit, word = time_axis(float(data["lag"].values[-1]))
    lag = data["lag"].values / unit
    with look():
        figure = new_figure(6.0, 4.8)
        memory, apart = figure.subplots(2, 1, sharex=True)
        for name, dash, colour in (("along", "o-", BLUE), ("across", "s--", VERMILION)):
            values = data[f"velocity_correlation_{name}"].values
            memory.plot(lag, values, dash, color=colour, label=name, markersize=3.5)
        memory.axhline(0.0, color=FAINT, linewidth=0.8)
        style_axes(memory, "", "Autocorrelation of\nvelocity (1)")
        memory.legend(fontsize=8.5, ncols=2)
        parted = np.sqrt(data["pair_dispersion"].values) / 1e3
        apart.plot(lag, parted, "o-", color=GREEN, markersize=3.5)
        style_axes(apart, f"Lag ({word})", "Parting of\nneighbours (km)")
        apart.set_ylim(0)
        apart.xaxis.set_major_locator(MaxNLocator(integer=True))
    caption = (
        "Autocorrelation of the elements' velocities, means over windows (along: the same "
        "direction, across: turned to the left), and the root mean square by which vectors "
        "between neighbours change. Elements are followed until a remap. The mean circulation "
        "keeps the correlation above zero."
    )
    return "motion_lags", caption, figure
