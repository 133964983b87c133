# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures: geometry of what is drawn, and pixels of a drawn map against the colour scale."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
import shapely.affinity
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from floeflow.report.figures import bonds, maps, series, style
from floeflow.report.figures.budgets import budget_figure, budget_unit
from floeflow.report.figures.cost import cost_figure
from floeflow.report.figures.frame import Frame, prepare_axes
from floeflow.report.figures.packing import packing_figures
from floeflow.scene.blocks import Domain
from floeflow.state import read_state
from support.synthetic import Run, first_state, make_mask, make_packing


@pytest.fixture(scope="module")
def frame(run: Run) -> Frame:
    return Frame(run.scene.domain, make_mask()["land"])


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def pixel(figure: Figure, x: float, y: float) -> np.ndarray:
    """Colour (0..1) that the first axes of a figure show at a place of theirs."""
    figure.canvas.draw()
    image = np.asarray(figure.canvas.buffer_rgba())
    column, row = figure.axes[0].transData.transform((x, y))
    return image[image.shape[0] - 1 - int(row), int(column), :3] / 255.0


@given(st.floats(1e-6, 1e9), st.integers(1, 12))
def test_nice_step_cuts_into_few_round_parts(span: float, most: int):
    step = style.nice_step(span, most)
    assert span / step <= most * (1 + 1e-9)
    assert span / step > most / 2.51
    assert f"{step:.6e}"[0] in "125"


def test_common_limits():
    fields = np.array([0.5, np.nan]), np.array([3.0])
    assert style.common_limits(style.THICKNESS, *fields) == (0.0, 3.0)
    assert style.common_limits(style.CONCENTRATION, *fields) == (0.0, 1.0)
    assert style.common_limits(style.THICKNESS, np.array([np.nan])) == (0.0, 1.0)
    assert style.common_limits(style.THICKNESS) == (0.0, 1.0)
    one_fast = np.concatenate([np.full(999, 0.2), [30.0]])
    assert style.common_limits(style.SPEED, one_fast) == (0.0, 0.2)


@pytest.mark.parametrize(
    "quantity", [style.CONCENTRATION, style.THICKNESS, style.SNOW, style.SPEED, style.DISTANCE]
)
def test_colour_maps_survive_black_and_white(quantity: style.Quantity):
    colours = quantity.cmap(np.linspace(0, 1, 12))[:, :3]
    lightness = colours @ [0.299, 0.587, 0.114]
    steps = np.diff(lightness)
    assert np.all(steps > 0) or np.all(steps < 0)
    assert np.ptp(lightness) > 0.45


def test_the_packing_is_drawn_element_by_element():
    """Every panel counts each element once; without a size function there is no fourth panel."""
    packing = make_packing()
    count = int((packing["type"].values == 1).sum())
    ((name, caption, figure),) = packing_figures(packing)
    assert name == "packing_quality" and f"{count} elements" in caption
    assert "asked for" not in caption and not figure.axes[3].axison
    heights = [sum(bar.get_height() for bar in axes.patches) for axes in figure.axes[:3]]
    assert heights == [count, count, 2 * count]
    packing["size_ratio"] = ("element", np.where(packing["type"].values == 1, 1.0, 0.0))
    ((_, caption, figure),) = packing_figures(packing)
    assert "spread 0.00" in caption and figure.axes[3].axison
    assert all(axes.get_xlabel() and axes.get_ylabel() for axes in figure.axes)
    assert list(packing_figures(make_packing(elements=False))) == []


def test_cells_move_and_turn_with_their_element():
    packing = make_packing()
    state = packing.copy(deep=True)
    state["theta"] = ("element", np.zeros(state.sizes["element"]))
    state["theta"].values[3] = 0.7
    state["x"].values[3] += 5.0e4
    shapes = maps.element_shapes(state, packing)
    start = packing["cell_start"].values
    ring = np.stack([packing["cell_x"].values, packing["cell_y"].values], axis=1)
    cell = shapely.Polygon(ring[start[3] : start[4]])
    origin = (float(packing["x"][3]), float(packing["y"][3]))
    turned = shapely.affinity.rotate(cell, 0.7, origin=origin, use_radians=True)
    expected = shapely.affinity.translate(turned, 5.0e4)
    drawn = shapely.Polygon(shapes.polygons[3] * 1e3)
    assert drawn.symmetric_difference(expected).area < 1e-6 * cell.area
    untouched = shapely.Polygon(shapes.polygons[4] * 1e3)
    assert untouched.equals_exact(shapely.Polygon(ring[start[4] : start[5]]), 1e-6)


def test_elements_without_a_cell_are_discs():
    packing = make_packing()
    state = packing.assign(theta=("element", np.zeros(packing.sizes["element"])))
    state["id"].values[-1] = 10_000
    shapes = maps.element_shapes(state, packing)
    coast = np.flatnonzero(packing["type"].values == 2)
    assert shapes.of_disc.tolist() == coast.tolist()
    assert len(shapes.polygons) == shapes.of_polygon.size == state.sizes["element"] - coast.size


