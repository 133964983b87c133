# SPDX-License-Identifier: GPL-2.0-or-later
"""LIGGGHTS with the plugin, driven as a library: the only Python that talks to it.

An engine opens LIGGGHTS afresh at each `load`, in the order of the ids, so that the same state
gives the same bits wherever it came from. All methods are collective over the communicator;
tables go in and come out whole on every rank.
"""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.core.period import Period, wrapped
from floeflow.dynamics.engine.checks import check_bonds, check_contacts, check_elements, check_time
from floeflow.dynamics.engine.division import Division, choose_division
from floeflow.dynamics.engine.log import log_tail, open_fault
from floeflow.dynamics.engine.params import EngineParams, Forcing
from floeflow.dynamics.engine.plugin import load_plugin, open_liggghts
from floeflow.dynamics.engine.setup import (
    EVEN,
    bond_reach,
    box_of,
    contact_reach,
    setup_commands,
)
from floeflow.dynamics.engine.tables import (
    count_pairs,
    create_elements,
    first_fault,
    get_elements,
    get_internal,
    get_pairs,
    get_sums,
    missing_pairs,
    put_pairs,
)
from floeflow.dynamics.engine.walls import (
    FIX,
    check_wall_contacts,
    count_walls,
    get_wall_contacts,
    put_wall_contacts,
    set_walls,
    wall_forces,
)
from floeflow.state.bonds import BOND_COLUMNS, Arrays, empty_pairs, without

__all__ = ["Engine", "EngineError", "EngineParams", "Forcing"]

# Steps between two looks at the plugin's fault flag.
CHUNK = 2000


class EngineError(FloeError):
    """LIGGGHTS or an element failed; the sentence says which and where."""


def _inside(elements: Arrays, period: Period | None) -> Arrays:
    """Elements at the places where a repeated rectangle holds them."""
    if period is None:
        return elements
    x, y = wrapped(np.column_stack([elements["x"], elements["y"]]), period).T
    return elements | {"x": x.copy(), "y": y.copy()}


