# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 4: ten days of a wind of 20 m/s against a coast, with what windows do at their ends.

Within a window ridging moves rest overlaps; at its end the areas close, discs shrink, are merged or
replaced, and contacts and ridges must go on with the forces that they had: what is wrong by a
little adds up over forty windows, and a pack under full load would jump at each. What must hold:
finite, nothing lost, volume and sea to 1e-12, energy of each window accounted for, speeds below
what the wind gives, overlaps within what the ridging force takes, and where elements are merged or
replaced every time a step that does not run away.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.stability import jam
from support.stability.jam import Pressed, Setting

# Light ice that is hit by heavy ice leaves with at most twice its speed.
HIT = 2.0


def hold(at: Setting, seen: Pressed, record) -> None:
    """All that must hold of a jam."""
    energy = seen.energy()
    worst = float(energy.relative.max())
    whole = abs(energy.residual.sum()) / energy.scale.sum()
    record(
        hours=len(seen.series) * jam.WINDOW / jam.HOUR,
        elements=int(seen.state.sizes["element"]),
        largest_speed=seen.largest("largest_speed"),
        speed_over_free_drift=seen.largest("largest_speed") / jam.free_drift(at),
        overlap_over_bound=max(seen.overlap),
        ridged_share=seen.total("ridged_area") / float(at.state["area"].sum()),
        volume_error=seen.volume_error,
        sea_error=seen.sea_error,
        least_step=min(seen.steps) / seen.steps[0],
        residual=whole,
        residual_of_the_worst_window=worst,
    )
    assert seen.volume_error < 1e-12
    assert seen.sea_error < 1e-12
    assert seen.largest("largest_speed") < HIT * jam.free_drift(at)
    assert max(seen.overlap) <= 1.02
    assert worst < 0.02
    # Discs shrink as they ridge, and with them the step, until they are replaced or merged.
    if at.remesh in ("remap every window", "merge"):
        assert min(seen.steps) > 0.5 * seen.steps[0]
    # It was pressed: ice went into ridges and against the coast.
    assert seen.total("ridged_area") > 0.0
    assert seen.total("impulse_coast_x") > 0.0


A_DAY, TEN_DAYS = (4, 80), (40, 200)


@pytest.mark.parametrize(
    ("remesh", "windows", "elements"),
    [
        # In a day nothing overlaps enough to be remapped, but where every window remaps.
        *((remesh, *A_DAY) for remesh in jam.REMESHING if remesh != "remap"),
        *(pytest.param(remesh, *TEN_DAYS, marks=pytest.mark.slow) for remesh in jam.REMESHING),
    ],
)
def test_windows_of_a_pack_pressed_against_a_coast(
    tmp_path: Path, remesh: str, windows: int, elements: int, record
):
    """Into a bay, with no remeshing, with remap where elements overlap or always, with merge."""
    at = jam.setting(remesh, elements)
    seen = jam.press(at, windows, tmp_path / "log")
    hold(at, seen, record)
    if remesh == "remap every window":
        assert seen.total("remap_done") == windows


@pytest.mark.slow
def test_ice_that_is_remapped_ridges_as_much(tmp_path: Path, record):
    """Six days without remeshing and with remap where elements overlap: the same ridges."""
    ridged = []
    for remesh in ("none", "remap"):
        at = jam.setting(remesh, 120)
        seen = jam.press(at, 24, tmp_path / "log")
        ridged.append(seen.total("ridged_area") / float(at.state["area"].sum()))
    record(ridged_share=ridged[0], ridged_share_with_remap=ridged[1])
    assert seen.total("remap_done") >= 2
    assert ridged[1] == pytest.approx(ridged[0], rel=0.15)


@pytest.mark.parametrize("remesh", ["none", "remap every window"])
def test_windows_of_a_pack_pressed_into_a_corner(tmp_path: Path, remesh: str, record):
    at = jam.setting(remesh, 80, (-jam.WIND / np.sqrt(2.0), -jam.WIND / np.sqrt(2.0)))
    hold(at, jam.press(at, 4, tmp_path / "log"), record)
