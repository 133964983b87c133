# SPDX-License-Identifier: GPL-2.0-or-later
"""States of older schema versions, brought to the present one when they are read.

A change of the schema raises `SCHEMA_VERSION` and adds one function here: from the version before
to the new one. A state goes through all of them in turn. What cannot be converted is refused in one
sentence that says why; a state of a newer version is refused too. docs/api.md says which changes
of the schema ask for a new version.
"""

from __future__ import annotations

from collections.abc import Callable

import xarray as xr

from floeflow.core.errors import FloeError

SCHEMA_VERSION = 2

Migration = Callable[[xr.Dataset], xr.Dataset]


def _from_1(state: xr.Dataset) -> xr.Dataset:
    """Version 2: the mixed layer is on the scene's grid; in version 1 each element had its own."""
    if "sea_temperature" in state and "element" in state["sea_temperature"].dims:
        raise FloeError(
            "its mixed layer is kept per element (schema version 1), which cannot be put on the "
            "scene's grid: start the run anew"
        )
    return state


MIGRATIONS: dict[int, Migration] = {1: _from_1}


def migrate(state: xr.Dataset) -> xr.Dataset:
    """The state in the present schema.

    Parameters
    ----------
    state : xarray.Dataset
        As it was read, with the attribute ``schema_version``.

    Returns
    -------
    xarray.Dataset
        The same object where the version is the present one.

    Raises
    ------
    FloeError
        Where there is no version, the version is newer, or the state cannot be converted.
    """
    version = state.attrs.get("schema_version")
    if version is None:
        raise FloeError("this is not a FloeFlow state: it has no schema_version")
    if version == SCHEMA_VERSION:
        return state
    if not isinstance(version, int) or version not in MIGRATIONS:
        raise FloeError(
            f"its schema version is {version}, this FloeFlow reads versions "
            f"{min(MIGRATIONS)} to {SCHEMA_VERSION}"
        )
    state = state.copy()
    while version < SCHEMA_VERSION:
        state = MIGRATIONS[version](state)
        version += 1
    state.attrs["schema_version"] = SCHEMA_VERSION
    return state
