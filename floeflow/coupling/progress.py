# SPDX-License-Identifier: GPL-2.0-or-later
"""Progress of a job's windows: a bar on a terminal, two lines a window elsewhere."""

from __future__ import annotations

import contextlib
import logging
import sys
from collections.abc import Iterator
from typing import Any, Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

Event = dict[str, Any]


class Show(Protocol):
    """Takes one event of the ranks."""

    def __call__(self, event: Event) -> None:
        """Show it."""


def speed(event: Event) -> float:
    """Element-steps per second since the window's dynamics began."""
    seconds = event["dynamics_seconds"]
    return float(event["elements"] * event["step"] / seconds) if seconds > 0 else 0.0


def line(event: Event) -> str:
    """Describe an event in one line."""
    share = event["step"] / event["steps"]
    left = event["dynamics_seconds"] * (1.0 / share - 1.0)
    return (
        f"window {event['window']}: step {event['step']} of {event['steps']} ({share:.0%}), "
        f"{speed(event):.3g} element-steps/s, {left:.0f} s left"
    )


@contextlib.contextmanager
def show_progress(windows: list[str]) -> Iterator[Show]:
    """Show events while the context lasts; every event also goes to the log.

    A terminal that went away (its workflow was killed) does not stop the job.
    """
    with contextlib.ExitStack() as stack:
        if sys.stderr.isatty():
            bar = stack.enter_context(_bar())
            show: Show = _BarShow(bar, len(windows))
        else:
            show = _Lines()

        def log_and_show(event: Event) -> None:
            logging.info("%s", line(event))
            with contextlib.suppress(OSError):
                show(event)

        yield log_and_show


class _Lines:
    """Two lines for each window: its first sample, which tells how fast it goes, and its end."""

    def __init__(self) -> None:
        self._begun: set[str] = set()

    def __call__(self, event: Event) -> None:
        first = event["window"] not in self._begun
        self._begun.add(event["window"])
        if first or event["step"] >= event["steps"]:
            print(line(event), file=sys.stderr, flush=True)


def _bar() -> Progress:
    columns = (
        TextColumn("window {task.fields[window]}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %  {task.fields[speed]:.3g} element-steps/s"),
        TimeRemainingColumn(),
    )
    return Progress(*columns, console=Console(stderr=True))


class _BarShow:
    """One bar for each window."""

    def __init__(self, bar: Progress, windows: int) -> None:
        self._bar = bar
        self._windows = windows
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, event: Event) -> None:
        window = event["window"]
        if window not in self._tasks:
            self._tasks[window] = self._bar.add_task(
                window, total=event["steps"], window=window, speed=0.0
            )
        self._bar.update(self._tasks[window], completed=event["step"], speed=speed(event))
