# SPDX-License-Identifier: GPL-2.0-or-later
"""Modules from outside that add effects, readers, diagnostics, figures or column schemes.

A package names its module as an entry point of the group ``floeflow.extensions``; importing the
module registers what it adds. A registry loads them before it is first read. Their bytes are in
the digests of every stage: a changed extension runs jobs again, as changed code of FloeFlow does.
"""

from __future__ import annotations

import functools
import hashlib
import importlib
import importlib.util
from importlib.metadata import entry_points
from pathlib import Path

from floeflow.core.errors import FloeError

GROUP = "floeflow.extensions"


@functools.cache
def modules() -> tuple[str, ...]:
    """Names of the modules that installed packages offer, sorted."""
    return tuple(sorted({entry.value for entry in entry_points(group=GROUP)}))


@functools.cache
def load_extensions() -> None:
    """Import all extensions, once in a process.

    Raises
    ------
    FloeError
        Where one cannot be imported.
    """
    for name in modules():
        try:
            importlib.import_module(name)
        except Exception as error:
            raise FloeError(
                f"the extension {name} cannot be imported: {type(error).__name__}: {error}"
            ) from None


@functools.cache
def extension_digest() -> str:
    """SHA-256 of the names and bytes of the extensions' modules; empty where there are none."""
    digest = hashlib.sha256()
    for name in modules():
        found = importlib.util.find_spec(name)
        digest.update(name.encode())
        if found is not None and found.origin:
            digest.update(Path(found.origin).read_bytes())
    return digest.hexdigest() if modules() else ""
