# SPDX-License-Identifier: GPL-2.0-or-later
"""Movies of the map: one MP4 a field, one picture a window boundary, the same scale throughout.

A program of its own encodes them (ffmpeg, in the wheel of the package imageio-ffmpeg), so that
nothing but that optional package is needed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize

from floeflow.core.atomic_write import write_atomically
from floeflow.core.errors import FloeError
from floeflow.report.box_drift import box_drift
from floeflow.report.figures.frame import Frame, prepare_axes
from floeflow.report.figures.maps import add_colour_bar
from floeflow.report.figures.style import INK, look, new_figure
from floeflow.report.map_player import (
    FIELDS,
    Array,
    chosen_frames,
    field_frames,
    scale_ends,
    time_labels,
)

SHOWN = ("thickness", "drift", "damage", "deformation")
WIDTH, DPI = 8.0, 120  # inches
# Pictures a second: a movie lasts half a minute, if that is neither a slide show nor a blur.
SECONDS, SLOWEST, FASTEST = 30.0, 4.0, 25.0


def write_movies(
    grid: xr.Dataset, frame: Frame, title: str, start: datetime, window: float, folder: Path
) -> list[Path]:
    """Write a movie of each field of `SHOWN` that the grid holds.

    Parameters
    ----------
    grid : xarray.Dataset
        Gridded output at all times, concentration as a share, with ``window`` numbers.
    frame : Frame
        Land, projection, extent.
    title : str
        Of the scene.
    start : datetime
        The scene's start.
    window : float
        Length of a window (s).
    folder : Path
        Gets ``<field>.mp4``.

    Returns
    -------
    list of Path
        The movies.

    Raises
    ------
    FloeError
        Where the package imageio-ffmpeg is missing, or a movie cannot be written.
    """
    shown = grid.isel(time=chosen_frames(grid.sizes["time"]))
    labels = time_labels(start, shown["window"].values * window)
    rate = float(np.clip(len(labels) / SECONDS, SLOWEST, FASTEST))
    paths = []
    for name in SHOWN:
        values = field_frames(shown, name)
        if values is None:
            continue
        heads = [f"{title}: {FIELDS[name].title.lower()}, {at}" for at in labels]
        pictures = draw_pictures(shown, name, values, frame, heads)
        paths.append(folder / f"{name}.mp4")
        encode(pictures, paths[-1], rate)
    return paths


def draw_pictures(
    grid: xr.Dataset, name: str, values: Array, frame: Frame, titles: list[str]
) -> Iterator[np.ndarray]:
    """Pictures of a field, (height, width, 3) of bytes; both sizes even, as encoders ask.

    Parameters
    ----------
    grid : xarray.Dataset
        Gridded output, for the arrows of the drift.
    name : str
        Key in `FIELDS`.
    values : ndarray
        In the reader's unit, NaN where there is none, (time, y, x).
    frame : Frame
        Land, projection, extent.
    titles : list of str
        Of each picture.

    Yields
    ------
    ndarray
        Red, green and blue, 0 to 255, (height, width, 3).
    """
    field = FIELDS[name]
    quantity = replace(field.quantity, label=f"{field.title} ({field.unit})")
    low, high = scale_ends(quantity, values)
    with look():
        figure = new_figure(*frame.size(WIDTH))
        figure.set_dpi(DPI)
        axes = figure.add_subplot()
        prepare_axes(axes, frame, titles[0], quantity.water)
        picture = axes.imshow(
            values[0],
            extent=frame.extent,
            origin="lower",
            cmap=quantity.cmap,
            norm=Normalize(low, high),
            interpolation="nearest",
            zorder=3,
        )
        add_colour_bar(
            figure, axes, quantity, (low, high), bool(np.nanmax(values, initial=high) > high)
        )
        arrows, boxes = None, box_drift(grid) if name == "drift" else None
        if boxes is not None:
            x, y = boxes.places(frame.extent)
            step = x[1] - x[0] if x.size > 1 else frame.extent[1] - frame.extent[0]
            arrows = axes.quiver(
                *(x, y, *boxes.at(0)),
                angles="xy", scale_units="xy", scale=boxes.top / (1.3 * step), pivot="mid",
                color=INK, width=0.0028, zorder=6, edgecolor="white", linewidth=0.3,
            )  # fmt: skip
        figure.canvas.draw()
        # What stands where is settled by the first picture.
        figure.set_layout_engine("none")
        for k, text in enumerate(titles):
            picture.set_data(values[k])
            axes.set_title(text)
            if arrows is not None and boxes is not None:
                arrows.set_UVC(*boxes.at(k))
            assert isinstance(figure.canvas, FigureCanvasAgg)
            figure.canvas.draw()
            rgb = np.asarray(figure.canvas.buffer_rgba())[..., :3]
            rows, columns = (size - size % 2 for size in rgb.shape[:2])
            yield np.ascontiguousarray(rgb[:rows, :columns])


def encode(pictures: Iterable[np.ndarray], path: Path, rate: float) -> None:
    """Write pictures as an MP4 (H.264, which every browser plays), whole or not at all.

    Parameters
    ----------
    pictures : iterable of ndarray
        (height, width, 3) of bytes, all of one even size.
    path : Path
        The movie.
    rate : float
        Pictures a second.

    Raises
    ------
    FloeError
        Where the package imageio-ffmpeg is missing, or the movie cannot be written.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        raise FloeError(
            f"{path}: the package imageio-ffmpeg is not installed: "
            ".venv/bin/pip install 'floeflow[movies]'"
        ) from None
    # The same pictures give the same bytes. The name of the unfinished file tells no format.
    options = ["-f", "mp4", "-crf", "20", "-threads", "1", "-fflags", "+bitexact"]
    options += ["-flags:v", "+bitexact", "-movflags", "+faststart"]
    with write_atomically(path) as unfinished:
        writer = None
        try:
            for picture in pictures:
                if writer is None:
                    size = picture.shape[1], picture.shape[0]
                    writer = imageio_ffmpeg.write_frames(
                        str(unfinished), size, fps=rate, codec="libx264", quality=None,
                        macro_block_size=2, ffmpeg_log_level="error", output_params=options,
                    )  # fmt: skip
                    writer.send(None)
                writer.send(picture)
        finally:
            if writer is not None:
                writer.close()
