# SPDX-License-Identifier: GPL-2.0-or-later
"""Movies of the map: pictures with the field's colours, a file that a decoder reads back."""

from __future__ import annotations

import builtins
from datetime import datetime
from pathlib import Path
from types import SimpleNamespace

import imageio_ffmpeg
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from floeflow.core.errors import FloeError
from floeflow.report.box_drift import box_drift
from floeflow.report.figures.style import LAND
from floeflow.report.map_player import FIELDS, field_frames
from floeflow.report.movies import draw_pictures, encode, write_movies
from support.scripts import load_script
from support.synthetic import Run
from unit.report.test_map_player import TIMES, frame, grid

START = datetime(1982, 1, 1)


def has_colour(picture: np.ndarray, colour: tuple[float, ...]) -> bool:
    """Whether a hundredth of a picture has a colour, to two levels of 255."""
    away = np.abs(picture.astype(float) - 255.0 * np.array(colour[:3])).max(axis=-1)
    return bool((away < 2.0).mean() > 0.01)


def test_pictures_have_the_colours_of_their_values() -> None:
    data = grid()
    values = field_frames(data, "thickness")
    assert values is not None
    titles = [f"day {k}" for k in range(TIMES)]
    pictures = list(draw_pictures(data, "thickness", values, frame(), titles))
    assert len(pictures) == TIMES
    cmap = FIELDS["thickness"].quantity.cmap
    for k, picture in enumerate(pictures):
        assert picture.dtype == np.uint8 and not (np.array(picture.shape[:2]) % 2).any()
        # Ice of 1, 2 and 3 m on one scale from 0 to 3 m, and the land.
        for other in range(TIMES):
            assert has_colour(picture, cmap((1 + other) / 3.0)) == (other == k)
        assert has_colour(picture, to_rgb(LAND))


def test_arrows_point_where_the_ice_goes() -> None:
    boxes = box_drift(grid())
    assert boxes is not None
    x, y = boxes.places(frame().extent)
    u, v = boxes.at(1)
    ice = np.isfinite(u)
    assert ice.any() and (u[ice] > 0.0).all() and not v[ice].any()
    # The ice lies in the lower left quarter.
    across, up = np.meshgrid(x, y)
    assert across[ice].max() < 0.0 and up[ice].max() < 0.0
    assert boxes.top == pytest.approx(0.1)


def test_movies_are_read_back_and_repeat_themselves(tmp_path: Path) -> None:
    folders = tmp_path / "one", tmp_path / "two"
    for folder in folders:
        paths = write_movies(grid(), frame(), "A pack", START, 86400.0, folder)
        # No damage and no deformation without their variables.
        assert [path.name for path in paths] == ["thickness.mp4", "drift.mp4"]
        assert sorted(path.name for path in folder.iterdir()) == ["drift.mp4", "thickness.mp4"]
    for name in ("thickness.mp4", "drift.mp4"):
        assert (folders[0] / name).read_bytes() == (folders[1] / name).read_bytes()
    frames = imageio_ffmpeg.read_frames(str(folders[0] / "thickness.mp4"))
    told = next(frames)
    assert told["codec"] == "h264" and told["pix_fmt"].startswith("yuv420p")
    width, height = told["size"]
    first, *rest = (np.frombuffer(each, np.uint8).reshape(height, width, 3) for each in frames)
    assert len(rest) == TIMES - 1
    # Colours come back but for what the compression takes.
    cmap = FIELDS["thickness"].quantity.cmap
    for k, picture in enumerate((first, *rest)):
        wanted = 255.0 * np.array(cmap((1 + k) / 3.0)[:3])
        away = np.abs(picture.astype(float) - wanted).max(axis=-1)
        assert (away < 12.0).mean() > 0.02, k


def test_the_rule_makes_the_movies_of_a_run(run: Run, tmp_path: Path) -> None:
    movies = tmp_path / "movies"
    movies.mkdir()
    (movies / "old.mp4").touch()
    load_script("postprocess/movie_files").main(
        SimpleNamespace(
            input=SimpleNamespace(
                scene=str(run.scene_file),
                grid=str(run.grid),
                mask=str(run.folder / "preprocess/mask.nc"),
            ),
            output=SimpleNamespace(movies=str(movies)),
        )
    )
    assert "thickness.mp4" in {path.name for path in movies.iterdir()}
    assert not (movies / "old.mp4").exists()


def test_without_the_package_a_sentence_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = builtins.__import__

    def none(name: str, *more: object) -> object:
        if name == "imageio_ffmpeg":
            raise ImportError(name)
        return plain(name, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", none)
    with pytest.raises(FloeError, match=r"a\.mp4: .*imageio-ffmpeg is not installed.*movies"):
        encode([], tmp_path / "a.mp4", 4.0)
