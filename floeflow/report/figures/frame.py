# SPDX-License-Identifier: GPL-2.0-or-later
"""The frame of a map: land, graticule, scale bar and axes in kilometres."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pyproj
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.typing import ColorType

from floeflow.report.figures.style import FAINT, INK, LAND, WATER, nice_step
from floeflow.scene.blocks import Domain

DEGREES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0)
LINE_POINTS = 721
HALO = [withStroke(linewidth=2.2, foreground="white", alpha=0.8)]


@dataclass(frozen=True)
class Frame:
    """What all maps of a scene share.

    Parameters
    ----------
    domain : Domain
        The scene's rectangle and projection.
    land : xarray.DataArray
        1 where land, with x and y of cell centres (m), (y, x).
    """

    domain: Domain
    land: xr.DataArray

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom, top (km)."""
        domain = self.domain
        left, right, bottom, top = (
            value / 1e3 for value in (domain.x_min, domain.x_max, domain.y_min, domain.y_max)
        )
        return left, right, bottom, top

    def size(self, width: float) -> tuple[float, float]:
        """Width and height (inches) of a figure whose map fills it beside a colour bar.

        Parameters
        ----------
        width : float
            Of the figure (inches).

        Returns
        -------
        tuple of float
            Inches.
        """
        left, right, bottom, top = self.extent
        aspect = (top - bottom) / (right - left)
        return width, float(np.clip(0.72 * width * aspect + 0.75, 2.4, 1.6 * width))


def prepare_axes(axes: Axes, frame: Frame, title: str, water: ColorType = WATER) -> None:
    """Water, land, graticule, scale bar, labels and limits of a map.

    Parameters
    ----------
    axes : Axes
        Of the figure.
    frame : Frame
        Extent (km) and projection of the map.
    title : str
        Above the map.
    water : ColorType, optional
        Its colour.
    """
    left, right, bottom, top = frame.extent
    axes.set_facecolor(water)
    axes.set_title(title)
    axes.set_aspect("equal")
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_xlabel("x (km)")
    axes.set_ylabel("y (km)")
    axes.tick_params(labelsize=8)
    draw_land(axes, frame.land)
    draw_graticule(axes, frame)
    draw_scale_bar(axes, right - left)


def draw_land(axes: Axes, land: xr.DataArray) -> None:
    """Land cells of the mask, beneath everything else.

    Parameters
    ----------
    axes : Axes
        In km.
    land : xarray.DataArray
        Not 0 on land, on (y, x) (m).
    """
    x, y = land["x"].values / 1e3, land["y"].values / 1e3
    half_x, half_y = (abs(axis[1] - axis[0]) / 2 if axis.size > 1 else 0.5 for axis in (x, y))
    shown = np.ma.masked_where(land.values == 0, land.values)
    axes.imshow(
        shown,
        extent=(x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y),
        origin="lower",
        cmap=ListedColormap([LAND]),
        interpolation="nearest",
        zorder=1,
    )


def draw_scale_bar(axes: Axes, width_km: float) -> None:
    """A bar of a round length, about a fifth of the map, in the lower left corner.

    Parameters
    ----------
    axes : Axes
        In km.
    width_km : float
        Width of the map (km).
    """
    length = nice_step(width_km, 5)
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    x, y = left + 0.04 * (right - left), bottom + 0.045 * (top - bottom)
    thick = 0.012 * (top - bottom)
    pad = 0.02 * (right - left)
    back = Rectangle(
        (x - pad, y - 1.6 * thick),
        length + 2 * pad,
        7.2 * thick,
        facecolor="white",
        alpha=0.85,
        edgecolor="none",
        zorder=8,
    )
    axes.add_patch(back)
    for part, colour in ((0, INK), (1, "white")):
        axes.add_patch(
            Rectangle(
                (x + part * length / 2, y),
                length / 2,
                thick,
                facecolor=colour,
                edgecolor=INK,
                linewidth=0.6,
                zorder=9,
            )
        )
    axes.text(
        x + length / 2,
        y + 1.5 * thick,
        f"{length:g} km",
        ha="center",
        va="bottom",
        fontsize=7.5,
        zorder=9,
    )


