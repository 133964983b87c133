# SPDX-License-Identifier: GPL-2.0-or-later
"""Maps of the elements, coloured by what they carry.

Elements are drawn as the cells that they got from the tessellation, carried and turned with them,
so that a lead shows as a gap; elements without a cell as discs. Everything goes into a few
collections: 100,000 elements draw in seconds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import Collection, EllipseCollection, PolyCollection
from matplotlib.colors import Normalize, to_rgba
from matplotlib.figure import Figure

from floeflow.core.polygons import body_outlines, carried_outlines, own_outlines
from floeflow.report.figures.frame import HALO, Frame, prepare_axes
from floeflow.report.figures.style import COAST, INK, Quantity, look, new_figure, nice_step
from floeflow.state.schema import MOBILE

WIDTH = 6.0
ARROWS = 18


@dataclass(frozen=True)
class Shapes:
    """Outlines of a state's elements (km).

    Parameters
    ----------
    polygons : list of ndarray
        Cells, (corner, 2) each.
    of_polygon : ndarray
        Index of each cell's element.
    of_disc : ndarray
        Indices of the elements that have no cell.
    """

    polygons: list[np.ndarray]
    of_polygon: np.ndarray
    of_disc: np.ndarray


def element_shapes(state: xr.Dataset, packing: xr.Dataset) -> Shapes:
    """Cells of the elements, moved and turned to where they are in a state.

    A state of remapped elements holds their cells; of others they are those of the packing.

    Parameters
    ----------
    state, packing : xarray.Dataset
        As their contracts say; an id that is in one of them only gets a disc, or nothing.

    Returns
    -------
    Shapes
        Polygons (km), the rows of their elements, and the rows of elements without a cell.
    """
    if "cell_corners" in state:
        body, corners = own_outlines(state), state["cell_corners"].values
    else:
        unturned = packing.assign(theta=("element", np.zeros(packing.sizes["element"])))
        body, corners = body_outlines(packing, unturned), np.diff(packing["cell_start"].values)
    has_cell = np.isin(state["id"].values, body.id[corners >= 3])
    of_polygon = np.flatnonzero(has_cell)
    drawn = carried_outlines(body, state[["id", "x", "y", "theta"]].isel(element=of_polygon))
    places = np.stack([drawn.x, drawn.y], axis=1) / 1e3
    polygons = np.split(places, drawn.start[1:-1]) if of_polygon.size else []
    return Shapes(polygons, of_polygon, np.flatnonzero(~has_cell))


def element_values(state: xr.Dataset, quantity: str) -> np.ndarray:
    """Thickness (m), concentration (1) or speed (m/s) of each element, (element,).

    Thickness is NaN where an element has no ice.

    Parameters
    ----------
    state : xarray.Dataset
        With n elements.
    quantity : str
        ``thickness``, ``concentration`` or ``speed``.

    Returns
    -------
    ndarray
        (element,).
    """
    if quantity == "speed":
        return np.hypot(state["u"].values, state["v"].values)
    fraction = state["ice_fraction"].values.sum(axis=1)
    if quantity == "concentration":
        return np.asarray(fraction)
    volume = state["ice_volume"].values.sum(axis=1)
    return np.divide(volume, fraction, out=np.full_like(volume, np.nan), where=fraction > 0)


def element_map(
    frame: Frame,
    state: xr.Dataset,
    shapes: Shapes,
    values: np.ndarray,
    quantity: Quantity,
    limits: tuple[float, float],
    title: str,
    arrows: tuple[np.ndarray, np.ndarray, str] | None = None,
) -> Figure:
    """Map the elements, coloured by a quantity.

    Parameters
    ----------
    frame : Frame
        Land, projection, extent.
    state : xarray.Dataset
        Where the elements are.
    shapes : Shapes
        Their outlines, from `element_shapes`.
    values : ndarray
        What colours them, (element,).
    quantity : Quantity
        Its name and colours.
    limits : tuple of float
        Ends of the colour scale.
    title : str
        Title.
    arrows : tuple, optional
        Components along x and y, (element,) each, and their unit; thinned to box means.

    Returns
    -------
    Figure
        Of Matplotlib, to be closed by the caller.
    """
    with look():
        figure = new_figure(*frame.size(WIDTH))
        axes = figure.add_subplot()
        prepare_axes(axes, frame, title, quantity.water)
        mobile = state["type"].values == MOBILE
        for collection, index in shape_collections(axes, state, shapes):
            colours = quantity.cmap(Normalize(*limits)(np.nan_to_num(values[index])))
            colours[~mobile[index]] = to_rgba(COAST)
            # A white outline tells few elements apart; of many it would hide the colours.
            edges = "#ffffff" if len(index) <= 3000 else colours
            collection.set(facecolor=colours, edgecolor=edges, linewidth=0.3)
            axes.add_collection(collection, autolim=False)
        beyond = bool(np.nanmax(values, initial=limits[1]) > limits[1])
        add_colour_bar(figure, axes, quantity, limits, beyond)
        if not mobile.any():
            say_no_ice(axes)
        elif arrows is not None:
            u, v, unit = arrows
            x, y = state["x"].values / 1e3, state["y"].values / 1e3
            draw_arrows(axes, frame, x[mobile], y[mobile], u[mobile], v[mobile], unit)
    return figure


def shape_collections(
    axes: Axes, state: xr.Dataset, shapes: Shapes
) -> list[tuple[Collection, np.ndarray]]:
    """Cells and discs of a state's elements for these axes, each with the elements' indices.

    Parameters
    ----------
    axes : Axes
        In km.
    state : xarray.Dataset
        Elements.
    shapes : Shapes
        Their cells and discs (km).

    Returns
    -------
    list of tuple of Collection and ndarray
        Collection, and the rows of its elements.
    """
    found: list[tuple[Collection, np.ndarray]] = []
    if shapes.of_polygon.size:
        found.append((PolyCollection(shapes.polygons, zorder=3), shapes.of_polygon))
    if shapes.of_disc.size:
        index = shapes.of_disc
        width = 2.0 * state["radius"].values[index] / 1e3
        offsets = np.stack([state["x"].values[index], state["y"].values[index]], axis=1) / 1e3
        discs = EllipseCollection(
            width,
            width,
            np.zeros_like(width),
            units="xy",
            offsets=offsets,
            offset_transform=axes.transData,
            zorder=2,
        )
        found.append((discs, index))
    return found


def add_colour_bar(
    figure: Figure, axes: Axes, quantity: Quantity, limits: tuple[float, float], beyond: bool
) -> None:
    """Colour bar of a quantity beside a map, pointed where values lie beyond its end.

    Parameters
    ----------
    figure : Figure
        That is drawn.
    axes : Axes
        Of the map.
    quantity : Quantity
        Its colours and label.
    limits : tuple of float
        Ends of the scale, in the unit of the label.
    beyond : bool
        Whether values lie beyond the upper end.
    """
    mappable = ScalarMappable(Normalize(*limits), quantity.cmap)
    extend = "max" if beyond else "neither"
    bar = figure.colorbar(mappable, ax=axes, shrink=0.86, pad=0.02, aspect=28, extend=extend)
    bar.set_label(quantity.label)
    bar.ax.tick_params(labelsize=8)
    bar.outline.set_linewidth(0.6)


def say_no_ice(axes: Axes) -> None:
    """Write it across the map.

    Parameters
    ----------
    axes : Axes
        Of the map.
    """
    axes.text(
        0.5,
        0.5,
        "no ice",
        transform=axes.transAxes,
        ha="center",
        fontsize=16,
        zorder=9,
        path_effects=HALO,
    )


def box_means(
    frame: Frame, x: np.ndarray, y: np.ndarray, *values: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Means of x, y and values in the boxes of a coarse lattice over the map, empty ones left out.

    Parameters
    ----------
    frame : Frame
        Its extent holds ``ARROWS`` boxes along the longer side.
    x, y : ndarray
        Places (km), (n,).
    values : ndarray
        (n,) each.

    Returns
    -------
    tuple of ndarray
        x, y (km) and each value in its unit, (boxes,) each.
    """
    left, right, bottom, top = frame.extent
    size = max(right - left, top - bottom) / ARROWS
    column, row = np.floor((x - left) / size), np.floor((y - bottom) / size)
    _, box, count = np.unique(row * 10 * ARROWS + column, return_inverse=True, return_counts=True)
    return tuple(np.bincount(box, part) / count for part in (x, y, *values))


