# SPDX-License-Identifier: GPL-2.0-or-later
"""Input files are checked before any job: each fault is one sentence that names the file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.forcings import analytic, inputs
from floeflow.scene import load_scene
from floeflow.scene.blocks import Scene

SMALL = {"x_min": -2e5, "x_max": 2e5, "y_min": -8e5, "y_max": -4e5, "spacing": 1e5}


def forcing_scene(path: Path | str, **changes: Any) -> Scene:
    values = {
        "name": "t",
        "domain": SMALL,
        "effects": ("wind", "ocean_drag", "thermodynamics"),
        "forcing": {"source": "file", "file": str(path)},
        "time": {"windows": 2},
    }
    return Scene.model_validate(values | changes)


def forcing_file(path: Path, change: Callable[[xr.Dataset], Any] | None = None) -> None:
    """Two windows of analytic forcing in one file, changed in place."""
    plain = Scene.model_validate(
        {"name": "t", "domain": SMALL, "effects": ("wind", "ocean_drag", "thermodynamics"),
         "time": {"window": 172800.0}}
    )  # fmt: skip
    data = analytic.make_analytic(plain, 1)
    changed = change(data) if change else None
    analytic.write_cf(data if changed is None else changed, path)


def test_good_forcing_passes(tmp_path: Path) -> None:
    forcing_file(tmp_path / "f.nc")
    inputs.check_forcing_file(forcing_scene(tmp_path / "f.nc"))


def units(name: str, value: str) -> Callable[[xr.Dataset], None]:
    return lambda data: data[name].attrs.update(units=value)


def twice(data: xr.Dataset) -> xr.Dataset:
    return data.assign(second=data["u10"], third=data["u10"]).drop_vars("u10")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda d: d.drop_vars(["u10", "v10"]), "has no wind: no standard_names eastward_wind"),
        (lambda d: d.drop_vars("v10"), "no variable has standard_name northward_wind"),
        (twice, "'second', 'third' all have standard_name eastward_wind"),
        (lambda d: d.drop_vars("tas" if "tas" in d else "t2m"), "has no air_temperature"),
        (lambda d: d.drop_vars("huss"), "has no specific_humidity: neither"),
        (lambda d: d.drop_vars("uo").drop_vars("vo"), "has no ocean: no standard_names eastward_s"),
        (units("u10", "furlongs"), "'u10' has units 'furlongs', not such as m s-1"),
        (lambda d: d.isel(time=slice(0, 3)), "covers 1981-12-31 00:00:00 to 1981-12-31 12:00:00"),
        (lambda d: d.isel(time=slice(None, None, -1)), "'time' does not ascend"),
    ],
)
def test_bad_forcing_is_refused(
    tmp_path: Path, change: Callable[[xr.Dataset], Any], sentence: str
) -> None:
    forcing_file(tmp_path / "f.nc", change)
    with pytest.raises(FloeError, match=sentence) as caught:
        inputs.check_forcing_file(forcing_scene(tmp_path / "f.nc"))
    assert str(caught.value).startswith(str(tmp_path / "f.nc"))


def test_forcing_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FloeError, match="none.nc: there is no such file"):
        inputs.check_forcing_file(forcing_scene(tmp_path / "none.nc"))


def test_only_what_the_effects_need_is_asked_for(tmp_path: Path) -> None:
    forcing_file(tmp_path / "f.nc", lambda data: data[["u10", "v10"]])
    inputs.check_forcing_file(forcing_scene(tmp_path / "f.nc", effects=("wind",)))
    with pytest.raises(FloeError, match="has no ocean"):
        inputs.check_forcing_file(forcing_scene(tmp_path / "f.nc", effects=("wind", "tilt")))


def test_shipped_scenes_pass(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)
    for name in ("arctic_1981", "smoke"):
        scene = load_scene(project / f"config/scenes/{name}.yaml")
        inputs.check_forcing_file(scene)
