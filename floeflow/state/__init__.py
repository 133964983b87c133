# SPDX-License-Identifier: GPL-2.0-or-later
"""The state at a window boundary: its schema, reader and writer."""

from floeflow.state.files import read_dataset, read_state, write_dataset, write_state
from floeflow.state.migrations import SCHEMA_VERSION
from floeflow.state.schema import VARIABLES, Variable, check_state

__all__ = [
    "SCHEMA_VERSION",
    "VARIABLES",
    "Variable",
    "check_state",
    "read_dataset",
    "read_state",
    "write_dataset",
    "write_state",
]
