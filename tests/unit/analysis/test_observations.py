# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs beside observations that were made from them: what must come out is known."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from scipy.spatial import cKDTree

from floeflow.analysis.observations.compare import STAGES, Observed, compare
from floeflow.analysis.observations.drift_errors import (
    Carrier,
    at_boundaries,
    carrier,
    lead_errors,
    velocity_carrier,
)
from floeflow.analysis.observations.point_files import read_points
from floeflow.core.errors import FloeError
from floeflow.core.grids import scene_crs, to_lonlat
from floeflow.diagnostics.diagnostics import diagnose, write_json
from floeflow.diagnostics.followed import frame_of
from floeflow.diagnostics.study_summaries import read_summary, valid_summaries
from floeflow.scene.hashes import stage_hash
from floeflow.state import read_state, write_dataset
from support.synthetic import WINDOW, Run, make_run

START = datetime(2020, 1, 30)
IABP = """BuoyID Year Hour Min DOY POS_DOY Lat Lon BP Ts Ta
300234 2020 6 0 30.25 30.25 85.10 -120.5 1012 -999 -20
300234 2020 12 0 30.50 30.50 -999 -999 1012 -999 -20
300234 2020 18 0 30.75 30.75 85.20 -121.5 1012 -999 -20
"""


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("300234.dat", IABP),
        (
            "DN1_300234_p1.csv",
            "datetime (UTC),latitude (deg),longitude (deg)\n"
            "2020-01-30 06:00:00,85.1,-120.5\n2020-01-30 18:00:00,85.2,-121.5\n",
        ),
        (
            "any.csv",
            "# mine\nlon;id;time;lat\n-120.5;300234;2020-01-30T07:00:00+01:00;85.1\n"
            "-121.5;300234;2020-01-30T18:00Z;85.2\n",
        ),
    ],
)
def test_known_layouts_say_the_same(name: str, text: str, tmp_path: Path):
    path = tmp_path / name
    path.write_text(text)
    found = read_points(path, START)
    assert found.seconds.tolist() == [6 * 3600.0, 18 * 3600.0]
    assert found.lon.tolist() == [-120.5, -121.5] and found.lat.tolist() == [85.1, 85.2]
    assert set(found.id) == {"DN1_300234_p1" if name.startswith("DN") else "300234"}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,lon\n2020-01-30,5\n", "line 1 names no column for lat"),
        ("lon,lat\n5,80\n", "line 1 names no column for time"),
        ("time,lon,lat\n30 Jan,5,80\n", "line 2: time '30 Jan' is not a date"),
        ("time,lon,lat\n2020-01-30,5,eighty\n", "line 2: lat 'eighty' is not a number"),
        ("time,lon,lat\n2020-01-30,5,98\n", "line 2: longitude 5 and latitude 98 are no place"),
        ("time,lon,lat\n2020-01-30,5\n", "line 2 has 2 columns, not 3"),
        ("time,lon,lat\n", "no line below its names has a place"),
        ("", "holds no line"),
    ],
)
def test_what_makes_no_sense_is_named(text: str, said: str, tmp_path: Path):
    path = tmp_path / "x.csv"
    path.write_text(text)
    with pytest.raises(FloeError, match=f"x.csv: .*{said}"):
        read_points(path, START)


def test_places_at_boundaries_end_at_long_gaps():
    hours = np.array([0.0, 6.0, 12.0, 48.0]) * 3600.0
    places = at_boundaries(hours, hours, 0 * hours, np.array([3.0, 12.0, 24.0, 60.0]) * 3600.0)
    np.testing.assert_allclose(places[:2], np.array([3.0, 12.0]) * 3600.0)
    assert np.isnan(places[2:]).all()


def still(moved: complex) -> Carrier:
    x, y = (each.ravel() for each in np.meshgrid(np.arange(9) * 1e4, np.arange(9) * 1e4))
    return Carrier(cKDTree(np.stack([x, y], axis=1)), np.full(x.size, moved), 2e4)


def test_a_run_that_is_off_by_a_share_errs_in_step_with_the_lead():
    truth = 2e4 + 2e4j + 1e3 * np.arange(9)
    carriers = [still(1.1e3 + 0j)] * 8
    found = lead_errors([truth], carriers, lambda _, places: np.full(places.shape, 900.0 + 0j), 4)
    np.testing.assert_allclose(found.rms[0], 100.0 * found.lead, rtol=1e-9)
    np.testing.assert_allclose(found.rms[1], 0.0, atol=1e-9)
    np.testing.assert_allclose(found.rms[2], 100.0 * found.lead, rtol=1e-9)
    np.testing.assert_allclose(found.along, [100.0 * found.lead, 0 * found.lead], atol=1e-9)
    np.testing.assert_allclose(found.skill("free_drift"), 0.0, atol=1e-9)
    assert found.count.tolist() == [7, 6, 5, 4]


