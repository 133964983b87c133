# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice that passes gates: area and volume over a line between two places, such as Fram Strait.

The part of each disc that lies on the far side of the line is known before and after the motion;
its change, times the ice of the element, is what passed. So the flux is smooth in time and adds up
to what went through, however large the elements are.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.grids import from_lonlat, scene_crs
from floeflow.scene import Scene
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]
Line = tuple[Array, Array]


def gate_lines(scene: Scene) -> dict[str, Line]:
    """Ends of each gate on the scene's map (m), (2,) each, by name.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    dict of (ndarray, ndarray)
        First and last end, x and y (m), (2,) each, by the gate's name.
    """
    crs = scene_crs(scene.domain)
    lines = {}
    for name, (lon_a, lat_a, lon_b, lat_b) in zip(
        scene.gates.names, scene.gates.lines, strict=True
    ):
        x, y = from_lonlat(crs, np.array([lon_a, lon_b]), np.array([lat_a, lat_b]))
        lines[name] = np.array([x[0], y[0]]), np.array([x[1], y[1]])
    return lines


def far_share(line: Line, x: Array, y: Array, radius: Array) -> tuple[Array, Array]:
    """Share of discs that lies to the right of a line (from its first end), and where along it.

    Parameters
    ----------
    line : Line
        Its ends (m).
    x : ndarray
        Centres (m), (n,).
    y : ndarray
        Centres (m), (n,).
    radius : ndarray
        m, (n,).

    Returns
    -------
    tuple of ndarray
        Share of the disc's area, 0 to 1, and the place of the centre along the line, 0 to 1
        between its ends, (n,) each.
    """
    start, end = line
    length = float(np.hypot(*(end - start)))
    along_x, along_y = (end - start) / length
    dx, dy = x - start[0], y - start[1]
    away = np.clip((dx * along_y - dy * along_x) / radius, -1.0, 1.0)
    share = 0.5 + (np.arcsin(away) + away * np.sqrt(1.0 - away**2)) / np.pi
    return share, (dx * along_x + dy * along_y) / length


def gate_fluxes(before: xr.Dataset, after: xr.Dataset, lines: dict[str, Line]) -> dict[str, float]:
    """What passed the gates to the right (as seen from the first end to the second).

    Parameters
    ----------
    before, after : xarray.Dataset
        States before and after the motion of a window, of the same elements.
    lines : dict
        From `gate_lines`.

    Returns
    -------
    dict of float
        ``gate_area_<name>`` (m2 of ice) and ``gate_volume_<name>`` (m3).
    """
    mobile = before["type"].values == MOBILE
    area, radius = (before[name].values[mobile] for name in ("area", "radius"))
    ice, volume = (
        area * before[f"ice_{name}"].values[mobile].sum(axis=1) for name in ("fraction", "volume")
    )
    terms = {}
    for name, line in lines.items():
        (first, begin), (last, end) = (
            far_share(line, state["x"].values[mobile], state["y"].values[mobile], radius)
            for state in (before, after)
        )
        middle = 0.5 * (begin + end)
        passed = np.where((middle >= 0.0) & (middle <= 1.0), last - first, 0.0)
        terms[f"gate_area_{name}"] = float(ice @ passed)
        terms[f"gate_volume_{name}"] = float(volume @ passed)
    return terms
