# SPDX-License-Identifier: GPL-2.0-or-later
"""``python -m floeflow.scene --write | --check | SCENE``: documents, their freshness, a scene."""

from __future__ import annotations

import argparse
import difflib
import sys
from pathlib import Path

from floeflow.core.errors import FloeError
from floeflow.scene.docs import PROJECT, documents
from floeflow.scene.load import load_scene


def main() -> int:
    """Write or check the generated documents, or validate a scene file."""
    parser = argparse.ArgumentParser(prog="python -m floeflow.scene", description=__doc__)
    task = parser.add_mutually_exclusive_group(required=True)
    task.add_argument("--write", action="store_true", help="write the generated documents")
    task.add_argument("--check", action="store_true", help="fail where one is out of date")
    task.add_argument("scene", nargs="?", type=Path, help="validate this scene file")
    arguments = parser.parse_args()
    if arguments.scene:
        try:
            scene = load_scene(arguments.scene)
        except FloeError as error:
            print(f"floeflow: {error}", file=sys.stderr)
            return 1
        print(f"{arguments.scene}: scene '{scene.name}' with {', '.join(scene.effects)}")
        return 0
    return _write() if arguments.write else _check()


def _write() -> int:
    for path, text in documents().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return 0


def _check() -> int:
    stale = 0
    for path, text in documents().items():
        now = path.read_text() if path.exists() else ""
        if now != text:
            stale = 1
            name = str(path.relative_to(PROJECT))
            change = difflib.unified_diff(
                now.splitlines(), text.splitlines(), name, f"{name} (generated)", n=0, lineterm=""
            )
            print("\n".join(change))
            print(f"{name} is out of date: run 'python -m floeflow.scene --write'")
    return stale


if __name__ == "__main__":
    sys.exit(main())
