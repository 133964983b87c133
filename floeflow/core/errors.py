# SPDX-License-Identifier: GPL-2.0-or-later
"""The one exception that users see: a sentence that names file, key or place."""

from __future__ import annotations

import logging
import sys
import tempfile
import traceback
from collections.abc import Callable


class FloeError(Exception):
    """A fault in what the user gave, said in one clear sentence.

    The workflow and the stages print it without a traceback and exit with code 1. It is one line,
    whatever breaks and controls of a terminal the names and attributes of a file hold.
    """

    def __str__(self) -> str:
        """The sentence, in characters that can be printed."""
        return plain(super().__str__())


def plain(text: str) -> str:
    """A text on one line: spaces for breaks, escapes for what no one can see.

    Parameters
    ----------
    text : str
        Any text, as of a library's error.

    Returns
    -------
    str
        Without line breaks or control characters.
    """
    return "".join(
        sign if sign.isprintable() else " " if sign.isspace() else ascii(sign)[1:-1]
        for sign in text
    )


def answer(command: Callable[[], object]) -> int:
    """Run a command and print what it returns, or its fault in one sentence; the exit code.

    A fault of the program itself is told in a sentence too.

    Parameters
    ----------
    command : callable
        The command; its result is printed.

    Returns
    -------
    int
        0, or 1 after a fault.
    """
    try:
        print(command())
    except FloeError as error:
        print(f"floeflow: {error}", file=sys.stderr)
        return 1
    except Exception as error:
        print(f"floeflow: {unexpected(error)}", file=sys.stderr)
        return 1
    return 0


def unexpected(error: Exception) -> str:
    """What is said of a fault of the program: a sentence, with the file that has its traceback.

    Parameters
    ----------
    error : Exception
        That was raised.

    Returns
    -------
    str
        One line, for people.
    """
    kind = type(error).__name__
    words = plain(" ".join(str(error).split()))[:200]
    said = f"{kind}: {words}" if words else kind
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="floeflow-", suffix=".log", delete=False, encoding="utf-8"
        ) as log:
            traceback.print_exception(error, file=log)
    except OSError:
        return f"{said}; this is a fault of the program, please report it"
    return f"{said}; this is a fault of the program, please report it with {log.name}"


def answer_quietly(command: Callable[[], object]) -> int:
    """`answer` without warnings of the log: an estimate reads what a run will warn of.

    Parameters
    ----------
    command : callable
        The command; its result is printed.

    Returns
    -------
    int
        0, or 1 after a fault.
    """
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        return answer(command)
    finally:
        logging.disable(before)
