# SPDX-License-Identifier: GPL-2.0-or-later
"""The one place that says how MPI programs are started."""

from __future__ import annotations

import os


def mpi_environment() -> dict[str, str]:
    """Environment under which ``mpirun`` starts for any user, on any number of cores."""
    return {
        **os.environ,
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        # Ranks yield the core while they wait: needed where ranks outnumber cores.
        "OMPI_MCA_mpi_yield_when_idle": "1",
        # One thread a rank, whatever the numerical libraries find.
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "NUMBA_NUM_THREADS": "1",
    }
