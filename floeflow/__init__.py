# SPDX-License-Identifier: GPL-2.0-or-later
"""FloeFlow: a sea-ice discrete element model that runs as a workflow.

docs/architecture.md has its layers, from ``core`` up to ``cli``.
"""

# The only place of the version: the package, states, hashes and `make tag` read it here.
__version__ = "0.1.0"

# xarray's search for engines loads eccodes, which brings a PROJ of its own. Where that one is there
# first, pyproj calls into it and fails ("no database context"); this way round both work.
import pyproj as pyproj
