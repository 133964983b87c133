# SPDX-License-Identifier: GPL-2.0-or-later
"""Analyses of a run as sea-ice scientists make them, in one dataset: ``analyses.nc``.

Only what scene and run support is there: no regression on wind without wind, no floe sizes where
floes are not resolved, no exponents where the scales are too few.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import timedelta
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.constants import EARTH_ROTATION, ICE_DENSITY, SNOW_DENSITY
from floeflow.core.grids import scene_crs, to_lonlat
from floeflow.diagnostics import ice_edge
from floeflow.diagnostics.break_events import (
    SOON,
    BreakEvents,
    breaks_between_samples,
    count_rows,
    event_rows,
    soon_share,
)
from floeflow.diagnostics.collect import cell_area
from floeflow.diagnostics.deformation import FIT_FROM, ORDERS, Scaling, fit_scaling
from floeflow.diagnostics.floe_sizes import (
    FLOES,
    LARGEST_ELEMENT,
    RESOLVED,
    fit_sizes,
    floe_diameters,
)
from floeflow.diagnostics.followed import frame_of
from floeflow.diagnostics.fracture import ANGLES, Cracks, bond_stresses, by_angle, new_cracks
from floeflow.diagnostics.linear_features import Features
from floeflow.diagnostics.motion_analyses import (
    DRIFT_BINS,
    ENOUGH,
    KINDS,
    RATE_BINS,
    RATES,
    WIND_BINS,
    Motion,
    correlation,
)
from floeflow.diagnostics.thickness_distribution import EDGES, thickness_areas
from floeflow.diagnostics.wind_drift import FreeDrift, WindFit, WindSums, free_drift, wind_fit
from floeflow.dynamics.engine.params import EngineParams
from floeflow.dynamics.motion import engine_params
from floeflow.scene import Scene
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]
Rows = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]

CAVEAT = (
    "Exponents depend on how triangles are chosen and filtered, and are not comparable below 10 km "
    "(Hutchings et al. 2024); signed gradients cancel within boxes (Beaudry & Tremblay 2026)."
)
# Variables that are times since the scene's start.
TIMES = ("thickness_time", "interval_time", "edge_time", "break_time", "break_window_time")
# Months of winter and summer of the northern hemisphere.
WINTER, SUMMER = (11, 12, 1, 2, 3, 4), (6, 7, 8, 9)
# Runs up to this long (s) are one period, longer ones are cut into months.
ONE_PERIOD = 45 * 86400.0
# Bonds by their stress over their compressive strength.
NORMAL_BINS, SHEAR_BINS = np.linspace(-1.02, 0.5, 77), np.linspace(0.0, 1.0, 51)
# Windows of a run of which the wind is looked up.
MOST_WINDS = 120


@dataclass
class Analyses:
    """What is gathered while the boundaries of a run go by.

    Parameters
    ----------
    scene : Scene
        The scene.
    remapped : set of int
        Windows at whose end ice was remapped; to be filled before the first state.
    """

    scene: Scene
    remapped: set[int] = field(default_factory=set)
    times: list[float] = field(default_factory=list)
    thickness: list[Array] = field(default_factory=list)
    mass: list[tuple[float, float]] = field(default_factory=list)
    breaks: Rows = field(default_factory=dict)

    @cached_property
    def events(self) -> BreakEvents:
        """Where bonds broke."""
        return BreakEvents(self.remapped)

    @cached_property
    def motion(self) -> Motion:
        """Sums of the motion."""
        winds = Winds(self.scene) if "wind" in self.scene.effects else None
        time = self.scene.time
        return Motion(time.window, time.windows, self.remapped, winds)

    def follow(self, states: Iterable[xr.Dataset]) -> Iterator[xr.Dataset]:
        """Hand snapshots on, and gather from each.

        Parameters
        ----------
        states : iterable of xarray.Dataset
            Snapshots in the order of time.

        Yields
        ------
        xarray.Dataset
            The same snapshots, in their order.
        """
        for state in states:
            self.take(state)
            yield state

    def take(self, state: xr.Dataset) -> None:
        """Gather from one state or snapshot.

        Parameters
        ----------
        state : xarray.Dataset
            State or snapshot.
        """
        self.times.append(float(state.attrs["time"]))
        self.thickness.append(thickness_areas(state))
        self.mass.append(_mass(state))
        self.motion.take(frame_of(state))
        self.events.take(state)

    def take_samples(self, samples: xr.Dataset) -> None:
        """Gather when bonds broke from the samples of the motion; nothing without bonds.

        Parameters
        ----------
        samples : xarray.Dataset
            From `floeflow.diagnostics.collect.read_series`.
        """
        if "intact_bonds" in samples:
            self.breaks = count_rows(*breaks_between_samples(samples))
            text = f"share of the breaks in the first {SOON:g} of a window"
            said = {"units": "1", "long_name": f"{text}, as much where they do not follow windows"}
            if self.breaks:
                self.breaks["break_soon_share"] = ((), soon_share(samples), said)

    def result(self, grid: xr.Dataset | None, states: dict[str, xr.Dataset]) -> xr.Dataset:
        """All analyses.

        Parameters
        ----------
        grid : xarray.Dataset or None
            Fields at all boundaries, shares of 1.
        states : dict of Dataset
            States with bonds at "start" and "end", as far as they are there.

        Returns
        -------
        xarray.Dataset
            Each variable with its unit; empty where nothing could be analysed.
        """
        rows: Rows = {}
        attrs = {"title": f"Analyses of scene {self.scene.name}", "deformation": CAVEAT}
        self._add_thickness(rows)
        if self.motion.winds:
            self._add_wind(rows)
        if self.motion.intervals:
            self._add_deformation(rows)
        self._add_lags(rows)
        rows |= self.breaks | event_rows(self.events.windows)
        if grid is not None:
            rows |= edge_rows(grid, cell_area(grid, Path("grid.nc")))
        for name, state in states.items():
            rows |= floe_rows(state, name)
        if "bond_id_lo" in states.get("end", ()):
            rows |= stress_rows(states["end"], engine_params(self.scene))
            cracks = new_cracks(states["start"], states["end"]) if "start" in states else None
            rows |= crack_rows(cracks) if cracks is not None else {}
        data = xr.Dataset(rows, attrs=attrs)
        for name in TIMES:
            if name in data:
                data[name].attrs = _time_attributes(self.scene)
        return data

    def _add_thickness(self, rows: Rows) -> None:
        said = {"units": "m2", "long_name": "ice area by thickness of the ice"}
        rows["thickness_time"] = (("boundary",), np.array(self.times), {})
        rows["thickness_area"] = (("boundary", "thickness"), np.stack(self.thickness), said)
        said = {"units": "m", "long_name": "lower and upper bounds of the bins of thickness"}
        bounds = np.stack([EDGES[:-1], EDGES[1:]], axis=1)
        rows["thickness_bounds"] = (("thickness", "bound"), bounds, said)

    def _add_wind(self, rows: Rows) -> None:
        motion = self.motion
        numbers = np.array([number for number, _ in motion.winds])
        periods = period_of(self.scene, (numbers - 0.5) * self.scene.time.window)
        known = list(dict.fromkeys(periods))
        fits: list[list[WindFit]] = []
        areas = np.zeros((len(known) + 1, len(KINDS)))
        for at, name in enumerate(["all", *known]):
            row = []
            for k, kind in enumerate(KINDS):
                sums = WindSums()
                for period, (_, parts) in zip(periods, motion.winds, strict=True):
                    if name in ("all", period):
                        sums += parts[kind]
                areas[at, k] = sums.weight
                row.append(wind_fit(sums))
            fits.append(row)
        dims = ("period", "ice")
        rows["period"] = (("period",), np.array(["all", *known]), {})
        rows["ice"] = (("ice",), np.array(KINDS), {})
        for name, unit, text, part in (
            ("wind_factor", "1", "drift over wind (modulus of the complex regression)", "factor"),
            ("wind_turning", "rad", "angle from wind to drift, counted to the left", "turning"),
            ("wind_explained", "1", "share of the variance of drift explained", "explained"),
        ):
            data = np.array([[getattr(fit, part) for fit in row] for row in fits])
            rows[name] = (dims, data, {"units": unit, "long_name": text})
        said = {"units": "m2", "long_name": "ice area times windows behind each regression"}
        rows["wind_weight"] = (dims, areas, said)
        said = {"units": "m2", "long_name": "ice area by wind speed and drift along the wind"}
        rows["wind_drift_area"] = (("wind", "drift"), motion.drift_counts, said)
        middle = 0.5 * (WIND_BINS[:-1] + WIND_BINS[1:])
        rows["wind"] = (("wind",), middle, {"units": "m s-1", "long_name": "wind speed"})
        along = 0.5 * (DRIFT_BINS[:-1] + DRIFT_BINS[1:])
        rows["drift"] = (("drift",), along, {"units": "m s-1", "long_name": "drift along the wind"})
        free = free_drift(middle, self.free_drift)
        for name, values in (("along", free.real), ("across", free.imag)):
            text = f"free drift of the mean ice {name} the wind, without current"
            said = {"units": "m s-1", "long_name": text}
            rows[f"free_drift_{name}"] = (("wind",), values, said)

    @property
    def free_drift(self) -> FreeDrift:
        """Balance of the run's mean ice."""
        scene, effects = self.scene, set(self.scene.effects)
        dynamics, domain = scene.dynamics, scene.domain
        area, load = np.array(self.mass).sum(axis=0)
        _, lat = to_lonlat(
            scene_crs(domain),
            np.array([0.5 * (domain.x_min + domain.x_max)]),
            np.array([0.5 * (domain.y_min + domain.y_max)]),
        )
        return FreeDrift(
            dynamics.air_drag,
            dynamics.ocean_drag if "ocean_drag" in effects else 0.0,
            np.radians(dynamics.turning_angle) if "turning_angle" in effects else 0.0,
            2.0 * EARTH_ROTATION * float(np.sin(np.radians(lat[0])))
            if "coriolis" in effects
            else 0.0,
            float(load / area) if area > 0.0 else 0.0,
        )

    def _add_deformation(self, rows: Rows) -> None:
        motion = self.motion
        counts, scales = np.stack(motion.counts), np.stack(motion.scales)
        moments, times = motion.moment_array, np.array(motion.intervals)
        said = {"units": "1", "long_name": "pieces of ice: triangles first, then boxes"}
        rows["interval_time"] = (("interval",), times, {})
        rows["deformation_count"] = (("interval", "scale"), counts, said)
        safe = np.where(counts > 0, counts, np.nan)
        said = {"units": "m", "long_name": "root of the pieces' mean area"}
        rows["deformation_scale"] = (("interval", "scale"), scales / safe, said)
        said = {
            "units": "s-1",
            "long_name": "mean total deformation to the power of an order, and root of that order",
        }
        mean = (moments / safe[..., None]) ** (1.0 / ORDERS)
        rows["deformation_moment"] = (("interval", "scale", "order"), mean, said)
        rows["order"] = (("order",), ORDERS, {"units": "1", "long_name": "order of the moment"})
        for k, name in enumerate(("total", "divergence", "shear")):
            values = np.array([item[k] for item in motion.means])
            text = f"mean rate of {name} deformation of the triangles (absolute values)"
            said = {"units": "s-1", "long_name": text}
            rows[f"deformation_{name}"] = (("interval",), values, said)
        seasons = seasons_of(self.scene, times)
        fits: list[Scaling] = []
        for chosen in seasons.values():
            part = np.flatnonzero(chosen)
            fits.append(fit_scaling(counts[part], scales[part], moments[part], motion.spacing))
        if any(np.isfinite(fit.low) for fit in fits):
            rows["season"] = (("season",), np.array(list(seasons)), {})
            for name, text in (
                ("exponent", "exponent of the moments, rate^order ~ scale^-exponent"),
                ("error", "standard error of the exponent"),
            ):
                said = {"units": "1", "long_name": text}
                values = np.stack([getattr(fit, name) for fit in fits])
                rows[f"scaling_{name}"] = (("season", "order"), values, said)
            for name in ("low", "high"):
                said = {"units": "m", "long_name": f"{name} end of the scales of the fit"}
                values = np.array([getattr(fit, name) for fit in fits])
                rows[f"scaling_{name}"] = (("season",), values, said)
        said = {"units": "1", "long_name": "pieces by rate, triangles and boxes of 4 spacings"}
        rows["rate_count"] = (("piece", "rate_kind", "rate"), motion.rates, said)
        rows["rate_kind"] = (("rate_kind",), np.array(RATES), {})
        said = {"units": "s-1", "long_name": "bounds of the bins of rates"}
        rows["rate_bounds"] = (
            ("rate", "bound"),
            np.stack([RATE_BINS[:-1], RATE_BINS[1:]], axis=1),
            said,
        )
        rows |= feature_rows(motion.features)
        spacing = {"units": "m", "long_name": "typical distance of neighbouring elements"}
        rows["spacing"] = ((), motion.spacing, spacing | {"fit_from": f"{FIT_FROM} spacings"})

    def _add_lags(self, rows: Rows) -> None:
        motion, window = self.motion, self.scene.time.window
        found = correlation(motion.lagged)
        number = motion.pairs[:, 0]
        known = np.flatnonzero(np.isfinite(found) | (number > ENOUGH * number[1]))
        if not known.size:
            return
        lags = np.arange(int(known[-1]) + 1)
        rows["lag"] = (("lag",), lags * window, {"units": "s", "long_name": "lag of time"})
        for name, values in (("along", found.real), ("across", found.imag)):
            text = f"autocorrelation of the elements' mean velocity over a window, {name}"
            said = {"units": "1", "long_name": text}
            rows[f"velocity_correlation_{name}"] = (("lag",), values[lags], said)
        mean = np.divide(motion.pairs[:, 1], number, out=np.zeros_like(number), where=number > 0)
        mean = np.where(number > ENOUGH * number[1], mean, np.nan)
        mean[0] = 0.0
        said = {"units": "m2", "long_name": "mean squared change of vectors between neighbours"}
        rows["pair_dispersion"] = (("lag",), mean[lags], said)