def draw_arrows(
    axes: Axes,
    frame: Frame,
    x: np.ndarray,
    y: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    unit: str,
) -> None:
    """Arrows of box means with a key of a round length; nothing where all are at rest.

    Parameters
    ----------
    axes : Axes
        Of the figure.
    frame : Frame
        Extent (km) and projection of the map.
    x : ndarray
        Places (km), (n,).
    y : ndarray
        Places (km), (n,).
    u : ndarray
        Components, (n,).
    v : ndarray
        Components, (n,).
    unit : str
        Of the components.
    """
    x, y, u, v = box_means(frame, x, y, u, v)
    lengths = np.hypot(u, v)
    # Most arrows of a fitting length; the few fastest may reach further.
    typical = float(np.quantile(lengths, 0.95)) if lengths.any() else 0.0
    largest = typical or float(lengths.max(initial=0.0))
    if not largest > 0:
        axes.text(
            0.98,
            0.975,
            "at rest",
            transform=axes.transAxes,
            ha="right",
            va="top",
            fontsize=9,
            zorder=9,
        )
        return
    left, right, bottom, top = frame.extent
    box = max(right - left, top - bottom) / ARROWS
    arrows = axes.quiver(
        x,
        y,
        u,
        v,
        angles="xy",
        scale_units="xy",
        scale=largest / (1.6 * box),
        color=INK,
        width=0.0034,
        zorder=6,
        edgecolor="white",
        linewidth=0.35,
    )
    key = nice_step(largest, 2)
    axes.quiverkey(
        arrows,
        0.9,
        1.03,
        key,
        f"{key:g} {unit}",
        labelpos="W",
        fontproperties={"size": 8},
        labelsep=0.05,
    )
