# SPDX-License-Identifier: GPL-2.0-or-later
"""What is generated from the models: ``config/README.md``, ``default.yaml``, the JSON schema."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import yaml
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from floeflow.analysis.estimate.dimensionless_numbers import meaning
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import EFFECTS

PROJECT = Path(__file__).resolve().parents[2]

_README_HEAD = """# Scenes

A scene is one YAML file. It holds only what differs from the defaults below:

```yaml
{example}```

Run it with `make run SCENE=config/scenes/mine.yaml`, or with Snakemake itself:
`snakemake --profile workflows/profiles/local --config scene=config/scenes/mine.yaml`.

File paths are taken from the project's folder. A key that is unknown, given twice or out of its
range stops the run before any job, with a sentence that names it.

This page, `default.yaml` and `workflows/schemas/scene.schema.json` are generated from the models in
`floeflow/scene/blocks.py` by `python -m floeflow.scene --write`.
"""

_EXAMPLE = """name: mine
effects: [wind, ocean_drag, coriolis]
packing:
  elements: 1000
time:
  windows: 2
"""


@dataclass(frozen=True)
class Key:
    """One key of a scene, as the documents show it."""

    path: str
    kind: str
    default: Any
    unit: str
    allowed: str
    text: str


def keys(model: type[BaseModel] = Scene, prefix: str = "") -> Iterator[Key]:
    """Yield every key of the models, block by block."""
    for name, info in model.model_fields.items():
        inner = info.annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel):
            yield from keys(inner, f"{prefix}{name}.")
            continue
        extra = info.json_schema_extra
        unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
        default = None if info.is_required() else info.default
        yield Key(
            f"{prefix}{name}", _kind(info), default, unit, _allowed(info), info.description or ""
        )


def _kind(info: FieldInfo) -> str:
    if get_origin(info.annotation) is Literal:
        return "choice"
    if get_origin(info.annotation) is tuple:
        return "list of names"
    return getattr(info.annotation, "__name__", "text").replace("str", "text")


def _allowed(info: FieldInfo) -> str:
    if get_origin(info.annotation) is Literal:
        return ", ".join(f"`{choice}`" for choice in get_args(info.annotation))
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    bounds = []
    for constraint in info.metadata:
        for attribute, sign in signs.items():
            bound = getattr(constraint, attribute, None)
            if bound is not None:
                bounds.append(f"{sign} {bound}")
    return ", ".join(bounds)


def _plain(default: Any) -> Any:
    if isinstance(default, tuple):
        return list(default)
    return default.isoformat() if hasattr(default, "isoformat") else default


def _yaml_value(default: Any) -> str:
    text = yaml.safe_dump(_plain(default), default_flow_style=True, width=10_000).strip()
    return text.removesuffix("\n...").removesuffix("...").strip()


def readme() -> str:
    """Text of ``config/README.md``."""
    lines = [_README_HEAD.format(example=_EXAMPLE)]
    lines += ["Effects: see [docs/effects.md](../docs/effects.md)."]
    block = None
    for key in keys():
        head = key.path.rpartition(".")[0]
        if head != block:
            block = head
            title = f"`{head}`" if head else "Top level"
            lines += ["", f"## {title}", "", "| key | default | unit | allowed | meaning |"]
            lines += ["|---|---|---|---|---|"]
        default = "required" if key.default is None else f"`{_yaml_value(key.default)}`"
        name = key.path.rpartition(".")[2]
        lines.append(f"| `{name}` | {default} | {key.unit} | {key.allowed} | {key.text} |")
    return "\n".join(lines) + "\n"


_EFFECTS_HEAD = """# Effects

A scene names its effects; what it does not name is absent: no rule in the workflow, no switch in
the plugin, no variable in the state, no figure in the report.

    python -m floeflow.scene.effects config/scenes/mine.yaml

estimates from the scene alone how far each effect would move the results and what share of the run
time it would cost, and recommends. `effects: auto` in a scene takes the recommendation. Every run
writes the estimates to `results/<scene>/effects.json` and into its report.
[How the estimates are made](estimates.md).

This page is generated from `floeflow/scene/effects.py` and
`floeflow/analysis/estimate/dimensionless_numbers.py` by
`python -m floeflow.scene --write`.

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


def default_yaml() -> str:
    """Text of ``config/default.yaml``: every key with its default and its line of help."""
    lines = [
        "# SPDX-License-Identifier: GPL-2.0-or-later",
        "# Every key of a scene with its default. For reading: generated by",
        "# `python -m floeflow.scene --write`; a scene file overrides what it names.",
    ]
    blocks: list[str] = []
    for key in keys():
        parents = key.path.split(".")[:-1]
        for depth, parent in enumerate(parents):
            if blocks[: depth + 1] != parents[: depth + 1]:
                if depth == 0:
                    lines.append("")
                lines.append(f"{'  ' * depth}{parent}:")
                blocks = parents[: depth + 1]
        blocks = parents
        pad = "  " * len(parents)
        notes = " ".join(
            part for part in (f"[{key.unit}]" if key.unit else "", key.allowed) if part
        )
        lines.append(f"{pad}# {key.text}" + (f" {notes}" if notes else ""))
        name = key.path.rpartition(".")[2]
        value = "my_scene" if key.default is None else _yaml_value(key.default)
        lines.append(f"{pad}{name}: {value}")
    return "\n".join(lines) + "\n"


def json_schema() -> str:
    """Text of ``workflows/schemas/scene.schema.json``, for editors."""
    return json.dumps(Scene.model_json_schema(), indent=1) + "\n"


def documents() -> dict[Path, str]:
    """Every generated file with its text."""
    return {
        PROJECT / "config/README.md": readme(),
        PROJECT / "docs/effects.md": effects_page(),
        PROJECT / "config/default.yaml": default_yaml(),
        PROJECT / "workflows/schemas/scene.schema.json": json_schema(),
    }
