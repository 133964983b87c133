# SPDX-License-Identifier: GPL-2.0-or-later
"""Read a scene: safe YAML, no key twice, validated, each fault one sentence."""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from floeflow.core.errors import FloeError
from floeflow.scene.blocks import Scene
from floeflow.scene.checks import check_combinations
from floeflow.scene.effects import check_effects, known_effects

MAX_BYTES = 1_000_000
# Longer whole numbers are no setting, and Python may refuse to print them.
MAX_BITS = 64
# Faults of a number out of its range, which is told with the key's unit.
_BOUNDS = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")
# Aliases of aliases may stand for more values than any memory holds.
MOST_VALUES = 100_000
# Numbers of YAML 1.1 that are hardly meant: 0500 is 320, and 1:30 is 90.
OTHER_BASE = re.compile(r"[-+]?(?:0[0-9_]+$|[0-9_]+(:))")
KINDS = {"int": "whole number", "float": "number", "bool": "truth value", "timestamp": "date"}

# Picks the effects of a scene with ``effects: auto``: `floeflow.analysis.resolve` has one.
Chooser = Callable[[Scene], tuple[str, ...]]


class _SceneLoader(yaml.SafeLoader):
    """Safe YAML that refuses a key given twice and numbers that are not what they seem."""

    def get_single_node(self) -> yaml.Node | None:
        """Compose the document, whose aliases may not hold themselves or stand for too much."""
        node = super().get_single_node()
        if node is not None and _values(node, {}) > MOST_VALUES:
            raise FloeError(f"aliases stand for more than {MOST_VALUES} values")
        return node

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """Construct a mapping.

        Raises
        ------
        FloeError
            Where a key is given twice; names its line.
        """
        seen: set[str] = set()
        for key_node, _ in node.value:
            name = str(key_node.value)
            if name in seen:
                line = key_node.start_mark.line + 1
                raise FloeError(f"key '{name}' is given twice (line {line})")
            seen.add(name)
        return super().construct_mapping(node, deep)

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Construct a value; one that is not what its form or tag says is refused by its line."""
        try:
            value = super().construct_object(node, deep)
        except (ValueError, KeyError, AttributeError, TypeError, ArithmeticError) as error:
            kind = KINDS.get(node.tag.rpartition(":")[2], "value")
            why = f": {error}" if kind == "date" and "must be in" in str(error) else ""
            raise FloeError(_at(node, f"is not a {kind}{why}")) from None
        if isinstance(value, int) and value.bit_length() > MAX_BITS:
            raise FloeError(_at(node, "is a number of too many digits"))
        if type(value) in (int, float) and (mark := OTHER_BASE.match(str(node.value))):
            how = "base 60: write seconds" if mark[1] else "octal: leave the leading zero out"
            raise FloeError(_at(node, f"is {value:g} to YAML, as {how}"))
        if isinstance(value, str):
            try:
                value.encode()
            except UnicodeEncodeError:
                raise FloeError(_at(node, "holds half of a character")) from None
        return value


def _values(node: yaml.Node, known: dict[int, int]) -> int:
    """Number of values under a node, with those that aliases stand for.

    Raises
    ------
    FloeError
        Where an alias holds itself; names the line of its anchor.
    """
    if id(node) not in known:
        known[id(node)] = -1
        parts = node.value if isinstance(node, yaml.CollectionNode) else []
        flat = [part for pair in parts for part in (pair if isinstance(pair, tuple) else (pair,))]
        known[id(node)] = 1 + sum(_values(part, known) for part in flat)
    if known[id(node)] < 0:
        raise FloeError(f"line {node.start_mark.line + 1}: this value holds an alias of itself")
    return known[id(node)]


def _at(node: yaml.Node, fault: str) -> str:
    """Sentence for a value of a scene file that is no such thing."""
    text = ascii(str(node.value))
    shown = text if len(text) <= 42 else f"{text[:40]}...'"
    return f"line {node.start_mark.line + 1}: {shown} {fault}"


def load_scene(path: str | Path, choose: Chooser | None = None) -> Scene:
    """Read and validate a scene file.

    Parameters
    ----------
    path : str or Path
        YAML file of the scene.
    choose : callable, optional
        Picks the effects where the scene says ``effects: auto``.

    Returns
    -------
    Scene
        Frozen model with every key filled in; the effects are in the registry's order.

    Raises
    ------
    FloeError
        One sentence that names the file and the key.
    """
    path = Path(path)
    raw = _read(path)
    try:
        return parse_scene(raw, path.stem, choose)
    except FloeError as error:
        raise FloeError(f"{path}: {error}") from None


def _read(path: Path) -> bytes:
    try:
        # A pipe would wait for a writer for ever, a device never ends.
        if path.exists() and not path.is_file():
            kind = "a folder" if path.is_dir() else "a pipe or a device"
            raise FloeError(f"{path}: the scene cannot be read: it is no file, but {kind}")
        with path.open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FloeError(f"{path}: the scene cannot be read: {reason}") from None
    if len(raw) > MAX_BYTES:
        raise FloeError(f"{path}: a scene of over {MAX_BYTES} bytes is no scene")
    return raw


def read_resolved(path: str | Path) -> Scene:
    """Read a scene whose keys were all resolved before, as ``results/<scene>/scene.yaml`` is.

    Parameters
    ----------
    path : str or Path
        Of the resolved scene.

    Returns
    -------
    Scene
        With the values in the file, and no other default.

    Raises
    ------
    FloeError
        Where the file cannot be read or does not hold a scene.
    """
    path = Path(path)
    keys = read_keys(path)
    try:
        keys.setdefault("name", path.stem)
        return Scene.model_validate(keys)
    except ValidationError as error:
        raise FloeError(f"{path}: {_validation_sentence(error)}") from None


def read_keys(path: str | Path) -> dict[str, Any]:
    """Read the keys that a scene file sets, before any default or check of their values.

    Parameters
    ----------
    path : str or Path
        Of the scene file.

    Returns
    -------
    dict
        By block and key, as YAML gives them.

    Raises
    ------
    FloeError
        Where the file cannot be read or is no mapping; see `load_scene`.
    """
    raw = _read(Path(path))
    try:
        return _keys_of(raw)
    except FloeError as error:
        raise FloeError(f"{path}: {error}") from None


def parse_scene(raw: bytes, default_name: str, choose: Chooser | None = None) -> Scene:
    """Validate the bytes of a scene file; see `load_scene`.

    Parameters
    ----------
    raw : bytes
        UTF-8 YAML.
    default_name : str
        Name of a scene that gives none.
    choose : Chooser, optional
        What ``effects: auto`` stands for.

    Returns
    -------
    Scene
        Validated.

    Raises
    ------
    FloeError
        For a key that is misspelt, given twice or out of range.
    """
    data = _keys_of(raw)
    data.setdefault("name", default_name)
    return build_scene(data, choose)


def _keys_of(raw: bytes) -> dict[str, Any]:
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        raise FloeError(f"byte {error.start + 1} is not UTF-8 text") from None
    try:
        # The loader derives from SafeLoader: no tag can construct a Python object.
        data = yaml.load(text, Loader=_SceneLoader)  # noqa: S506
    except yaml.YAMLError as error:
        raise FloeError(_yaml_sentence(error)) from None
    except RecursionError:
        raise FloeError("the YAML is nested too deeply") from None
    if data is None:
        data = {}
    if not isinstance(data, dict):
        raise FloeError("a scene is a mapping of keys to values")
    return data


def build_scene(keys: Mapping[str, Any], choose: Chooser | None = None) -> Scene:
    """Validate keys that were read from a scene file or derived from one.

    Parameters
    ----------
    keys : mapping of object
        By block.
    choose : Chooser, optional
        What ``effects: auto`` stands for.

    Returns
    -------
    Scene
        Complete, its effects in the registry's order.

    Raises
    ------
    FloeError
        One sentence that names the key.
    """
    data = dict(keys)
    auto = data.get("effects") == "auto"
    if auto:
        del data["effects"]
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        raise FloeError(_validation_sentence(error)) from None
    known_effects()  # those of extensions too, before any is looked up
    if auto:
        if choose is None:
            raise FloeError(
                "effects: 'auto' is resolved from mask and forcing when a run starts; here, name "
                "the effects"
            )
        scene = scene.model_copy(update={"effects": choose(scene)})
        scene._auto = True
    scene = scene.model_copy(update={"effects": check_effects(scene.effects)})
    check_combinations(scene)
    return scene


def _yaml_sentence(error: yaml.YAMLError) -> str:
    mark = getattr(error, "problem_mark", None)
    where = f"line {mark.line + 1}: " if mark is not None else ""
    problem = getattr(error, "problem", None) or "this is not YAML"
    return f"{where}{problem}"


def _validation_sentence(error: ValidationError) -> str:
    faults = error.errors(include_url=False)
    # An unknown key comes first: it is the likely cause of other faults.
    faults.sort(key=lambda fault: fault["type"] != "extra_forbidden")
    more = f" (and {len(faults) - 1} more faults)" if len(faults) > 1 else ""
    return _fault_sentence(faults[0]) + more


def _fault_sentence(fault: ErrorDetails) -> str:
    location = [str(part) for part in fault["loc"]]
    place = ".".join(location)
    if fault["type"] == "extra_forbidden":
        known = _known_keys(location[:-1])
        near = get_close_matches(location[-1], known, n=1, cutoff=0.5)
        above = "".join(f"{part}." for part in location[:-1])
        hint = f"did you mean '{above}{near[0]}'?" if near else "known are " + ", ".join(known)
        return f"unknown key '{place}'; {hint}"
    if fault["loc"] == ("name",):
        return (
            f"name: {fault['input']!r} is not a plain name (lower-case letters, digits, '_' and "
            "'-', at most 64, no path)"
        )
    message = fault["msg"][0].lower() + fault["msg"][1:]
    value = fault["input"]
    got = "" if isinstance(value, dict | list) else f" (got {value!r:.60})"
    unit = _unit(location) if fault["type"] in _BOUNDS else ""
    return f"{place}: {message}{unit}{got}"


def _unit(location: list[str]) -> str:
    """Unit of a key as it stands behind a number; empty where it has none."""
    model: type[BaseModel] = Scene
    for part in location[:-1]:
        annotation = model.model_fields[part].annotation if part in model.model_fields else None
        if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
            return ""
        model = annotation
    info = model.model_fields.get(location[-1])
    extra = info.json_schema_extra if info else None
    unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
    return f" {unit}" if unit not in ("", "1") else ""


def _known_keys(location: list[str]) -> list[str]:
    model: type[BaseModel] = Scene
    for part in location:
        annotation = model.model_fields[part].annotation
        assert isinstance(annotation, type) and issubclass(annotation, BaseModel)
        model = annotation
    return list(model.model_fields)
