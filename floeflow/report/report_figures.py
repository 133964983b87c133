# SPDX-License-Identifier: GPL-2.0-or-later
"""All pictures of a report, in the order in which they stand.

Maps go into the page as PNG, charts as SVG; both lie beside the report as well.
Pairs of maps that are to be compared share their colour scale.
"""

from __future__ import annotations

import base64
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from floeflow.core.extensions import load_extensions
from floeflow.diagnostics.collect import displacement
from floeflow.diagnostics.run_cost import Stage
from floeflow.report.figures.analyses import analysis_figures
from floeflow.report.figures.bonds import bond_map, follows_start
from floeflow.report.figures.budgets import budget_figure
from floeflow.report.figures.cost import cost_figure
from floeflow.report.figures.frame import Frame
from floeflow.report.figures.maps import Shapes, element_map, element_shapes, element_values
from floeflow.report.figures.packing import packing_figures
from floeflow.report.figures.series import series_figures
from floeflow.report.figures.style import (
    CONCENTRATION,
    DISTANCE,
    SPEED,
    THICKNESS,
    Quantity,
    as_svg,
    common_limits,
    write_png,
)
from floeflow.scene import Scene

BONDS_OF_START = (
    "Bonds of the start between elements that are still there, as they are at the end: glue lines "
    "that are whole, cracked from an end, or gone, carried with the element of lower id. Those "
    "that froze anew are not drawn. Gaps between cells are leads."
)
BONDS_OF_END = (
    "Bonds of the end, those that froze anew among them: glue lines that are whole or cracked from "
    "an end. Elements were made anew in the run, so that no bond of the start can be followed. "
    "Gaps between cells are leads."
)
CAPTIONS = {
    "thickness": "Ice thickness of the elements (mean over the ice in each)",
    "concentration": "Ice concentration of the elements (share of each one's area under ice)",
    "speed": "Drift speed of the elements; arrows are means over boxes",
}
TITLES = {
    "thickness": "Ice thickness",
    "concentration": "Ice concentration",
    "speed": "Drift speed",
}


@dataclass(frozen=True)
class Picture:
    """A figure in the page."""

    name: str
    caption: str
    uri: str
    wide: bool = False


@dataclass(frozen=True)
class Easel:
    """Where figures are written and how finely."""

    folder: Path
    dpi: int

    def picture(self, name: str, caption: str, figure: Figure, wide: bool = False) -> Picture:
        """A map: PNG in the folder and in the page.

        Parameters
        ----------
        name : str
            Of the file, without ending.
        caption : str
            One sentence, with units.
        figure : Figure
            That is drawn.
        wide : bool, optional
            Over the whole width of the page.

        Returns
        -------
        Picture
            For the page.
        """
        data = write_png(figure, self.folder / f"{name}.png", self.dpi)
        return Picture(name, caption, _uri("image/png", data), wide)

    def chart(self, name: str, caption: str, figure: Figure) -> Picture:
        """A chart: SVG in the folder and in the page.

        Parameters
        ----------
        name : str
            Of the file, without ending.
        caption : str
            One sentence, with units.
        figure : Figure
            That is drawn.

        Returns
        -------
        Picture
            For the page.
        """
        data = as_svg(figure)
        (self.folder / f"{name}.svg").write_bytes(data)
        return Picture(name, caption, _uri("image/svg+xml", data))


def _uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def moments(scene: Scene, first: xr.Dataset, last: xr.Dataset) -> dict[str, str]:
    """Start and end of the run as text, by 'start' and 'end'.

    Parameters
    ----------
    scene : Scene
        Its start.
    first : xarray.Dataset
        States at the start and at the end.
    last : xarray.Dataset
        States at the start and at the end.

    Returns
    -------
    dict of str
        UTC.
    """
    texts = {}
    for name, state in (("start", first), ("end", last)):
        at = scene.time.start + timedelta(seconds=float(state.attrs["time"]))
        texts[name] = f"{at:%Y-%m-%d %H:%M} UTC"
    return texts


def speed_scale(scene: Scene) -> Quantity:
    """Drift speed with the scene's own top of the scale, if it sets one.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    Quantity
        m/s; without a top where the data set it.
    """
    top = scene.report.maximum_velocity
    return replace(SPEED, high=top if top > 0 else None)


