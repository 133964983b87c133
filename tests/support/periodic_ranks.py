# SPDX-License-Identifier: GPL-2.0-or-later
"""A window of a scene under mpirun: ``python periodic_ranks.py SCENE STATE OUT``."""

from __future__ import annotations

import sys
from pathlib import Path

import xarray as xr
from mpi4py import MPI

from floeflow.coupling.coupled_windows import advance_window
from floeflow.scene.load import load_scene
from floeflow.state.files import read_state, write_state

path, start, out = map(Path, sys.argv[1:])
comm = MPI.COMM_WORLD
log, forcing = out.with_suffix(".log"), xr.Dataset()
scene = load_scene(path)
done = advance_window(comm, scene, read_state(start), forcing, log, lambda **_: None)
if comm.rank == 0:
    write_state(done.state, out)
