# SPDX-License-Identifier: GPL-2.0-or-later
"""Budgets of the run: what changed, what explains it, and what is left over.

Each is closed window by window, so that faults of opposite sign in two windows do not hide each
other; its verdict rests on the worst window. Thresholds stand here and are shown in the report.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Limits:
    """Relative residuals up to ``closed`` are round-off, up to ``fair`` worth a look."""

    closed: float
    fair: float


# A share of the turnover up to this is round-off, however small the change is.
ROUND_OFF = 1e-8
# No reader would call a budget closed whose residual is a larger share of what changed.
OF_CHANGE = 0.1

# Sums of a window's terms reach round-off, and so do the grid's totals. What depends on the time
# step (energy of the DEM) cannot, and gets the width of its method.
LIMITS: dict[str, Limits] = {
    "momentum": Limits(1e-8, 1e-4),
    "ice_volume": Limits(1e-10, 1e-6),
    "ice_volume_dynamics": Limits(1e-12, 1e-9),
    "column_energy": Limits(1e-10, 1e-6),
    "dem_energy": Limits(2e-2, 1e-1),
    "grid": Limits(1e-10, 1e-6),
}


@dataclass(frozen=True)
class Budget:
    """One budget of the run.

    Parameters
    ----------
    name : str
        Short name, also of the per-window residual in ``diagnostics.nc``.
    label : str
        What it is, for people.
    unit : str
        Unit of change, terms and residual.
    change : ndarray
        What changed in each window, (window,).
    terms : mapping of str to ndarray
        What explains the change, signed, (window,) each.
    scale : ndarray
        To which the residual is compared, (window,).
    windows : ndarray
        Numbers of the windows, (window,).
    limits : Limits
        Of the relative residual.
    stock : bool
        The entries are stocks at a time, of which the last stands for the run; else changes,
        which add up over it.
    """

    name: str
    label: str
    unit: str
    change: Array
    terms: Mapping[str, Array]
    scale: Array
    windows: NDArray[np.int64]
    limits: Limits
    stock: bool = False

    @property
    def residual(self) -> Array:
        """Change that the terms do not explain, (window,)."""
        return self.change - sum(self.terms.values(), np.zeros_like(self.change))

    @property
    def relative(self) -> Array:
        """Absolute residual over the scale, (window,); infinite where the scale alone is 0."""
        return relative(self.residual, self.scale)

    def _total(self, values: Array) -> float:
        return float(values[-1:].sum() if self.stock else values.sum())

    def summary(self) -> dict[str, Any]:
        """Sums over the windows (of stocks the last) and the worst window, as JSON types."""
        ratios = self.relative
        worst = int(np.argmax(ratios)) if ratios.size else None
        value = float(ratios[worst]) if worst is not None else 0.0
        change, left = self._total(self.change), self._total(self.residual)
        of_change = float(relative(np.array([left]), np.array([change]))[0])
        return {
            "name": self.name,
            "label": self.label,
            "unit": self.unit,
            "change": change,
            "terms": {name: self._total(term) for name, term in self.terms.items()},
            "residual": left,
            "relative": value if np.isfinite(value) else None,
            "of_change": of_change if np.isfinite(of_change) else None,
            "worst_window": int(self.windows[worst]) if worst is not None else None,
            "closed_limit": self.limits.closed,
            "fair_limit": self.limits.fair,
            "verdict": verdict(value, self.limits, of_change),
        }


def relative(residual: Array, scale: Array) -> Array:
    """Return |residual| / |scale|: 0 where both vanish, infinite where only the scale does.

    Parameters
    ----------
    residual : ndarray
        In one unit, of one shape.
    scale : ndarray
        In one unit, of one shape.

    Returns
    -------
    ndarray
        1.
    """
    size, base = np.abs(residual), np.abs(scale)
    ratio = np.divide(size, base, out=np.full_like(size, np.inf), where=base > 0)
    return np.where(size == 0, 0.0, np.where(np.isnan(ratio), np.inf, ratio))


def verdict(value: float, limits: Limits, of_change: float = 0.0) -> str:
    """Return 'closed', 'fair' or 'open' for a residual.

    Parameters
    ----------
    value : float
        Share of the turnover, in the worst window.
    limits : Limits
        Up to which it is closed and fair.
    of_change : float
        Share of the run's change. A residual beyond round-off that is more than a tenth of what
        changed makes the budget fair at best.

    Returns
    -------
    str
        One of these three.
    """
    closed = value <= limits.closed and (value <= ROUND_OFF or of_change <= OF_CHANGE)
    if closed:
        return "closed"
    return "fair" if value <= limits.fair else "open"


def _matching(scalars: xr.Dataset, prefix: str, suffix: str = "") -> dict[str, Array]:
    """Per-window terms named prefix + term + suffix, by term."""
    return {
        name[len(prefix) : len(name) - len(suffix)]: scalars[name].values.astype(float)
        for name in map(str, scalars.data_vars)
        if name.startswith(prefix) and name.endswith(suffix)
    }


def _absolute_sum(terms: Mapping[str, Array], like: Array) -> Array:
    return sum((np.abs(term) for term in terms.values()), np.zeros(like.shape))


def momentum_budget(scalars: xr.Dataset, axis: str) -> Budget:
    """Momentum of the mobile elements along an axis over the dynamics of each window.

    Parameters
    ----------
    scalars : xarray.Dataset
        Budget scalars of the series on the dimension ``window``.
    axis : str
        ``x`` or ``y``.

    Returns
    -------
    Budget
        P_end - P_start against the sum of impulses (kg m/s), relative to the sum of their
        absolute values, or to the momentum itself where nothing pushes.
    """
    start = scalars[f"momentum_{axis}_start"].values.astype(float)
    end = scalars[f"momentum_{axis}_end"].values.astype(float)
    terms = _matching(scalars, "impulse_", f"_{axis}")
    pushed = _absolute_sum(terms, start)
    return Budget(
        f"momentum_{axis}",
        f"Momentum along {axis}",
        "kg m/s",
        end - start,
        terms,
        np.where(pushed > 0, pushed, np.abs(start) + np.abs(end)),
        scalars["window"].values,
        LIMITS["momentum"],
    )


def ice_volume_budgets(
    scalars: xr.Dataset, volume: Array, exports: Mapping[str, Array]
) -> list[Budget]:
    """Ice volume of the run, and what the dynamics did to it (nothing, to round-off).

    The scalars are as in `momentum_budget`; ``volume`` is that of the states at the window
    boundaries inside the scene's rectangle (m3), (window + 1,), ``exports`` what came in from
    beyond its sides in each window, see `exports_of`.

    Parameters
    ----------
    scalars : xarray.Dataset
        As in `momentum_budget`, on ``window``.
    volume : ndarray
        Of the ice inside the rectangle at the boundaries (m3), (window + 1,).
    exports : mapping of ndarray
        What came in from beyond the rectangle's sides in each window (m3), see `exports_of`.

    Returns
    -------
    list of Budget
        Of the run, and of the dynamics alone; m3.
    """
    start = scalars["ice_volume_start"].values.astype(float)
    moved = scalars["ice_volume_dynamics"].values.astype(float) - start
    windows = scalars["window"].values
    growth = _matching(scalars, "growth_") | rim_terms(scalars, "ice_volume")
    run = Budget(
        "ice_volume",
        "Ice volume",
        "m3",
        np.diff(volume),
        {**growth, "dynamics": moved, **exports},
        np.maximum(volume[1:], _absolute_sum({**growth, **exports}, moved)),
        windows,
        LIMITS["ice_volume"],
    )
    dynamics = Budget(
        "ice_volume_dynamics",
        "Ice volume over the dynamics",
        "m3",
        moved,
        {},
        start,
        windows,
        LIMITS["ice_volume_dynamics"],
    )
    return [run, dynamics]


def rim_terms(scalars: xr.Dataset, quantity: str) -> dict[str, Array]:
    """What the effect rims took out (negative) and let in, by side, where anything passed.

    Parameters
    ----------
    scalars : xarray.Dataset
        As in `momentum_budget`, on ``window``.
    quantity : str
        Such as ``ice_volume``.

    Returns
    -------
    dict of ndarray
        By ``export <side>`` and ``inflow <side>``, (window,).
    """
    left = _matching(scalars, f"export_{quantity}_")
    came = _matching(scalars, f"inflow_{quantity}_")
    terms = {f"export {side}": -amount for side, amount in left.items() if amount.any()}
    return terms | {f"inflow {side}": amount for side, amount in came.items() if amount.any()}


def exports_of(boundaries: xr.Dataset, name: str) -> dict[str, Array]:
    """What each window brought in through the sides of the rectangle, less what left, (window,).

    The growth of ice that is outside counts here too: it is the change of what lies beyond. Only
    sides beyond which anything ever was.

    Parameters
    ----------
    boundaries : xarray.Dataset
        From `floeflow.diagnostics.collect.summarise_states`.
    name : str
        ``ice_area``, ``ice_volume`` or ``snow_volume``.

    Returns
    -------
    dict of ndarray
        In the unit of the quantity, (window,), by the side in words.
    """
    prefix = f"{name}_beyond_"
    return {
        f"through {str(key).removeprefix(prefix)} side": -np.diff(item.values)
        for key, item in boundaries.data_vars.items()
        if str(key).startswith(prefix) and item.values.any()
    }


def total_of(boundaries: xr.Dataset, name: str) -> xr.DataArray:
    """Inside of the rectangle and beyond its sides together, on ``boundary``.

    Parameters
    ----------
    boundaries : xarray.Dataset
        On ``boundary``.
    name : str
        Of the quantity.

    Returns
    -------
    xarray.DataArray
        In the unit of the quantity.
    """
    prefix = f"{name}_beyond_"
    beyond = [item for key, item in boundaries.data_vars.items() if str(key).startswith(prefix)]
    return sum(beyond, boundaries[name])


def snow_volume_budget(scalars: xr.Dataset, volume: Array, exports: Mapping[str, Array]) -> Budget:
    """Snow volume of the run; see `ice_volume_budgets`.

    Parameters
    ----------
    scalars : xarray.Dataset
        As in `momentum_budget`, on ``window``.
    volume : ndarray
        Of the snow inside the rectangle at the boundaries (m3), (window + 1,).
    exports : mapping of ndarray
        What came in from beyond the rectangle's sides in each window (m3), see `exports_of`.

    Returns
    -------
    Budget
        m3.
    """
    terms = _matching(scalars, "snow_")
    named = {name: term for name, term in terms.items() if not name.startswith("volume_")}
    named |= {**exports, **rim_terms(scalars, "snow_volume")}
    return Budget(
        "snow_volume",
        "Snow volume",
        "m3",
        np.diff(volume),
        named,
        np.maximum(volume[1:], _absolute_sum(named, volume[1:])),
        scalars["window"].values,
        LIMITS["ice_volume"],
    )


_STORED = {
    "energy": ("Energy of the columns", "J"),
    "water": ("Water in ice and snow", "kg"),
    "salt": ("Salt in the ice", "kg"),
    "pond": ("Water in melt ponds", "m3"),
    "sea_heat": ("Heat of the mixed layer", "J"),
    "sea_salt": ("Salt of the mixed layer", "kg"),
}


def column_budgets(scalars: xr.Dataset) -> list[Budget]:
    """What went into the columns against their ``<quantity>_stored``, where they tell of it.

    Parameters
    ----------
    scalars : xarray.Dataset
        On ``window``.

    Returns
    -------
    list of Budget
        One for each quantity that is told of.
    """
    found = []
    for kind, (label, unit) in _STORED.items():
        if f"{kind}_stored" not in scalars:
            continue
        terms = _matching(scalars, f"{kind}_")
        stored = terms.pop("stored")
        scale, windows = _absolute_sum(terms, stored), scalars["window"].values
        named = f"column_{kind}", label, unit
        found.append(Budget(*named, stored, terms, scale, windows, LIMITS["column_energy"]))
    return found


def dem_energy_budget(scalars: xr.Dataset, kinetic: Array, elastic: Array) -> Budget | None:
    """Mechanical energy against work and dissipation as the engine accumulates them.

    Parameters
    ----------
    scalars : xarray.Dataset
        Budget scalars of the series on the dimension ``window``.
    kinetic, elastic : ndarray
        Change over the dynamics of each window (J), (window,).

    Returns
    -------
    Budget or None
        None where the engine reports neither work nor dissipation.
    """
    work = {f"work {k}": v for k, v in _matching(scalars, "work_").items()}
    lost = {f"dissipation {k}": -v for k, v in _matching(scalars, "dissipation_").items()}
    if not work and not lost:
        return None
    terms = {**work, **lost}
    return Budget(
        "dem_energy",
        "Mechanical energy",
        "J",
        kinetic + elastic,
        terms,
        _absolute_sum(terms, kinetic),
        scalars["window"].values,
        LIMITS["dem_energy"],
    )


def grid_budget(
    name: str, label: str, unit: str, grid: xr.DataArray, elements: Array, outside: Array
) -> Budget:
    """Total on the grid against the elements' total at the same window boundaries.

    Parameters
    ----------
    name, label, unit : str
        Of the quantity.
    grid : xarray.DataArray
        Totals on the grid with the coordinate ``grid_window``, (grid,).
    elements : ndarray
        The elements' totals at the same boundaries, (grid,).
    outside : ndarray
        The part of it in elements that have left the grid, (grid,).

    Returns
    -------
    Budget
        At the boundaries that the grid has.
    """
    return Budget(
        f"grid_{name}",
        label,
        unit,
        grid.values.astype(float),
        {"elements": elements, "outside": -outside} if outside.any() else {"elements": elements},
        elements,
        grid["grid_window"].values,
        LIMITS["grid"],
        stock=True,
    )
