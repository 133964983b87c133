# SPDX-License-Identifier: GPL-2.0-or-later
"""Output that goes to a file: one line an event, errors whole."""

from __future__ import annotations

import io
import logging
import re
import sys
from functools import partial

import pytest
from snakemake.logging import DefaultFormatter
from snakemake_interface_logger_plugins.common import LogEvent

from floeflow.coupling.progress import WholeRun, duration, show_progress
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


def event(window: int, step: int) -> dict[str, object]:
    name = f"{window:04d}"
    return {"window": name, "step": step, "steps": 20, "elements": 9, "dynamics_seconds": 1.0}


def test_a_window_has_two_lines(capsys: pytest.CaptureFixture[str]):
    with show_progress(4) as show:
        for step in (5, 10, 15, 20):
            show(event(1, step))
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(",")[0] for line in lines] == [
        "window 0001: step 5 of 20 (25%)",
        "window 0001: step 20 of 20 (100%)",
    ]
    assert lines[0].endswith("; run: window 1 of 4 (6%)")
    assert re.search(r"; run: window 1 of 4 \(25%\), \d+ s left$", lines[1])


def test_the_rest_of_a_run_takes_as_long_as_the_job_went():
    """A job that begins behind the 100th of 365 windows; a window takes 20 s."""
    clock = iter([0.0, 10.0, 190.0])
    run = WholeRun(365, partial(next, clock))
    assert run.left(event(101, 0)) is None
    assert run.left(event(101, 10)) == pytest.approx(20.0 * 264.5)
    assert run.say(event(110, 10)) == "run: window 110 of 365 (30%), 85 min left"
    assert [duration(each) for each in (12.2, 89.6, 400.0, 7300.0)] == [
        "12 s", "90 s", "7 min", "2 h 2 min",
    ]  # fmt: skip


def test_a_terminal_has_a_bar_for_the_run_and_one_for_the_window(monkeypatch: pytest.MonkeyPatch):
    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)
    with show_progress(4) as show:
        for window in (2, 3):
            for step in (10, 20):
                show(event(window, step))
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue())
    last = [row.strip() for row in re.split(r"[\r\n]+", text) if row.strip()][-2:]
    assert last[0].startswith("run ") and "window 3 of 4 (75%)" in last[0]
    assert last[1].startswith("window ") and "step 20 of 20" in last[1]
