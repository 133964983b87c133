# SPDX-License-Identifier: GPL-2.0-or-later
"""How fast memory alone would let the element model be.

A step reads and writes what it must of each element and each pair once in each pass over them. Over
the bandwidth of this machine that is the least time of a step of a raft too large for the caches.
"""

from __future__ import annotations

import time

import numpy as np

# What one step moves, bytes read and written, with sizes of the plugin's records (contact/body.h,
# contact/records.h) and LIGGGHTS' arrays; what the caches keep within a pass is counted once.
BOND = 96 + 8  # a column of BondBlock, two numbers of elements
CONTACT = 8 + 32 + 32  # Ends, a ContactRow in and out
ELEMENT = {
    "body, by the pairs": 64,
    "body, in and out, by the integrator": 128,
    "load, in and out, by the pairs": 64,
    "load, in and cleared, by the integrator": 64,
    "place in and out, orientation in and out, mass, kind": 48 + 16 + 12,
    "place and that of the lists, by LIGGGHTS' check of its lists": 48,
}
STREAM_BYTES = 1 << 28


def stream_bandwidth(repeats: int = 7) -> float:
    """Bytes per second of the best pass over an array that is read and written in place."""
    numbers = np.ones(STREAM_BYTES // 8)
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        np.multiply(numbers, 1.0000001, out=numbers)
        best = min(best, time.perf_counter() - start)
    return 2 * numbers.nbytes / best


def bytes_per_step(elements: int, bonds: int, contacts: int) -> int:
    """Bytes that a step moves at least."""
    return elements * sum(ELEMENT.values()) + bonds * BOND + contacts * CONTACT
