# SPDX-License-Identifier: GPL-2.0-or-later
"""Orders of convergence and what Richardson's extrapolation says of the limit."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

# Below this order or above, a sequence is not taken for convergent.
LEAST_ORDER, MOST_ORDER = 0.3, 5.0


def observed_order(levels: Sequence[float], steps: Sequence[float]) -> float:
    """Order p from differences of neighbouring levels, |u_k - u_(k+1)| ~ level ** p.

    Parameters
    ----------
    levels : sequence of float
        From fine to coarse, n of them.
    steps : sequence of float
        Distance of each level's result from that of the next coarser one, n - 1.

    Returns
    -------
    float
        Least-squares slope over the three finest pairs; NaN where a step is not positive or there
        are fewer than two.
    """
    pairs = [
        (math.log(levels[k]), math.log(step))
        for k, step in enumerate(steps)
        if step > 0 and math.isfinite(step)
    ][:3]
    if len(pairs) < 2 or len(steps) < 2:
        return math.nan
    x, y = zip(*pairs, strict=True)
    return float(np.polyfit(x, y, 1)[0])


def tail(levels: Sequence[float], step: float, order: float) -> float:
    """Error that the finest level still has: |u_0 - u_1| / (r^p - 1), Richardson (1911).

    Infinite where the sequence does not converge.

    Parameters
    ----------
    levels : sequence of float
        Finest first.
    step : float
        Difference between the two finest.
    order : float
        Observed order of convergence p.

    Returns
    -------
    float
        In the unit of ``step``.
    """
    if not LEAST_ORDER <= order <= MOST_ORDER:
        return math.inf
    return step / ((levels[1] / levels[0]) ** order - 1.0)


def with_tail(
    levels: Sequence[float], errors: Sequence[float], steps: Sequence[float]
) -> tuple[list[float], float, bool]:
    """Errors against the limit instead of the finest level.

    Parameters
    ----------
    levels, errors, steps : sequence of float
        From fine to coarse; errors against the finest level (the first is 0); steps as in
        `observed_order`.

    Returns
    -------
    tuple of list of float, float and bool
        Errors, the observed order, and whether the sequence converges. Where it does not, the
        finest level gets its distance from the next one as error.
    """
    order = observed_order(levels, steps)
    rest = tail(levels, steps[0], order) if steps else math.inf
    converges = math.isfinite(rest)
    if not converges:
        rest = steps[0] if steps else 0.0
    # u_k - u_0 and u_0 - u_limit point the same way where the sequence converges.
    return [rest, *(error + rest for error in errors[1:])], order, converges