def draw_graticule(axes: Axes, frame: Frame) -> None:
    """Parallels and meridians as light lines with labels.

    Parameters
    ----------
    axes : Axes
        In km.
    frame : Frame
        Extent (km) and projection of the map.
    """
    for kind, x, y, text in _graticule(frame):
        _line(axes, x, y)
        label = _label_parallel if kind == "parallel" else _label_meridian
        label(axes, frame, x, y, text)


def graticule_lines(
    frame: Frame,
) -> tuple[list[tuple[np.ndarray, np.ndarray]], list[tuple[float, float, str]]]:
    """Parallels and meridians (km, NaN outside of the map), and labels with their places (km).

    A label stands where its line meets the map's edge first; labels that would touch are left out.

    Parameters
    ----------
    frame : Frame
        Projection and extent of the map.

    Returns
    -------
    lines : list of tuple of ndarray
        x and y of each (km).
    labels : list of tuple
        x and y (km) and text of each.
    """
    left, right, bottom, top = frame.extent
    lines: list[tuple[np.ndarray, np.ndarray]] = []
    labels: list[tuple[float, float, str]] = []
    for kind, x, y, text in _graticule(frame):
        lines.append((x, y))
        across, up = (x - left) / (right - left), (y - bottom) / (top - bottom)
        inside = np.minimum(np.minimum(across, 1 - across), np.minimum(up, 1 - up))
        wanted = np.abs(across + up - 1.0) if kind == "parallel" else inside
        usable = np.isfinite(inside) & (inside > 0.035) & ~((across < 0.33) & (up < 0.12))
        for there_x, there_y, _ in labels:
            near_x = np.abs(x - there_x) < 0.09 * (right - left)
            usable &= ~(near_x & (np.abs(y - there_y) < 0.05 * (top - bottom)))
        if usable.any():
            place = int(np.argmin(np.where(usable, wanted, np.inf)))
            labels.append((float(x[place]), float(y[place]), text))
    return lines, labels


def _graticule(frame: Frame) -> Iterator[tuple[str, np.ndarray, np.ndarray, str]]:
    """Kind, places (km) and label of each parallel and meridian that the map may hold."""
    latitudes, longitudes, pole = _degrees_seen(frame)
    lat_step = _step(float(np.ptp(latitudes)), 5)
    lon_span = float(np.ptp(longitudes))
    lon_step = 30.0 if pole else _step(lon_span, 5)
    parallels = np.arange(-90.0 + lat_step, 90.0 - lat_step / 2, lat_step)
    inside = (parallels > latitudes.min()) & (parallels < latitudes.max())
    parallels = parallels[inside]
    round_trip = np.linspace(-180.0, 180.0, LINE_POINTS)
    for latitude in parallels:
        x, y = _project(frame, round_trip, np.full(LINE_POINTS, latitude))
        yield "parallel", x, y, _degree(latitude, "N", "S")
    # Meridians stop short of the pole, where they would crowd.
    reach = parallels if pole and parallels.size else latitudes
    low, high = float(latitudes.min()), float(latitudes.max())
    if pole:
        low, high = (low, float(reach.max())) if low > -45 else (float(reach.min()), high)
    start = np.ceil(longitudes.min() / lon_step) * lon_step
    for longitude in np.arange(start, longitudes.max() + 1e-9, lon_step)[: 360 if pole else None]:
        if pole and longitude >= start + 360.0 - 1e-9:
            break
        along = np.linspace(low, high, LINE_POINTS)
        x, y = _project(frame, np.full(LINE_POINTS, longitude), along)
        wrapped = (longitude + 180.0) % 360.0 - 180.0
        yield "meridian", x, y, _degree(wrapped, "E", "W")


@lru_cache(maxsize=8)
def _transformer(source: str, target: str) -> pyproj.Transformer:
    return pyproj.Transformer.from_crs(source, target, always_xy=True)


