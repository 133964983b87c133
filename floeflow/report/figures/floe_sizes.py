# SPDX-License-Identifier: GPL-2.0-or-later
"""Floe sizes: how many are larger, a power law and a lognormal beside them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from scipy.special import ndtr

from floeflow.report.figures.style import BLUE, FAINT, INK, VERMILION, look, new_figure


def floe_figures(data: xr.Dataset) -> Iterator[tuple[str, str, Figure]]:
    """Draw the floes of start and end, as far as the run resolves them.

    Parameters
    ----------
    data : xarray.Dataset
        Of ``diagnostics.nc``.

    Returns
    -------
    iterator of tuple
        Name, caption and figure.
    """
    for word in ("start", "end"):
        name = f"floe_diameter_{word}"
        if name in data:
            yield _floes(data[name], word)


def _floes(floes: xr.DataArray, word: str) -> tuple[str, str, Figure]:
    sizes = np.sort(floes.values)
    larger = 1.0 - np.arange(sizes.size) / sizes.size
    told = f"{sizes.size} floes of more than 10 elements at the {word} of the run"
    with look():
        figure = new_figure(6.0, 3.3)
        axes = figure.add_subplot()
        axes.loglog(sizes / 1e3, larger, ".", color=INK, label="floes")
        if "power_law_exponent" in floes.attrs:
            fit = {key: float(value) for key, value in floes.attrs.items() if key not in SAID}
            start, exponent = fit["power_law_from"], fit["power_law_exponent"]
            x = np.geomspace(start, sizes[-1], 80)
            share = float((sizes >= start).mean())
            law = share * (x / start) ** (1.0 - exponent)
            axes.loglog(x / 1e3, law, "-", color=BLUE, label="power law")
            z = (np.log(np.append(start, x)) - fit["lognormal_mean"]) / fit["lognormal_spread"]
            above = ndtr(-z)
            axes.loglog(
                x / 1e3, share * above[1:] / above[0], "--", color=VERMILION, label="lognormal"
            )
            goodness = 100.0 * fit["power_law_goodness"]
            told += (
                f", n(d) ~ d^−a with a = {exponent:.2f} ± {fit['power_law_error']:.2f} above "
                f"{start / 1e3:.3g} km by maximum likelihood; {goodness:.0f} "
                "% of samples of that law fit it worse (below 10 %: ruled out); ratio of "
                f"likelihoods to the lognormal {fit['likelihood_ratio']:+.1f} standard deviations"
            )
        axes.set_xlabel("Diameter of a disc of the floe's area (km)")
        axes.set_ylabel("Share of floes that are larger")
        axes.grid(color=FAINT, alpha=0.25, linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(fontsize=8.5)
    caption = f"Floes are fragments of elements that bonds hold together: {told}."
    return f"floe_sizes_{word}", caption, figure


SAID = ("units", "long_name")
