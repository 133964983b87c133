# SPDX-License-Identifier: GPL-2.0-or-later
"""A hierarchy of fields on a grid: exact totals, values within their sources' bounds, constants."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.core.errors import FloeError
from floeflow.transfer import (
    EMPTY,
    ROOM,
    Field,
    Grid,
    Ranks,
    build_remapper,
    conservative_transfer,
    curvilinear,
    open_room,
)

FIELDS = (
    Field("area", "extensive", ROOM),
    Field("ice", "extensive", "area"),
    Field("volume", "extensive", "ice"),
    Field("temperature", "intensive", "volume"),
    Field("mass", "extensive"),
)
GRID = Grid(np.arange(5.0), np.arange(4.0))
MESH = curvilinear(np.array([0.0, 1.0, 1.5, 3.0, 4.0]), np.array([0.0, 0.7, 2.0, 3.0]))


def pack(n, seed=0):
    """Elements at random within the cells, with room to spare."""
    rng = np.random.default_rng(seed)
    area = np.full(n, 15.0 / n)
    ice = area * rng.uniform(0, 1, n) * (rng.uniform(size=n) > 0.1)
    return rng.uniform(-0.5, 4.5, n), rng.uniform(-0.5, 3.5, n), {
        "area": area,
        "ice": ice,
        "volume": ice * rng.uniform(0.1, 4, n),
        "temperature": np.where(ice > 0, rng.uniform(-40, 0, n), np.nan),
        "mass": rng.uniform(0, 1e9, n),
    }  # fmt: skip


def carried(x, y, values, target=GRID, reach=1, ranks=None, room=None):
    parents = {name: values[name] for name in ("area", "ice", "volume")}
    room = room or open_room(target, reach=reach)
    remapper = build_remapper(x, y, parents, room, ranks=ranks)
    return conservative_transfer(FIELDS, values, remapper, ranks=ranks), remapper


def check(values, found, remapper):
    """Totals to 1e-13, values within the bounds of their sources to 1e-14."""
    on = remapper.bins.placed()
    grid = found.values
    temperature = np.where(values["volume"] > 0, values["temperature"], 0.0)
    amounts = {**values, "temperature": values["volume"] * temperature}
    sums = {**grid, "temperature": grid["volume"] * np.nan_to_num(grid["temperature"])}
    for name in sums:
        if name in found.infeasible:
            continue
        size = np.abs(amounts[name][on]).sum()
        assert abs(sums[name].sum() - amounts[name][on].sum()) <= 1e-13 * size
        assert abs(found.missing[name]) <= 1e-13 * size
    sea = remapper.bins.room.area
    assert (grid["area"] >= 0).all() and (grid["area"] <= sea * (1 + 1e-14)).all()
    for name, parent, field in (
        ("ice", "area", values["ice"] / np.where(values["area"] > 0, values["area"], 1.0)),
        ("volume", "ice", values["volume"] / np.where(values["ice"] > 0, values["ice"], 1.0)),
        ("temperature", "volume", values["temperature"]),
    ):
        has = np.isfinite(grid["temperature"]) if name == "temperature" else grid[parent] > 1e-99
        low, high = remapper.weights[parent].bounds(np.where(values[parent] > 0, field, 0.0))
        per = grid[name] if name == "temperature" else grid[name] / np.where(has, grid[parent], 1)
        slack = 1e-14 * np.maximum(np.abs(low), np.abs(high))[has]
        assert (per[has] >= low[has] - slack).all() and (per[has] <= high[has] + slack).all()


@pytest.mark.parametrize(("target", "reach"), [(GRID, 1), (GRID, 2), (MESH, 1)])
@pytest.mark.parametrize("n", [1, 5, 200])
def test_totals_and_bounds(target, reach, n):
    x, y, values = pack(n, n)
    found, remapper = carried(x, y, values, target, reach)
    check(values, found, remapper)
    if n == 200 and target is GRID:
        assert found.infeasible == []


def test_constants_stay():
    x, y, values = pack(150)
    values["volume"] = 2.5 * values["ice"]
    values["temperature"] = np.full(150, -1.8)
    found, _ = carried(x, y, values)
    has = found.values["ice"] > 0
    np.testing.assert_allclose((found.values["volume"] / found.values["ice"])[has], 2.5, rtol=1e-14)
    np.testing.assert_allclose(found.values["temperature"][has], -1.8, rtol=1e-14)


amount = st.floats(1e-9, 1.0) | st.just(0.0)
element = st.tuples(
    st.floats(-2, 6) | st.sampled_from([0.0, 0.5, 1.0, 2.0]),
    st.floats(-2, 5) | st.sampled_from([0.0, 0.5, 1.0, 2.0]),
    amount,
    amount,
    amount,
    st.floats(-40, 40),
)


@settings(deadline=None, derandomize=True, max_examples=250)
@given(st.lists(element, max_size=12), st.sampled_from([(GRID, 1), (GRID, 2), (MESH, 1)]))
def test_any_elements(rows, where):
    x, y, area, fraction, thickness, temperature = np.array(rows).reshape(-1, 6).T
    ice = area * fraction
    values = {
        "area": area,
        "ice": ice,
        "volume": ice * thickness,
        "temperature": temperature,
        "mass": thickness,
    }
    found, remapper = carried(x, y, values, *where)
    check(values, found, remapper)
    constant = {**values, "temperature": np.full_like(area, 273.15)}
    again = carried(x, y, constant, *where)[0].values["temperature"]
    np.testing.assert_allclose(again[np.isfinite(again)], 273.15, rtol=1e-14)
    beyond = remapper.weights["ice"].status == EMPTY
    assert (found.values["ice"][beyond] == 0).all()


def test_more_area_than_room_is_said_by_how_much():
    x, y, values = pack(400)
    values = {**values, "area": 2.0 * values["area"]}
    found, _ = carried(x, y, values)
    assert "area" in found.infeasible
    np.testing.assert_array_equal(found.values["area"], 1.0)
    assert found.missing["area"] == pytest.approx(30.0 - 20.0, rel=1e-12)


def test_land_gets_nothing_and_what_is_outside_is_counted():
    x, y, values = pack(300)
    x[:30] = 40.0
    area = np.ones(GRID.shape)
    area[:, :2] = 0.0
    found, _ = carried(x, y, values, room=open_room(GRID, area))
    assert (found.values["ice"][:, :2] == 0).all()
    assert (found.values["mass"][:, :2] == 0).all()
    gone = (x > 4.5) | (x <= 1.0)
    assert found.outside["mass"] == pytest.approx(values["mass"][gone].sum(), rel=1e-12)
    assert found.values["mass"].sum() == pytest.approx(values["mass"][~gone].sum(), rel=1e-13)


def test_ranks_share_elements_with_the_same_result():
    """Two slices in step, each with the sums of both; ranks see the same grid."""
    import threading

    x, y, values = pack(200)
    whole, _ = carried(x, y, values)
    parts = [slice(0, 77), slice(77, 200)]
    board, barrier, results = [None, None], threading.Barrier(2), [None, None]

    def reduce(rank, combine):
        def call(part):
            board[rank] = part
            barrier.wait(60)
            result = combine(board[0], board[1])
            barrier.wait(60)
            return result

        return call

    def work(rank):
        rows = parts[rank]
        ranks = Ranks(reduce(rank, np.add), reduce(rank, np.maximum))
        own = {name: value[rows] for name, value in values.items()}
        results[rank] = carried(x[rows], y[rows], own, ranks=ranks)[0]

    threads = [threading.Thread(target=work, args=(rank,)) for rank in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    for name, expected in whole.values.items():
        np.testing.assert_array_equal(results[0].values[name], results[1].values[name])
        np.testing.assert_allclose(results[0].values[name], expected, rtol=1e-11, atol=1e-12)
        assert results[0].missing[name] == pytest.approx(
            0.0, abs=1e-12 * np.nansum(np.abs(expected))
        )


def test_wrong_input_is_named():
    x, y, values = pack(20)
    with pytest.raises(FloeError, match="'thickness' is intensive, but of which parent"):
        Field("thickness", "intensive")
    remapper = build_remapper(x, y, {"area": values["area"]}, open_room(GRID))
    with pytest.raises(FloeError, match="'volume' sits on 'ice', which is no extensive field"):
        conservative_transfer(FIELDS[2:3], values, remapper)
    with pytest.raises(FloeError, match="'ice' has no values"):
        conservative_transfer(FIELDS[:2], {"area": values["area"]}, remapper)
    with pytest.raises(FloeError, match="'volume' is averaged over 'ice', for which there are no"):
        conservative_transfer(FIELDS[:3], values, remapper)
    values["ice"][3] = np.nan
    with pytest.raises(FloeError, match="ice: remap: it is nan at element 3"):
        conservative_transfer(FIELDS[:2], values, remapper)
    values["area"][4], values["ice"][3], values["ice"][4] = 0.0, 0.0, 1.0
    with pytest.raises(FloeError, match="element 4 has 1 of 'ice', but no 'area'"):
        conservative_transfer(FIELDS[:2], values, remapper)
    with pytest.raises(FloeError, match=r"area: remap: it has shape \(2,\)"):
        conservative_transfer(FIELDS[:1], {"area": np.ones(2)}, remapper)
    with pytest.raises(FloeError, match="look like degrees"):
        build_remapper(1e5 * x, 1e5 * y, {}, open_room(GRID))
