# SPDX-License-Identifier: GPL-2.0-or-later
"""One look for all figures: type, colours, colour maps, and how a figure becomes a file.

Colour maps are cmocean's sequential ones, whose lightness is monotonic: they survive a black and
white print and the common forms of colour blindness. Lines and bars take the colours of Okabe and
Ito (2008) and differ in dash or hatch as well. Figures are made without pyplot, so there is no
global state and any number of them can be made side by side.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, to_rgba
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from matplotlib.typing import ColorType

from floeflow.core.atomic_write import write_atomically
from floeflow.report.figures.ticks import plain_ticks

# cmocean builds its maps with an argument that matplotlib is about to drop, and warns of each.
with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)
    import cmocean

INK, FAINT = "#1d2733", "#6b7885"
BLUE, VERMILION, GREEN, ORANGE, SKY = "#0072b2", "#d55e00", "#009e73", "#e69f00", "#56b4e9"
WATER, LAND, COAST = "#dce6ee", "#b9b4aa", "#7d776c"

# Typed loosely: matplotlib's stubs list the names it has, which differ between its versions.
_SETTINGS: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 5),
    "axes.formatter.use_mathtext": True,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "hatch.linewidth": 0.6,
    # Reproducible names in SVG, and its letters as outlines, so that any browser draws them alike.
    "svg.hashsalt": "floeflow",
    "svg.fonttype": "path",
}


@dataclass(frozen=True)
class Quantity:
    """How a mapped quantity is named and coloured.

    Parameters
    ----------
    name : str
        Part of the file name.
    label : str
        With unit, beside the colour bar.
    colours : str
        Name of a cmocean map.
    low, high : float or None
        Ends of the scale; None: from the data, the low one at most 0.
    share : float
        Share of the data below the upper end, and above the lower one, where that comes from the
        data: a few fast elements must not bleach all others.
    signed : bool
        Values of both signs, on a scale that is pale at 0 and reaches as far to both sides.
    """

    name: str
    label: str
    colours: str
    low: float | None = 0.0
    high: float | None = None
    share: float = 1.0
    signed: bool = False

    @property
    def cmap(self) -> Colormap:
        """The colour map without its darkest parts, in which outlines and print would drown."""
        full = getattr(cmocean.cm, self.colours)
        dark_first = self.colours == "ice"
        which = "both" if self.signed else "min" if dark_first else "max"
        crop: Colormap = cmocean.tools.crop_by_percent(full, 30 if dark_first else 12, which=which)
        return crop

    @property
    def water(self) -> ColorType:
        """Colour of open water: where the scale tells ice from none, its own zero."""
        return to_rgba(self.cmap(0.0)) if self.colours == "ice" else WATER


CONCENTRATION = Quantity("concentration", "Ice concentration (1)", "ice", 0.0, 1.0)
THICKNESS = Quantity("thickness", "Ice thickness (m)", "dense")
VOLUME = Quantity("volume", "Ice volume per area (m)", "dense")
SNOW = Quantity("snow", "Snow thickness on ice (m)", "tempo")
SPEED = Quantity("speed", "Drift speed (m/s)", "amp", share=0.99)
DISTANCE = Quantity("distance", "Net displacement (km)", "amp", share=0.99)


@contextmanager
def look() -> Iterator[None]:
    """Draw with the report's look; figures made inside keep it."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_SETTINGS)
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure (inches) with room made for labels as they come.

    Parameters
    ----------
    width : float
        inches.
    height : float
        inches.

    Returns
    -------
    Figure
        With constrained layout.
    """
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def style_axes(axes: Axes, x: str, y: str) -> None:
    """Labels, a faint grid, no box.

    Parameters
    ----------
    axes : Axes
        Of the figure.
    x : str
        Labels of the axes, with units.
    y : str
        Labels of the axes, with units.
    """
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(color=FAINT, alpha=0.25, linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    # Labels between the powers of ten cost more time than the rest of a figure.
    for scale, name in ((axes.xaxis, axes.get_xscale()), (axes.yaxis, axes.get_yscale())):
        if name == "log":
            scale.set_minor_formatter(NullFormatter())


def write_png(figure: Figure, path: Path, dpi: int) -> bytes:
    """Write a figure as PNG, and return its bytes.

    Parameters
    ----------
    figure : Figure
        That is drawn.
    path : Path
        PNG file.
    dpi : int
        Pixels per inch.

    Returns
    -------
    bytes
        Of the file.

    Raises
    ------
    FloeError
        Where it cannot be written.
    """
    with look(), write_atomically(path) as temporary:
        plain_ticks(figure)
        figure.savefig(temporary, dpi=dpi, format="png", metadata={"Software": "FloeFlow"})
    return path.read_bytes()


def as_svg(figure: Figure) -> bytes:
    """A figure as SVG without a date.

    Parameters
    ----------
    figure : Figure
        That is drawn.

    Returns
    -------
    bytes
        The same for the same figure.
    """
    buffer = io.BytesIO()
    with look():
        plain_ticks(figure)
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


def common_limits(quantity: Quantity, *fields: np.ndarray) -> tuple[float, float]:
    """Colour limits for maps that are to be compared: the quantity's own, else of the data.

    Parameters
    ----------
    quantity : Quantity
        Its fixed ends come first.
    fields : ndarray
        Values of any shape; those that are not finite do not count.

    Returns
    -------
    tuple of float
        Low and high, low < high also for constant or absent data.
    """
    values = np.concatenate([np.ravel(field) for field in fields]) if fields else np.zeros(0)
    values = values[np.isfinite(values)]
    low = quantity.low
    if low is None:
        low = min(0.0, float(np.quantile(values, 1.0 - quantity.share))) if values.size else 0.0
    high = quantity.high
    if high is None:
        high = float(np.quantile(values, quantity.share)) if values.size else low
    return low, high if high > low else low + 1.0


def nice_step(span: float, most: int) -> float:
    """Smallest of 1, 2, 5 x 10^n that cuts a span into at most that many parts.

    Parameters
    ----------
    span : float
        Positive, in any unit.
    most : int
        Number of parts.

    Returns
    -------
    float
        In the unit of the span.
    """
    if not span > 0:
        return 1.0
    raw = span / most
    base = 10.0 ** np.floor(np.log10(raw))
    return float(next(base * k for k in (1, 2, 5, 10) if base * k >= raw * (1 - 1e-12)))
