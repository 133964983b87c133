# SPDX-License-Identifier: GPL-2.0-or-later
"""The map with a time slider: bytes that a reader can turn back into the fields."""

from __future__ import annotations

import base64
import zlib
from datetime import datetime

import numpy as np
import pytest
import xarray as xr

from floeflow.report.figures.frame import Frame
from floeflow.report.map_player import (
    FIELDS,
    chosen_frames,
    encode_frames,
    land_path,
    make_player,
    round_up,
    time_labels,
    with_tendencies,
)
from floeflow.scene.blocks import Domain

DOMAIN = Domain(x_min=-2e5, x_max=2e5, y_min=-1e5, y_max=1e5, spacing=5e4)
NY, NX, TIMES = 4, 8, 3


def grid() -> xr.Dataset:
    """Ice in the lower left half that thickens with time; drift to the right."""
    x, y = -1.75e5 + 5e4 * np.arange(NX), -7.5e4 + 5e4 * np.arange(NY)
    cover = np.zeros((TIMES, NY, NX))
    cover[:, :2, :4] = 0.8
    thick = np.where(cover > 0, 1.0 + np.arange(TIMES)[:, None, None], np.nan)
    u = np.where(cover > 0, 0.1, np.nan)
    fields = {"siconc": cover, "sithick": thick, "siu": u, "siv": 0.0 * u}
    return xr.Dataset(
        {name: (("time", "y", "x"), values) for name, values in fields.items()},
        {"x": x, "y": y, "window": ("time", np.arange(TIMES))},
    )


def frame() -> Frame:
    land = np.zeros((8, 16))
    land[:, 12:] = 1
    axes = {"y": -8.75e4 + 2.5e4 * np.arange(8), "x": -1.875e5 + 2.5e4 * np.arange(16)}
    return Frame(DOMAIN, xr.DataArray(land, axes, ("y", "x")))


def unpack(text: str) -> np.ndarray:
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8)


def test_frames_come_back_to_half_a_level():
    player = make_player(grid(), frame(), datetime(1982, 1, 1), 86400.0)
    assert player is not None
    layers = {layer["name"]: layer for layer in player["layers"]}
    assert list(layers) == ["thickness", "concentration", "drift"]
    thickness = layers["thickness"]
    levels = unpack(thickness["data"]).reshape(TIMES, NY, NX)
    # From the top of the map down.
    ice = levels[:, 2:, :4].astype(float)
    assert not levels[:, :2].any() and not levels[:, :, 4:].any()
    low, high = thickness["low"], thickness["high"]
    back = low + (ice - 1) / 254 * (high - low)
    expected = 1.0 + np.arange(TIMES)[:, None, None] + 0.0 * ice
    np.testing.assert_allclose(back, expected, atol=(high - low) / 508 + 1e-9)
    assert thickness["source"] == "grid.nc: sithick"
    assert layers["drift"]["unit"] == "cm/s"
    assert len(base64.b64decode(thickness["palette"])) == 3 * 255
    assert player["times"] == ["01 Jan 1982", "02 Jan 1982", "03 Jan 1982"]


def test_stress_and_age_are_shown_where_a_scene_has_them():
    """Pressure is compression: a scale from tension below zero up, in kN/m; age in days."""
    data = grid()
    ice = data["sithick"].notnull()
    rows = np.linspace(-40e3, 10e3, NX)[None, None, :] + 0.0 * data["sithick"]
    data = data.assign(
        sistresave=rows.where(ice), sistremax=(5e3 + 0.0 * rows).where(ice),
        siage=(2.0 * 86400.0 + 0.0 * rows).where(ice),
    )  # fmt: skip
    player = make_player(data, frame(), datetime(1982, 1, 1), 86400.0)
    assert player is not None
    layers = {layer["name"]: layer for layer in player["layers"]}
    assert list(layers) == [
        "thickness", "concentration", "drift", "pressure", "shear_stress", "age",
    ]  # fmt: skip
    for name, unit, expected in (
        ("pressure", "kN/m", -1e-3 * rows.values[:, :2, :4]),
        ("shear_stress", "kN/m", 5.0),
        ("age", "days", 2.0),
    ):
        layer = layers[name]
        levels = unpack(layer["data"]).reshape(TIMES, NY, NX)[:, 2:, :4].astype(float)
        back = layer["low"] + (levels - 1) / 254 * (layer["high"] - layer["low"])
        step = (layer["high"] - layer["low"]) / FIELDS[name].steps
        assert layer["unit"] == unit
        np.testing.assert_allclose(back, expected + 0.0 * back, atol=step, err_msg=name)
    tension = data.assign(sistresave=-data["sistresave"])
    player = make_player(tension, frame(), datetime(1982, 1, 1), 86400.0)
    assert player is not None
    low = next(each["low"] for each in player["layers"] if each["name"] == "pressure")
    assert -45.0 <= low <= -40.0