def _project(frame: Frame, lon: np.ndarray, lat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Kilometres in the scene's projection, NaN where it has no place for a point."""
    x, y = _transformer("EPSG:4326", frame.domain.crs).transform(lon, lat)
    x, y = np.asarray(x) / 1e3, np.asarray(y) / 1e3
    left, right, bottom, top = frame.extent
    seen = (x >= left) & (x <= right) & (y >= bottom) & (y <= top)
    return np.where(seen, x, np.nan), np.where(seen, y, np.nan)


def _degrees_seen(frame: Frame) -> tuple[np.ndarray, np.ndarray, bool]:
    """Latitudes and (unwrapped) longitudes on the map, and whether a pole lies on it."""
    domain = frame.domain
    to_degrees = _transformer(domain.crs, "EPSG:4326")
    x, y = np.meshgrid(
        np.linspace(domain.x_min, domain.x_max, 61), np.linspace(domain.y_min, domain.y_max, 61)
    )
    lon, lat = to_degrees.transform(x, y)
    good = np.isfinite(lon) & np.isfinite(lat)
    lon, lat = np.asarray(lon)[good], np.asarray(lat)[good]
    if lon.size == 0:
        return np.zeros(1), np.zeros(1), False
    poles = (_project(frame, np.zeros(1), np.full(1, sign * 90.0))[0] for sign in (1, -1))
    if any(np.isfinite(pole).all() for pole in poles):
        return lat, np.linspace(-180.0, 180.0, 13), True
    middle = lon[lon.size // 2]
    return lat, middle + (lon - middle + 180.0) % 360.0 - 180.0, False


def _step(span: float, most: int) -> float:
    return next((step for step in DEGREES if span / step <= most), DEGREES[-1])


def _degree(value: float, positive: str, negative: str) -> str:
    if abs(value) < 1e-9 or abs(abs(value) - 180.0) < 1e-9:
        return f"{abs(value):.0f}°"
    return f"{abs(value):g}°{positive if value > 0 else negative}"


def _line(axes: Axes, x: np.ndarray, y: np.ndarray) -> None:
    axes.plot(x, y, color="white", linewidth=1.1, alpha=0.35, zorder=5)
    axes.plot(x, y, color=FAINT, linewidth=0.5, alpha=0.75, zorder=5)


def _label_parallel(axes: Axes, frame: Frame, x: np.ndarray, y: np.ndarray, text: str) -> None:
    """Label where the line comes nearest to the diagonal that leads to the lower right corner."""
    left, right, bottom, top = frame.extent
    across, up = (x - left) / (right - left), (y - bottom) / (top - bottom)
    margin = (across > 0.06) & (across < 0.94) & (up > 0.05) & (up < 0.95)
    if not margin.any():
        return
    margin &= ~_near_labels(axes, x, y)
    if not margin.any():
        return
    off = np.where(margin, np.abs(across + up - 1.0) + 0.3 * (across < 0.5), np.inf)
    place = int(np.argmin(off))
    _text(axes, x[place], y[place], text)


def _label_meridian(axes: Axes, frame: Frame, x: np.ndarray, y: np.ndarray, text: str) -> None:
    """Label near the end of the line that lies closest to the map's edge, clear of the corner."""
    left, right, bottom, top = frame.extent
    across, up = (x - left) / (right - left), (y - bottom) / (top - bottom)
    edge = np.minimum(np.minimum(across, 1 - across) - 0.03, np.minimum(up, 1 - up))
    corner = (across < 0.36) & (up < 0.17)
    usable = np.isfinite(edge) & (edge > 0.025) & ~corner & ~_near_labels(axes, x, y)
    if not usable.any():
        return
    place = int(np.argmin(np.where(usable, edge, np.inf)))
    _text(axes, x[place], y[place], text)


def _near_labels(axes: Axes, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Where a label would touch one that is there already."""
    wide, high = (np.ptp(limits) for limits in (axes.get_xlim(), axes.get_ylim()))
    near = np.zeros(x.shape, dtype=bool)
    for text in axes.texts:
        there_x, there_y = text.get_position()
        near |= (np.abs(x - there_x) < 0.1 * wide) & (np.abs(y - there_y) < 0.04 * high)
    return near


def _text(axes: Axes, x: float, y: float, text: str) -> None:
    axes.text(
        x,
        y,
        text,
        fontsize=6.8,
        color=INK,
        ha="center",
        va="center",
        zorder=7,
        path_effects=HALO,
        clip_on=True,
    )