def element_pictures(
    easel: Easel, scene: Scene, frame: Frame, first: xr.Dataset, last: xr.Dataset, cells: xr.Dataset
) -> Iterator[Picture]:
    """Maps of the elements at start and end, their displacement, and their bonds.

    Parameters
    ----------
    easel : Easel
        Where figures are written.
    scene : Scene
        Its effects and title.
    frame : Frame
        Extent and projection of the maps.
    first : xarray.Dataset
        States at the start and at the end.
    last : xarray.Dataset
        States at the start and at the end.
    cells : xarray.Dataset
        Polygons of the elements.

    Returns
    -------
    iterator of Picture
        One after the other.
    """
    when = moments(scene, first, last)
    states = {"start": first, "end": last}
    shapes = {name: element_shapes(state, cells) for name, state in states.items()}
    for quantity in (THICKNESS, CONCENTRATION, speed_scale(scene)):
        fields = {name: element_values(s, quantity.name) for name, s in states.items()}
        limits = common_limits(quantity, *fields.values())
        for name, state in states.items():
            moves = quantity.name == "speed"
            # How it began is told once, by thickness; the slider shows the rest.
            if name == "start" and quantity is not THICKNESS:
                continue
            arrows = (state["u"].values, state["v"].values, "m/s") if moves else None
            title = f"{TITLES[quantity.name]}, {name}: {when[name]}"
            figure = element_map(
                frame, state, shapes[name], fields[name], quantity, limits, title, arrows
            )
            caption = f"{CAPTIONS[quantity.name]}, {name} of the run."
            yield easel.picture(f"elements_{quantity.name}_{name}", caption, figure)
    yield _displacement_picture(easel, frame, first, last, shapes["end"])
    if "bonds" in scene.effects:
        yield easel.picture(
            "elements_bonds",
            BONDS_OF_START if follows_start(last) else BONDS_OF_END,
            bond_map(frame, first, last, shapes["end"], f"Bonds, {when['end']}"),
            wide=True,
        )


def _displacement_picture(
    easel: Easel, frame: Frame, first: xr.Dataset, last: xr.Dataset, shapes: Shapes
) -> Picture:
    moved, step = displacement(first, last)
    place = np.searchsorted(last["id"].values, moved["id"].values)
    along = np.zeros((last.sizes["element"], 2))
    along[place] = step / 1e3
    distance = np.hypot(along[:, 0], along[:, 1])
    figure = element_map(
        frame,
        last,
        shapes,
        distance,
        DISTANCE,
        common_limits(DISTANCE, distance),
        "Net displacement in the run",
        (along[:, 0], along[:, 1], "km"),
    )
    caption = "Net displacement of the elements from the start to the end, drawn at their end."
    return easel.picture("elements_displacement", caption, figure)


# Charts that extensions add: name, caption and figure of each, from scene and ``diagnostics.nc``.
Charts = Callable[[Scene, xr.Dataset], Iterator[tuple[str, str, Figure]]]
ADDED: list[Charts] = []


def charts(function: Charts) -> Charts:
    """Register a function that draws further charts of the series.

    Parameters
    ----------
    function : callable
        Yields name, caption and figure.

    Returns
    -------
    callable
        The function itself.
    """
    ADDED.append(function)
    return function


def series_pictures(easel: Easel, scene: Scene, data: xr.Dataset) -> Iterator[Picture]:
    """Time series that the scene's effects bring, and those of extensions.

    Parameters
    ----------
    easel : Easel
        Where figures are written.
    scene : Scene
        Its effects and start.
    data : xarray.Dataset
        Of ``diagnostics.nc``.

    Returns
    -------
    iterator of Picture
        One after the other.
    """
    load_extensions()
    start = f"{scene.time.start:%Y-%m-%d %H:%M}"
    drawn = [series_figures(data, start, scene.effects), *(each(scene, data) for each in ADDED)]
    for name, caption, figure in itertools.chain(*drawn):
        yield easel.chart(name, caption, figure)


def analysis_pictures(easel: Easel, scene: Scene, data: xr.Dataset) -> Iterator[Picture]:
    """Analyses of ice and motion, as far as the run supports them.

    Parameters
    ----------
    easel : Easel
        Where figures are written.
    scene : Scene
        Its start.
    data : xarray.Dataset
        Of ``analyses.nc``.

    Returns
    -------
    iterator of Picture
        One after the other.
    """
    for name, caption, figure in analysis_figures(data, scene.time.start):
        yield easel.chart(name, caption, figure)


def packing_pictures(easel: Easel, packing: xr.Dataset) -> Iterator[Picture]:
    """How the elements of the start are distributed.

    Parameters
    ----------
    easel : Easel
        Where figures are written.
    packing : xarray.Dataset
        Elements of the start.

    Yields
    ------
    Picture
        One for each distribution.
    """
    for name, caption, figure in packing_figures(packing):
        yield easel.chart(name, caption, figure)


def budget_pictures(easel: Easel, budgets: Sequence[Mapping[str, Any]]) -> Iterator[Picture]:
    """Budgets as bars; those with nothing but a residual stand in the table only.

    Parameters
    ----------
    easel : Easel
        Where figures are written.
    budgets : sequence of mapping of object
        Of ``diagnostics.json``.

    Returns
    -------
    iterator of Picture
        One after the other.
    """
    for budget in budgets:
        if len(budget["terms"]) > 1:
            caption = f"{budget['label']}: what changed it over all windows."
            yield easel.chart(f"budget_{budget['name']}", caption, budget_figure(budget))


def cost_pictures(easel: Easel, stages: Sequence[Stage]) -> Iterator[Picture]:
    """Cost of the stages as bars.

    Parameters
    ----------
    easel : Easel
        Where figures are written.
    stages : sequence of Stage
        With wall time (s).

    Returns
    -------
    iterator of Picture
        One.
    """
    rows = [(f"  {s.name}" if s.inner else s.name, s.seconds, s.inner) for s in stages]
    caption = "Wall time by stage; hatched: parts of the windows."
    yield easel.chart("cost_stages", caption, cost_figure(rows))