def test_thickness_is_over_the_ice_and_nowhere_without():
    columns = ("element", "category")
    state = xr.Dataset(
        {
            "ice_fraction": (columns, [[0.25, 0.25], [0.0, 0.0]]),
            "ice_volume": (columns, [[0.25, 0.75], [0.0, 0.0]]),
            "u": ("element", [3.0, 0.0]),
            "v": ("element", [4.0, 0.0]),
        }
    )
    np.testing.assert_array_equal(maps.element_values(state, "thickness"), [2.0, np.nan])
    assert maps.element_values(state, "concentration").tolist() == [0.5, 0.0]
    assert maps.element_values(state, "speed").tolist() == [5.0, 0.0]


def test_map_shows_each_element_in_its_colour(run: Run, frame: Frame):
    state, packing = first_state(make_packing(), run.scene), make_packing()
    values = maps.element_values(state, "thickness")
    quantity, limits = style.THICKNESS, (0.0, 3.0)
    shapes = maps.element_shapes(state, packing)
    figure = maps.element_map(frame, state, shapes, values, quantity, limits, "Thickness")
    # Clear of outlines, graticule and scale bar.
    for index in (60, 90, 130, 155):
        x, y = state["x"].values[index] / 1e3, state["y"].values[index] / 1e3
        expected = quantity.cmap(values[index] / 3.0)[:3]
        np.testing.assert_allclose(pixel(figure, x, y), expected, atol=0.03)
    coast = int(np.flatnonzero(state["type"].values == 2)[12])
    x, y = state["x"].values[coast] / 1e3, state["y"].values[coast] / 1e3
    np.testing.assert_allclose(pixel(figure, x, y), np.array([125, 119, 108]) / 255, atol=0.03)


def test_map_without_ice_says_so(run: Run, frame: Frame):
    packing = make_packing(elements=False)
    state = first_state(packing, run.scene)
    shapes = maps.element_shapes(state, packing)
    none = np.zeros(0)
    figure = maps.element_map(
        frame, state, shapes, none, style.SPEED, (0, 1), "Speed", (none, none, "m/s")
    )
    assert "no ice" in texts(figure)
    figure = bonds.bond_map(frame, state, state, shapes, "Bonds")
    assert "no ice" in texts(figure)


def test_elements_at_rest_get_no_arrows(run: Run, frame: Frame):
    packing = make_packing()
    state = first_state(packing, run.scene)
    zero = np.zeros(state.sizes["element"])
    shapes = maps.element_shapes(state, packing)
    figure = maps.element_map(
        frame, state, shapes, zero, style.SPEED, (0, 1), "Speed", (zero, zero, "m/s")
    )
    assert "at rest" in texts(figure)


def test_colour_bar_is_pointed_where_values_lie_beyond(run: Run, frame: Frame):
    packing = make_packing()
    state = first_state(packing, run.scene)
    shapes, values = maps.element_shapes(state, packing), np.full(state.sizes["element"], 0.5)
    bars = []
    for top in (0.4, 0.5):
        figure = maps.element_map(frame, state, shapes, values, style.SPEED, (0, top), "Speed")
        figure.canvas.draw()
        bars.append(len(figure.axes[1].patches))
    assert bars == [1, 0]


