# SPDX-License-Identifier: GPL-2.0-or-later
"""One column from the command line: forcing of a place, record, figure, faults in one sentence."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.analysis.single_column.run import (
    PROCESSES,
    arguments,
    check,
    forcing_of,
    run,
    settings_of,
)
from floeflow.core.errors import FloeError

PROJECT = Path(__file__).resolve().parents[3]
HOURS = np.arange(0.0, 24.0 * 6 + 1)


def era5(hours: np.ndarray = HOURS) -> xr.Dataset:
    """A cold spell as ERA5 gives it, with sums of radiation and snow, at a point."""
    shape = hours.size
    values = {
        "u10": (np.full(shape, 3.0), "m s**-1"),
        "v10": (np.full(shape, -4.0), "m s**-1"),
        "t2m": (248.0 + 5.0 * np.sin(2.0 * np.pi * hours / 24.0), "K"),
        "d2m": (np.full(shape, 242.0), "K"),
        "msl": (np.full(shape, 1.01e5), "Pa"),
        "ssrd": (np.full(shape, 3600.0 * 20.0), "J m**-2"),
        "strd": (np.full(shape, 3600.0 * 180.0), "J m**-2"),
        "sf": (np.full(shape, 1e-5), "m of water equivalent"),
    }
    data = {name: ("valid_time", v, {"units": units}) for name, (v, units) in values.items()}
    time = ("valid_time", hours, {"units": "hours since 2020-01-01", "standard_name": "time"})
    return xr.Dataset(data, {"valid_time": time})


def asked(path: Path, *more: str):
    return arguments().parse_args([str(path), *more])


@pytest.fixture(name="forcing")
def forcing_file(tmp_path: Path) -> Path:
    era5().to_netcdf(tmp_path / "era5.nc")
    return tmp_path / "era5.nc"


@pytest.mark.parametrize(
    "more",
    [
        ["--scheme", "bl99", "--categories", "3"],
        ["--scheme", "mushy", "--layers", "5"],
        ["--scheme", "zero_layer", "--without", "mixed_layer"],
        ["--without", *PROCESSES],
        ["--thickness", "0"],
        ["--ponds", "--light", "delta_eddington", "--lon", "10", "--lat", "75"],
    ],
)
def test_a_run_leaves_its_record_and_its_picture(forcing: Path, tmp_path: Path, more: list[str]):
    out, picture = tmp_path / "out.nc", tmp_path / "deep/out.png"
    text = run(asked(forcing, "--output", str(out), "--figure", str(picture), *more))
    residuals = [float(each) for each in re.findall(r"(?:energy|water|salt) ([-+.e\d]+)", text)]
    assert 2 <= len(residuals) <= 3 and max(residuals) < 1e-8
    with xr.open_dataset(out) as data:
        assert data["time"].values[0] == np.datetime64("2020-01-01")
        assert data.sizes["time"] == 7 and "units" in data["ice_volume"].attrs
        volume = data["ice_volume"].values
        terms = sum(data[n].values[1:] for n in data if str(n).startswith("growth"))
        np.testing.assert_allclose(np.diff(volume), terms, atol=1e-12)
        if "--thickness" in more:
            assert volume[0] == 0.0 and np.isnan(data["ice_thickness"].values[0])
        assert volume[-1] > volume[0]
        assert ("snow_snowfall" in data) == ("snow" not in more)
    image = picture.read_bytes()
    assert image.startswith(b"\x89PNG") and len(image) > 20_000


def test_sums_and_dew_points_become_what_the_column_takes(forcing: Path):
    given = asked(forcing)
    values = forcing_of(given, settings_of(given))(3.25 * 86400.0)
    assert values["wind_u"][0] == pytest.approx(5.0)
    assert values["shortwave_down"][0] == pytest.approx(20.0, rel=1e-12)
    assert values["snowfall"][0] == pytest.approx(0.01 / 3600.0, rel=1e-12)
    assert values["air_temperature"][0] == pytest.approx(253.0)
    assert values["specific_humidity"][0] == pytest.approx(2.8e-4, rel=1e-2)
    assert values["ocean_heat_flux"][0] == 2.0
    assert "snowfall" not in forcing_of(given, settings_of(asked(forcing, "--without", "snow")))(0)


def test_mean_rates_are_of_the_hour_before(tmp_path: Path):
    data = era5().drop_vars("ssrd")
    # The mean of the hour up to h of light that grows by 2 W/m2 an hour is that of h - 1/2.
    data["avg_sdswrf"] = ("valid_time", 2.0 * (HOURS - 0.5) + 1.0, {"units": "W m**-2"})
    data.to_netcdf(tmp_path / "era5.nc")
    given = asked(tmp_path / "era5.nc")
    values = forcing_of(given, settings_of(given))(2.0 * 86400.0)
    assert values["shortwave_down"][0] == pytest.approx(2.0 * 48.0 + 1.0, rel=1e-9)


def test_the_nearest_point_of_a_grid_is_taken(forcing: Path, tmp_path: Path):
    point = era5()
    other = point.copy(deep=True)
    other["t2m"] = point["t2m"] + 9.0
    lat = ("latitude", [80.0, 75.0], {"units": "degrees_north"})
    lon = ("longitude", [10.0, 350.0], {"units": "degrees_east"})
    south = xr.concat([other, other], "longitude")
    north = xr.concat([other, point], "longitude")
    grid = xr.concat([north, south], "latitude").assign_coords(latitude=lat, longitude=lon)
    grid.to_netcdf(tmp_path / "grid.nc")
    there = asked(tmp_path / "grid.nc", "--lon", "-12", "--lat", "81")
    here = asked(forcing)
    ours, theirs = (forcing_of(each, settings_of(each))(1e5) for each in (there, here))
    assert -1.0 < ours.pop("sun_height")[0] < 0.0  # the night of the second of January
    assert ours == theirs
    with pytest.raises(FloeError, match="'l[a-z]+' has 2 values: name the place by --lon and"):
        nowhere = asked(tmp_path / "grid.nc")
        forcing_of(nowhere, settings_of(nowhere))


def test_a_column_reads_as_scenes_do(tmp_path: Path):
    """Days' means by their bounds, the level at the surface, a curvilinear grid, parts in files."""
    hourly = era5().drop_vars(["u10", "t2m"])
    hourly.to_netcdf(tmp_path / "surface.nc")
    days = np.arange(1.0, 8.0)
    lat, lon = np.meshgrid([70.0, 75.0, 80.0], [0.0, 20.0, 40.0], indexing="ij")
    level = np.array([100.0, 500.0, 1000.0])
    dims = ("time", "level", "j", "i")
    # Warmer by a degree a day, much colder aloft, 3 degrees warmer at the place that is asked for.
    warmth = 240.0 + days[:, None, None, None] + 0.05 * (level - 1000.0)[:, None, None]
    warmth = warmth + np.where((lat == 75.0) & (lon == 20.0), 3.0, 0.0)
    met = xr.Dataset(
        {
            "ta": (dims, warmth, {"standard_name": "air_temperature", "units": "K"}),
            "ua": (dims, 0 * warmth + 3.0, {"standard_name": "eastward_wind", "units": "m s-1"}),
            "va": (dims, 0 * warmth, {"standard_name": "northward_wind", "units": "m s-1"}),
            "time_bnds": (("time", "bnds"), np.stack([days - 1.0, days], axis=1)),
            "lat2": (("j", "i"), lat, {"units": "degrees_north"}),
            "lon2": (("j", "i"), lon, {"units": "degrees_east"}),
        },
        {
            "time": ("time", days, {"units": "days since 2020-01-01", "bounds": "time_bnds"}),
            "level": ("level", level, {"units": "hPa"}),
        },
    )
    met.to_netcdf(tmp_path / "met.nc")
    files = [str(tmp_path / "m*.nc"), str(tmp_path / "surface.nc")]
    given = arguments().parse_args([*files, "--lon", "19", "--lat", "76"])
    forcing = forcing_of(given, settings_of(given))
    # The mean of the third day stands at its noon.
    values = forcing(2.5 * 86400.0)
    assert values["air_temperature"][0] == pytest.approx(246.0, abs=1e-9)
    assert values["wind_u"][0] == pytest.approx(3.0)
    said = "\n".join(forcing.said)
    assert "level = 1000 hPa" in said and "means over time" in said and "dew_point: d2m" in said
    off = arguments().parse_args([*files, "--lon", "19", "--lat", "-70"])
    with pytest.raises(FloeError, match="--lat -70 lies off its map; the nearest point is 70.00 N"):
        forcing_of(off, settings_of(off))


