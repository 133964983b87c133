# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of a packing on cases whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.packings.packing import make_packing
from floeflow.packings.quality import LABELS, neighbour_counts, quality
from floeflow.scene.blocks import Packing, Sizes
from unit.packings.test_floes import image as floe_image
from unit.packings.test_floes import mask_of_floes
from unit.packings.test_packing import coastline, mask_of


def test_figures_of_a_tessellation_stand_in_the_file() -> None:
    mask = coastline()
    made = make_packing(mask, Packing(elements=400, size=Sizes(coast=0.5)), 1)
    figures = quality(mask, made)
    for name, value in figures.items():
        assert float(made[f"quality_{name}"]) == value
        assert made[f"quality_{name}"].attrs["long_name"] == LABELS[name][0]
    assert abs(figures["area_error"]) < 1e-12 and abs(figures["volume_error"]) < 1e-12
    assert figures["overlap"] == 0.0
    # Euler: nearly six sides a cell, less along shores and edges.
    assert 4.0 < figures["neighbours"] < 6.0
    assert figures["anisotropy"] < 0.1
    assert 0.0 < float(made["quality_size_error"]) < 0.3
    ratio = made["size_ratio"].values[made["type"].values == 1]
    assert ratio.std() == float(made["quality_size_error"]) and 0.8 < ratio.mean() < 1.2
    sides, touching = neighbour_counts(made)
    assert sides.mean() == pytest.approx(figures["neighbours"])
    assert touching.mean() == pytest.approx(figures["coordination"])
    radius = made["radius"].values[made["type"].values == 1]
    assert figures["radius_least"] == radius.min() and figures["radius_largest"] == radius.max()


def test_figures_of_a_square_lattice() -> None:
    mask = mask_of(np.ones((20, 20)), np.zeros((20, 20), bool))
    made = make_packing(mask, Packing(elements=100), 1)
    at = (np.arange(10) + 0.5) * 1e5
    x, y = np.meshgrid(at + float(mask["x"][0]) - 2.5e4, at)
    row = np.arange(100).reshape(10, 10)
    pairs = np.concatenate(
        [np.stack([row[:, :-1], row[:, 1:]], -1).reshape(-1, 2),
         np.stack([row[:-1], row[1:]], -1).reshape(-1, 2)]
    )  # fmt: skip
    made = made.drop_dims("edge").isel(element=np.arange(100))
    made["x"], made["y"] = ("element", x.ravel()), ("element", y.ravel())
    made["radius"] = ("element", np.full(100, 5.0e4))
    made["edge_lo"], made["edge_hi"] = ("edge", pairs[:, 0] + 1), ("edge", pairs[:, 1] + 1)
    figures = quality(mask, made)
    assert figures["coordination"] == figures["neighbours"] == pytest.approx(3.6)
    assert figures["anisotropy"] == pytest.approx(0.0, abs=1e-12)
    assert figures["disc_share"] == pytest.approx(np.pi / 4)
    assert figures["overlap"] == pytest.approx(0.0, abs=1e-12)
    made["radius"] = ("element", np.full(100, 5.5e4))
    assert quality(mask, made)["overlap"] == pytest.approx(1 - 1 / 1.1)


def test_discs_keep_near_the_outlines_of_their_floes() -> None:
    mask = mask_of_floes(floe_image())
    made = make_packing(mask, Packing(generator="floes", elements=300), 3, False)
    coarse = make_packing(mask, Packing(generator="floes", elements=60), 3, False)
    fine = float(made["quality_outline_distance"])
    assert fine < 0.5 * float(made["quality_radius_median"])
    assert fine < float(coarse["quality_outline_distance"])
