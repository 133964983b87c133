# SPDX-License-Identifier: GPL-2.0-or-later
"""Labels of ticks: the words of Matplotlib's own, without its parser of TeX."""

from __future__ import annotations

from pathlib import Path

import matplotlib.mathtext
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from floeflow.report.figures.style import as_svg, look, new_figure, write_png
from floeflow.report.figures.ticks import plain, plain_ticks


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.5", "0.5"),
        (r"$\mathdefault{0.25}$", "0.25"),
        ("$\\mathdefault{\N{MINUS SIGN}3}$", "\N{MINUS SIGN}3"),
        (r"$\mathdefault{10^{-3}}$", "10⁻³"),
        (r"$\mathdefault{2\times10^{12}}$", "2×10¹²"),
        ("$\\times\\mathdefault{10^{\N{MINUS SIGN}5}}\\mathdefault{}$", "×10⁻⁵"),
    ],
)
def test_tex_becomes_letters(text: str, expected: str) -> None:
    assert plain(text) == expected


def a_figure() -> Figure:
    with look():
        figure = new_figure(5.0, 2.0)
        linear, log = figure.subplots(1, 2)
        linear.plot([0.0, 1.0], [0.0, 3e7])
        log.loglog(10.0 ** np.arange(5), 10.0 ** -np.arange(5.0))
        log.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    return figure


def labels(figure: Figure) -> list[str]:
    """All labels of the ticks and offsets of a figure, drawn."""
    with look():
        figure.canvas.draw()
    axes = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    words = [text.get_text() for axis in axes for text in axis.get_ticklabels()]
    return words + [axis.get_offset_text().get_text() for axis in axes]


def test_all_labels_say_what_they_said() -> None:
    old, figure = labels(a_figure()), a_figure()
    plain_ticks(figure)
    new = labels(figure)
    assert new == [plain(word) for word in old] != old
    assert "×10⁷" in new and "10⁻²" in new
    # A formatter that a figure has chosen stays.
    assert "100" in new


def test_charts_and_maps_parse_no_tex(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("a label of a tick is TeX")

    monkeypatch.setattr(matplotlib.mathtext.MathTextParser, "parse", never)
    assert as_svg(a_figure()).startswith(b"<?xml")
    assert write_png(a_figure(), tmp_path / "a.png", 72)
