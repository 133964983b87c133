# SPDX-License-Identifier: GPL-2.0-or-later
"""LIGGGHTS with the plugin, driven as a library: the only Python that talks to it.

An engine opens LIGGGHTS afresh at each `load`, in the order of the ids, so that the same state
gives the same bits wherever it came from. All methods are collective over the communicator;
tables go in and come out whole on every rank.
"""

from __future__ import annotations

import ctypes
import types
from pathlib import Path

import numpy as np
from mpi4py import MPI

from floeflow.dynamics.bondtable import (
    BOND_COLUMNS,
    CONTACT_COLUMNS,
    Arrays,
    empty_pairs,
    line_length,
)
from floeflow.dynamics.enginechecks import check_bonds, check_contacts, check_elements
from floeflow.dynamics.engineparams import EngineParams, Forcing, bond_reach
from floeflow.dynamics.pluginlib import load_plugin, quiet_errors
from floeflow.errors import FloeError

__all__ = ["Engine", "EngineError", "EngineParams", "Forcing"]

COLUMNS = ("x", "y", "theta", "u", "v", "omega", "radius", "mass", "thickness", "ice_area")
# Steps between two looks at the plugin's fault flag.
CHUNK = 2000
_NOT_FINITE, _BOND_REACH = 1, 3


