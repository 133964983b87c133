# SPDX-License-Identifier: GPL-2.0-or-later
"""Thickness by place and day, where a mask has none."""

from __future__ import annotations

from datetime import datetime

import numpy as np

from floeflow.masks.thickness_climatology import climatological_thickness

LON, LAT = np.array([[0.0, -60.0, 110.0, 45.0]]), np.array([[90.0, 84.0, 80.0, 74.0]])


def test_thick_north_of_greenland_thin_off_siberia_in_both_seasons() -> None:
    may = climatological_thickness(LON, LAT, datetime(1982, 5, 10))
    september = climatological_thickness(LON, LAT, datetime(1982, 9, 15))
    for found in (may, september):
        assert found.shape == LON.shape
        pole, greenland, siberia, barents = found[0]
        assert greenland > pole > siberia > barents > 0.0
    # Submarines found a swing of the basin's mean of about a metre (Rothrock et al. 2008).
    assert 0.6 < (may - september)[0, :3].mean() < 1.4


def test_the_south_is_thickest_in_its_own_spring() -> None:
    lon, lat = np.array([-50.0, 60.0]), np.array([-70.0, -65.0])
    thick = climatological_thickness(lon, lat, datetime(1982, 10, 1))
    thin = climatological_thickness(lon, lat, datetime(1982, 3, 1))
    assert np.all(thick > thin) and thick[0] > 2.0 * thick[1]


def test_the_year_s_mean_is_what_submarines_found() -> None:
    """A mean draft of 2.97 m is 3.3 m of ice (Rothrock et al. 2008); the table is within a tenth.

    Places of their area: beyond 75 N between 150 E and 125 W, and the pole.
    """
    lon, lat = np.meshgrid(np.arange(150.0, 236.0, 5.0), np.arange(75.0, 90.0, 1.0))
    days = [datetime(1982, month, 15) for month in range(1, 13)]
    mean = [
        np.average(climatological_thickness(lon, lat, day), weights=np.cos(np.deg2rad(lat)))
        for day in days
    ]
    assert abs(np.mean(mean) / 3.3 - 1.0) < 0.1
