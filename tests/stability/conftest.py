# SPDX-License-Identifier: GPL-2.0-or-later
"""What the hard cases share: their marker, a log, and the record of what each one showed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent

Record = Callable[..., None]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--record", help="file that gets what the hard cases showed, as JSON")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_SHOWN] = []


_SHOWN: pytest.StashKey[list[dict[str, object]]] = pytest.StashKey()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if HERE in item.path.parents:
            item.add_marker("stability")


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item):  # noqa: ANN201
    outcome = yield
    report = outcome.get_result()
    if HERE not in item.path.parents or report.when != "call":
        return
    entry: dict[str, object] = {
        "module": item.path.stem.removeprefix("test_"),
        "test": item.name,
        "what": (
            item.function.__doc__ or item.originalname.replace("_", " ").removeprefix("test ")
        ),
        "outcome": "expected failure" if hasattr(report, "wasxfail") else report.outcome,
        "figures": dict(item.user_properties),
    }
    item.config.stash[_SHOWN].append(entry)


def pytest_sessionfinish(session: pytest.Session) -> None:
    path = session.config.getoption("--record", default=None)
    if path:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        shown = json.dumps(session.config.stash[_SHOWN], indent=1, default=float)
        Path(path).write_text(shown + "\n")


@pytest.fixture
def record(request: pytest.FixtureRequest) -> Record:
    """Keep figures for the table of hard cases."""

    def keep(**figures: object) -> None:
        request.node.user_properties.extend(figures.items())

    return keep


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return tmp_path / "liggghts.log"
