# SPDX-License-Identifier: GPL-2.0-or-later
"""Statistics of breaks, on sequences and places whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from floeflow.diagnostics.break_events import (
    LOST,
    BreakEvents,
    breaks_between_samples,
    bursts,
    busy_share,
    count_rows,
    dispersion,
    event_labels,
    event_rows,
    mean_event,
    neighbour_ratio,
    soon_share,
    window_breaks,
)

SPACING = 1.0e4
HOURS = 4096


def test_independent_breaks_have_factors_of_one_at_every_length() -> None:
    counts = np.random.default_rng(0).poisson(5.0, HOURS)
    found = dispersion(counts)
    assert found.steps.tolist() == [2**k for k in range(10)]
    assert found.blocks.tolist() == [HOURS // step for step in found.steps]
    # Four standard errors of a variance of so many intervals.
    assert (np.abs(found.fano - 1.0) < 4.0 * np.sqrt(2.0 / found.blocks)).all()
    assert (np.abs(found.allan - 1.0) < 6.0 * np.sqrt(2.0 / found.blocks)).all()


def test_cascades_raise_both_factors_to_their_size() -> None:
    """Independent cascades of ten bonds each: the variance is ten times the mean."""
    counts = 10 * np.random.default_rng(1).poisson(2.0, HOURS)
    found = dispersion(counts)
    wide = 4.0 * np.sqrt(2.0 / found.blocks)
    assert (np.abs(found.fano / 10.0 - 1.0) < wide).all()
    assert (np.abs(found.allan / 10.0 - 1.0) < 1.5 * wide).all()


def test_a_rate_that_changes_slowly_raises_the_fano_factor_alone() -> None:
    """With a rate a + b sin: Fano at one hour is 1 + b²/(2a); the Allan factor stays at 1."""
    rate = 20.0 + 15.0 * np.sin(2.0 * np.pi * np.arange(HOURS) / 512.0)
    found = dispersion(np.random.default_rng(2).poisson(rate))
    assert found.fano[0] == pytest.approx(1.0 + 15.0**2 / 40.0, rel=0.1)
    assert found.allan[0] == pytest.approx(1.0, abs=0.1)
    assert found.fano[5] > 8.0 * found.fano[0]


def test_few_intervals_and_whole_packs_have_no_factors() -> None:
    assert dispersion(np.ones(7, dtype=int)).steps.size == 0
    assert dispersion(np.zeros(64, dtype=int)).steps.size == 0
    assert dispersion(np.ones(8, dtype=int)).fano.tolist() == [0.0]
    assert count_rows(np.arange(9.0), np.zeros(9, dtype=int)) == {}


def test_half_of_the_breaks_come_in_a_share_of_the_time() -> None:
    assert busy_share(np.full(10, 3)) == pytest.approx(0.5)
    assert busy_share(np.array([0, 0, 8, 0])) == pytest.approx(0.125)
    assert busy_share(np.array([0, 0, 6, 2])) == pytest.approx(0.25 * 4.0 / 6.0)
    assert np.isnan(busy_share(np.zeros(4, dtype=int)))


def test_bursts_are_spells_above_twice_the_mean() -> None:
    sizes, lasted = bursts(np.array([9, 0, 0, 0, 0, 8, 7, 0, 0, 0, 0, 0, 0, 0, 9]))
    assert sizes.tolist() == [9, 15, 9] and lasted.tolist() == [1, 2, 1]
    assert bursts(np.full(6, 2))[0].size == 0 and bursts(np.zeros(0, dtype=int))[0].size == 0


def test_breaks_are_counted_within_windows() -> None:
    """Bonds that froze between windows are no breaks that were undone."""
    samples = xr.Dataset(
        {
            "sample_window": ("sample", [1, 1, 1, 2, 2, 2]),
            "time": ("sample", [0.0, 1.0, 2.0, 2.0, 3.0, 4.0]),
            "intact_bonds": ("sample", [10, 9, 9, 12, 12, 7]),
        }
    )
    times, counts = breaks_between_samples(samples)
    assert times.tolist() == [1.0, 2.0, 3.0, 4.0] and counts.tolist() == [1, 0, 0, 5]
    rows = count_rows(times, counts)
    assert rows["break_count"][1].sum() == 6 and rows["burst_duration"][1].tolist() == [1.0]
    assert rows["burst_size"][1].tolist() == [5]


def hours(held: list[list[int]]) -> xr.Dataset:
    """Samples of windows of eight hours."""
    windows = np.repeat(np.arange(len(held)), 9)
    time = np.concatenate([8.0 * k + np.arange(9.0) for k in range(len(held))])
    bonds = np.concatenate(held)
    names = {"sample_window": windows, "time": 3600.0 * time, "intact_bonds": bonds}
    return xr.Dataset({name: ("sample", values) for name, values in names.items()})


def test_breaks_that_follow_the_windows_are_told() -> None:
    evenly = [90 - 10 * k for k in range(9)]
    assert soon_share(hours([evenly, evenly])) == pytest.approx(0.125)
    at_once = [90, *[50] * 8]
    assert soon_share(hours([at_once, evenly])) == pytest.approx(50.0 / 120.0)
    assert np.isnan(soon_share(hours([[7] * 9])))


def triangular(side: int = 60) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (m) and neighbours of a triangular lattice."""
    row, column = (each.ravel() for each in np.mgrid[:side, :side])
    x, y = (column + 0.5 * (row % 2)) * SPACING, row * SPACING * np.sqrt(0.75)
    at = np.arange(side * side)
    up = np.where(row % 2 == 1, column + 1, column - 1)
    pairs = [
        np.stack([at, at + 1], 1)[column < side - 1],
        np.stack([at, at + side], 1)[row < side - 1],
        np.stack([at, (row + 1) * side + up], 1)[(row < side - 1) & (up >= 0) & (up < side)],
    ]
    return x, y, np.concatenate(pairs)


