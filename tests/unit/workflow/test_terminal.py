# SPDX-License-Identifier: GPL-2.0-or-later
"""Output that goes to a file: one line an event, errors whole."""

from __future__ import annotations

import io
import logging

import pytest
from snakemake.logging import DefaultFormatter
from snakemake_interface_logger_plugins.common import LogEvent

from floeflow.coupling.progress import show_progress
from floeflow.workflow.terminal import one_line_an_event


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def logger_to(stream: io.StringIO) -> logging.Logger:
    logger = logging.Logger("test")
    handler = logging.StreamHandler(stream)
    handler.setFormatter(DefaultFormatter(quiet=set()))
    logger.addHandler(handler)
    one_line_an_event(logger)
    return logger


def say(logger: logging.Logger) -> None:
    job = {"jobid": 3, "rule_msg": "Mask: ice", "reason": "Missing output"}
    logger.info("Select jobs to execute...")
    logger.info("", extra={"event": LogEvent.JOB_INFO, **job})
    logger.info("", extra={"event": LogEvent.PROGRESS, "done": 1, "total": 4})
    logger.info("")
    logger.error("it broke\nin two lines")


def test_a_file_gets_one_line_an_event():
    stream = io.StringIO()
    say(logger_to(stream))
    lines = stream.getvalue().splitlines()
    assert lines[0].startswith("[") and lines[0].endswith("Job 3: Mask: ice Reason: Missing output")
    assert lines[1:] == ["1 of 4 steps (25%) done", "it broke", "in two lines"]


def test_a_terminal_stays_as_it_is():
    stream = Terminal()
    say(logger_to(stream))
    assert "Select jobs" in stream.getvalue() and "ice\nReason" in stream.getvalue()


def test_a_window_has_two_lines(capsys: pytest.CaptureFixture[str]):
    with show_progress(["0001"]) as show:
        for step in (5, 10, 15, 20):
            show(
                {
                    "window": "0001",
                    "step": step,
                    "steps": 20,
                    "elements": 9,
                    "dynamics_seconds": 1.0,
                }
            )
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(",")[0] for line in lines] == [
        "window 0001: step 5 of 20 (25%)",
        "window 0001: step 20 of 20 (100%)",
    ]
