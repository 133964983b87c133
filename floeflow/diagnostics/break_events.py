# SPDX-License-Identifier: GPL-2.0-or-later
"""When and where bonds break: how the breaks cluster in time, and events of neighbours.

In time, the samples of the motion tell how many bonds broke between them. Counts of independent
breaks at a steady rate (a Poisson process) have a variance equal to their mean at every length of
the counting interval: a Fano factor of 1. Cascades raise it, and so does a rate that changes with
the wind. The Allan factor compares neighbouring intervals only, so that a slowly changing rate
leaves it at 1 (Lowen & Teich 1996, for point processes).

In space, an element at which bonds broke in a window is known from the length of its outline that
bonds hold. Such elements that are neighbours are one event. Both are laid beside the same number of
elements drawn at random, since in a pack of which much breaks neighbours meet by chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.diagnostics.deformation import triangles
from floeflow.diagnostics.floe_sizes import fragments
from floeflow.diagnostics.followed import ICE
from floeflow.state.schema import MOBILE
from floeflow.state.snapshots import BONDED, bonded_length

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]
Rows = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]

# Counts are compared over at least so many intervals.
INTERVALS = 8
# A burst lasts while breaks come faster than so many times the mean of the run.
FAST = 2.0
# Breaks soon after a window's start are those in this share of it.
SOON = 0.125
# An element lost a bond where its held outline fell by more than this share of the spacing: half of
# a side of a hexagon.
LOST = 0.29
# Drawings of as many elements at random.
DRAWN = 20


def breaks_between_samples(samples: xr.Dataset) -> tuple[Array, Index]:
    """Bonds that broke between the samples of the motion.

    Parameters
    ----------
    samples : xarray.Dataset
        With ``sample_window``, ``time`` (s) and ``intact_bonds``; nothing breaks between windows.

    Returns
    -------
    tuple of ndarray
        Ends of the intervals (s) and numbers of breaks, (interval,).
    """
    number, time = samples["sample_window"].values, samples["time"].values
    inside = number[1:] == number[:-1]
    lost = -np.diff(samples["intact_bonds"].values)
    return np.asarray(time[1:][inside], dtype=np.float64), lost[inside].astype(np.int64)


def soon_share(samples: xr.Dataset) -> float:
    """Share of the breaks that come in the first `SOON` of a window (1); NaN where none broke.

    Bonds freeze between windows. Where many of them break at once in the next one, breaks follow
    the windows and not the wind.

    Parameters
    ----------
    samples : xarray.Dataset
        As for `breaks_between_samples`.

    Returns
    -------
    float
        From 0 to 1; the length of `SOON` where breaks do not follow the windows.
    """
    number, time = samples["sample_window"].values, samples["time"].values
    soon = broken = 0
    for window in np.unique(number):
        held, at = samples["intact_bonds"].values[number == window], time[number == window]
        early = at <= at[0] + SOON * (at[-1] - at[0]) * (1.0 + 1e-9)
        soon += int(held[0] - held[early][-1])
        broken += int(held[0] - held[-1])
    return soon / broken if broken else np.nan


@dataclass(frozen=True)
class Dispersion:
    """How counts scatter, by the length of the interval in which breaks are counted.

    Attributes
    ----------
    steps : ndarray
        Lengths in intervals between samples: 1, 2, 4, ..., (length,).
    blocks : ndarray
        Numbers of such intervals, (length,).
    fano, allan : ndarray
        Variance of the counts over their mean, and half of the mean square of the difference of
        neighbours over it (1), (length,); both 1 for independent breaks at a steady rate.
    """

    steps: Index
    blocks: Index
    fano: Array
    allan: Array


def dispersion(counts: Index) -> Dispersion:
    """Fano and Allan factors of counts in intervals of one length.

    Parameters
    ----------
    counts : ndarray
        Breaks, (interval,).

    Returns
    -------
    Dispersion
        Of no length where nothing broke, or where there are fewer than `INTERVALS` intervals.
    """
    steps, blocks, fano, allan = [], [], [], []
    step = 1
    while counts.any() and counts.size // step >= INTERVALS:
        many = counts.size // step
        # What is left over at the end belongs to no interval of this length.
        sums = counts[: many * step].reshape(many, step).sum(axis=1).astype(np.float64)
        mean = max(float(sums.mean()), np.finfo(float).tiny)
        steps.append(step)
        blocks.append(many)
        fano.append(float(sums.var(ddof=1)) / mean)
        allan.append(0.5 * float((np.diff(sums) ** 2).mean()) / mean)
        step *= 2
    return Dispersion(np.array(steps, int), np.array(blocks, int), np.array(fano), np.array(allan))


def busy_share(counts: Index) -> float:
    """Least share of the time in which half of all bonds broke (1); NaN where none broke.

    Parameters
    ----------
    counts : ndarray
        Breaks in intervals of one length, (interval,).

    Returns
    -------
    float
        At most a half, which breaks at an even rate have.
    """
    if not counts.any():
        return np.nan
    carried = np.concatenate([np.zeros(1), np.cumsum(np.sort(counts)[::-1])]) / counts.sum()
    # Where the half is reached; intervals without breaks, at the end, add nothing to it.
    at = int(np.searchsorted(carried, 0.5))
    part = (0.5 - carried[at - 1]) / (carried[at] - carried[at - 1])
    return float((at - 1 + part) / counts.size)


def bursts(counts: Index) -> tuple[Index, Index]:
    """Spells in which breaks come faster than `FAST` times their mean.

    Parameters
    ----------
    counts : ndarray
        Breaks in intervals of one length, (interval,).

    Returns
    -------
    tuple of ndarray
        Breaks of each burst and its length in intervals, (burst,).
    """
    fast = counts > FAST * counts.mean() if counts.size else np.zeros(0, dtype=bool)
    turns = np.diff(np.concatenate([[0], fast.astype(np.int64), [0]]))
    first, end = np.flatnonzero(turns == 1), np.flatnonzero(turns == -1)
    total = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
    return total[end] - total[first], end - first


def neighbour_ratio(broken: Mask, pairs: Index) -> float:
    """How often both of two neighbours are broken, over how often both would be by chance.

    The join count of Moran (1948), drawing without replacement.

    Parameters
    ----------
    broken : ndarray
        Elements at which bonds broke, (element,).
    pairs : ndarray
        Rows of neighbours, (pair, 2).

    Returns
    -------
    float
        1 where breaks fall at random; NaN where fewer than two elements are broken.
    """
    chosen, n = int(broken.sum()), broken.size
    if chosen < 2 or not len(pairs):
        return np.nan
    by_chance = chosen * (chosen - 1) / (n * (n - 1))
    return float(broken[pairs].all(axis=1).mean() / by_chance)


def event_labels(broken: Mask, pairs: Index) -> Index:
    """Number of the event, from 0, of each broken element in the order of their rows, (broken,).

    Parameters
    ----------
    broken : ndarray
        Elements at which bonds broke, (element,).
    pairs : ndarray
        Rows of neighbours, (pair, 2).

    Returns
    -------
    ndarray
        Broken neighbours have the same number, (broken,).
    """
    return fragments(np.flatnonzero(broken), pairs)


def mean_event(labels: Index) -> float:
    """Mean size of the event of a broken element, in elements; NaN without events.

    Parameters
    ----------
    labels : ndarray
        From `event_labels`.

    Returns
    -------
    float
        At least 1; the mean over elements, so that large events weigh by their size.
    """
    sizes = np.bincount(labels).astype(np.float64)
    return float((sizes**2).sum() / sizes.sum()) if sizes.size else np.nan


@dataclass(frozen=True)
class WindowBreaks:
    """Where bonds broke in a window.

    Attributes
    ----------
    time : float
        Its end (s).
    share : float
        Of the elements that lost a bond (1).
    ratio : float
        From `neighbour_ratio`.
    mean, random : float
        Mean size of a broken element's event, and of as many elements at random (elements).
    elements : ndarray
        Of each event, (event,).
    length : ndarray
        Held outline that each event lost, counted once a bond (m), (event,).
    """

    time: float
    share: float
    ratio: float
    mean: float
    random: float
    elements: Index
    length: Array


def window_breaks(time: float, lost: Array, pairs: Index, spacing: float) -> WindowBreaks:
    """Events of one window.

    Parameters
    ----------
    time : float
        Its end (s).
    lost : ndarray
        Fall of the outline that bonds hold (m), (element,).
    pairs : ndarray
        Rows of neighbours, (pair, 2).
    spacing : float
        Of the elements (m).

    Returns
    -------
    WindowBreaks
        Without events where no element lost a bond.
    """
    broken = lost > LOST * spacing
    labels = event_labels(broken, pairs)
    # The same drawings for the same window, so that a report is the same again.
    rng = np.random.default_rng(broken.size)
    drawn = [mean_event(event_labels(rng.permutation(broken), pairs)) for _ in range(DRAWN)]
    return WindowBreaks(
        time,
        float(broken.mean()) if broken.size else 0.0,
        neighbour_ratio(broken, pairs),
        mean_event(labels),
        float(np.mean(drawn)),
        np.bincount(labels).astype(np.int64),
        # What a bond held is missing at both of its elements.
        0.5 * np.bincount(labels, lost[broken]).astype(np.float64),
    )


@dataclass(frozen=True)
class _Held:
    """Elements with ice and the length that bonds hold of each."""

    window: int
    time: float
    id: Index
    x: Array
    y: Array
    held: Array
    spacing: float


@dataclass
class BreakEvents:
    """Where bonds break, gathered boundary by boundary.

    Parameters
    ----------
    remapped : set of int
        Windows at whose end ice was remapped: nothing is known of where bonds broke in them.
    """

    remapped: set[int]
    windows: list[WindowBreaks] = field(default_factory=list)
    _before: _Held | None = None

    def take(self, state: xr.Dataset) -> None:
        """Go on by one boundary; nothing without bonds.

        Parameters
        ----------
        state : xarray.Dataset
            State or snapshot.
        """
        if BONDED not in state and "bond_id_lo" not in state:
            return
        before, now = self._before, _held(state)
        self._before = now
        if before is None or now.window != before.window + 1 or now.window in self.remapped:
            return
        corners = triangles(before.x, before.y, before.spacing)
        sides = np.sort(np.concatenate([corners[:, k] for k in ([0, 1], [1, 2], [2, 0])]), 1)
        pairs = np.unique(sides, axis=0)
        _, i, j = np.intersect1d(before.id, now.id, assume_unique=True, return_indices=True)
        there = np.zeros(before.id.size, dtype=bool)
        there[i] = True
        # Beside an element that left or merged bonds are gone that did not break.
        beside = np.unique(pairs[~there[pairs].all(axis=1)])
        lost = np.zeros(before.id.size)
        lost[i] = before.held[i] - now.held[j]
        there[beside] = False
        kept = np.flatnonzero(there)
        row = np.full(before.id.size, -1)
        row[kept] = np.arange(kept.size)
        pairs = row[pairs]
        pairs = pairs[(pairs >= 0).all(axis=1)]
        self.windows.append(window_breaks(now.time, lost[kept], pairs, before.spacing))


def _held(state: xr.Dataset) -> _Held:
    held = state[BONDED].values if BONDED in state else bonded_length(state)
    share = state["ice_fraction"].values.sum(axis=1)
    kept = np.flatnonzero((state["type"].values == MOBILE) & (share >= ICE))
    kept = kept[np.argsort(state["id"].values[kept], kind="stable")]
    area = state["area"].values[kept]
    return _Held(
        int(state.attrs["window"]),
        float(state.attrs["time"]),
        state["id"].values[kept],
        state["x"].values[kept],
        state["y"].values[kept],
        held[kept],
        float(np.sqrt(np.median(area))) if area.size else np.nan,
    )


def count_rows(times: Array, counts: Index) -> Rows:
    """Breaks over time, how they cluster, and bursts.

    Parameters
    ----------
    times : ndarray
        Ends of the intervals (s), (interval,).
    counts : ndarray
        Breaks, (interval,).

    Returns
    -------
    Rows
        On ``break_interval``, ``break_step`` and ``burst``, with units; nothing where none broke.
    """
    if not counts.any():
        return {}
    step = float(np.median(np.diff(times))) if times.size > 1 else float(times[0])
    said = {"units": "1", "long_name": "bonds that broke since the sample before"}
    rows: Rows = {
        "break_time": (("break_interval",), times, {}),
        "break_count": (("break_interval",), counts, said),
        "break_busy_share": (
            (), busy_share(counts),
            {"units": "1", "long_name": "least share of the time in which half of all bonds broke"},
        ),
    }  # fmt: skip
    found = dispersion(counts)
    if found.steps.size:
        texts = {
            "fano": "variance of the breaks in intervals over their mean",
            "allan": "half of the mean square of the change between neighbouring intervals over it",
        }
        said = {"units": "s", "long_name": "length of the intervals in which breaks are counted"}
        rows["break_step"] = (("break_step",), found.steps * step, said)
        said = {"units": "1", "long_name": "number of these intervals"}
        rows["break_blocks"] = (("break_step",), found.blocks, said)
        for name, text in texts.items():
            said = {"units": "1", "long_name": f"{text}; 1 for independent breaks"}
            rows[f"break_{name}"] = (("break_step",), getattr(found, name), said)
    sizes, lasted = bursts(counts)
    text = f"of spells in which bonds break faster than {FAST:g} times their mean"
    rows["burst_size"] = (("burst",), sizes, {"units": "1", "long_name": f"breaks {text}"})
    said = {"units": "s", "long_name": f"lengths {text}"}
    rows["burst_duration"] = (("burst",), lasted * step, said)
    return rows


def event_rows(windows: Sequence[WindowBreaks]) -> Rows:
    """Where bonds broke, window by window.

    Parameters
    ----------
    windows : sequence of WindowBreaks
        In the order of time.

    Returns
    -------
    Rows
        On ``break_window`` and ``break_event``, with units; nothing where no element lost a bond.
    """
    if not any(each.elements.size for each in windows):
        return {}
    rows: Rows = {
        "break_window_time": (("break_window",), np.array([each.time for each in windows]), {})
    }
    for name, part, text in (
        ("share", "share", "share of the elements that lost a bond in the window"),
        (
            "neighbour_ratio", "ratio",
            "pairs of neighbours that both lost a bond, over those expected by chance",
        ),
        ("mean_event", "mean", "mean size of the event of an element that lost a bond, elements"),
        ("random_event", "random", "the same of as many elements drawn at random, elements"),
    ):  # fmt: skip
        values = np.array([getattr(each, part) for each in windows])
        rows[f"break_{name}"] = (("break_window",), values, {"units": "1", "long_name": text})
    elements = np.concatenate([each.elements for each in windows])
    said = {"units": "1", "long_name": "elements of each event: neighbours that lost bonds"}
    rows["break_event_elements"] = (("break_event",), elements, said)
    length = np.concatenate([each.length for each in windows])
    said = {"units": "m", "long_name": "length of the bonds that each event lost"}
    rows["break_event_length"] = (("break_event",), length, said)
    return rows
