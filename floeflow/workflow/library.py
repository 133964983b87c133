# SPDX-License-Identifier: GPL-2.0-or-later
"""Digests of the library's code, by stage: a stage runs again when what makes it changed."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

import floeflow
from floeflow.core.errors import FloeError
from floeflow.core.extensions import extension_digest
from floeflow.core.file_hash import file_hash

# Packages behind each stage, beside those that all share. Keys of the scene have hashes of their
# own, so a new key alone reruns nothing.
SHARED = ("core", "state")
PACKAGES: dict[str, tuple[str, ...]] = {
    "land": ("masks",),
    "mask": ("masks", "coupling"),
    "packing": ("packings",),
    "cells": ("packings",),
    "bonds": ("packings",),
    "initial": ("packings", "column", "coupling"),
    "windows": ("forcings", "column", "dynamics", "transfer", "coupling"),
    "fields": ("transfer", "diagnostics", "forcings"),
    "diagnostics": ("diagnostics", "forcings"),
    "trajectory": ("diagnostics",),
    "mesh": ("diagnostics",),
    "coast": ("packings",),
    "estimate": ("masks", "forcings", "analysis"),
    "report": ("diagnostics", "report"),
    "studies": ("analysis", "report"),
}


@functools.cache
def package_digest(package: str) -> str:
    """SHA-256 of the names and bytes of a package's modules and data.

    Parameters
    ----------
    package : str
        Name of a package, with dots.

    Returns
    -------
    str
        Hexadecimal, 64 digits.
    """
    folder = Path(floeflow.__file__).parent / package
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.suffix in (".py", ".json", ".j2", ".js", ".css"):
            digest.update(f"{path.relative_to(folder)}\n".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def library_digest(stage: str) -> str:
    """Digest (16 hexadecimal digits) of the code behind a stage.

    Parameters
    ----------
    stage : str
        Name of the stage.

    Returns
    -------
    str
        Hexadecimal, 16 digits; extensions that are installed change it.
    """
    parts = [package_digest(package) for package in (*SHARED, *PACKAGES[stage])]
    parts += [added] if (added := extension_digest()) else []
    return hashlib.sha256(" ".join(parts).encode()).hexdigest()[:16]


def made_with(plugin: Path) -> str:
    """Digests of the plugin and of the code that make windows, in one word.

    Parameters
    ----------
    plugin : Path
        Path of the plugin's library.

    Returns
    -------
    str
        Two times 16 hexadecimal digits, with a hyphen between.
    """
    return f"{file_hash(plugin)[:16]}-{library_digest('windows')}"


def check_made_with(plugin: Path, at_start: str) -> None:
    """Refuse to go on with another plugin or other code than the run began with.

    Parameters
    ----------
    plugin : Path
        Shared library.
    at_start : str
        Digest that the run began with; empty for none.

    Raises
    ------
    FloeError
        Says which of them has changed.
    """
    now = made_with(plugin)
    if at_start and now != at_start:
        same = now.partition("-")[0] == at_start.partition("-")[0]
        changed = "the code of floeflow" if same else str(plugin)
        raise FloeError(
            f"{changed} has changed since this run began, so its windows would be of two "
            "kinds; finished ones are kept: run the same command again"
        )