def test_buoys_out_of_reach_are_refused():
    with pytest.raises(FloeError, match="buoys: none has fixes"):
        lead_errors([1e6 + 1e3 * np.arange(9)], [still(1e3 + 0j)] * 8, None, 4)


def test_velocities_stand_in_where_a_remap_cut_the_tracks(run: Run):
    one, two = (frame_of(read_state(run.state(k))) for k in (1, 2))
    place = np.array([complex(one.x.mean() - 5e4, one.y.mean())])
    by_step, by_velocity = (make(one, two).at(place) for make in (carrier, velocity_carrier))
    # Drift grows from 0.04 to 0.08 m/s along x: the mean of both ends lags behind the window's.
    assert by_velocity[0].real == pytest.approx(0.75 * by_step[0].real, rel=0.02)


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, str]:
    """A run beside tables and a grid that were made from it."""
    run = make_run(tmp_path_factory.mktemp("compared"))
    data, numbers = diagnose(run.files, run.scene.effects, run.scene.domain)
    write_dataset(data, run.folder / "diagnostics.nc")
    write_json(numbers, run.folder / "diagnostics.json")
    resolved = yaml.safe_dump(run.scene.model_dump(mode="json"))
    (run.folder / "scene.yaml").write_text(resolved)
    crs, start = scene_crs(run.scene.domain), run.scene.time.start
    lines = ["id,time,lon,lat"]
    for number in (20, 60, 100):
        for window in range(4):
            state = read_state(run.state(window))
            x, y = (state[name].values[number : number + 1] for name in ("x", "y"))
            lon, lat = to_lonlat(crs, x, y)
            when = start + timedelta(seconds=window * WINDOW)
            lines.append(f"b{number},{when.isoformat()},{lon[0]:.9f},{lat[0]:.9f}")
    buoys = run.root / "buoys.csv"
    buoys.write_text("\n".join(lines))
    with xr.open_dataset(run.grid, decode_times=False) as opened:
        grid = opened.load()
    when = run.root / "seen.nc"
    seen = grid[["siconc"]].clip(0.0, 1.0)
    seen["time"] = grid["time"].assign_attrs(units=f"seconds since {start:%Y-%m-%d %H:%M:%S}")
    for axis in "xy":
        seen[axis].attrs |= {"standard_name": f"projection_{axis}_coordinate", "units": "m"}
    seen["crs"] = ((), 0, crs.to_cf())
    seen["siconc"].attrs |= {"grid_mapping": "crs", "standard_name": "sea_ice_area_fraction"}
    seen.to_netcdf(when)
    middle = grid["sithick"].values[1]
    row, column = np.argwhere(np.isfinite(middle))[3]
    lon, lat = to_lonlat(crs, grid["x"].values[[column]], grid["y"].values[[row]])
    thick = run.root / "thick.csv"
    thick.write_text(
        f"time,lon,lat,thickness\n{(start + timedelta(seconds=WINDOW)).isoformat()},"
        f"{lon[0]},{lat[0]},{middle[row, column] - 0.25}\n"
    )
    said = compare(run.folder, Observed([buoys], [thick], when), [run.folder])
    return run, said


def test_a_run_agrees_with_what_was_made_from_it(compared: tuple[Run, str]):
    run, said = compared
    with xr.open_dataset(run.folder / "comparison/comparison.nc") as data:
        data.load()
    # Virtual buoys go with their neighbours' mean: 100 m of some 2 km.
    assert data["drift_error"].sel(forecast="run").values[0] < 100.0
    assert data["drift_error"].values[0, 0] < data["drift_error"].values[1, 0]
    assert np.allclose(data["edge_over"].values + data["edge_under"].values, 0.0)
    assert data["edge_time"].values[0] == np.datetime64("1981-12-31T00:00:00")
    offset = data["thickness_run"].values - data["thickness_observed"].values
    assert offset == pytest.approx([0.25])
    assert "+0.25 m" in said and "3 buoys" in said


def test_the_report_finds_the_comparison(compared: tuple[Run, str]):
    run, _ = compared
    keys = "-".join(stage_hash(run.scene, stage) for stage in STAGES)
    (path,) = valid_summaries(run.folder, keys)
    digest = read_summary(Path(path))
    titles = [table["title"] for table in digest["tables"]]
    assert titles == ["Drift error against lead time", "Runs side by side"]
    assert {drawing["name"] for drawing in digest["drawings"]} == {
        *("buoys", "displacements", "edge", "thickness", "runs")
    }


def test_folders_without_a_finished_run_are_named(tmp_path: Path):
    with pytest.raises(FloeError, match="holds no run"):
        compare(tmp_path, Observed())
    (tmp_path / "scene.yaml").write_text("name: x\n")
    with pytest.raises(FloeError, match="has not ended"):
        compare(tmp_path, Observed())
