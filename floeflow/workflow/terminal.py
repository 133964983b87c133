# SPDX-License-Identifier: GPL-2.0-or-later
"""What Snakemake prints where its output is no terminal: one line an event, and no idle words."""

from __future__ import annotations

import logging
from functools import partial
from typing import Any

# Words that tell of no event.
IDLE = ("Select jobs to execute", "Execute ", "Assuming unrestricted shared", "Using shell")


class OneLine(logging.Formatter):
    """Another formatter's words for an event, on one line.

    Parameters
    ----------
    inner : logging.Formatter
        Makes the words.
    """

    def __init__(self, inner: logging.Formatter) -> None:
        super().__init__()
        self._inner = inner

    def format(self, record: logging.LogRecord) -> str:
        """Words of a record; those of a job or of progress on one line, errors as they are.

        Parameters
        ----------
        record : logging.LogRecord
            Of the log.

        Returns
        -------
        str
            For the terminal.
        """
        text = self._inner.format(record)
        if getattr(record, "event", None) is None or record.levelno >= logging.WARNING:
            return text
        if "\njob " in text:  # the table of all jobs
            return text
        return " ".join(line.strip() for line in text.splitlines() if line.strip())


def tells(record: logging.LogRecord) -> bool:
    """Whether a record tells of anything.

    Parameters
    ----------
    record : logging.LogRecord
        Of the log.

    Returns
    -------
    bool
        False for what Snakemake says while it has nothing to do.
    """
    words = str(record.msg or "").strip()
    named = getattr(record, "event", None) is not None
    return record.levelno >= logging.WARNING or (
        (named or bool(words)) and not words.startswith(IDLE)
    )


def _without_gap(handler: Any, record: logging.LogRecord) -> bool:
    """As `tells`; Snakemake's handler writes an empty line before a job that follows no other."""
    handler.last_msg_was_job_info = True
    return tells(record)


def one_line_an_event(logger: Any) -> None:
    """Let a logger's streams that are no terminal print one line an event.

    Parameters
    ----------
    logger : logging.Logger
        Snakemake's.
    """
    for handler in logger.handlers:
        stream = getattr(handler, "stream", None)
        file = isinstance(handler, logging.FileHandler)
        if stream is None or file or handler.formatter is None or stream.isatty():
            continue
        handler.setFormatter(OneLine(handler.formatter))
        handler.addFilter(partial(_without_gap, handler))