class EngineError(FloeError):
    """LIGGGHTS or an element failed; the sentence says which and where."""


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
    """

    def __init__(self, comm: MPI.Comm, params: EngineParams, log: Path) -> None:
        self.comm, self.params, self.log = comm, params, Path(log)
        self._library = load_plugin()
        self._instance = ctypes.c_void_p()
        self._steps = 0
        self._start = 0.0
        self._forcing: Forcing | None = None
        self._expected = (0, 0)  # elements, bonds

    def __enter__(self) -> Engine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: types.TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close LIGGGHTS; the engine can `load` again."""
        if self._instance:
            self._library.floe_close(self._instance)
            self._instance = ctypes.c_void_p()

    def load(
        self,
        elements: Arrays,
        bonds: Arrays | None = None,
        contacts: Arrays | None = None,
        time: float = 0.0,
    ) -> None:
        """Open LIGGGHTS with a state.

        Parameters
        ----------
        elements : dict of ndarray, shape (n,)
            id (ascending), type (1 mobile, 2 fixed), x, y (m), theta (rad), u, v (m/s),
            omega (rad/s), radius (m), mass (kg), thickness (m), ice_area (m2).
        bonds : dict of ndarray, shape (nb,), optional
            As from `bondtable.new_bonds`.
        contacts : dict of ndarray, shape (nc,), optional
            id_lo, id_hi, slip (m), rest_overlap (m).
        time : float
            Time of this state on the forcing's axis, s.

        Raises
        ------
        FloeError
            If a table is not as it must be.
        EngineError
            If LIGGGHTS refuses, or a pair lies outside of its neighbour lists.
        """
        bonds = bonds if bonds is not None and self.params.bonds else empty_pairs(BOND_COLUMNS)
        contacts = contacts if contacts is not None else empty_pairs(CONTACT_COLUMNS)
        check_elements(elements)
        check_bonds(elements, bonds)
        check_contacts(elements, bonds, contacts)
        reach = bond_reach(elements, bonds, self.params)
        self.close()
        self._open()
        self._start, self._steps = time, 0
        self._set_up(elements, reach)
        self._create(elements)
        self._command("run 0 post no")
        self._put_pairs(bonds, contacts)
        self._command("run 0 post no")  # forces with the pairs
        self._expected = (len(elements["id"]), len(bonds["id_lo"]))
        if self._forcing is not None:
            self.set_forcing(self._forcing)

    def set_forcing(self, forcing: Forcing) -> None:
        """Hand over the forcing of the coming steps; needs a loaded state.

        Raises
        ------
        FloeError
            If a field that the switches need is missing, misshapen or not finite.
        """
        velocity, coriolis = forcing.packed(self.params.external)
        x, y = np.asarray(forcing.x, float), np.asarray(forcing.y, float)
        time = np.ascontiguousarray(forcing.time, dtype=float)
        spacing = [float(a[-1] - a[0]) / (len(a) - 1) if len(a) > 1 else 1.0 for a in (x, y)]
        self._check(
            self._library.floe_set_forcing(
                *(self._instance, len(time), len(y), len(x), time),
                *(float(x[0]), spacing[0], float(y[0]), spacing[1], velocity, coriolis),
            )
        )
        self._forcing = forcing

    def run(self, steps: int) -> None:
        """Advance by a number of steps. Cutting a run into several calls changes no bit.

        Raises
        ------
        EngineError
            If LIGGGHTS fails, an element becomes non-finite, runs away or is lost, or a bond
            leaves the neighbours' reach.
        """
        self._check_time(steps)
        while steps > 0:
            # Cut at multiples of the chunk, whatever the caller asks for.
            now = min(steps, CHUNK - self._steps % CHUNK)
            self._command(f"run {now} pre no post no")
            self._steps += now
            steps -= now
            self._check_faults()

    def elements(self) -> Arrays:
        """Elements as `load` takes them, on every rank."""
        n = int(self._library.floe_count_elements(self._instance))
        ids, kind = np.empty(n, np.int64), np.empty(n, np.int8)
        columns = np.empty((n, len(COLUMNS)))
        self._library.floe_get_elements(self._instance, ids, kind, columns)
        ids, kind, columns = (self._gather(a) for a in (ids, kind, columns))
        order = np.argsort(ids)
        out = {"id": ids[order], "type": kind[order]}
        for k, name in enumerate(COLUMNS):
            out[name] = columns[order, k].copy()
        return out

    def bonds(self) -> Arrays:
        """Bond table, sorted by (id_lo, id_hi), on every rank; broken bonds are not in it."""
        return self._pairs()[0]

    def contacts(self) -> Arrays:
        """Contact history, sorted by (id_lo, id_hi), on every rank."""
        return self._pairs()[1]

    def diagnostics(self) -> dict[str, float]:
        """Sums over all ranks: energies and works (J), impulses (N s), counts.

        Works, impulses, dissipations and broken bonds are accumulated since `load`; the largest
        overlap (m), energies, momentum and counts belong to now. Each is summed where it
        arises, none is the remainder of the others.
        """
        names = self._library.floe_sum_names().decode().split()
        sums = np.empty(len(names))
        self._check(self._library.floe_sums(self._instance, sums, len(sums)))
        total, largest = np.empty_like(sums), np.empty_like(sums)
        self.comm.Allreduce(sums, total, op=MPI.SUM)
        self.comm.Allreduce(sums, largest, op=MPI.MAX)
        out = dict(zip(names, total.tolist(), strict=True))
        out["max_overlap"] = float(largest[names.index("max_overlap")])
        out["time"] = self._start + self._steps * self.params.time_step
        return out

    def _open(self) -> None:
        words = ["liggghts", "-screen", "none", "-log", str(self.log)]
        arguments = (ctypes.c_char_p * len(words))(*(word.encode() for word in words))
        handle = ctypes.c_void_p(MPI._addressof(self.comm))
        with quiet_errors():
            failed = self._library.floe_open(
                len(words), arguments, handle, ctypes.byref(self._instance)
            )
        self._check(failed)

    def _set_up(self, elements: Arrays, reach: float) -> None:
        radius = elements["radius"]
        skin = self._skin(elements)
        margin = 2.0 * float(radius.max()) * reach + skin
        low = [float(elements[axis].min()) - margin for axis in ("x", "y")]
        high = [float(elements[axis].max()) + margin for axis in ("x", "y")]
        for line in (
            "units si",
            "dimension 2",
            "atom_style granular",
            "atom_modify sort 1000 0",
            "boundary m m p",
            "newton off",
            "communicate single vel yes",
            "processors * * 1",
            # As deep as wide neighbourhoods: LIGGGHTS refuses to bin a flat box.
            f"region box block {low[0]!r} {high[0]!r} {low[1]!r} {high[1]!r}"
            f" {-margin!r} {margin!r} units box",
            "create_box 2 box",
            f"neighbor {skin!r} bin",
            # Not `one` or `page`: with other than their defaults LIGGGHTS 3.8 makes new lists at
            # each `run` and forgets all pairs.
            "neigh_modify delay 0 every 1 check yes",
            "neigh_modify exclude type 2 2",
            self.params.pair_style(reach),
            "pair_coeff * *",
            f"timestep {self.params.time_step!r}",
            self.params.fix_style(),
            "thermo_style custom step atoms",
            "thermo_modify lost ignore norm no",
            "thermo 1000000000",
        ):
            self._command(line)

    def _skin(self, elements: Arrays) -> float:
        if self.params.skin is not None:
            return self.params.skin
        # A list should last some hundreds of steps: neither rebuilt often nor full of pairs that
        # never meet. Ice driven by wind reaches some tenths of a metre per second.
        speed = max(0.3, float(np.hypot(elements["u"], elements["v"]).max()))
        mean = float(elements["radius"].mean())
        return float(np.clip(2.0 * 300.0 * speed * self.params.time_step, 0.02 * mean, 0.5 * mean))

    def _create(self, elements: Arrays) -> None:
        columns = np.ascontiguousarray(
            np.column_stack([np.asarray(elements[name], dtype=float) for name in COLUMNS])
        )
        ids = np.ascontiguousarray(elements["id"], dtype=np.int64)
        kind = np.ascontiguousarray(elements["type"], dtype=np.int8)
        self._check(
            self._library.floe_create_elements(self._instance, len(ids), ids, kind, columns)
        )
        self._library.floe_set_start_time(self._instance, self._start)

    def _put_pairs(self, bonds: Arrays, contacts: Arrays) -> None:
        arguments: list[object] = []
        for table, names in ((bonds, BOND_COLUMNS), (contacts, CONTACT_COLUMNS)):
            ids = np.column_stack([table["id_lo"], table["id_hi"]]).astype(np.int64)
            values = np.column_stack([np.asarray(table[name], dtype=float) for name in names])
            arguments += [len(ids), np.ascontiguousarray(ids), np.ascontiguousarray(values)]
        placed = (ctypes.c_longlong(), ctypes.c_longlong())
        self._check(
            self._library.floe_put_pairs(
                self._instance, *arguments, ctypes.byref(placed[0]), ctypes.byref(placed[1])
            )
        )
        for count, table, kind in zip(placed, (bonds, contacts), ("bond", "contact"), strict=True):
            if self.comm.allreduce(count.value) != len(table["id_lo"]):
                held = self._pairs()[0 if kind == "bond" else 1]
                have = set(zip(held["id_lo"].tolist(), held["id_hi"].tolist(), strict=True))
                want = zip(table["id_lo"].tolist(), table["id_hi"].tolist(), strict=True)
                lo, hi = next(pair for pair in want if pair not in have)
                raise EngineError(
                    f"The {kind} between elements {lo} and {hi} lies outside of the neighbour "
                    "lists: its elements are too far apart."
                )

    def _pairs(self) -> tuple[Arrays, Arrays]:
        counts = (ctypes.c_longlong(), ctypes.c_longlong())
        self._library.floe_count_pairs(
            self._instance, ctypes.byref(counts[0]), ctypes.byref(counts[1])
        )
        ids = [np.empty((c.value, 2), np.int64) for c in counts]
        values = [
            np.empty((c.value, len(names)))
            for c, names in zip(counts, (BOND_COLUMNS, CONTACT_COLUMNS), strict=True)
        ]
        self._library.floe_get_pairs(self._instance, ids[0], values[0], ids[1], values[1])
        tables = []
        for k, names in enumerate((BOND_COLUMNS, CONTACT_COLUMNS)):
            pair, row = self._gather(ids[k]), self._gather(values[k])
            order = np.lexsort((pair[:, 1], pair[:, 0]))
            table = {"id_lo": pair[order, 0].copy(), "id_hi": pair[order, 1].copy()}
            for column, name in enumerate(names):
                table[name] = row[order, column].copy()
            tables.append(table)
        tables[0]["length"] = line_length(tables[0])
        return tables[0], tables[1]

    def _gather(self, local: np.ndarray) -> np.ndarray:
        return np.concatenate(self.comm.allgather(local))

    def _command(self, line: str) -> None:
        self._check(self._library.floe_command(self._instance, line.encode()))

    def _check(self, failed: int) -> None:
        if failed:
            self._instance = ctypes.c_void_p()  # what it holds now is not to be trusted or freed
            raise EngineError(
                f"LIGGGHTS: {self._library.floe_error().decode()}{log_tail(self.log)}"
            )

    def _check_time(self, steps: int) -> None:
        needed = self.params.external
        if not needed:
            return
        if self._forcing is None:
            raise FloeError(f"The scene's effects need forcing ({', '.join(needed)}).")
        first, last = float(self._forcing.time[0]), float(self._forcing.time[-1])
        begin = self._start + self._steps * self.params.time_step
        end = begin + steps * self.params.time_step
        slack = 0.5 * self.params.time_step
        if first < last and (begin < first - slack or end > last + slack):
            raise FloeError(
                f"The forcing covers {first:g} s to {last:g} s, not {begin:g} s to {end:g} s."
            )

    def _check_faults(self) -> None:
        whole, real = np.zeros(4, np.int64), np.zeros(6)
        self._library.floe_fault(self._instance, whole, real)
        found = [f for f in self.comm.allgather((whole.tolist(), real.tolist())) if f[0][0]]
        if found:
            raise EngineError(_fault_sentence(*min(found, key=lambda f: f[0][1:3])))
        n = self.comm.allreduce(int(self._library.floe_count_elements(self._instance)))
        if n != self._expected[0]:
            missing = set(range(1, self._expected[0] + 1)) - set(self.elements()["id"].tolist())
            raise EngineError(
                f"{self._expected[0] - n} elements were lost by step {self._steps}, among them "
                f"{min(missing, default=0)}{log_tail(self.log)}"
            )
        if self._expected[1]:
            self._check_bonds()

    def _check_bonds(self) -> None:
        counts = (ctypes.c_longlong(), ctypes.c_longlong())
        self._library.floe_count_pairs(
            self._instance, ctypes.byref(counts[0]), ctypes.byref(counts[1])
        )
        held = self.comm.allreduce(counts[0].value)
        broken = round(self.diagnostics()["bonds_broken"])
        if held + broken != self._expected[1]:
            raise EngineError(
                f"{self._expected[1] - broken - held} bonds were lost without breaking by step "
                f"{self._steps}: set a longer reach."
            )


def _fault_sentence(whole: list[int], real: list[float]) -> str:
    kind, step, ident, partner = whole
    x, y, fx, fy, torque, speed = real
    place = f"at ({x:.6g}, {y:.6g}) m in step {step}"
    if kind == _BOND_REACH:
        return (
            f"The bond between elements {ident} and {partner}, {place}, became longer than the "
            "neighbour lists reach: set a longer reach."
        )
    what = "became non-finite" if kind == _NOT_FINITE else f"ran away with {speed:.3g} m/s"
    return (
        f"Element {ident} {what} {place}; last force ({fx:.6g}, {fy:.6g}) N, torque "
        f"{torque:.6g} N m: is the time step too long?"
    )


def log_tail(log: Path, lines: int = 5) -> str:
    """Last lines of a log, to stand behind a sentence; empty where there is none."""
    try:
        tail = log.read_text(errors="replace").splitlines()[-lines:]
    except OSError:
        return ""
    return "".join(f"\n  {line}" for line in [f"(tail of {log})", *tail])
