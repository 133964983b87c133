# SPDX-License-Identifier: GPL-2.0-or-later
"""Both ways: what the ice gives to ocean and air on the grid, and the model as a component."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import xarray as xr
import yaml

from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError
from floeflow.core.grids import scene_grid
from floeflow.coupling.fluxes import FIELDS, join_fluxes, spread, window_fluxes
from floeflow.coupling.model import IceModel
from floeflow.scene.blocks import Domain, Scene
from floeflow.state import read_dataset, write_dataset
from floeflow.state.schema import MOBILE

SQUARE = {"x_min": -4e5, "x_max": 4e5, "y_min": -4e5, "y_max": 4e5, "spacing": 1e5}
EFFECTS = ["wind", "ocean_drag", "coriolis", "tilt", "friction", "thermodynamics", "snow",
           "shortwave", "lateral_melt", "frazil"]  # fmt: skip


def test_spreading_keeps_the_totals_and_their_places() -> None:
    grid = scene_grid(Domain(x_min=0.0, x_max=1e6, y_min=-5e5, y_max=5e5, spacing=1e5))
    random = np.random.default_rng(3)
    x, y = 1e5 + 8e5 * random.random(40), -4e5 + 8e5 * random.random(40)
    area, totals = np.full(40, 4e9), random.normal(size=(2, 40))
    cells, outside = spread(grid, x, y, area, totals)
    np.testing.assert_allclose(cells.sum(axis=(1, 2)), totals.sum(axis=1), rtol=0, atol=1e-12)
    assert (outside == 0).all()
    # Bilinear weights keep the centre of what they spread.
    mesh_x, mesh_y = grid.mesh()
    centre = (cells[0] * mesh_x).sum(), (cells[0] * mesh_y).sum()
    assert centre[0] == pytest.approx(float(totals[0] @ x), rel=2e-3)
    # Beyond the rim nothing is put into the grid, and nothing is lost.
    far = np.array([0.0, 2e6]), np.zeros(2)
    cells, outside = spread(grid, *far, np.full(2, 4e9), np.ones((1, 2)))
    assert cells.sum() + outside[0] == pytest.approx(2.0, rel=1e-12)
    assert 1.3 < outside[0] < 1.7


def test_the_file_of_two_windows_says_what_and_where_it_is(tmp_path: Path) -> None:
    """CF: projection, true places, units of what is beyond; each mean over its window."""
    keys = {"name": "f", "effects": ["wind", "ocean_drag"], "exchange": {"fluxes": True}}
    scene = Scene.model_validate(keys | {"domain": {**SQUARE, "crs": "EPSG:6931"}})
    columns = {"x": [0.0, 4e5], "y": [0.0, 0.0], "area": [4e9, 4e9], "type": [MOBILE, MOBILE]}
    state = xr.Dataset({name: ("element", values) for name, values in columns.items()})
    sums = {"wind_impulse_x": np.array([1e12, 2e12]), "water_ocean": np.array([-1e9, 0.0])}
    parts = []
    for window in (0, 1):
        made = window_fluxes(scene, state, sums, (window * 3600.0, (window + 1) * 3600.0))
        write_dataset(made.assign_attrs(window=window + 1), tmp_path / f"{window}.nc")
        parts.append(read_dataset(tmp_path / f"{window}.nc"))
    write_dataset(join_fluxes(parts), tmp_path / "both.nc")
    data = read_dataset(tmp_path / "both.nc")
    assert "window" not in data.attrs and data["cell_area"].dims == ("y", "x")
    np.testing.assert_array_equal(data["time_bounds"], [[0.0, 3600.0], [3600.0, 7200.0]])
    total = (data["tau_x_air"] * data["cell_area"]).sum(("y", "x")) * 3600.0
    total = total + data["tau_x_air_outside"]
    np.testing.assert_allclose(total, 3e12, rtol=1e-12)
    assert (data["tau_x_air_outside"] > 5e11).all()
    assert data["tau_x_air_outside"].attrs["units"] == "N s"
    assert data["water_ocean_outside"].attrs["units"] == "kg"
    # FloeFlow's own reader takes the projection and the places for what they are.
    variables = cf.variables_of(data)
    layout = cf.layout(variables, variables["water_ocean"], "both.nc")
    assert cf.projection(variables, variables["water_ocean"], "both.nc").equals("EPSG:6931")
    assert layout.time == "time" and (layout.x, layout.y) == ("x", "y")
    middle = np.unravel_index(int(data["water_ocean"][0].values.argmax()), (8, 8))
    assert data["lat"].values[middle] > 89.0
    with xr.open_dataset(tmp_path / "both.nc") as decoded:
        assert {"lat", "lon"} <= set(decoded["water_ocean"].coords)
        assert decoded["time"].values[0] == np.datetime64("1981-12-31T00:30")


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Thirty elements of ice in a small sea, driven by wind and weather for two windows."""
    folder = tmp_path_factory.mktemp("component")
    lat, lon = np.arange(60.5, 90.0), np.arange(0.0, 360.0, 2.0)
    attrs = {"standard_name": "sea_ice_area_fraction", "units": "1"}
    values = np.full((lat.size, lon.size), 0.9)
    xr.Dataset(
        {"siconc": (("lat", "lon"), values, attrs)},
        {
            "lat": ("lat", lat, {"units": "degrees_north"}),
            "lon": ("lon", lon, {"units": "degrees_east"}),
        },
    ).to_netcdf(folder / "ice.nc")
    scene = {
        "name": "component",
        "effects": EFFECTS,
        "domain": SQUARE,
        "mask": {"file": str(folder / "ice.nc"), "land": "none"},
        "packing": {"elements": 30, "relaxations": 3},
        "forcing": {"step": 3600.0, "cyclone": {"x": 0.0, "y": 0.0, "radius": 3e5}},
        "time": {"windows": 2, "window": 7200.0},
    }
    path = folder / "component.yaml"
    path.write_text(yaml.safe_dump(scene))
    return path


