# SPDX-License-Identifier: GPL-2.0-or-later
"""Load the probe of ``make doctor`` with LIGGGHTS in it and have it count elements over MPI.

Called as ``mpirun -n 2 python probe.py LIBRARY``. Ends with exit code 0 when LIGGGHTS opened on
all ranks, ran its commands, and the probe, compiled from LIGGGHTS' headers, counted as many
elements as were made.
"""

import ctypes
import sys

from mpi4py import MPI

COMMANDS = """\
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
region box block 0 4 0 1 0 1 units box
create_box 1 box
create_atoms 1 single 0.5 0.5 0.5 units box
create_atoms 1 single 1.5 0.5 0.5 units box
create_atoms 1 single 3.5 0.5 0.5 units box
"""


def main(library: str) -> int:
    """Load the probe; return 0 when it works on all ranks of the launch."""
    probe = ctypes.CDLL(library, mode=ctypes.RTLD_GLOBAL)
    names = [b"probe", b"-log", b"none", b"-screen", b"none"]
    arguments = (ctypes.c_char_p * len(names))(*names)
    world = ctypes.c_void_p(MPI._handleof(MPI.COMM_WORLD))
    liggghts = ctypes.c_void_p()
    probe.lammps_open(len(names), arguments, world, ctypes.byref(liggghts))
    for command in COMMANDS.splitlines():
        probe.probe_command(liggghts, command.encode())
    counted = probe.probe_elements(liggghts)
    probe.lammps_close(liggghts)
    expected = COMMANDS.count("create_atoms")
    if MPI.COMM_WORLD.rank == 0:
        print(f"{counted} of {expected} elements on {MPI.COMM_WORLD.size} ranks")
    return 0 if counted == expected else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
