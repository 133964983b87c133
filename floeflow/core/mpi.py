# SPDX-License-Identifier: GPL-2.0-or-later
"""The one place that says how MPI programs are started."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping

# What a running MPI process leaves to its children: an mpirun that finds it takes itself for a part
# of that process. Settings of the user's own (other OMPI_MCA_ names) stay.
_INHERITED = re.compile(r"PMIX_|ORTE_|OMPI_(?!MCA_)|OMPI_MCA_(ess|pmix|orte_)")


def mpi_environment(base: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Environment under which ``mpirun`` starts for any user, on any number of cores.

    Parameters
    ----------
    base : mapping
        Environment to start from.

    Returns
    -------
    dict of str
        What a process is started with, `base` included.
    """
    return {
        # Where the ranks run, the system decides. Open MPI binds the first ranks of every program
        # to the first cores: programs side by side would share these and leave the others idle.
        "OMPI_MCA_hwloc_base_binding_policy": "none",
        **{name: value for name, value in base.items() if not _INHERITED.match(name)},
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
