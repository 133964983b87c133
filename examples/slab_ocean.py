# SPDX-License-Identifier: GPL-2.0-or-later
"""A slab ocean beside FloeFlow, window by window: heat down, stress and melt water up.

    .venv/bin/python examples/slab_ocean.py config/scenes/mine.yaml
    .venv/bin/python examples/slab_ocean.py config/scenes/mine.yaml --through files

The scene needs thermodynamics, and no mixed layer of its own. Each cell of the scene grid holds a
mixed layer of one temperature and salinity. It gives the ice heat by how warm it is, and gets what
the ice gives back: through the model's get and set, or through CF files that any grid model could
read and write.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.errors import FloeError
from floeflow.coupling.model import IceModel

Array = NDArray[np.float64]

DENSITY, HEAT = 1026.0, 3990.0  # kg/m3, J/kg/K
# Heat transfer between water and ice, and the friction velocity where there is no ice to tell it.
TRANSFER, LEAST_FRICTION = 0.006, 1.0e-3  # 1, m/s


@dataclass
class SlabOcean:
    """A mixed layer in each cell.

    Parameters
    ----------
    temperature, salinity : ndarray
        Degrees Celsius and 1e-3, (ny, nx).
    depth : float
        m.
    friction : ndarray
        Friction velocity below the ice (m/s), from the stress of the last window.
    """

    temperature: Array
    salinity: Array
    depth: float = 30.0
    friction: Array = field(default_factory=lambda: np.array(LEAST_FRICTION))

    def heat_to_ice(self) -> Array:
        """Heat flux to the ice where there is any (W/m2): bulk formula of McPhee (1992)."""
        above = self.temperature + 0.054 * self.salinity
        speed = np.maximum(self.friction, LEAST_FRICTION)
        return np.maximum(DENSITY * HEAT * TRANSFER * speed * above, 0.0)

    def take(self, fluxes: dict[str, Array], seconds: float) -> None:
        """Take what a window gave, means over the cells: heat (W/m2), water and salt (kg/m2/s)."""
        mass = DENSITY * self.depth
        self.temperature = self.temperature + fluxes["heat_ocean"] * seconds / (HEAT * mass)
        salt = fluxes.get("salt_ocean", 0.0) * seconds
        fresh = fluxes["water_ocean"] * seconds
        self.salinity = (self.salinity * mass + 1e3 * salt) / (mass + fresh)
        stress = np.hypot(fluxes["tau_x_ocean"], fluxes["tau_y_ocean"])
        self.friction = np.sqrt(stress / DENSITY)

    def content(self, area: Array) -> float:
        """Heat in the ocean above 0 degrees (J)."""
        return float((HEAT * DENSITY * self.depth * self.temperature * area).sum())


NEEDED = ("heat_ocean", "water_ocean", "salt_ocean", "tau_x_ocean", "tau_y_ocean")


def through_values(model: IceModel, ocean: SlabOcean) -> None:
    """One window through get and set."""
    model.set_value("ocean_heat_flux", ocean.heat_to_ice())
    model.update()
    names = [name for name in NEEDED if name in model.get_output_var_names()]
    ocean.take({name: model.get_value(name) for name in names}, model.get_time_step())


def through_files(model: IceModel, ocean: SlabOcean, folder: Path) -> None:
    """The same through files: the ocean writes what it gives, and reads what it gets."""
    window = round(model.get_current_time() / model.get_time_step()) + 1
    given, got = folder / f"ocean_{window:04d}.nc", folder / f"ice_{window:04d}.nc"
    attrs = {"standard_name": "upward_sea_ice_basal_heat_flux", "units": "W m-2"}
    xr.Dataset({"ocean_heat_flux": (("y", "x"), ocean.heat_to_ice(), attrs)}).to_netcdf(given)
    with xr.open_dataset(given) as data:
        model.set_value("ocean_heat_flux", data["ocean_heat_flux"].values)
    model.update()
    model.write_fluxes(got)
    with xr.open_dataset(got, decode_times=False) as data:
        seconds = float(np.diff(data["time_bounds"].values[0])[0])
        ocean.take({name: data[name].values[0] for name in NEEDED if name in data}, seconds)


def main() -> None:
    """Run a scene beside a slab ocean."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scene")
    parser.add_argument("--through", choices=("values", "files"), default="values")
    parser.add_argument("--folder", type=Path, default=Path("results/slab_ocean"))
    parser.add_argument("--temperature", type=float, default=-1.5, help="at the start, degrees C")
    given = parser.parse_args()
    try:
        couple(given)
    except FloeError as error:
        parser.exit(1, f"{error}\n")


def couple(given: argparse.Namespace) -> None:
    """Run scene and ocean to the scene's end.

    Raises
    ------
    FloeError
        For a scene that has a sea of its own, or no thermodynamics; as the model.
    """
    model = IceModel()
    model.initialize(given.scene)
    if "mixed_layer" in model.scene.effects:
        raise FloeError(f"{given.scene}: the effect mixed_layer is a sea of its own: leave it out")
    if "ocean_heat_flux" not in model.get_input_var_names():
        raise FloeError(f"{given.scene}: a slab ocean needs the effect thermodynamics")
    shape = model.get_grid_shape()
    ocean = SlabOcean(np.full(shape, given.temperature), np.full(shape, 34.0))
    given.folder.mkdir(parents=True, exist_ok=True)
    area = model.get_cell_area()
    while model.get_current_time() < model.get_end_time():
        if given.through == "files":
            through_files(model, ocean, given.folder)
        else:
            through_values(model, ocean)
        volume = float((model.get_value("sivol") * area).sum()) / 1e9
        mean = float((ocean.temperature * area).sum() / area.sum())
        day = model.get_current_time() / 86400.0
        print(f"day {day:6.2f}: ice {volume:10.3f} km3, ocean {mean:8.4f} degrees")
    model.finalize()


if __name__ == "__main__":
    main()