def spoil(name: str, value: float) -> Callable[[xr.Dataset], None]:
    def change(data: xr.Dataset) -> None:
        data[name].values[30] = value

    return change


def units(name: str, text: str) -> Callable[[xr.Dataset], None]:
    def change(data: xr.Dataset) -> None:
        data[name].attrs["units"] = text

    return change


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (spoil("t2m", np.nan), "'t2m' is missing or not finite at 2020-01-02 06:00:00"),
        (spoil("u10", np.inf), "'u10' is missing or not finite at 2020-01-02 06:00:00"),
        (
            spoil("u10", 1e6),
            "'u10' is 1e.06 m s-1 at 2020-01-02 06:00:00, outside -150 to 150 m s-1",
        ),
        (spoil("ssrd", 1e9), "'ssrd' is 277778 W m-2 at 2020-01-02 05:30:00"),
        (units("t2m", "degC"), "'t2m' is 5\\d\\d.* K .* outside 150 to 350 K: check its units"),
        (units("msl", "furlong"), "'msl' has units 'furlong', not such as Pa"),
        (lambda d: d.drop_vars("t2m"), "has no air_temperature: no standard_name air_temp"),
        (lambda d: d.drop_vars("u10"), "has no wind: no standard_names eastward_wind and"),
        (lambda d: d.drop_vars("d2m"), "has no specific_humidity"),
        (lambda d: d.drop_isel(valid_time=[40, 41]), "gap from 2020-01-02 15:.* to 2020-01-02 18"),
        (lambda d: d.isel(valid_time=slice(None, None, -1)), "does not ascend"),
    ],
)
def test_bad_forcing_is_one_sentence(tmp_path: Path, change, sentence: str):
    data = era5()
    changed = change(data)
    (data if changed is None else changed).to_netcdf(tmp_path / "bad.nc")
    given = asked(tmp_path / "bad.nc")
    with pytest.raises(FloeError, match=sentence) as caught:
        forcing_of(given, settings_of(given))
    assert str(caught.value).startswith(str(tmp_path / "bad.nc"))


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (["--step", "0"], "--step must be above zero"),
        (["--thickness", "-1"], "--thickness must not be below zero"),
        (["--fraction", "1.5"], "--fraction must lie between 0 and 1"),
        (["--layers", "1"], "--layers must be 2 or more"),
        (["--lon", "3"], "--lon and --lat come together"),
        (["--ponds", "--scheme", "zero_layer"], "--ponds needs --scheme bl99 or mushy"),
        (["--scheme", "mushy", "--salinity", "0"], r"--salinity must be 0.5 \(1e-3\) or more"),
        (["--mixed-layer-depth", "nan"], "--mixed-layer-depth must be above zero"),
        (["--step", "1e-300"], "--step must be 1 s or more"),
        (["--days", "inf"], r"--days must be at most 1e\+06"),
        (["--thickness", "1e300"], "--thickness must be at most 20"),
        (["--categories", "1000000"], "--categories must be at most 20"),
        (["--ocean-heat-flux", "nan"], "--ocean-heat-flux must be at most 1000"),
        (["--lat", "999", "--lon", "0"], "--lat must be at most 90"),
    ],
)
def test_bad_numbers_are_one_sentence(more: list[str], sentence: str):
    with pytest.raises(FloeError, match=sentence):
        check(asked(Path("none.nc"), *more))