def test_box_means_keep_the_sum(frame: Frame):
    rng = np.random.default_rng(3)
    left, right, bottom, top = frame.extent
    x, y = rng.uniform(left, right, 500), rng.uniform(bottom, top, 500)
    bx, by, u = maps.box_means(frame, x, y, np.full(500, 2.5))
    assert bx.size < maps.ARROWS**2 + 1
    assert np.allclose(u, 2.5)
    size = (right - left) / maps.ARROWS
    cells = {
        (int((a - left) // size), int((b - bottom) // size)) for a, b in zip(bx, by, strict=True)
    }
    assert len(cells) == bx.size


def test_graticule_labels_degrees_and_scale_bar_kilometres(frame: Frame):
    with style.look():
        figure = style.new_figure(6, 6)
        prepare_axes(figure.add_subplot(), frame, "Map")
    found = texts(figure)
    assert "100 km" in found
    assert {"76°N", "77°N"} <= set(found)
    assert [text for text in found if text.endswith("W")]


def test_graticule_around_the_pole_has_each_meridian_once():
    domain = Domain(x_min=-2e6, x_max=2e6, y_min=-2e6, y_max=2e6)
    axis = np.linspace(-1.9e6, 1.9e6, 20)
    land = xr.DataArray(np.zeros((20, 20)), {"y": axis, "x": axis}, ("y", "x"))
    with style.look():
        figure = style.new_figure(6, 6)
        prepare_axes(figure.add_subplot(), Frame(domain, land), "Map")
    found = texts(figure)
    meridians = [t for t in found if t in ("0°", "180°") or t.endswith(("E", "W"))]
    # The one in the corner of the scale bar may go without.
    assert len(set(meridians)) == len(meridians) >= 11
    assert "80°N" in found


def test_graticule_in_the_south():
    domain = Domain(crs="EPSG:3031", x_min=-3e6, x_max=-1e6, y_min=0, y_max=2e6, spacing=1e5)
    axis = np.linspace(-2.95e6, -1.05e6, 20)
    land = xr.DataArray(np.zeros((20, 20)), {"y": axis + 3e6, "x": axis}, ("y", "x"))
    with style.look():
        figure = style.new_figure(6, 6)
        prepare_axes(figure.add_subplot(), Frame(domain, land), "Map")
    assert [text for text in texts(figure) if text.endswith("°S")]


def test_glue_lines_lie_between_their_elements(run: Run):
    state = read_state(run.state(0))
    lines = bonds.glue_lines(state, state) * 1e3
    place = np.stack([state["x"].values, state["y"].values], axis=1)
    middle = (place[state["bond_id_lo"].values - 1] + place[state["bond_id_hi"].values - 1]) / 2
    np.testing.assert_allclose(lines.mean(axis=1), middle, atol=1e-6)
    length = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    np.testing.assert_allclose(length, state["bond_length"].values)


def test_bonds_are_sorted_by_what_became_of_them(run: Run):
    first, last = read_state(run.state(0)), read_state(run.state(3))
    whole, cracked, broken = bonds.sort_bonds(first, last)
    assert whole.sizes["bond"] + cracked.sizes["bond"] == last.sizes["bond"]
    assert broken.sizes["bond"] == first.sizes["bond"] - last.sizes["bond"] > 0
    assert cracked.sizes["bond"] == int((last["bond_crack_a"] > 0).sum()) > 0


def test_bonds_of_the_start_are_followed_where_elements_came_and_went(run: Run):
    first, last = read_state(run.state(0)), read_state(run.state(3))
    gone = int(first["bond_id_lo"][0])
    fewer = last.isel(element=np.flatnonzero(last["id"].values != gone))
    none = first.isel(bond=slice(0))
    fewer = fewer.drop_dims("bond").merge(none[[n for n in none if none[n].dims == ("bond",)]])
    _, _, broken = bonds.sort_bonds(first, fewer)
    held = (first["bond_id_lo"] == gone) | (first["bond_id_hi"] == gone)
    assert 0 < broken.sizes["bond"] == first.sizes["bond"] - int(held.sum())


def test_after_a_remap_no_bond_is_called_broken(run: Run, frame: Frame):
    packing = make_packing()
    state = first_state(packing, run.scene)
    shapes = maps.element_shapes(state, packing)
    told = []
    remapped = state.assign_attrs(effects=f"{state.attrs['effects']} remap")
    for last in (state, remapped):
        figure = bonds.bond_map(frame, state, last, shapes, "Bonds")
        told.append([text.get_text().partition(":")[0] for text in figure.legends[0].get_texts()])
    assert told == [["whole", "partly cracked", "broken"], ["whole", "partly cracked"]]


@pytest.mark.parametrize(
    "seconds, expected",
    [(5 * 86400.0, (86400.0, "days")), (86400.0, (3600.0, "hours")), (90.0, (60.0, "minutes"))],
)
def test_time_axis(seconds: float, expected: tuple[float, str]):
    assert series.time_axis(seconds) == expected


def test_units_are_the_largest_that_the_values_fill():
    assert series.pick_unit(series.AREA_UNITS, np.array([2.0e12])) == (1e12, "10⁶ km²")
    assert series.pick_unit(series.VOLUME_UNITS, np.array([5e8, np.nan])) == (1e6, "10⁶ m³")
    assert series.pick_unit(series.ENERGY_UNITS, np.array([np.nan])) == (1.0, "J")
    assert budget_unit("kg m/s", np.array([-3.0e15])) == (1e15, "10¹⁵ kg m/s")
    assert budget_unit("kg m/s", np.zeros(2)) == (1.0, "kg m/s")


def test_budget_bars_carry_numbers_and_residual():
    budget = {
        "label": "Ice volume",
        "unit": "m3",
        "change": 4.0e9,
        "terms": {"base": 5.0e9, "surface_melt": -1.0e9},
        "residual": 2.0e3,
        "relative": 3e-7,
        "verdict": "fair",
    }
    figure = budget_figure(budget)
    axes = figure.axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()] == [
        "base",
        "surface melt",
        "change",
    ]
    assert [bar.get_width() for bar in axes.patches] == [5.0, -1.0, 4.0]
    assert axes.get_title(loc="left") == (
        "Residual 2.0e+03 m³, 3.0e-07 relative in the worst window: fair"
    )
    assert axes.get_xlabel() == "Ice volume (km³)"


def test_cost_bars(tmp_path: Path):
    figure = cost_figure([("mask", 3.0, False), ("dynamics", 9.0, True)])
    assert [bar.get_width() for bar in figure.axes[0].patches] == [3.0, 9.0]
    assert texts(cost_figure([])) == ["nothing was timed"]
    data = style.write_png(figure, tmp_path / "cost.png", 60)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert style.as_svg(figure) == style.as_svg(figure)
