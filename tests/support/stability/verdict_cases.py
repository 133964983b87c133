# SPDX-License-Identifier: GPL-2.0-or-later
"""Run by test_verdicts.py under mpirun: a small form of each hard case, and its verdict as JSON.

``exact`` must be the same on any number of ranks, ``close`` to a millionth; what chaotic packs do
later is neither, so they say only whether they kept to what must hold.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.engine import EngineParams
from floeflow.dynamics.ridging.overlaps import rest_overlaps
from floeflow.dynamics.step.critical import critical_step
from floeflow.state.bonds import CONTACT_COLUMNS, Arrays, empty_pairs
from stability.test_jam import LAWS as JAM_LAWS
from stability.test_jam import free_drift, strait
from stability.test_long import CORIOLIS, canonical_spin, moving_raft
from stability.test_long import LAWS as RAFT_LAWS
from stability.test_mass import LAWS as WIND_LAWS
from stability.test_mass import fastest_drift, jumping, mixed_masses
from stability.test_shatter import LAWS as BOND_LAWS
from support.full_ice import full_params
from support.rafts import discs, lattice, uniform
from support.stability import jam
from support.stability.packs import neighbours, shaken, squeezed
from support.stability.watch import Watched, default_step, watch

Shown = dict[str, dict[str, object]]
Case = Callable[[MPI.Comm, Path], Shown]
STILL = uniform((0.0, 0.0), (0.0, 0.0), CORIOLIS)


def of(seen: Watched) -> dict[str, object]:
    """What must be the same of any watched run; watching it has looked at the rest."""
    kept = {"elements": len(seen.elements["id"]), "accounted": seen.residual < 0.02}
    return kept | {"bonds": len(seen.bonds["id_lo"])}


def bits(*tables: Arrays) -> str:
    """Hash of the bytes of tables."""
    whole = hashlib.sha256()
    for table in tables:
        for name in sorted(table):
            whole.update(np.ascontiguousarray(table[name]).tobytes())
    return whole.hexdigest()


def vanishing_mass(comm: MPI.Comm, log: Path) -> Shown:
    """Case 1: masses a billion apart in touch, under a wind that jumps with each step."""
    pack = mixed_masses()
    params = default_step(pack, None, full_params(time_step=1.0, **WIND_LAWS), 0.8)
    wind = jumping(params.time_step, 400)
    seen = watch(log, pack, params, 300 * params.time_step, forcing=wind, samples=4, comm=comm)
    slow = seen.largest_speed < 1.01 * fastest_drift(params)
    return {
        "exact": of(seen) | {"slow": slow, "parted": seen.largest_overlap < 0.01},
        "close": {"step": params.time_step, "largest_speed": seen.largest_speed},
    }


def _bonded_lattice(share: float) -> tuple[Arrays, Arrays, EngineParams]:
    pack = shaken(lattice(8, 6), 1e-5)
    laws = replace(BOND_LAWS, bond_damping=0.1, compressive_strength=1e8, friction=False,
                   deterministic=True)  # fmt: skip
    bonds = neighbours(pack)
    return pack, bonds, replace(laws, time_step=share * critical_step(pack, bonds, laws)[0])


def step_below_the_limit(comm: MPI.Comm, log: Path) -> Shown:
    """Case 2: no energy grows, and added up without round-off, the same bits come out."""
    pack, bonds, params = _bonded_lattice(0.97)
    seen = watch(log, pack, params, 400 * params.time_step, bonds, samples=4, comm=comm)
    calm = bool(seen.energy.max() < 1.5 * seen.energy[0])
    exact = {"calm": calm, "bits": bits(seen.elements, seen.bonds)}
    return {"exact": exact, "close": {"step": params.time_step}}


def step_beyond_the_limit(comm: MPI.Comm, log: Path) -> Shown:
    """Case 2: stopped, and the element named."""
    pack, bonds, params = _bonded_lattice(2.0)
    watch(log, pack, params, 4000 * params.time_step, bonds, samples=40, comm=comm)
    return {"exact": {}, "close": {}}


def overlapping_start(comm: MPI.Comm, log: Path) -> Shown:
    """Case 3: discs with a tenth of overlap stay at rest."""
    pack = squeezed(lattice(8, 8), 0.1)
    contacts = rest_overlaps(pack, None, empty_pairs(CONTACT_COLUMNS))
    params = default_step(pack, None, full_params(time_step=1.0, ocean_drag=True), 0.8)
    seen = watch(
        log, pack, params, 200 * params.time_step, None, contacts, STILL, samples=4, comm=comm
    )
    exact = {"contacts": len(seen.contacts["id_lo"]), "at_rest": seen.largest_speed < 1e-6}
    return {"exact": of(seen) | exact, "close": {"step": params.time_step}}


def radius_of_nothing(comm: MPI.Comm, log: Path) -> Shown:
    """Case 3: refused, and the element named."""
    pack = lattice(4, 4)
    pack["radius"][10] = 0.0
    watch(log, pack, full_params(time_step=1.0), 10.0, comm=comm)
    return {"exact": {}, "close": {}}


def arch_over_a_strait(comm: MPI.Comm, log: Path) -> Shown:
    """Case 4: the ice hangs on the coast."""
    ice, bonds = strait()
    laws = replace(JAM_LAWS, bonds=True, compressive_strength=3e4, tensile_share=0.2)
    params = default_step(ice, bonds, laws, 0.8)
    wind = uniform((0.0, -5.0), (0.0, 0.0), CORIOLIS)
    seen = watch(log, ice, params, 600 * params.time_step, bonds, forcing=wind, samples=4,
                 comm=comm)  # fmt: skip
    exact = {"broken": int(seen.sums["bonds_broken"])}
    exact["slow"] = seen.largest_speed < 1.5 * free_drift(params, 5.0)
    return {"exact": of(seen) | exact, "close": {"largest_speed": seen.largest_speed}}


def jam_in_windows(remesh: str) -> Case:
    """Case 4: two windows against the coast, areas closed, elements replaced or merged."""

    def case(comm: MPI.Comm, log: Path) -> Shown:
        at = jam.setting(remesh, 40)
        seen = jam.press(at, 2, log, comm)
        energy = seen.energy()
        exact = {
            "volume": seen.volume_error < 1e-12,
            "sea": seen.sea_error < 1e-12,
            "slow": seen.largest("largest_speed") < 2.0 * jam.free_drift(at),
            "overlap": max(seen.overlap) <= 1.02,
            "accounted": bool(energy.relative.max() < 0.02),
            "pressed": seen.total("ridged_area") > 0.0,
        }
        return {"exact": exact, "close": {"step": seen.steps[0]}}

    return case


def shattering(comm: MPI.Comm, log: Path) -> Shown:
    """Case 5: all bonds break in one step."""
    pack = lattice(12, 12)
    bonds = neighbours(pack)
    x, y = (pack[name] - pack[name].mean() for name in "xy")
    pack |= {"u": 0.002 * x, "v": 0.002 * y}
    params = default_step(pack, bonds, BOND_LAWS, 0.8)
    broken = []
    seen = watch(
        log, pack, params, 5 * params.time_step, bonds, samples=5, comm=comm,
        look=lambda engine, _: broken.append(int(engine.diagnostics()["bonds_broken"])),
    )  # fmt: skip
    mass = pack["mass"] @ np.hypot(pack["u"], pack["v"])
    still = bool(np.abs(seen.momentum).max() < 1e-12 * mass)
    lost = {"fracture": seen.sums["dissipation_fracture"], "energy": float(seen.energy[-1])}
    return {"exact": of(seen) | {"broken": broken, "momentum": still}, "close": lost}


def ice_that_nothing_breaks(comm: MPI.Comm, log: Path) -> Shown:
    """Case 5: refused, and the bond named."""
    pack = lattice(4, 4)
    watch(log, pack, replace(BOND_LAWS, compressive_strength=1e30), 1.0, neighbours(pack),
          comm=comm)  # fmt: skip
    return {"exact": {}, "close": {}}


def one_element(comm: MPI.Comm, log: Path) -> Shown:
    """Case 7: a scene of one element, which goes its circle while all ranks but one have none."""
    pack = discs([0.0], [0.0])
    pack["u"][:] = 1.0
    params = replace(full_params(time_step=10.0, coriolis=True), deterministic=True)
    seen = watch(log, pack, params, 2e4, forcing=STILL, samples=4, comm=comm)
    speed = float(np.hypot(seen.elements["u"], seen.elements["v"])[0])
    exact = of(seen) | {"bits": bits(seen.elements)}
    return {"exact": exact, "close": {"speed": speed}}


def two_far_apart(comm: MPI.Comm, log: Path) -> Shown:
    """Case 7: islands of one element each; most ranks hold none."""
    pack = discs([0.0, 3e5], [0.0, 2e5], [1000.0, 300.0])
    pack["u"][:] = 0.5
    params = full_params(time_step=10.0, **WIND_LAWS)
    wind = uniform((10.0, 5.0), (0.1, 0.1), CORIOLIS)
    seen = watch(log, pack, params, 5e3, forcing=wind, samples=4, comm=comm)
    return {"exact": of(seen), "close": {"largest_speed": seen.largest_speed}}


def inertial_raft(comm: MPI.Comm, log: Path) -> Shown:
    """Case 8: energy, speed and spin of a raft that nothing slows."""
    ice, bonds = moving_raft()
    params = default_step(ice, bonds, RAFT_LAWS, 0.8)
    seen = watch(
        log, ice, params, 1500 * params.time_step, bonds, forcing=STILL, samples=4, comm=comm
    )
    speed = float(np.hypot(*seen.momentum) / ice["mass"].sum())
    close = {
        "speed": speed,
        "spin": canonical_spin(seen.elements) / canonical_spin(ice),
        "energy": float(seen.energy[-1] / seen.energy[0]),
    }
    exact = {"cracked": int(seen.sums["bonds_cracked"]), "kept": abs(speed / 0.3 - 1.0) < 1e-12}
    return {"exact": of(seen) | exact, "close": close}


CASES: dict[str, Case] = {
    "1 vanishing mass": vanishing_mass,
    "2 step below the limit": step_below_the_limit,
    "2 step beyond the limit": step_beyond_the_limit,
    "3 overlapping start": overlapping_start,
    "3 radius of nothing": radius_of_nothing,
    "4 arch over a strait": arch_over_a_strait,
    "4 jam, no remeshing": jam_in_windows("none"),
    "4 jam, remap": jam_in_windows("remap every window"),
    "4 jam, merge": jam_in_windows("merge"),
    "5 shattering": shattering,
    "5 ice that nothing breaks": ice_that_nothing_breaks,
    "7 one element": one_element,
    "7 two far apart": two_far_apart,
    "8 inertial raft": inertial_raft,
}


def judge(comm: MPI.Comm, case: Case, log: Path) -> Shown:
    """Verdict of a case: stable, or the sentence with which it was refused or stopped."""
    try:
        return {"verdict": {"kind": "stable", "named": []}, **case(comm, log)}
    except FloeError as error:
        named = re.findall(r"elements? (\d+)(?: and (\d+))?", str(error))
        ids = sorted(int(n) for pair in named for n in pair if n)
        said = {"sentence": str(error).replace(str(log.parent), "")}
        return {"verdict": {"kind": "refused", "named": ids}, "exact": said, "close": {}}


def main(folder: Path) -> None:
    """Judge all cases; every rank must come to the same verdict."""
    comm = MPI.COMM_WORLD
    out = {}
    for name, case in CASES.items():
        verdict = judge(comm, case, folder / f"{name}.{comm.size}.log")
        everywhere = comm.allgather(json.dumps(verdict["verdict"], sort_keys=True))
        assert len(set(everywhere)) == 1, f"{name}: the ranks do not agree: {everywhere}"
        out[name] = verdict
    if comm.rank == 0:
        (folder / "verdicts.json").write_text(json.dumps(out, default=float))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