def test_values_that_would_fail_later_are_refused(forcing: Path):
    for word, sentence in (
        ("emissivity=[", r"--physics emissivity=\[: '\[' is no value"),
        ("emissivity=[1]", "physics.emissivity: input should be a valid number"),
    ):
        with pytest.raises(FloeError, match=sentence):
            settings_of(asked(forcing, "--physics", word))
    with pytest.raises(FloeError, match="--every 0.001 asks for .* records; at most 1000000 are"):
        run(asked(forcing, "--every", "1e-3"))


@pytest.mark.parametrize("option", ["--output", "--figure"])
def test_the_forcing_is_not_written_over(forcing: Path, option: str):
    given = asked(forcing, option, str(forcing))
    with pytest.raises(FloeError, match=f"{option} .*era5.nc: this is a file that is read"):
        forcing_of(given, settings_of(given))


def test_a_run_begins_within_its_forcing(forcing: Path):
    given = asked(forcing)
    later = asked(forcing, "--start", "2020-01-03T06:00")
    whole, part = (forcing_of(each, settings_of(each)) for each in (given, later))
    assert part.first == datetime(2020, 1, 3, 6) and part.length == whole.length
    assert part(3600.0) == whole(2.25 * 86400.0 + 3600.0)
    east = asked(forcing, "--start", "2020-01-03T08:00+02:00")
    assert forcing_of(east, settings_of(east)).first == part.first
    for text, sentence in (
        ("2019-12-31", "--start 2019-12-31 00:00:00: the forcing goes from 2020"),
        ("March", "--start March: give a time such as 2015-03-01T12:00"),
    ):
        outside = asked(forcing, "--start", text)
        with pytest.raises(FloeError, match=sentence):
            forcing_of(outside, settings_of(outside))