def started(scene_file: Path) -> IceModel:
    model = IceModel()
    model.initialize(scene_file)
    return model


def test_the_block_of_the_page_runs(scene_file: Path, project: Path) -> None:
    text = (project / "docs/how-to/coupling.md").read_text()
    (block,) = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    there: dict[str, Any] = {}
    own = block.replace("config/scenes/smoke.yaml", str(scene_file))
    assert own != block
    exec(compile(own, "coupling.md", "exec"), there)
    assert there["ocean_gets"].shape == (8, 8) and np.isfinite(there["ocean_gets"]).all()


def test_what_the_grid_gets_is_what_the_elements_gave(scene_file: Path) -> None:
    model = started(scene_file)
    model.update()
    assert model.fluxes is not None
    fluxes, area, step = model.fluxes, model.get_cell_area(), model.get_time_step()
    given = {
        name: float((fluxes[name][0] * area).sum()) * step + float(fluxes[f"{name}_outside"][0])
        for name in ("tau_x_air", "tau_x_ocean", "tau_y_air", "tau_y_ocean")
    }
    assert np.hypot(given["tau_x_ocean"], given["tau_y_ocean"]) > 0
    budget = model.series
    assert budget is not None
    for axis in "xy":
        assert given[f"tau_{axis}_air"] == pytest.approx(
            float(budget[f"impulse_wind_{axis}"]), rel=1e-9
        )
        assert given[f"tau_{axis}_ocean"] == pytest.approx(
            -float(budget[f"impulse_ocean_{axis}"]), rel=1e-9
        )
    heat = float((fluxes["heat_ocean"][0] * area).sum()) * step
    heat += float(fluxes["heat_ocean_outside"][0])
    assert heat == pytest.approx(
        -float(budget["energy_ocean"]) - float(budget["energy_to_ocean"]), rel=1e-9
    )
    water = float((fluxes["water_ocean"][0] * area).sum()) * step
    water += float(fluxes["water_ocean_outside"][0])
    assert water == pytest.approx(-float(budget["water_ocean"]), rel=1e-9)
    model.finalize()


@pytest.mark.parametrize("scheme", ["zero_layer", pytest.param("mushy", marks=pytest.mark.slow)])
def test_a_scene_of_every_effect_gives_what_its_budget_says(
    scene_file: Path, tmp_path: Path, scheme: str
) -> None:
    """With a sea of its own, cracks, ridges and a remap: elements' terms to round-off."""
    keys = yaml.safe_load(scene_file.read_text())
    more = ["turning_angle", "bonds", "ridging", "refreeze", "mixed_layer", "redistribution"]
    keys |= {"effects": [*EFFECTS, *more, "rims", "merge", "remap"]}
    keys["column"] = {"scheme": scheme, "categories": 3}
    path = tmp_path / "every.yaml"
    path.write_text(yaml.safe_dump(keys))
    model = started(path)
    for _ in range(2):
        model.update()
        fluxes, budget, step = model.fluxes, model.series, model.get_time_step()
        assert fluxes is not None and budget is not None
        for axis in "xy":
            for name, term, sign in (("air", "wind", 1.0), ("ocean", "ocean", -1.0)):
                field = fluxes[f"tau_{axis}_{name}"][0]
                total = float((field * model.get_cell_area()).sum()) * step
                total += float(fluxes[f"tau_{axis}_{name}_outside"][0])
                right = sign * float(budget[f"impulse_{term}_{axis}"])
                assert total == pytest.approx(right, rel=1e-9)
        # Open water has columns of its own: what it got from the air is told as well.
        heat = float((fluxes["heat_air"][0] * model.get_cell_area()).sum()) * step
        heat += float(fluxes["heat_air_outside"][0])
        assert heat == pytest.approx(float(budget["energy_atmosphere"]), rel=1e-9)
        made = set(FIELDS) & set(fluxes)
        assert set(FIELDS) - made <= (set() if scheme == "mushy" else {"light_ocean", "salt_ocean"})
        assert all(np.isfinite(fluxes[name]).all() for name in made)
    assert "sea_temperature" in model.state
    model.finalize()


