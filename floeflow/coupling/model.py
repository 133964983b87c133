# SPDX-License-Identifier: GPL-2.0-or-later
"""FloeFlow as a component of a coupled model: initialize, update, finalize, get and set values.

The verbs are those of the Basic Model Interface (Hutton, Piper & Tucker 2020). A step is a coupling
window. What is set is forcing on the scene grid, and holds until it is set again; what is got are
the fluxes of the last window and the ice at its end, on the same grid.

>>> model = IceModel()                                   # doctest: +SKIP
>>> model.initialize("config/scenes/mine.yaml")          # doctest: +SKIP
>>> while model.get_current_time() < model.get_end_time():   # doctest: +SKIP
...     model.set_value("ocean_heat_flux", heat)
...     model.update()
...     ocean.take(model.get_value("heat_ocean"))
>>> model.finalize()                                     # doctest: +SKIP
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from mpi4py import MPI
from numpy.typing import NDArray

from floeflow.core.errors import FloeError
from floeflow.core.grids import cell_area, scene_crs, scene_grid
from floeflow.coupling.coupled_windows import advance_window
from floeflow.coupling.first_state import first_state
from floeflow.coupling.fluxes import FIELDS, spread
from floeflow.coupling.sea.places import sea_places
from floeflow.forcings.forcing import field_units
from floeflow.forcings.window import window_forcing
from floeflow.scene import Scene, load_scene
from floeflow.scene.effects import forcing_variables
from floeflow.state import read_state, write_dataset
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]

# The ice on the scene grid: units and what it is.
ICE: dict[str, tuple[str, str]] = {
    "siconc": ("1", "share of the cell under ice"),
    "sivol": ("m", "ice volume over the cell's area"),
    "siu": ("m s-1", "velocity of the ice along x"),
    "siv": ("m s-1", "velocity of the ice along y"),
}
GRID = 0


class IceModel:
    """A scene that is advanced window by window from another program.

    Attributes
    ----------
    scene : Scene
        After `initialize`.
    state : xarray.Dataset
        The elements now.
    fluxes : xarray.Dataset or None
        What the last window gave, see `floeflow.coupling.fluxes.window_fluxes`.
    series : xarray.Dataset or None
        Series and budget terms of the last window.
    """

    def __init__(self, comm: MPI.Comm = MPI.COMM_SELF) -> None:
        self.comm = comm
        self.scene: Scene
        self.state: xr.Dataset
        self.fluxes: xr.Dataset | None = None
        self.series: xr.Dataset | None = None
        self._given: dict[str, Array] = {}
        self._scratch: tempfile.TemporaryDirectory[str] | None = None

    def initialize(self, scene: str | Path, state: str | Path | None = None) -> None:
        """Read a scene; make its first state from its mask, or start from a state of a run.

        Parameters
        ----------
        scene : str or Path
            Scene file.
        state : str, Path, optional
            NetCDF file of a state.

        Raises
        ------
        FloeError
            Where the scene, its files or the state are wrong.
        """
        read = load_scene(scene)
        keys = {"exchange": read.exchange.model_copy(update={"fluxes": True})}
        self.scene = read.model_copy(update=keys)
        self._scratch = tempfile.TemporaryDirectory(prefix="floeflow-")
        self._cells, self._places = None, None
        self._grid = scene_grid(read.domain)
        if state is None or {"remap", "mixed_layer"} & set(read.effects):
            first = first_state(self.scene, Path(self._scratch.name))
            self.state, self._cells = first.state, first.cells
            if "mixed_layer" in read.effects:
                self._places = sea_places(first.mask, self._grid.x, self._grid.y)
        if state is not None:
            self.state = read_state(state)
        self._area = cell_area(self._grid, scene_crs(read.domain))

    def update(self) -> None:
        """Advance by one window.

        Raises
        ------
        FloeError
            As a window of a run.
        """
        scratch = self._folder()
        window = int(self.state.attrs["window"]) + 1
        forcing = window_forcing(self.scene, window, scratch)
        for name, values in self._given.items():
            forcing[name] = (forcing[name].dims, np.broadcast_to(values, forcing[name].shape))
        log = scratch / f"{window:04d}.liggghts.log"
        places = self._cells, self._places
        done = advance_window(self.comm, self.scene, self.state, forcing, log, _quiet, *places)
        self.state, self.fluxes, self.series = done.state, done.fluxes, done.series

    def update_until(self, time: float) -> None:
        """Advance by whole windows to a time (s since the scene's start).

        Parameters
        ----------
        time : float
            s since the scene's start.

        Raises
        ------
        FloeError
            Where no window ends at that time.
        """
        windows = (time - self.get_current_time()) / self.get_time_step()
        if windows < 0 or abs(windows - round(windows)) > 1e-9:
            raise FloeError(f"no coupling window of {self.get_time_step():g} s ends at {time:g} s")
        for _ in range(round(windows)):
            self.update()

    def finalize(self) -> None:
        """Remove what was kept beside the run; the state stays readable."""
        if self._scratch is not None:
            self._scratch.cleanup()
            self._scratch = None

    def get_component_name(self) -> str:
        """Name of the component."""
        return "FloeFlow"

    def get_input_var_names(self) -> tuple[str, ...]:
        """Forcing that the scene's effects read, and that may be set."""
        return forcing_variables(self.scene.effects)

    def get_output_var_names(self) -> tuple[str, ...]:
        """Fluxes of the last window, and the ice now."""
        made = () if self.fluxes is None else tuple(n for n in FIELDS if n in self.fluxes)
        return (*made, *ICE)

    def get_value(self, name: str) -> Array:
        """A field on the scene grid, (ny, nx); rows along y, both axes ascending.

        Parameters
        ----------
        name : str
            Of an output.

        Returns
        -------
        ndarray
            A copy, in the units of `get_var_units`, (ny, nx).

        Raises
        ------
        FloeError
            For a name that is no output, or a flux before the first window.
        """
        if name in ICE:
            return self._ice(name)
        if name in self._given:
            return self._given[name].copy()
        if self.fluxes is None or name not in self.fluxes:
            known = ", ".join(self.get_output_var_names())
            raise FloeError(f"'{name}' is not an output of the scene now; there are {known}")
        return np.array(self.fluxes[name].values[0])

    def set_value(self, name: str, values: Any) -> None:
        """Give a forcing field for the windows to come, (ny, nx) or one number.

        Parameters
        ----------
        name : str
            Of the forcing, one of `get_input_var_names`.
        values : object
            SI units.

        Raises
        ------
        FloeError
            For a name that the scene does not read, a wrong shape, or values that are not finite.
        """
        if name not in self.get_input_var_names():
            known = ", ".join(self.get_input_var_names())
            raise FloeError(f"'{name}' is not read by the scene's effects; they read {known}")
        field = np.asarray(values, dtype=float)
        if field.shape not in ((), self._grid.shape):
            raise FloeError(f"'{name}' has the shape {field.shape}, not {self._grid.shape}")
        if not np.isfinite(field).all():
            raise FloeError(f"'{name}' has values that are not finite")
        self._given[name] = np.broadcast_to(field, self._grid.shape).copy()

    def get_var_units(self, name: str) -> str:
        """Units of an input or output.

        Parameters
        ----------
        name : str
            Of an input or output.

        Returns
        -------
        str
            Such as W m-2.
        """
        if name in FIELDS or name in ICE:
            return (FIELDS.get(name) or ICE[name])[0]
        return field_units()[name.removesuffix("_u").removesuffix("_v")]

    def get_var_grid(self, name: str) -> int:
        """All variables lie on grid 0, the scene grid.

        Parameters
        ----------
        name : str
            Of an input or output.

        Returns
        -------
        int
            0.
        """
        return GRID

    def get_grid_type(self, grid: int = GRID) -> str:
        """Kind of the grid.

        Parameters
        ----------
        grid : int, optional
            0.

        Returns
        -------
        str
            "uniform_rectilinear", as the Basic Model Interface calls it.
        """
        return "uniform_rectilinear"

    def get_grid_shape(self, grid: int = GRID) -> tuple[int, int]:
        """Rows and columns.

        Parameters
        ----------
        grid : int, optional
            0.

        Returns
        -------
        tuple of int
            (ny, nx).
        """
        return self._grid.shape

    def get_grid_spacing(self, grid: int = GRID) -> tuple[float, float]:
        """Distance of rows and of columns (m of the projection).

        Parameters
        ----------
        grid : int, optional
            0.

        Returns
        -------
        tuple of float
            m, (dy, dx); both are the scene's spacing.
        """
        return self._grid.spacing, self._grid.spacing

    def get_grid_origin(self, grid: int = GRID) -> tuple[float, float]:
        """First y and first x (m of the projection).

        Parameters
        ----------
        grid : int, optional
            0.

        Returns
        -------
        tuple of float
            m, (y, x) of the cell with the lowest of both.
        """
        return float(self._grid.y[0]), float(self._grid.x[0])

    def get_cell_area(self) -> Array:
        """True areas of the cells (m2), (ny, nx)."""
        return self._area.copy()

    def get_start_time(self) -> float:
        """Start (s)."""
        return 0.0

    def get_current_time(self) -> float:
        """Time now (s since the scene's start)."""
        return float(self.state.attrs["time"])

    def get_end_time(self) -> float:
        """End of the scene (s)."""
        return self.scene.time.windows * self.scene.time.window

    def get_time_step(self) -> float:
        """Length of a window (s)."""
        return self.scene.time.window

    def get_time_units(self) -> str:
        """Units of all times."""
        return "s"

    def write_fluxes(self, path: str | Path) -> None:
        """Write the fluxes of the last window as a CF file, whole or not at all.

        Parameters
        ----------
        path : str or Path
            Of the file.

        Raises
        ------
        FloeError
            Before the first window, or where it cannot be written.
        """
        if self.fluxes is None:
            raise FloeError(f"{path}: there are no fluxes before the first window")
        write_dataset(self.fluxes, path)

    def _ice(self, name: str) -> Array:
        mobile = self.state["type"].values == MOBILE
        x, y, area, u, v = (self.state[n].values[mobile] for n in ("x", "y", "area", "u", "v"))
        ice = area * self.state["ice_fraction"].values[mobile].sum(axis=1)
        volume = area * self.state["ice_volume"].values[mobile].sum(axis=1)
        wanted = {"siconc": ice, "sivol": volume, "siu": ice * u, "siv": ice * v}[name]
        (total, covered), _ = spread(self._grid, x, y, area, np.stack([wanted, ice]))
        base = self._area if name in ("siconc", "sivol") else covered
        return np.divide(total, base, out=np.zeros_like(total), where=base > 0)

    def _folder(self) -> Path:
        if self._scratch is None:
            raise FloeError("the model is not initialized")
        return Path(self._scratch.name)


def _quiet(**event: Any) -> None:
    """Progress that nobody looks at."""
