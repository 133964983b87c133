# SPDX-License-Identifier: GPL-2.0-or-later
"""Documents that are generated from code: of the scene's keys, and of the effects."""

from __future__ import annotations

import difflib
from pathlib import Path

from floeflow.analysis.estimate.dimensionless_numbers import meaning
from floeflow.core.errors import FloeError
from floeflow.scene import docs
from floeflow.scene.docs import PROJECT
from floeflow.scene.effects import EFFECTS

_EFFECTS_HEAD = """# Effects

A scene names its effects; what it does not name is absent: no rule in the workflow, no switch in
the plugin, no variable in the state, no figure in the report.

<!-- slow -->
```console
$ .venv/bin/floeflow effects config/scenes/mine.yaml
```

This estimates from the scene alone how far each effect would move the results and what share of the
run time it would cost, and recommends effects. `effects: auto` in a scene takes the recommendation.
Every run writes the estimates to `results/<scene>/effects.json` and into its report.
[How the estimates are made](estimates.md).

This page is generated from `floeflow/scene/effects.py` and
`floeflow/analysis/estimate/dimensionless_numbers.py` by
`.venv/bin/floeflow docs --write`.

| effect | what it is | needs | when it matters: number near 1 or above |
|---|---|---|---|
"""


def effects_page() -> str:
    """Text of ``docs/effects.md``."""
    lines = []
    for e in EFFECTS.values():
        needs = ", ".join(f"`{need}`" for need in e.needs)
        matters = meaning(e.name).replace("|", "\\|")
        lines.append(f"| `{e.name}` | {e.physics} ({e.source}) | {needs} | {matters} |")
    lines += ["", "What each adds, and what a scene without it does not have:", ""]
    lines += ["| effect | " + " | ".join(_ADDED) + " |", "|---" * (len(_ADDED) + 1) + "|"]
    for e in EFFECTS.values():
        cells = [", ".join(_short(getattr(e, field))) for field in _ADDED.values()]
        lines.append(f"| `{e.name}` | " + " | ".join(cells) + " |")
    return _EFFECTS_HEAD + "\n".join(lines) + "\n"


_ADDED = {
    "rules": "rules",
    "plugin switches": "plugin",
    "column processes": "column",
    "forcing": "forcing",
    "state": "state",
    "gridded output": "output",
    "series": "diagnostics",
    "figures": "figures",
}


def _short(names: tuple[str, ...]) -> list[str]:
    most = 9
    shown = [f"`{name}`" for name in names[:most]]
    return [*shown, f"{len(names) - most} more"] if len(names) > most else shown


def documents() -> dict[Path, str]:
    """Every generated file with its text."""
    return docs.documents() | {PROJECT / "docs/effects.md": effects_page()}


def write_documents() -> str:
    """Write the generated files; what was done."""
    for path, text in documents().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return f"{len(documents())} documents written"


def check_documents() -> str:
    """Compare the generated files with what is there.

    Raises
    ------
    FloeError
        Where one is out of date, with the difference.
    """
    for path, text in documents().items():
        now = path.read_text() if path.exists() else ""
        if now != text:
            name = str(path.relative_to(PROJECT))
            change = difflib.unified_diff(
                now.splitlines(), text.splitlines(), name, f"{name} (generated)", n=0, lineterm=""
            )
            raise FloeError(
                f"{name} is out of date ('floeflow docs --write' writes it):\n" + "\n".join(change)
            )
    return "the generated documents are up to date"