def test_values_that_are_set_act(scene_file: Path) -> None:
    """A warm ocean melts ice that a cold one does not, and is told how much heat it gave."""
    volumes = []
    for heat in (0.0, 500.0):
        model = started(scene_file)
        model.set_value("ocean_heat_flux", heat)
        model.update_until(2 * model.get_time_step())
        assert model.get_current_time() == model.get_end_time()
        volumes.append(float((model.get_value("sivol") * model.get_cell_area()).sum()))
        ice = model.get_value("siconc")
        taken = model.get_value("heat_ocean")[ice > 0.5]
        assert (taken < -100).all() if heat else (np.abs(taken) < 1).all()
        model.finalize()
    assert volumes[1] < volumes[0]


def test_names_shapes_and_units(scene_file: Path) -> None:
    model = started(scene_file)
    assert model.get_grid_shape() == (8, 8)
    assert model.get_grid_spacing() == (1e5, 1e5)
    assert model.get_grid_origin() == (-3.5e5, -3.5e5)
    assert "wind_u" in model.get_input_var_names()
    assert model.get_output_var_names() == ("siconc", "sivol", "siu", "siv")
    assert float(model.get_value("siconc").max()) == pytest.approx(0.9, rel=0.25)
    assert model.get_var_units("heat_ocean") == "W m-2"
    assert model.get_var_units("wind_u") == "m s-1"
    for call, sentence in (
        (lambda: model.set_value("sunshine", 1.0), "'sunshine' is not read by the scene's effects"),
        (lambda: model.set_value("wind_u", np.zeros(3)), r"has the shape \(3,\), not \(8, 8\)"),
        (lambda: model.set_value("wind_u", np.nan), "values that are not finite"),
        (lambda: model.get_value("heat_ocean"), "is not an output of the scene now"),
        (lambda: model.update_until(100.0), "no coupling window of 7200 s ends at 100 s"),
        (lambda: model.write_fluxes("x.nc"), "no fluxes before the first window"),
    ):
        with pytest.raises(FloeError, match=sentence):
            call()
    model.finalize()
    with pytest.raises(FloeError, match="the model is not initialized"):
        model.update()


def slab(project: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("slab", project / "examples/slab_ocean.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    import sys

    sys.modules["slab"] = module
    spec.loader.exec_module(module)
    return module


def test_the_slab_ocean_loses_what_the_ice_gets(
    project: Path, scene_file: Path, tmp_path: Path
) -> None:
    """The same through values and through files; the ocean's heat is what it gave, to round-off."""
    module = slab(project)
    ends = []
    for way in ("values", "files"):
        model = started(scene_file)
        shape, area = model.get_grid_shape(), model.get_cell_area()
        ocean = module.SlabOcean(np.full(shape, -1.0), np.full(shape, 34.0))
        first, given = ocean.content(area), 0.0
        for _ in range(2):
            if way == "files":
                module.through_files(model, ocean, tmp_path)
            else:
                module.through_values(model, ocean)
            given += float((model.get_value("heat_ocean") * area).sum()) * model.get_time_step()
        assert given < 0
        assert ocean.content(area) - first == pytest.approx(given, rel=1e-6)
        assert float(ocean.temperature.min()) < -1.0
        ends.append(ocean.temperature)
        model.finalize()
    np.testing.assert_array_equal(ends[0], ends[1])
    with xr.open_dataset(tmp_path / "ice_0002.nc") as data:
        assert data["heat_ocean"].attrs["standard_name"].startswith("heat_flux_into_sea_water")
        assert data["time"].attrs["bounds"] == "time_bounds"


def test_a_slab_is_refused_beside_a_sea_of_the_scene_s_own(
    project: Path, scene_file: Path, tmp_path: Path
) -> None:
    module, keys = slab(project), yaml.safe_load(scene_file.read_text())
    for effects, said in (
        ([*EFFECTS, "mixed_layer"], "mixed_layer is a sea of its own"),
        (["wind", "ocean_drag"], "needs the effect thermodynamics"),
    ):
        path = tmp_path / "other.yaml"
        path.write_text(yaml.safe_dump(keys | {"effects": effects}))
        with pytest.raises(FloeError, match=said):
            module.couple(module.argparse.Namespace(scene=path))