def test_tendencies_stand_at_the_ends_of_their_windows():
    """In cm of ice a day, on a scale that is as long to both sides; nothing before the start."""
    data = grid()
    day = 917.0 / 100.0 / 86400.0
    shape = ("time", "y", "x")
    values = np.zeros((TIMES - 1, NY, NX))
    # Freezes, then melts; what drifted into water and away again shows there too.
    values[:, :2, :4] = np.array([2.0, -1.0])[:, None, None] * day
    moved = np.zeros_like(values)
    moved[1, 3, 7] = 0.5 * day
    made = xr.Dataset(
        {"sidmassth": (shape, values), "sidmassdyn": (shape, moved), "window": ("time", [1, 2])}
    )
    player = make_player(with_tendencies(data, made), frame(), datetime(1982, 1, 1), 86400.0)
    assert player is not None
    layers = {layer["name"]: layer for layer in player["layers"]}
    assert list(layers)[-2:] == ["growth", "moved"]
    growth = layers["growth"]
    assert growth["source"] == "tendencies.nc: sidmassth" and growth["none"] == "no value"
    assert growth["low"] == -growth["high"] == -2.0
    levels = unpack(growth["data"]).reshape(TIMES, NY, NX)[:, ::-1].astype(float)
    assert not levels[0].any()
    back = growth["low"] + (levels[1:, :2, :4] - 1) / 254 * (growth["high"] - growth["low"])
    step = (growth["high"] - growth["low"]) / FIELDS["growth"].steps
    np.testing.assert_allclose(back, values[:, :2, :4] / day, atol=step)
    levels = unpack(layers["moved"]["data"]).reshape(TIMES, NY, NX)[:, ::-1]
    assert levels[2, 3, 7] > 128 and levels[2, 3, 6] == 0
    # Zero is the palest colour.
    palette = np.frombuffer(base64.b64decode(growth["palette"]), np.uint8).reshape(255, 3)
    assert palette.astype(int).sum(axis=1).argmax() in (126, 127, 128)
    assert with_tendencies(data, None) is data


def test_arrows_point_where_the_ice_goes():
    player = make_player(grid(), frame(), datetime(1982, 1, 1), 86400.0)
    assert player is not None
    arrows = player["arrows"]
    u, v = unpack(arrows["data"]).view(np.int8).reshape(2, TIMES, arrows["rows"], arrows["columns"])
    assert (u[:, 2:, :4] == 127).all() and not v.any() and not u[:, :2].any()
    assert arrows["top"] == pytest.approx(10.0)


def test_values_beyond_the_scale_and_missing_ones():
    levels = encode_frames(np.array([np.nan, -1.0, 0.0, 5.0, 10.0, 99.0]), 0.0, 10.0)
    assert levels.tolist() == [0, 1, 1, 128, 255, 255]


def test_a_coarse_scale_keeps_its_ends_and_its_middle():
    values = np.linspace(-1.0, 1.0, 2001)
    levels = encode_frames(values, -1.0, 1.0, 62)
    assert len(np.unique(levels)) == 63
    assert levels[[0, 1000, -1]].tolist() == [1, 128, 255]
    fine = encode_frames(values, -1.0, 1.0)
    assert abs(levels.astype(int) - fine.astype(int)).max() <= 3
    assert {field.steps % 2 for field in FIELDS.values()} == {0}


def test_land_is_drawn_where_the_mask_has_it():
    path = land_path(frame().land)
    numbers = [float(part) for part in path.replace("M", " ").replace("L", " ").rstrip("Z").split()]
    x = np.array(numbers[::2])
    # Half way between the centres of the last cell of sea and the first of land.
    assert x.min() == pytest.approx(100.0)
    assert x.max() >= 200.0
    assert land_path(0 * frame().land) == ""


def test_scales_end_on_round_numbers():
    assert [round_up(value) for value in (0.93, 3.87, 11.2, 47.0)] == [1.0, 4.0, 12.0, 50.0]


def test_thousands_of_windows_are_thinned_with_the_last_kept():
    assert chosen_frames(365).tolist() == list(range(365))
    many = chosen_frames(4000)
    assert len(many) <= 1501 and many[0] == 0 and many[-1] == 3999


def test_hours_stand_where_windows_are_shorter_than_days():
    start = datetime(1982, 1, 1)
    assert time_labels(start, [0.0, 21600.0]) == ["01 Jan 1982 00:00", "01 Jan 1982 06:00"]


def test_every_field_names_what_it_needs():
    assert all(field.needs and field.text.endswith(".") for field in FIELDS.values())
