# SPDX-License-Identifier: GPL-2.0-or-later
"""The one exception that users see: a sentence that names file, key or place."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable


class FloeError(Exception):
    """A fault in what the user gave, said in one clear sentence.

    The front door and the stages print it without a traceback and exit with code 1.
    """


def answer(command: Callable[[], object]) -> int:
    """Run a command and print what it returns, or its fault in one sentence; the exit code."""
    try:
        print(command())
    except FloeError as error:
        print(f"floeflow: {error}", file=sys.stderr)
        return 1
    return 0


def answer_quietly(command: Callable[[], object]) -> int:
    """`answer` without warnings of the log: an estimate reads what a run will warn of."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        return answer(command)
    finally:
        logging.disable(before)