def test_a_run_that_begins_later_ends_with_the_forcing(forcing: Path, tmp_path: Path):
    out = tmp_path / "out.nc"
    more = ("--start", "2020-01-06", "--output", str(out), "--figure", str(tmp_path / "out.png"))
    run(asked(forcing, "--repeat", "2", *more))
    with xr.open_dataset(out) as data:
        assert data["time"].values[0] == np.datetime64("2020-01-06")
        assert data["time"].values[-1] == np.datetime64("2020-01-13")


def test_constants_are_those_of_a_scene(forcing: Path):
    given = asked(forcing, "--physics", "emissivity=0.95", "conductivity=maykut_untersteiner")
    physics = settings_of(given).physics
    assert (physics.emissivity, physics.conductivity) == (0.95, "maykut_untersteiner")
    for words, sentence in (
        ("emissivity=2", "physics.emissivity"),
        ("emisivity=0.9", "physics.emisivity"),
        ("emissivity", "--physics emissivity: give a key and its value"),
    ):
        with pytest.raises(FloeError, match=sentence):
            settings_of(asked(forcing, "--physics", words))


def test_a_constant_that_the_scheme_does_not_read_is_told(forcing: Path, caplog):
    words = ("--physics", "conductivity=maykut_untersteiner")
    settings_of(asked(forcing, "--scheme", "bl99", *words))
    assert not caplog.messages
    settings_of(asked(forcing, "--scheme", "mushy", *words))
    assert caplog.messages == [
        "physics.conductivity is given, but this scheme, light and effects do not read it"
    ]


def test_light_of_many_directions_asks_for_the_place(forcing: Path):
    given = asked(forcing, "--light", "delta_eddington")
    with pytest.raises(FloeError, match="needs the height of the sun: name --lon and --lat"):
        forcing_of(given, settings_of(given))


def test_the_command_says_what_is_wrong(tmp_path: Path):
    command = [
        sys.executable,
        "-m",
        "floeflow.cli",
        "column",
        str(tmp_path / "none.nc"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr == f"floeflow: {tmp_path / 'none.nc'}: there is no such file\n"


def test_the_tutorial_makes_its_forcing_and_runs(shared: Path, tmp_path: Path, monkeypatch):
    text = (PROJECT / "docs/tutorial_column.md").read_text()
    block = re.search(r"```python\n(.*?)```", text, re.S)
    assert block is not None
    table = shared / "data/era5_arctic_point_hourly_2012.txt"
    if not table.is_file():
        pytest.skip(f"no reference data at {table}")
    (tmp_path / table.name).symlink_to(table)
    monkeypatch.chdir(tmp_path)
    exec(compile(block[1], "tutorial", "exec"), {})
    commands = re.findall(r"^\$ .venv/bin/floeflow column (.*)$", text, re.M)
    assert len(commands) >= 2
    text = run(arguments().parse_args([*commands[0].split(), "--days", "5"]))
    assert (tmp_path / "column.nc").is_file() and "largest residual" in text
    for command in commands:
        arguments().parse_args(command.split())
