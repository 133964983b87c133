# SPDX-License-Identifier: GPL-2.0-or-later
"""Forcing from several files: each quantity from the first that has it, the rest stood in for."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.forcings import files, forcing
from floeflow.forcings.inputs import check_forcing_file, described
from floeflow.scene.blocks import Scene

AWAY = {"x_min": -2e6, "x_max": -1e6, "y_min": 4e5, "y_max": 1.2e6, "spacing": 2e5}
UNITS = "hours since 1981-12-31 00:00:00"
COLUMN = ("wind", "ocean_drag", "thermodynamics", "snow", "shortwave")
ERA5 = {
    "u10": (3.0, "m s**-1"),
    "v10": (4.0, "m s**-1"),
    "t2m": (250.0, "K"),
    "d2m": (248.0, "K"),
    "msl": (101000.0, "Pa"),
}
SUMS = {"ssrd": (3.6e5, "J m**-2"), "strd": (7.2e5, "J m**-2"), "sf": (1e-4, "m")}


def gridded(
    fields: dict[str, tuple[Any, str]], first: float = -1.0, last: float = 48.0, lat: float = 2.5
) -> xr.Dataset:
    hours = np.arange(first, last + 0.5)
    axes = np.arange(50.0, 90.1, lat), np.arange(0.0, 360.0, 5.0)
    shape = (hours.size, axes[0].size, axes[1].size)
    coords = {
        "time": ("time", hours, {"units": UNITS}),
        "lat": ("lat", axes[0], {"units": "degrees_north"}),
        "lon": ("lon", axes[1], {"units": "degrees_east"}),
    }
    data = {
        name: (tuple(coords), np.full(shape, value, dtype=float), {"units": units})
        for name, (value, units) in fields.items()
    }
    return xr.Dataset(data, coords)


def scene_of(*files: Path | str, **block: Any) -> Scene:
    values = {"source": "file", "files": tuple(str(item) for item in files), **block}
    return Scene.model_validate(
        {"name": "t", "domain": AWAY, "effects": COLUMN, "forcing": values, "time": {"windows": 2}}
    )


def make(scene: Scene, window: int = 1) -> xr.Dataset:
    check_forcing_file(scene)
    return forcing.make_forcing(scene, files.forcing_files(scene), window)


def test_an_atmosphere_alone_needs_what_stands_in_for_the_ocean(tmp_path: Path) -> None:
    gridded(ERA5 | SUMS).to_netcdf(tmp_path / "era5.nc")
    with pytest.raises(FloeError, match=r"has no ocean: .* forcing.fallback.ocean$"):
        make(scene_of(tmp_path / "era5.nc"))
    made = make(scene_of(tmp_path / "era5.nc", fallback={"ocean": "rest"}))
    assert (made["ocean_u"].values == 0).all() and (made["ocean_v"].values == 0).all()
    speed = np.hypot(made["wind_u"], made["wind_v"])
    np.testing.assert_allclose(speed, 5.0, rtol=1e-3)
    scene = scene_of(tmp_path / "era5.nc", fallback={"ocean": "gyre"})
    assert float(np.hypot(*(make(scene)[f"ocean_{axis}"] for axis in "uv")).max()) > 0.01
    lines = described(scene)
    assert "ocean: forcing.fallback: gyre" in lines
    assert any(line.startswith("wind: u10, v10 of ") for line in lines)


def test_an_ocean_alone_names_all_that_is_missing_at_once(tmp_path: Path) -> None:
    current = {"uo": (0.1, "m s-1"), "vo": (0.0, "m s-1")}
    gridded(current).to_netcdf(tmp_path / "ocean.nc")
    with pytest.raises(FloeError) as caught:
        make(scene_of(tmp_path / "ocean.nc"))
    said = str(caught.value)
    for word in ("wind", "air_temperature", "specific_humidity", "longwave_down", "snowfall"):
        assert f"no {word}" in said
    assert "no air_pressure" not in said  # it has a default
    assert said.endswith("in forcing.fallback.wind, forcing.fallback.weather")
    stand_ins = {"wind": "cyclone", "weather": "weather"}
    made = make(scene_of(tmp_path / "ocean.nc", fallback=stand_ins))
    np.testing.assert_allclose(np.hypot(made["ocean_u"], made["ocean_v"]), 0.1, rtol=1e-3)
    assert (made["air_temperature"].values == 248.15).all()


def test_each_quantity_comes_from_the_first_file_that_has_it(tmp_path: Path) -> None:
    """Two files of winds on unlike grids, ERA5's parts apart, and an ocean."""
    gridded(ERA5).to_netcdf(tmp_path / "a_instant.nc")
    gridded(SUMS).to_netcdf(tmp_path / "b_accum.nc")
    other = {"uas": (30.0, "m s-1"), "vas": (40.0, "m s-1"), "uo": (0.2, "m s-1"),
             "vo": (0.0, "m s-1")}  # fmt: skip
    gridded(other, lat=4.0).to_netcdf(tmp_path / "c_other.nc")
    made = make(scene_of(tmp_path / "*.nc"))
    np.testing.assert_allclose(np.hypot(made["wind_u"], made["wind_v"]), 5.0, rtol=1e-3)
    np.testing.assert_allclose(np.hypot(made["ocean_u"], made["ocean_v"]), 0.2, rtol=1e-3)
    np.testing.assert_allclose(made["shortwave_down"], 100.0, rtol=1e-9)
    with pytest.raises(FloeError, match="forcing.files: no file is named as .*none_.*nc"):
        make(scene_of(tmp_path / "none_*.nc"))


