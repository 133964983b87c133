# SPDX-License-Identifier: GPL-2.0-or-later
"""Names and sentences use the field's words: private ones of earlier versions do not come back."""

from __future__ import annotations

import io
import re
import tokenize
from pathlib import Path

from support.listing import listed

# Modules of earlier versions, which said nothing of what they do.
MODULES = set(
    "sure tidy first whole frontdoor march cure grown light closing carry names numbers seal "
    "expense wording digests knobs crumbs".split()
)
# Words that no identifier has as a part.
PARTS = set("sure tidy frontdoor march cure seal expense wording knob knobs crumb crumbs".split())
# Sentences that only their author understood.
PHRASES = re.compile(
    r"\b(knobs?|crumbs?|front ?door|pays? for|where the program ends|radii of nothing|"
    r"among dwarfs|goes on from there|redo(es)? (the|no|nothing)|a difference of its own|"
    r"is no key of|expense)\b",
    re.I,
)
TEXTS = ("*.md", "*.py", "*.smk", "*.yaml", "*.j2", "*.js", "*.sh", "*.h", "*.cpp", "Makefile")


def other_files(project: Path, *patterns: str) -> list[Path]:
    """Files of the project, of this test none."""
    files = [project / name for name in listed(project, *patterns)]
    return [file for file in files if file.name != Path(__file__).name]


def private_identifiers(source: str) -> set[str]:
    """Identifiers of a module that have a private word as a part."""
    if not re.search("|".join(sorted(PARTS)), source, re.I):
        return set()  # most files, which need not be cut into tokens
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    names = {token.string for token in tokens if token.type == tokenize.NAME}
    return {name for name in names if PARTS & set(name.lower().split("_"))}


def test_modules_say_what_they_do(project: Path):
    assert [path for path in other_files(project, "*.py") if path.stem in MODULES] == []


def test_identifiers_use_the_fields_words(project: Path):
    found = {path: private_identifiers(path.read_text()) for path in other_files(project, "*.py")}
    assert {path: names for path, names in found.items() if names} == {}


def test_sentences_are_plain(project: Path):
    found = {}
    for path in other_files(project, *TEXTS):
        # Of what was renamed, the list of changes tells.
        if path.name != "CHANGELOG.md" and (match := PHRASES.search(path.read_text())):
            found[path.relative_to(project).as_posix()] = match[0]
    assert found == {}


def test_private_words_are_found():
    assert private_identifiers("def turn_knobs(a): return a") == {"turn_knobs"}
    assert private_identifiers("def change(setting): return setting  # knob") == set()
    assert PHRASES.search("A changed plot redoes the plot")
    assert not PHRASES.search("Changing a plot setting only redraws the report")