def _mass(state: xr.Dataset) -> tuple[float, float]:
    """Ice area (m2), and mass of ice and snow (kg), of the mobile elements."""
    area = np.where(state["type"].values == MOBILE, state["area"].values, 0.0)[:, None]
    load = ICE_DENSITY * state["ice_volume"].values
    if "snow_volume" in state:
        load = load + SNOW_DENSITY * state["snow_volume"].values
    return float((area * state["ice_fraction"].values).sum()), float((area * load).sum())


class Winds:
    """Mean wind of windows at places."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene.model_copy(update={"effects": ("wind",)})
        # The wind of a window takes a tenth of a second: of a year every fourth one does.
        self.every = -(-scene.time.windows // MOST_WINDS)

    def at(self, window: int, x: Array, y: Array) -> NDArray[np.complex128]:
        """Mean wind over a window (m/s), bilinear in space; the grid's edge holds outside of it.

        Parameters
        ----------
        window : int
            Number of the window.
        x : ndarray
            Places (m), (n,).
        y : ndarray
            Places (m), (n,).

        Returns
        -------
        ndarray
            u + i v.

        Raises
        ------
        FloeError
            For forcing that cannot be made.
        """
        # Over a second to import, and what reads no wind has no need of them.
        from scipy.ndimage import map_coordinates

        from floeflow.forcings.window import window_forcing

        with tempfile.TemporaryDirectory() as scratch:
            forcing = window_forcing(self.scene, window, Path(scratch))
        time = forcing["time"].values
        places = [
            (place - axis[0]) / (axis[1] - axis[0])
            for place, axis in ((y, forcing["y"].values), (x, forcing["x"].values))
        ]
        parts = []
        for name in ("wind_u", "wind_v"):
            mean = np.trapezoid(forcing[name].values, time, axis=0) / (time[-1] - time[0])
            parts.append(map_coordinates(mean, places, order=1, mode="nearest"))
        return np.asarray(parts[0] + 1j * parts[1])


def _time_attributes(scene: Scene) -> dict[str, str]:
    return {
        "standard_name": "time",
        "units": f"seconds since {scene.time.start:%Y-%m-%d %H:%M:%S}",
        "calendar": "standard",
    }


def months_of(scene: Scene, seconds: Array) -> list[tuple[int, int]]:
    """Year and month of times since the scene's start.

    Parameters
    ----------
    scene : Scene
        Its start and length.
    seconds : ndarray
        Since the scene's start (s), (times,).

    Returns
    -------
    list of tuple of int
        (year, month) of each.
    """
    moments = [scene.time.start + timedelta(seconds=float(second)) for second in seconds]
    return [(moment.year, moment.month) for moment in moments]


def period_of(scene: Scene, seconds: Array) -> list[str]:
    """The period to which each time belongs: its month, or the run where that is short.

    Parameters
    ----------
    scene : Scene
        Its start and length.
    seconds : ndarray
        Since the scene's start (s), (times,).

    Returns
    -------
    list of str
        ``YYYY-MM``, or ``run``.
    """
    if scene.time.windows * scene.time.window <= ONE_PERIOD:
        return ["run"] * len(seconds)
    return [f"{year:04d}-{month:02d}" for year, month in months_of(scene, seconds)]


def seasons_of(scene: Scene, seconds: Array) -> dict[str, NDArray[np.bool_]]:
    """Which times count to the run, and to winter and summer where it has both.

    Parameters
    ----------
    scene : Scene
        Its start, and its hemisphere.
    seconds : ndarray
        Since the scene's start (s), (times,).

    Returns
    -------
    dict of ndarray
        By ``all``, ``winter`` and ``summer``, (times,).
    """
    found = {"all": np.ones(len(seconds), dtype=bool)}
    domain = scene.domain
    middle = np.array([0.5 * (domain.y_min + domain.y_max)])
    centre = np.array([0.5 * (domain.x_min + domain.x_max)])
    south = float(to_lonlat(scene_crs(domain), centre, middle)[1][0]) < 0.0
    months = np.array([month for _, month in months_of(scene, seconds)])
    parts = {
        name: np.isin((months + 5) % 12 + 1 if south else months, wanted)
        for name, wanted in (("winter", WINTER), ("summer", SUMMER))
    }
    return found | parts if all(part.any() for part in parts.values()) else found


def edge_rows(grid: xr.Dataset, area: Array) -> Rows:
    """Extent, marginal zone and leads at the times of the grid, of cells with an area of sea.

    Parameters
    ----------
    grid : xarray.Dataset
        Fields on (time, y, x), with ``siconc`` (1).
    area : ndarray
        Of sea in each cell (m2), (y, x).

    Returns
    -------
    Rows
        Variables on ``grid``, with units.
    """
    share = grid["siconc"].values
    pack = np.nan_to_num(share) >= ice_edge.PACK
    covered = np.where(pack, area, 0.0).sum(axis=(1, 2))
    opened = np.where(pack, (1.0 - np.nan_to_num(share)) * area, 0.0).sum(axis=(1, 2))
    leads = np.divide(opened, covered, out=np.full(covered.shape, np.nan), where=covered > 0)
    columns = {
        "extent": ("m2", "sea of cells with at least 15 % of ice", ice_edge.extent),
        "marginal_area": ("m2", "sea of cells with 15 to 80 % of ice", ice_edge.marginal),
    }
    rows: Rows = {"edge_time": (("grid",), grid["time"].values.astype(float), {})}
    for name, (unit, text, make) in columns.items():
        values = np.array([make(each, area) for each in share])
        rows[name] = (("grid",), values, {"units": unit, "long_name": text})
    said = {"units": "1", "long_name": "open share of the sea of cells with at least 70 % of ice"}
    rows["lead_fraction"] = (("grid",), leads, said)
    return rows


def feature_rows(found: Sequence[Features]) -> Rows:
    """Linear features of the intervals of deformation.

    Parameters
    ----------
    found : sequence of Features
        Of each interval.

    Returns
    -------
    Rows
        Variables on ``interval``, ``feature`` and ``angle``, with units.
    """
    angle, length, width = (
        np.concatenate([getattr(each, name) for each in found])
        for name in ("angle", "length", "width")
    )
    area = np.array([each.area for each in found])
    total = np.array([each.length.sum() for each in found])
    share = np.array([each.share for each in found])
    rows: Rows = {
        "localised_share": (
            ("interval",), share,
            {"units": "1", "long_name": "least share of the ice that carries half of deformation"},
        ),
        "feature_density": (
            ("interval",), np.divide(total, area, out=np.zeros_like(area), where=area > 0),
            {"units": "m-1", "long_name": "length of linear features over the area of ice"},
        ),
        "feature_length": (
            ("feature",), length, {"units": "m", "long_name": "length of linear features"},
        ),
        "feature_width": (("feature",), width, {"units": "m", "long_name": "their mean width"}),
        "feature_angle_length": (
            ("angle",), by_angle(angle, length),
            {"units": "m", "long_name": "length of linear features by direction"},
        ),
    }  # fmt: skip
    return rows | angle_rows()


def angle_rows() -> Rows:
    """Directions in which features and cracks are counted."""
    said = {"units": "rad", "long_name": "direction from the grid's x axis, counted to the left"}
    return {"angle": (("angle",), (np.arange(ANGLES) + 0.5) * np.pi / ANGLES, said)}


def stress_rows(state: xr.Dataset, params: EngineParams) -> Rows:
    """How bonds are loaded, beside the envelope at which they fail; nothing without bonds.

    Parameters
    ----------
    state : xarray.Dataset
        State with bonds.
    params : EngineParams
        Of the scene.

    Returns
    -------
    Rows
        Bonds by normal and shear stress over the compressive strength.
    """
    normal, shear = bond_stresses(state, params)
    if not normal.size:
        return {}
    counts = np.histogram2d(normal, shear, bins=(NORMAL_BINS, SHEAR_BINS))[0]
    said = {
        "units": "1",
        "long_name": "bonds by stress over compressive strength at the end",
        "tensile_share": f"{params.tensile_share:.6g}",
        "friction_angle_degrees": f"{np.degrees(params.friction_angle):.6g}",
    }
    rows: Rows = {"bond_stress_count": (("normal", "shear"), counts, said)}
    for name, bins, text in (
        ("normal", NORMAL_BINS, "normal stress over compressive strength, above 0 in tension"),
        ("shear", SHEAR_BINS, "shear stress over compressive strength"),
    ):
        middle = 0.5 * (bins[:-1] + bins[1:])
        rows[name] = ((name,), middle, {"units": "1", "long_name": text})
    return rows


def crack_rows(cracks: Cracks) -> Rows:
    """Cracks that opened in the run.

    Parameters
    ----------
    cracks : Cracks
        Between its first and its last state.

    Returns
    -------
    Rows
        Lengths by direction on ``angle``, sizes on ``crack``.
    """
    rows: Rows = {
        "crack_angle_length": (
            ("angle",), by_angle(cracks.angle, cracks.length),
            {"units": "m", "long_name": "length of lines that broke in the run, by direction"},
        ),
        "line_angle_length": (
            ("angle",), cracks.before,
            {"units": "m", "long_name": "length of all lines of the start, by direction"},
        ),
        "crack_size": (
            ("crack",), cracks.sizes,
            {"units": "m", "long_name": "length of cracks: broken lines that meet in elements"},
        ),
    }  # fmt: skip
    return rows | angle_rows()


def floe_rows(state: xr.Dataset, name: str) -> Rows:
    """Sizes of the floes of a state, where it resolves floes; nothing where not.

    Parameters
    ----------
    state : xarray.Dataset
        Elements and bonds.
    name : str
        When, for descriptions.

    Returns
    -------
    Rows
        Diameters (m) and the fit of their power law, with units.
    """
    if "bond_id_lo" not in state:
        return {}
    diameter, elements, spacing = floe_diameters(state)
    floes = diameter[elements > RESOLVED]
    if floes.size < FLOES or spacing > LARGEST_ELEMENT:
        return {}
    said = {
        "units": "m",
        "long_name": f"diameters of floes of more than {RESOLVED} elements at the {name}",
    }
    fit = fit_sizes(floes)
    if fit is not None:
        numbers = {
            "power_law_exponent": fit.exponent,
            "power_law_error": fit.error,
            "power_law_from": fit.smallest,
            "power_law_goodness": fit.goodness,
            "lognormal_mean": fit.mean,
            "lognormal_spread": fit.spread,
            "likelihood_ratio": fit.ratio,
        }
        said |= {key: f"{value:.6g}" for key, value in numbers.items()}
    return {f"floe_diameter_{name}": ((f"floe_{name}",), np.sort(floes), said)}
