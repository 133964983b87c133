# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables that benchmarks print."""

from __future__ import annotations

from collections.abc import Iterable


def show(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> None:
    """Print a table."""
    lines = [head, *rows]
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    for line in lines:
        print("  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)))
    print()
