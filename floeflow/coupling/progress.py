# SPDX-License-Identifier: GPL-2.0-or-later
"""Progress of a run: bars of run and window on a terminal, two lines a window elsewhere."""

from __future__ import annotations

import contextlib
import logging
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any, Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

Event = dict[str, Any]


class Show(Protocol):
    """Takes one event of the ranks."""

    def __call__(self, event: Event) -> None:
        """Show it."""


def speed(event: Event) -> float:
    """Element-steps per second since the window's dynamics began.

    Parameters
    ----------
    event : Event
        Of a window.

    Returns
    -------
    float
        1/s; 0 before any time has passed.
    """
    seconds = event["dynamics_seconds"]
    return float(event["elements"] * event["step"] / seconds) if seconds > 0 else 0.0


def line(event: Event) -> str:
    """Describe an event in one line.

    Parameters
    ----------
    event : Event
        Of a window.

    Returns
    -------
    str
        Without a line break.
    """
    share = event["step"] / event["steps"]
    left = event["dynamics_seconds"] * (1.0 / share - 1.0)
    return (
        f"window {event['window']}: step {event['step']} of {event['steps']} ({share:.0%}), "
        f"{speed(event):.3g} element-steps/s, {left:.0f} s left"
    )


class WholeRun:
    """How far a run is, counted in windows, and how long the rest will take.

    Parameters
    ----------
    windows : int
        Of the whole run.
    now : callable
        Seconds of a clock that only goes forward.
    """

    def __init__(self, windows: int, now: Callable[[], float] = time.monotonic) -> None:
        self.windows = windows
        self._now = now
        self._first: tuple[float, float] | None = None

    def done(self, event: Event) -> float:
        """Windows that are done, the share of the present one included.

        Parameters
        ----------
        event : Event
            Of a window.

        Returns
        -------
        float
            Windows, 0 to the number of windows.
        """
        return int(event["window"]) - 1 + float(event["step"] / event["steps"])

    def left(self, event: Event) -> float | None:
        """Seconds that the rest takes at the pace of this job; None at its first event.

        Parameters
        ----------
        event : Event
            Of a window.

        Returns
        -------
        float or None
            s of wall-clock time.
        """
        done, now = self.done(event), self._now()
        if self._first is None:
            self._first = done, now
        gone = done - self._first[0]
        return (now - self._first[1]) * (self.windows - done) / gone if gone > 0.0 else None

    def say(self, event: Event) -> str:
        """Window, share of the run, and time left.

        Parameters
        ----------
        event : Event
            Of a window.

        Returns
        -------
        str
            Without a line break; the time is left out at the first event.
        """
        left = self.left(event)
        rest = "" if left is None else f", {duration(left)} left"
        share = self.done(event) / self.windows
        return f"run: window {int(event['window'])} of {self.windows} ({share:.0%}){rest}"


def duration(seconds: float) -> str:
    """A time as people say it.

    Parameters
    ----------
    seconds : float
        Of a time.

    Returns
    -------
    str
        In s below 90 s, in min below 90 min, else in h and min.
    """
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"


@contextlib.contextmanager
def show_progress(windows: int) -> Iterator[Show]:
    """Show events while the context lasts; every event also goes to the log.

    A terminal that went away (its workflow was killed) does not stop the job.

    Parameters
    ----------
    windows : int
        Of the whole run, of which a job advances some.

    Yields
    ------
    callable
        Takes an event and shows it.
    """
    run = WholeRun(windows)
    with contextlib.ExitStack() as stack:
        if sys.stderr.isatty():
            bar = stack.enter_context(_bars())
            show: Show = _BarShow(bar, run)
        else:
            show = _Lines(run)

        def log_and_show(event: Event) -> None:
            logging.info("%s", line(event))
            with contextlib.suppress(OSError):
                show(event)

        yield log_and_show


class _Lines:
    """Two lines for each window: its first sample, which tells how fast it goes, and its end."""

    def __init__(self, run: WholeRun) -> None:
        self._begun: set[str] = set()
        self._run = run

    def __call__(self, event: Event) -> None:
        first = event["window"] not in self._begun
        self._begun.add(event["window"])
        said = self._run.say(event)
        if first or event["step"] >= event["steps"]:
            print(f"{line(event)}; {said}", file=sys.stderr, flush=True)


def _bars() -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[told]}"))
    return Progress(*columns, console=Console(stderr=True))


class _BarShow:
    """A bar for the whole run, and one for the present window."""

    def __init__(self, bar: Progress, run: WholeRun) -> None:
        self._bar, self._run = bar, run
        self._whole = bar.add_task("run", total=run.windows, told="")
        self._window = bar.add_task("window", total=1.0, told="")

    def __call__(self, event: Event) -> None:
        self._bar.update(
            self._whole, completed=self._run.done(event), told=self._run.say(event)[len("run: ") :]
        )
        self._bar.update(
            self._window,
            total=event["steps"],
            completed=event["step"],
            told=f"step {event['step']} of {event['steps']}, {speed(event):.3g} element-steps/s",
        )
