# SPDX-License-Identifier: GPL-2.0-or-later
"""Budgets as bars: each term, the change that they explain, and the residual in numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from floeflow.report.figures.series import ENERGY_UNITS, VOLUME_UNITS, pick_unit
from floeflow.report.figures.style import BLUE, FAINT, INK, ORANGE, look, new_figure

UNITS = {"J": ENERGY_UNITS, "m3": VOLUME_UNITS}


def budget_unit(unit: str, values: np.ndarray) -> tuple[float, str]:
    """Scale and unit in which a budget's values are best told.

    Parameters
    ----------
    unit : str
        In which the values are given.
    values : ndarray
        Terms of the budget.

    Returns
    -------
    tuple of float and str
        Divisor of the values, and the name of the unit.
    """
    if unit in UNITS:
        return pick_unit(UNITS[unit], values)
    largest = float(np.abs(values).max(initial=0.0))
    if largest <= 0 or 1e-3 <= largest < 1e4:
        return 1.0, unit
    power = int(np.floor(np.log10(largest)))
    superscript = str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return 10.0**power, f"10{superscript} {unit}"


def budget_figure(budget: Mapping[str, Any]) -> Figure:
    """Draw one budget of ``diagnostics.json``.

    Parameters
    ----------
    budget : mapping
        As from `floeflow.diagnostics.budgets.Budget.summary`.

    Returns
    -------
    Figure
        Horizontal bars: terms filled where they add and hatched where they take away, then the
        change; the residual beneath in numbers.
    """
    terms = {str(name).replace("_", " "): float(v) for name, v in budget["terms"].items()}
    names = [*terms, "change"]
    values = np.array([*terms.values(), float(budget["change"])])
    scale, unit = budget_unit(str(budget["unit"]), values)
    shown = values / scale
    with look():
        figure = new_figure(6.0, 1.25 + 0.27 * len(names))
        axes = figure.add_subplot()
        places = np.arange(len(names))[::-1]
        for name, value, place in zip(names, shown, places, strict=True):
            axes.barh(
                place,
                value,
                height=0.66,
                color=INK if name == "change" else (BLUE if value >= 0 else "white"),
                edgecolor=INK if name == "change" else (BLUE if value >= 0 else ORANGE),
                hatch="" if value >= 0 or name == "change" else "/////",
            )
        _write_values(axes, shown, places)
        axes.set_yticks(places, names)
        axes.axvline(0, color=INK, linewidth=0.8)
        axes.axhline(0.5, color=FAINT, linewidth=0.6, linestyle=":")
        axes.set_xlabel(f"{budget['label']} ({unit})")
        axes.grid(axis="x", color=FAINT, alpha=0.25, linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right", "left"]].set_visible(False)
        axes.tick_params(axis="y", length=0)
        axes.set_title(_residual_text(budget), fontsize=8.5, fontweight="normal")
    return figure


def _residual_text(budget: Mapping[str, Any]) -> str:
    ratio, left = budget["relative"], float(budget["residual"])
    unit = str(budget["unit"]).replace("m3", "m³").replace("m2", "m²")
    share = "without scale" if ratio is None else f"{float(ratio):.1e} relative in the worst window"
    return f"Residual {left:.1e} {unit}, {share}: {budget['verdict']}"


def _write_values(axes: Any, shown: np.ndarray, places: np.ndarray) -> None:
    """Write each value beside its bar, on the side where there is room."""
    reach = float(np.abs(shown).max(initial=0.0)) or 1.0
    low, high = min(0.0, float(shown.min())), max(0.0, float(shown.max()))
    axes.set_xlim(low - 0.2 * reach * (low < 0) - 0.03 * reach, high + 0.22 * reach)
    for value, place in zip(shown, places, strict=True):
        side = 1 if value >= 0 else -1
        axes.text(
            value + side * 0.015 * reach,
            place,
            f"{value if abs(value) > 1e-9 * reach else 0:.3g}".replace("-", "−"),
            ha="left" if side > 0 else "right",
            va="center",
            fontsize=8,
        )
