# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin's C interface as Python sees it, and where the plugin lies."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.ctypeslib import ndpointer

from floeflow.core.errors import FloeError
from floeflow.core.plugin import plugin_path
from floeflow.dynamics.engine.tables import COLUMNS as ELEMENT_COLUMNS
from floeflow.dynamics.engine.tables import INTERNAL
from floeflow.state.bonds import BOND_COLUMNS, CONTACT_COLUMNS, RIDGE_COLUMNS
from floeflow.state.walls import FACE_COLUMNS, FACE_NUMBERS

_INTEGERS = ndpointer(np.int64, flags="C_CONTIGUOUS")
_NUMBERS = ndpointer(np.float64, flags="C_CONTIGUOUS")
_TYPES = ndpointer(np.int8, flags="C_CONTIGUOUS")
_COUNT = ctypes.c_longlong
_COUNTED = ctypes.POINTER(ctypes.c_longlong)
# Results of functions that fail where something is wrong in the plugin itself: 0 for success, and a
# count, which is below 0 then.
_DONE, _NUMBER = object(), object()
# Version of the plugin's C interface (FLOE_INTERFACE in liggghts_models/capi/capi.h).
INTERFACE = 5
# Columns of the arrays that go in and out, as the plugin must have them (`floe_layout`).
LAYOUT = {
    "elements": ELEMENT_COLUMNS,
    "bonds": BOND_COLUMNS,
    "contacts": (*CONTACT_COLUMNS, *RIDGE_COLUMNS),
    "numbers of faces": FACE_NUMBERS,
    "faces": FACE_COLUMNS,
    "internal forces": INTERNAL,
}
_FUNCTIONS: dict[str, tuple[object, list[object]]] = {
    "floe_error": (ctypes.c_char_p, []),
    "floe_interface": (ctypes.c_int, []),
    "floe_layout": (ctypes.c_char_p, []),
    "floe_open": (
        ctypes.c_int,
        [
            ctypes.c_int,
            ctypes.POINTER(ctypes.c_char_p),
            ctypes.c_void_p,
            ctypes.POINTER(ctypes.c_void_p),
        ],
    ),
    "floe_close": (_DONE, [ctypes.c_void_p]),
    "floe_command": (ctypes.c_int, [ctypes.c_void_p, ctypes.c_char_p]),
    "floe_divide": (ctypes.c_int, [ctypes.c_void_p, _NUMBERS, _NUMBERS]),
    "floe_set_start_time": (_DONE, [ctypes.c_void_p, ctypes.c_double]),
    "floe_create_elements": (
        ctypes.c_int,
        [ctypes.c_void_p, _COUNT, _INTEGERS, _TYPES, _NUMBERS],
    ),
    "floe_count_elements": (_NUMBER, [ctypes.c_void_p]),
    "floe_get_elements": (_DONE, [ctypes.c_void_p, _INTEGERS, _TYPES, _NUMBERS]),
    "floe_put_pairs": (
        ctypes.c_int,
        [
            *(ctypes.c_void_p, _COUNT, _INTEGERS, _NUMBERS),
            *(_COUNT, _INTEGERS, _NUMBERS),
        ],
    ),
    "floe_count_pairs": (_DONE, [ctypes.c_void_p, _COUNTED, _COUNTED]),
    "floe_get_pairs": (_DONE, [ctypes.c_void_p, _INTEGERS, _NUMBERS, _INTEGERS, _NUMBERS]),
    "floe_internal": (ctypes.c_int, [ctypes.c_void_p, _NUMBERS]),
    "floe_set_walls": (
        ctypes.c_int,
        [ctypes.c_void_p, _COUNT, _COUNT, _INTEGERS, _NUMBERS],
    ),
    "floe_put_wall_contacts": (ctypes.c_int, [ctypes.c_void_p, _COUNT, _INTEGERS, _NUMBERS]),
    "floe_count_wall_contacts": (_NUMBER, [ctypes.c_void_p]),
    "floe_get_wall_contacts": (_DONE, [ctypes.c_void_p, _INTEGERS, _NUMBERS]),
    "floe_wall_forces": (_DONE, [ctypes.c_void_p, _NUMBERS, _NUMBERS]),
    "floe_set_forcing": (
        ctypes.c_int,
        [
            *(ctypes.c_void_p, _COUNT, _COUNT, _COUNT, _NUMBERS),
            *(ctypes.c_double,) * 4,
            *(_NUMBERS, _NUMBERS, ctypes.c_int, ctypes.c_int),
        ],
    ),
    "floe_set_depth": (_DONE, [ctypes.c_void_p, _NUMBERS]),
    "floe_sum_names": (ctypes.c_char_p, []),
    "floe_sums": (ctypes.c_int, [ctypes.c_void_p, _NUMBERS, ctypes.c_int]),
    "floe_fault": (_DONE, [ctypes.c_void_p, _INTEGERS, _NUMBERS]),
}


