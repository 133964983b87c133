# SPDX-License-Identifier: GPL-2.0-or-later
"""Labels of ticks in plain letters.

Matplotlib writes powers of ten, and all labels of an axis that may have one, in TeX's mathematics,
whose parser takes nearly half of the time of a report. Raised digits of the font say the same.
"""

from __future__ import annotations

import re
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import Formatter, LogFormatterSciNotation, ScalarFormatter

_RAISED = str.maketrans("-\N{MINUS SIGN}+0123456789", "⁻⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹")


def plain(text: str) -> str:
    r"""What Matplotlib's tick labels say in TeX, such as $2\times10^{-3}$, in letters: 2×10⁻³.

    Parameters
    ----------
    text : str
        A tick's label.

    Returns
    -------
    str
        Without TeX.
    """
    if "$" not in text:
        return text
    text = text.replace("$", "").replace(r"\times", "×")
    text = re.sub(r"\^\{(.*?)\}", lambda found: found[1].translate(_RAISED), text)
    return re.sub(r"\\mathdefault\{(.*?)\}", r"\1", text)


class PlainScalar(ScalarFormatter):
    """Matplotlib's labels of linear scales."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Label of a tick."""
        return plain(super().__call__(x, pos))

    def get_offset(self) -> str:
        """Power of ten of the whole axis."""
        return plain(super().get_offset())


class PlainLog(LogFormatterSciNotation):
    """Matplotlib's labels of logarithmic scales."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Label of a tick."""
        return plain(str(super().__call__(x, pos)))


PLAIN: dict[type[Formatter], type[Any]] = {
    ScalarFormatter: PlainScalar,
    LogFormatterSciNotation: PlainLog,
}


def plain_ticks(figure: Figure) -> None:
    """Let axes label their ticks in letters, where their formatter is one of Matplotlib's own.

    Parameters
    ----------
    figure : Figure
        That is drawn.
    """
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            for kind in ("major", "minor"):
                old = getattr(axis, f"get_{kind}_formatter")()
                if type(old) not in PLAIN:
                    continue
                new = PLAIN[type(old)]()
                # Its settings, which the figure's axes may have changed.
                new.__dict__.update(old.__dict__)
                getattr(axis, f"set_{kind}_formatter")(new)