def test_breaks_at_random_places_are_no_more_neighbours_than_chance_makes() -> None:
    _, _, pairs = triangular()
    broken = np.random.default_rng(3).random(3600) < 0.2
    assert neighbour_ratio(broken, pairs) == pytest.approx(1.0, abs=0.1)
    found = window_breaks(0.0, np.where(broken, SPACING, 0.0), pairs, SPACING)
    assert found.share == broken.mean()
    assert found.mean == pytest.approx(found.random, rel=0.2)
    assert found.elements.sum() == broken.sum()
    assert found.length.sum() == pytest.approx(0.5 * SPACING * broken.sum())


def test_a_lead_through_the_pack_is_one_event_of_its_length() -> None:
    _, _, pairs = triangular()
    lost = np.zeros((60, 60))
    lost[30] = SPACING  # a row of sixty
    lost[5, 7] = 0.5 * SPACING  # one far away
    lost[50, 50] = 0.9 * LOST * SPACING  # a crack that is no lost bond
    found = window_breaks(0.0, lost.ravel(), pairs, SPACING)
    assert sorted(found.elements.tolist()) == [1, 60]
    assert sorted(found.length.tolist()) == pytest.approx([0.25 * SPACING, 30.0 * SPACING])
    assert found.mean == pytest.approx((60.0**2 + 1.0) / 61.0)
    # 59 of the pairs are both broken, of 10,561; by chance 61 of 3,600 elements are.
    by_chance = 61.0 * 60.0 / (3600.0 * 3599.0)
    assert found.ratio == pytest.approx(59.0 / len(pairs) / by_chance)
    assert found.ratio > 15.0 and found.random < 2.0


def test_whole_packs_have_no_events() -> None:
    _, _, pairs = triangular(4)
    found = window_breaks(0.0, np.zeros(16), pairs, SPACING)
    assert found.share == 0.0 and found.elements.size == 0
    assert np.isnan([found.ratio, found.mean, found.random]).all()
    assert event_rows([found]) == {} and event_rows([]) == {}
    assert np.isnan(mean_event(event_labels(np.zeros(16, dtype=bool), pairs)))


def snapshot(window: int, held: np.ndarray, ids: np.ndarray | None = None) -> xr.Dataset:
    """A boundary of a lattice of elements with so much held outline (m)."""
    x, y, _ = triangular(8)
    rows = np.arange(64) if ids is None else ids - 1
    area = np.full(rows.size, SPACING**2 * np.sqrt(0.75))
    return xr.Dataset(
        {
            "id": ("element", rows + 1),
            "type": ("element", np.ones(rows.size, dtype=int)),
            "x": ("element", x[rows]),
            "y": ("element", y[rows]),
            "area": ("element", area),
            "ice_fraction": (("element", "category"), np.ones((rows.size, 1))),
            "bonded_length": ("element", held[rows]),
        },
        attrs={"window": window, "time": 86400.0 * window},
    )


def test_events_follow_the_boundaries_of_a_run() -> None:
    whole = np.full(64, 3.0 * SPACING)
    broken = whole.copy()
    broken[24:32] -= SPACING
    events = BreakEvents(set())
    for window, held in enumerate((whole, broken, broken, whole)):
        events.take(snapshot(window, held))
    assert [each.elements.tolist() for each in events.windows] == [[8], [], []]
    assert [each.time for each in events.windows] == [86400.0, 172800.0, 259200.0]
    rows = event_rows(events.windows)
    assert rows["break_event_elements"][1].tolist() == [8]
    assert rows["break_event_length"][1] == pytest.approx([4.0 * SPACING])
    assert rows["break_share"][1].tolist() == [0.125, 0.0, 0.0]


def test_remaps_and_elements_that_left_are_no_breaks() -> None:
    whole, none = np.full(64, 3.0 * SPACING), np.zeros(64)
    events = BreakEvents({1})
    events.take(snapshot(0, whole))
    events.take(snapshot(1, none))
    assert events.windows == []
    # What stood beside an element that left lost the bonds with it.
    events = BreakEvents(set())
    events.take(snapshot(0, whole))
    held = whole.copy()
    held[[1, 8]] = 0.0  # beside the first one
    held[40] = 0.0  # far away
    events.take(snapshot(1, held, np.arange(2, 65)))
    (found,) = events.windows
    # Counted are all but the one that left and its three neighbours.
    assert found.elements.tolist() == [1] and found.share == pytest.approx(1.0 / 60.0)


def test_runs_without_bonds_are_left_alone() -> None:
    events = BreakEvents(set())
    for window in range(2):
        events.take(snapshot(window, np.zeros(64)).drop_vars("bonded_length"))
    assert events.windows == []