def test_a_year_in_parts(tmp_path: Path) -> None:
    """The window spans two files; their times overlap by an hour, which the first one gives."""
    hours = np.arange(-1.0, 49.0)
    whole = gridded(ERA5 | SUMS)
    whole["u10"].values[:] = (hours / 2.0)[:, None, None]
    whole["v10"].values[:] = 0.0
    whole.isel(time=slice(0, 14)).to_netcdf(tmp_path / "part_1.nc")
    second = whole.isel(time=slice(13, None)).copy(deep=True)
    second["u10"].values[0] = 99.0
    second.to_netcdf(tmp_path / "part_2.nc")
    scene = scene_of(tmp_path / "part_*.nc", fallback={"ocean": "rest"})
    for window in (1, 2):
        made = make(scene, window)
        speed = np.hypot(made["wind_u"], made["wind_v"]).isel(x=1, y=1)
        np.testing.assert_allclose(speed, made["time"].values / 7200.0, rtol=3e-3, atol=1e-9)
    (tmp_path / "part_2.nc").unlink()
    with pytest.raises(FloeError, match="covers .* but the scene needs"):
        make(scene)


def test_parts_on_unlike_grids_are_refused(tmp_path: Path) -> None:
    gridded(ERA5 | SUMS, -1.0, 12.0).to_netcdf(tmp_path / "part_1.nc")
    gridded(ERA5 | SUMS, 13.0, 48.0, lat=4.0).to_netcdf(tmp_path / "part_2.nc")
    with pytest.raises(FloeError, match=r"part_2.nc: '\w+' is not on the grid of .*part_1.nc"):
        make(scene_of(tmp_path / "part_*.nc", fallback={"ocean": "rest"}))


def test_components_in_files_of_their_own(tmp_path: Path) -> None:
    """JRA55-do: uas and vas apart."""
    rest = {name: ERA5[name] for name in ("t2m", "d2m", "msl")}
    gridded({"uas": (3.0, "m s-1")} | rest | SUMS).to_netcdf(tmp_path / "uas.nc")
    gridded({"vas": (4.0, "m s-1")}).to_netcdf(tmp_path / "vas.nc")
    made = make(scene_of(tmp_path / "*as.nc", fallback={"ocean": "rest"}))
    np.testing.assert_allclose(np.hypot(made["wind_u"], made["wind_v"]), 5.0, rtol=1e-3)


def test_an_archive_as_era5_delivers_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    gridded(ERA5).to_netcdf(tmp_path / "data_stream-oper_stepType-instant.nc")
    gridded(SUMS).to_netcdf(tmp_path / "data_stream-oper_stepType-accum.nc")
    with zipfile.ZipFile(tmp_path / "era5.zip", "w") as archive:
        for step in ("instant", "accum"):
            name = f"data_stream-oper_stepType-{step}.nc"
            # A path out of the folder counts for nothing.
            archive.write(tmp_path / name, f"../../{name}")
            (tmp_path / name).unlink()
    scene = scene_of(tmp_path / "era5.zip", fallback={"ocean": "rest"})
    found = files.forcing_files(scene)
    assert [path.parent.parent for path in found] == [Path("results/inputs")] * 2
    np.testing.assert_allclose(make(scene)["longwave_down"], 200.0, rtol=1e-9)
    (tmp_path / "era5.zip").write_bytes(b"PK nothing")
    with pytest.raises(FloeError, match="era5.zip: cannot be unpacked"):
        files.forcing_files(scene)


def test_final_and_preliminary_era5_are_one_series(tmp_path: Path) -> None:
    """ERA5 of the last months: dimension expver, 1 where there is final data, 5 elsewhere."""
    data = gridded(ERA5 | SUMS)
    late = data["time"].values > 20.0
    versions = []
    for gone in (late, ~late):
        part = data.copy(deep=True)
        for name in (*ERA5, *SUMS):
            part[name].values[gone] = np.nan
        versions.append(part)
    both = xr.concat(versions, xr.Variable("expver", [1, 5])).transpose("time", "expver", ...)
    encoding = {name: {"_FillValue": -32767.0} for name in (*ERA5, *SUMS)}
    both.to_netcdf(tmp_path / "era5.nc", encoding=encoding)
    made = make(scene_of(tmp_path / "era5.nc", fallback={"ocean": "rest"}), 2)
    np.testing.assert_allclose(np.hypot(made["wind_u"], made["wind_v"]), 5.0, rtol=1e-3)
    np.testing.assert_allclose(made["longwave_down"], 200.0, rtol=1e-9)


def test_names_and_axes_of_old_files(tmp_path: Path) -> None:
    """NCEP: uwnd and vwnd on level-less axes; a time axis under another name."""
    plain = gridded({"uwnd": (6.0, "m/s"), "vwnd": (8.0, "m/s")})
    other = {"time": "tdim", "lat": "ygrid", "lon": "xgrid"}
    dims = tuple(other.values())
    data = xr.Dataset({name: (dims, plain[name].values, plain[name].attrs) for name in plain})
    for name, dim in other.items():
        data[name] = (dim, plain[name].values, plain[name].attrs)
    data.to_netcdf(tmp_path / "w.nc")
    scene = scene_of(tmp_path / "w.nc").model_copy(update={"effects": ("wind",)})
    made = make(scene)
    np.testing.assert_allclose(np.hypot(made["wind_u"], made["wind_v"]), 10.0, rtol=1e-3)