@functools.cache
def load_plugin() -> ctypes.CDLL:
    """Load the plugin, and LIGGGHTS with it, once per process.

    Raises
    ------
    FloeError
        If it is not there, cannot be loaded or lacks a function, as an older one does.
    """
    path = plugin_path()
    try:
        library = ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
    except OSError as error:
        raise FloeError(f"The LIGGGHTS plugin {path} cannot be loaded: {error}") from error
    for name, (result, arguments) in _FUNCTIONS.items():
        function = getattr(library, name, None)
        if function is None:
            raise FloeError(
                f"The LIGGGHTS plugin {path} does not fit this FloeFlow, it has no {name}: "
                "`make setup` builds it anew."
            )
        function.restype = {_DONE: ctypes.c_int, _NUMBER: _COUNT}.get(result, result)
        function.argtypes = arguments
        if result in (_DONE, _NUMBER):
            function.errcheck = _raise_if_failed(library)
    _check_layout(library, path)
    return library


def _raise_if_failed(library: ctypes.CDLL) -> Callable[[int, object, tuple[object, ...]], int]:
    """Result check of functions that fail only where the plugin is at fault."""

    def check(result: int, function: Any, _arguments: tuple[object, ...]) -> int:
        if result < 0 if function.restype is _COUNT else result:
            raise FloeError(f"The LIGGGHTS plugin failed: {library.floe_error().decode()}")
        return result

    return check


def _check_layout(library: ctypes.CDLL, path: Path) -> None:
    """Refuse a plugin whose arrays mean something else than they mean here."""
    version = int(library.floe_interface())
    if version != INTERFACE:
        raise FloeError(
            f"The LIGGGHTS plugin {path} does not fit this FloeFlow, its interface is number "
            f"{version} and not {INTERFACE}: `make setup` builds it anew."
        )
    parts = [tuple(part.split()) for part in library.floe_layout().decode().split(";")]
    for k, (what, names) in enumerate(LAYOUT.items()):
        found = parts[k] if k < len(parts) else ()
        if found != names:
            raise FloeError(
                f"The LIGGGHTS plugin {path} does not fit this FloeFlow, its columns of {what} are "
                f"'{' '.join(found)}' and not '{' '.join(names)}': `make setup` builds it anew."
            )


@contextlib.contextmanager
def quiet_errors() -> Iterator[None]:
    """Keep LIGGGHTS' warnings about its own styles, printed at each opening, off the terminal."""
    saved = os.dup(2)
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)


def open_liggghts(
    library: ctypes.CDLL, instance: ctypes.c_void_p, comm: MPI.Comm, log: Path
) -> int:
    """Open LIGGGHTS on a communicator with a log; returns 1 if that failed.

    Parameters
    ----------
    library : ctypes.CDLL
        Of the plugin.
    instance : ctypes.c_void_p
        Set where it succeeds.
    comm : MPI.Comm
        Ranks that share the engine.
    log : Path
        File that LIGGGHTS writes.

    Returns
    -------
    int
        0 for success.
    """
    words = ["liggghts", "-screen", "none", "-log", str(log)]
    arguments = (ctypes.c_char_p * len(words))(*(word.encode() for word in words))
    handle = ctypes.c_void_p(MPI._addressof(comm))
    with quiet_errors():
        return int(library.floe_open(len(words), arguments, handle, ctypes.byref(instance)))