class Engine:
    """One LIGGGHTS instance. Use as a context manager.

    Parameters
    ----------
    comm : MPI.Comm
        Communicator; all methods are collective on it.
    params : EngineParams
        Laws, switches and time step.
    log : Path
        File for LIGGGHTS' own log, written by the first rank.
    walls : dict of ndarray, optional
        Faces of walls, as from `floeflow.state.walls`.
    """

    def __init__(
        self, comm: MPI.Comm, params: EngineParams, log: Path, walls: Arrays | None = None
    ) -> None:
        self.comm, self.params, self.log, self.walls = comm, params, Path(log), walls
        self._library = load_plugin()
        self._handle = ctypes.c_void_p()
        self._steps = 0
        self._start = 0.0
        self._forcing: Forcing | None = None
        self._ids = np.zeros(0, np.int64)
        self._bonds = 0

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close LIGGGHTS; the engine can `load` again."""
        if self._handle:
            self._library.floe_close(self._handle)
            self._handle = ctypes.c_void_p()

    @property
    def _instance(self) -> ctypes.c_void_p:
        if not self._handle:
            raise EngineError("The engine holds no elements: none were loaded, or it is closed.")
        return self._handle

    @property
    def _now(self) -> float:
        return self._start + self._steps * self.params.time_step

    def load(
        self,
        elements: Arrays,
        bonds: Arrays | None = None,
        contacts: Arrays | None = None,
        time: float = 0.0,
        wall_contacts: Arrays | None = None,
    ) -> None:
        """Open LIGGGHTS with a state.

        Parameters
        ----------
        elements : dict of ndarray, shape (n,)
            id (ascending), type (1 mobile, 2 fixed), x, y (m), theta (rad), u, v (m/s),
            omega (rad/s), radius (m), mass (kg), thickness (m), ice_area (m2); optional
            cover (share that ice covers, 1 where absent) and ridged_area (m2, 0 where absent),
            which ridging adds to.
        bonds : dict of ndarray, shape (nb,), optional
            As from `bondtable.new_bonds`.
        contacts : dict of ndarray, shape (nc,), optional
            id_lo, id_hi, slip (m), rest_overlap (m), with ridging also ridge_closing,
            ridge_thickness and ridge_length (m).
        time : float
            Time of this state on the forcing's axis, s.
        wall_contacts : dict of ndarray, shape (nw,), optional
            id, face, and the columns of a contact. Absent: none, and ice that overlaps a wall is
            pushed out.

        Raises
        ------
        FloeError
            If a table is not as it must be.
        EngineError
            If LIGGGHTS refuses, or a pair lies outside of its neighbour lists.
        """
        bonds = bonds if bonds is not None and self.params.bonds else empty_pairs(BOND_COLUMNS)
        contacts = contacts if contacts is not None else empty_pairs(self.params.contact_columns)
        check_elements(elements)
        elements = _inside(elements, self.params.period)
        check_bonds(elements, bonds)
        check_contacts(elements, bonds, contacts, self.params.contact_columns)
        if self.walls is not None and wall_contacts is not None:
            check_wall_contacts(self.walls, elements, wall_contacts, self.params.contact_columns)
        reach = max(
            bond_reach(elements, bonds, self.params), contact_reach(elements, contacts, self.params)
        )
        self.close()
        self._open()
        self._start, self._steps = time, 0
        self._ids, self._bonds = np.asarray(elements["id"]), len(bonds["id_lo"])
        division = self._division(elements, reach)
        for line in setup_commands(
            elements, self.params, reach, division.command if division else EVEN
        ):
            self._command(line)
        if division:
            cuts = np.array(division.x), np.array(division.y)
            self._check(self._library.floe_divide(self._instance, *cuts))
        self._check(create_elements(self._library, self._instance, elements))
        self._library.floe_set_start_time(self._instance, self._start)
        if self.walls is not None:
            self._command(FIX)
            self._check(set_walls(self._library, self._instance, self.walls))
        self._command("run 0 post no")
        self._put_pairs(bonds, contacts)
        if self.walls is not None and wall_contacts is not None:
            self._check(put_wall_contacts(self._library, self._instance, wall_contacts))
        self._command("run 0 post no")  # forces with the pairs
        if self._forcing is not None:
            self.set_forcing(self._forcing)

    def remove(self, ids: np.ndarray) -> None:
        """Take elements out, with their bonds and contacts; what `diagnostics` adds up starts anew.

        Parameters
        ----------
        ids : ndarray
            Of the elements, (m,).

        Raises
        ------
        FloeError
            If no element would be left.
        """
        tables = (self.elements(), *self._pairs(), self.wall_contacts())
        elements, bonds, contacts, held = (without(table, ids) for table in tables)
        self.load(elements, bonds, contacts, self._now, held)

    def set_forcing(self, forcing: Forcing) -> None:
        """Hand over the forcing of the coming steps; needs a loaded state.

        Parameters
        ----------
        forcing : Forcing
            Fields on a grid.

        Raises
        ------
        FloeError
            If a field that the switches need is missing, misshapen or not finite.
        """
        velocity, steady = forcing.packed(self.params.external)
        x, y = np.asarray(forcing.x, float), np.asarray(forcing.y, float)
        time = np.ascontiguousarray(forcing.time, dtype=float)
        spacing = [float(a[-1] - a[0]) / (len(a) - 1) if len(a) > 1 else 1.0 for a in (x, y)]
        self._check(
            self._library.floe_set_forcing(
                *(self._instance, len(time), len(y), len(x), time),
                *(float(x[0]), spacing[0], float(y[0]), spacing[1], velocity),
                *(steady["coriolis"], forcing.over_discs, forcing.wind_stress),
            )
        )
        if "sea_floor_depth" in steady:
            self._library.floe_set_depth(self._instance, steady["sea_floor_depth"])
        self._forcing = forcing

    def run(self, steps: int) -> None:
        """Advance by a number of steps. Cutting a run into several calls changes no bit.

        Parameters
        ----------
        steps : int
            Their number.

        Raises
        ------
        EngineError
            If LIGGGHTS fails, an element becomes non-finite, runs away or is lost, or a bond
            leaves the neighbours' reach.
        """
        check_time(self.params, self._forcing, self._now, steps)
        while steps > 0:
            # Cut at multiples of the chunk, whatever the caller asks for.
            now = min(steps, CHUNK - self._steps % CHUNK)
            self._command(f"run {now} pre no post no")
            self._steps += now
            steps -= now
            self._check_faults()

    def elements(self) -> Arrays:
        """Elements as `load` takes them, on every rank."""
        found = get_elements(self._library, self._instance, self.comm)
        return _inside(found, self.params.period)

    def bonds(self) -> Arrays:
        """Bond table, sorted by (id_lo, id_hi), on every rank; broken bonds are not in it."""
        return self._pairs()[0]

    def contacts(self) -> Arrays:
        """Contact history, sorted by (id_lo, id_hi), on every rank."""
        return self._pairs()[1]

    def wall_contacts(self) -> Arrays:
        """History of contacts with walls, sorted by (id, face), on every rank."""
        library, columns = self._library, self.params.contact_columns
        return get_wall_contacts(library, self._instance, self.comm, columns)

    def wall_forces(self) -> tuple[np.ndarray, np.ndarray]:
        """Impulse (N s) on the ice since `load`, force on it now (N); each of shape (walls, 2)."""
        walls = 0 if self.walls is None else count_walls(self.walls)
        return wall_forces(self._library, self._instance, self.comm, walls)

    def internal_forces(self) -> Arrays:
        """What neighbours and walls do to each element now, in the order of `elements`.

        Returns
        -------
        dict of ndarray, shape (n,)
            force_x, force_y (N); moment_xx, moment_yy, moment_xy (N m), the sums of arms from the
            centre times forces there, above 0 in tension.

        Raises
        ------
        EngineError
            Where nothing is loaded.
        """
        failed, found = get_internal(self._library, self._instance, self.comm)
        self._check(failed)
        return found

    def _pairs(self) -> tuple[Arrays, Arrays]:
        return get_pairs(self._library, self._instance, self.comm, self.params.contact_columns)

    def diagnostics(self) -> dict[str, float]:
        """Sums over all ranks: energies and works (J), impulses (N s), counts.

        Works, impulses, dissipations and broken bonds are accumulated since `load`; the largest
        overlap (m), energies, momentum and counts belong to now. Each is summed where it
        arises, none is the remainder of the others.
        """
        failed, out = get_sums(self._library, self._instance, self.comm)
        self._check(failed)
        out["time"] = self._now
        return out

    def _open(self) -> None:
        # LIGGGHTS opens its log while it is half built, where a fault cannot be survived.
        fault = self.comm.bcast(open_fault(self.log) if self.comm.rank == 0 else None)
        if fault:
            raise EngineError(f"{self.log}: LIGGGHTS' log cannot be written: {fault}.")
        self._check(open_liggghts(self._library, self._handle, self.comm, self.log))

    def _division(self, elements: Arrays, reach: float) -> Division | None:
        """How the ranks share the box; from one rank, so that all have the same."""
        if self.comm.size == 1 or self.params.period is not None:
            return None
        box = box_of(elements, self.params, reach)
        found = None
        if self.comm.rank == 0:
            found = choose_division(elements, self.comm.size, (box.x, box.y), box.margin)
        return self.comm.bcast(found)

    def _put_pairs(self, bonds: Arrays, contacts: Arrays) -> None:
        self._check(put_pairs(self._library, self._instance, bonds, contacts))
        # None but these are there, so their number tells; a small periodic box may hold one twice.
        found = self.comm.allreduce(sum(count_pairs(self._library, self._instance)))
        if self.params.period is None and found == len(bonds["id_lo"]) + len(contacts["id_lo"]):
            return
        for table, present, kind in zip(
            (bonds, contacts), self._pairs(), ("bond", "contact"), strict=True
        ):
            for lo, hi in missing_pairs(table, present)[:1]:
                raise EngineError(
                    f"The {kind} between elements {lo} and {hi} lies outside of the neighbour "
                    "lists: its elements are too far apart."
                )

    def _command(self, line: str) -> None:
        self._check(self._library.floe_command(self._instance, line.encode()))

    def _check(self, failed: int) -> None:
        if failed:
            self._handle = ctypes.c_void_p()  # what it holds now is not to be trusted or freed
            raise EngineError(
                f"LIGGGHTS: {self._library.floe_error().decode()}{log_tail(self.log)}"
            )

    def _check_faults(self) -> None:
        fault = first_fault(self._library, self._instance, self.comm)
        if fault:
            raise EngineError(fault)
        n = self.comm.allreduce(int(self._library.floe_count_elements(self._instance)))
        if n != len(self._ids):
            lost = np.setdiff1d(self._ids, self.elements()["id"])
            raise EngineError(
                f"{len(lost)} elements were lost by step {self._steps}, the first of them "
                f"{lost[0]}.{log_tail(self.log)}"
            )
        held = self.comm.allreduce(count_pairs(self._library, self._instance)[0])
        if self._bonds and held + round(self.diagnostics()["bonds_broken"]) != self._bonds:
            raise EngineError(
                f"Bonds were lost without breaking by step {self._steps}: set a longer reach."
            )
