# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice in a box of walls under a turning wind: beside DEMSI's run, and with FloeFlow's own laws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from support.contact import figures, vortex, vortex_ridging

HOUR = 3600.0
# Time steps (s) of the members of the ensemble; each starts 1e-9 m off, at random.
STEPS = (4.0, 3.0, 2.4, 2.0, 1.5, 1.2)

Moved = tuple[np.ndarray, np.ndarray]


@pytest.fixture(scope="module")
def demsi(shared: Path) -> dict[str, np.ndarray]:
    """Time (s), place (m) and velocity (m/s) of the uniform vortex, in the lattice's order."""
    path = shared / "reference" / "demsi" / "vortex_uniform.nc"
    with xr.open_dataset(path, decode_times=False) as data:
        order = np.lexsort(data["x"].values[0].T[::-1])
        return {"time": data["time"].values} | {n: data[n].values[:, order] for n in ("x", "v")}


def springs(log: Path, seed: int, hours: int, step: float) -> tuple[list[Moved], float]:
    """Places and velocities (n, 2) of the ice every three hours; the largest overlap (m)."""
    out, largest = [], 0.0
    elements = vortex.box(vortex.lattice(), 1.0, seed)
    for hour, engine in enumerate(vortex.drift(log, elements, vortex.springs(step), hours), 1):
        largest = max(largest, engine.diagnostics()["max_overlap"])
        if hour % 3 == 0:
            ice = engine.elements()
            place = np.column_stack([ice["x"], ice["y"]])
            assert (place > 0).all() and (place < vortex.BOX).all()  # nothing is lost
            out.append((place, np.column_stack([ice["u"], ice["v"]])))
    return out, largest


@pytest.fixture(scope="module")
def members(tmp_path_factory: pytest.TempPathFactory) -> list[Moved]:
    """Each member's ice after a day."""
    log = tmp_path_factory.mktemp("vortex") / "log"
    return [springs(log, seed, 24, step)[0][-1] for seed, step in enumerate(STEPS)]


def beside(ours: Moved, demsi: dict[str, np.ndarray], number: int) -> np.ndarray:
    """Quadrant means less those of DEMSI's output with this number, (4, 4)."""
    first = vortex.lattice()
    theirs = vortex.quadrants(demsi["x"][number], demsi["v"][number], first)
    return vortex.quadrants(*ours, first) - theirs


def test_the_lattice_is_that_of_the_reference(demsi: dict[str, np.ndarray]) -> None:
    np.testing.assert_array_equal(vortex.lattice(), demsi["x"][0])


def test_three_hours_beside_demsi(log: Path, demsi: dict[str, np.ndarray]) -> None:
    moved, overlap = springs(log, 1, 3, 4.0)
    apart = beside(moved[-1], demsi, 1)
    assert np.abs(apart[:, :2]).max() < 40.0  # of 0.7 to 2.4 km
    assert np.abs(apart[:, 2:]).max() < 0.01
    assert overlap < 0.01 * vortex.RADIUS


@pytest.mark.slow
def test_a_day_beside_demsi(members: list[Moved], demsi: dict[str, np.ndarray], show) -> None:
    first = vortex.lattice()
    apart = np.array([beside(member, demsi, 8) for member in members])
    mean, spread = apart.mean(0), apart.std(0, ddof=1)
    with np.printoptions(precision=4, suppress=True, linewidth=120):
        print("FloeFlow - DEMSI\n", mean, "\nstandard deviation of members\n", spread)
        print("share within 2 deviations", (np.abs(mean) < 2 * spread).mean())
    theirs = vortex.quadrants(demsi["x"][8], demsi["v"][8], first)
    way = np.hypot(*(theirs[:, :2] - vortex.quadrants(first, first, first)[:, :2]).T)
    assert (np.hypot(*mean[:, :2].T) < 0.01 * way).all()
    assert np.abs(mean[:, 2:]).max() < 0.005
    show("vortex", figures.vortex, demsi["x"][8], members[0][0])


@pytest.mark.slow
@pytest.mark.xfail(
    strict=True,
    reason="some of the 16 means lie up to four deviations off: the first buckling of the lattice "
    "at the northern wall, within the first three hours",
)
def test_a_day_within_two_deviations(members: list[Moved], demsi: dict[str, np.ndarray]) -> None:
    apart = np.array([beside(member, demsi, 8) for member in members])
    assert (np.abs(apart.mean(0)) < 2 * apart.std(0, ddof=1)).all()


@pytest.mark.slow
def test_four_days_beside_demsi(log: Path, demsi: dict[str, np.ndarray]) -> None:
    moved, overlap = springs(log, 1, 96, 4.0)
    first = vortex.lattice()
    for number in (8, 16, 24, 32):
        theirs = vortex.quadrants(demsi["x"][number], demsi["v"][number], first)
        way = np.hypot(*(theirs[:, :2] - vortex.quadrants(first, first, first)[:, :2]).T)
        gap = np.hypot(*beside(moved[number - 1], demsi, number)[:, :2].T)
        print(number * 3, "h: gap (m)", gap.round(), "of", way.round())
        assert (gap < 0.05 * way).all()
    assert overlap < 0.01 * vortex.RADIUS


@pytest.mark.parametrize(
    ("hours", "thinnest"),
    [
        (0.5, 0.0),
        *(pytest.param(24.0, h, marks=pytest.mark.slow) for h in (1.0, 0.8, 0.0)),
    ],
)
def test_own_laws_at_one_step_for_any_ice(log: Path, hours: float, thinnest: float) -> None:
    random = np.random.default_rng(2)
    thickness = np.maximum(random.uniform(thinnest, 1.0, 5000), 1e-6)
    first = vortex_ridging.start(thickness)
    last, worst = vortex_ridging.run(log, first, 1.0, hours)
    print(thinnest, worst, "smallest radius", float(last["radius"].min()))
    # What makes force is small. Discs may overlap as far as ridges took ice from one side, which a
    # disc cannot show, but no centre comes near to another's or to a wall (docs/theory/contact.md).
    assert worst.elastic < 0.01 * vortex.RADIUS
    assert worst.discs < vortex.RADIUS and worst.wall < 0.7 * vortex.RADIUS
    # Nothing is lost: every element, all ice, all area.
    assert (last["id"].values == first["id"].values).all()
    for axis in "xy":
        assert (last[axis] > 0).all() and (last[axis] < vortex.BOX).all()
    volume = [float(s["area"] @ s["ice_volume"][:, 0]) for s in (first, last)]
    assert volume[1] == pytest.approx(volume[0], rel=1e-12)
    total = [float(s["area"].sum()) + s.attrs["unclaimed_water"] for s in (first, last)]
    assert total[1] == pytest.approx(total[0], rel=1e-12)
