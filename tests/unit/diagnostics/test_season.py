# SPDX-License-Identifier: GPL-2.0-or-later
"""The seasonal cycle from fields, gates and displacements that are known."""

from __future__ import annotations

import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.diagnostics import season

CRS = "EPSG:6931"


def grid_of(share: np.ndarray, metres: np.ndarray, months: list[str]) -> xr.Dataset:
    """Two cells of 10 and 20 km2 of sea; the first in the central basin, the other off Norway."""
    lonlat = {"lon": (("y", "x"), [[180.0, 10.0]]), "lat": (("y", "x"), [[86.0, 70.0]])}
    return xr.Dataset(
        {
            "siconc": (("time", "y", "x"), share[:, None, :]),
            "sivol": (("time", "y", "x"), (share * metres)[:, None, :]),
            "sea_area": (("y", "x"), [[1e7, 2e7]]),
        },
        coords={"time": np.array(months, "datetime64[ns]"), **lonlat},
    )


def test_cycle_of_two_cells() -> None:
    share = np.array([[1.0, 0.5], [0.8, 0.3], [0.6, 0.1]])
    metres = np.array([[3.0, 1.0], [2.0, 1.0], [1.0, 1.0]])
    found = season.cycle(grid_of(share, metres, ["1982-03-01", "1982-03-31", "1982-09-15"]))
    np.testing.assert_array_equal(found.months, np.array(["1982-03", "1982-09"], "datetime64[M]"))
    np.testing.assert_allclose(found.area, [(20e6 + 14e6) / 2, 8e6])
    # Less than 15 % counts as open.
    np.testing.assert_allclose(found.extent, [3e7, 1e7])
    np.testing.assert_allclose(found.volume, [(40e6 + 22e6) / 2, 8e6])
    np.testing.assert_allclose(found.thickness, [2.5, 1.0])
    assert season.swing(found) == pytest.approx(1.5)
    assert season.month_of(found, found.extent, largest=True) == 3
    assert season.month_of(found, found.extent, largest=False) == 9
    assert season.by_month(found, found.area) == pytest.approx({3: 17e6, 9: 8e6})


def test_concentration_in_per_cent_is_read_as_such() -> None:
    share = np.array([[0.5, 0.1]])
    grid = grid_of(share, np.ones((1, 2)), ["1982-03-01"])
    given = grid.assign(siconc=(100.0 * grid["siconc"]).assign_attrs(units="%"))
    found, told = season.cycle(given), season.cycle(grid)
    np.testing.assert_allclose([found.area, found.extent], [told.area, told.extent], rtol=1e-12)
    assert found.extent[0] == 1e7


def test_the_central_basin_ends_where_ice_leaves_it() -> None:
    lon, lat = np.array([180.0, 0.0, 0.0, -100.0]), np.array([79.0, 83.0, 86.0, 81.0])
    assert season.central(lon, lat).tolist() == [False, False, True, True]


def chunk_of(windows: list[int], paths: list[dict[int, float]]) -> xr.Dataset:
    """Elements near the pole at ends of windows: displacement in x by id."""
    ids = [key for path in paths for key in path]
    x, y = pyproj.Transformer.from_crs("EPSG:4326", CRS, always_xy=True).transform(180.0, 86.0)
    many = len(ids)
    times = np.array([f"1982-01-{1 + w:02d}" for w in windows], "datetime64[ns]")
    return xr.Dataset(
        {
            "id": ("element", ids),
            "type": ("element", np.ones(many, np.int8)),
            "x": ("element", np.full(many, x)),
            "y": ("element", np.full(many, y)),
            "drift_x": ("element", [v for path in paths for v in path.values()]),
            "drift_y": ("element", np.zeros(many)),
            "element_count": ("boundary", [len(path) for path in paths]),
            "window": ("boundary", windows),
            "time": ("boundary", times),
        }
    )


def test_drift_between_ends_of_windows_across_chunks() -> None:
    # Element 7 is born in window 2; window 3 ends with a remap.
    first = chunk_of([1, 2], [{4: 0.0, 5: 0.0}, {5: 864.0, 4: 1728.0, 7: 9e9}])
    second = chunk_of([3, 4], [{4: 1e7}, {4: 1e7 + 8640.0}])
    found = season.drift([first, second], [3], CRS, 86400.0)
    np.testing.assert_allclose(found.median, [0.02])
    np.testing.assert_allclose([found.lower[0], found.upper[0]], [0.015, 0.06])


def test_gates_and_totals_add_up() -> None:
    series = [
        xr.Dataset(
            {
                "gate_area_a": ("window", [1.0, 2.0]),
                "gate_volume_a": ("window", [3.0, -1.0]),
            }
        )
    ] * 2
    assert season.passed(series, "a") == (6.0, 4.0)
    assert season.total(series, "gate_area_a") == 6.0


def test_sums_by_month_of_terms_that_add_up() -> None:
    names = ("new", "gone", "missing")
    terms = {"new": ("window", [1.0, 2.0]), "gone": ("window", [0.0, -0.5])}
    chunks = [xr.Dataset(terms, coords={"window": numbers}) for numbers in ([30, 31], [32, 33])]
    found = season.month_sums(chunks, names, "1982-01-01T00:00:00", 86400.0)
    # The 31st window ends with the 31st of January.
    assert found == {"1982-01": 2.5, "1982-02": 2.5}


def test_ridged_shares_of_two_cells() -> None:
    share, metres = np.array([[1.0, 0.5], [1.0, 0.5]]), np.array([[3.0, 1.0], [3.0, 1.0]])
    grid = grid_of(share, metres, ["1982-03-01", "1982-03-31"])
    there, none = [[0.4, 0.0]], [[0.2, 0.0]]
    grid["sirdgconc"] = (("time", "y", "x"), np.array([there, none]))
    grid["sirdgthick"] = (("time", "y", "x"), np.array([[[5.0, np.nan]]] * 2))
    found = season.ridged(grid)
    np.testing.assert_allclose(found.area, [0.3e7 / 2e7])
    np.testing.assert_allclose(found.volume, [1.5e7 / 4e7])
