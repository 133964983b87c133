# SPDX-License-Identifier: GPL-2.0-or-later
"""Faults that all ranks share: no rank waits for one that has given up."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TypeVar

from mpi4py import MPI

from floeflow.core.errors import FloeError

T = TypeVar("T")

# Long enough for ranks that raised the same fault to arrive, short for a person who waits.
PATIENCE_SECONDS = 5.0


def on_root(comm: MPI.Comm, function: Callable[..., T], *arguments: object) -> T:
    """Result of a function that only rank 0 calls, given to every rank; so is its fault.

    Parameters
    ----------
    comm : MPI.Comm
        Ranks of the run.
    function : callable
        Called with the arguments.
    arguments : object
        Of the function.

    Returns
    -------
    object
        What the function gave on rank 0.

    Raises
    ------
    FloeError
        On every rank, where the function raised it on rank 0.
    """
    outcome: tuple[T | None, str | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (function(*arguments), None)
        except FloeError as error:
            outcome = (None, str(error))
    result, fault = comm.bcast(outcome)
    if fault is not None:
        raise FloeError(fault)
    return result


def on_all(comm: MPI.Comm, function: Callable[..., T], *arguments: object) -> T:
    """Result of a function that every rank calls on its own; a fault of one is a fault of all.

    Parameters
    ----------
    comm : MPI.Comm
        Ranks of the run.
    function : callable
        Called with the arguments.
    arguments : object
        Of the function.

    Returns
    -------
    object
        What the function gave on this rank.

    Raises
    ------
    FloeError
        On every rank, with the sentence of the lowest rank at fault.
    """
    result, fault = None, None
    try:
        result = function(*arguments)
    except FloeError as error:
        fault = str(error)
    for sentence in comm.allgather(fault):
        if sentence is not None:
            raise FloeError(sentence)
    return result  # type: ignore[return-value]


def leave(comm: MPI.Comm) -> None:
    """End with exit code 1: in order where all ranks come here, else by aborting the rest.

    Parameters
    ----------
    comm : MPI.Comm
        Ranks of the program.
    """
    barrier = comm.Ibarrier()
    deadline = time.monotonic() + PATIENCE_SECONDS
    while not barrier.Test():
        if time.monotonic() > deadline:
            comm.Abort(1)
    sys.exit(1)
