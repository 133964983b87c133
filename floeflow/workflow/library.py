# SPDX-License-Identifier: GPL-2.0-or-later
"""Digests of the library's code, by stage: a stage runs again when what makes it changed."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

import floeflow

# Packages behind each stage, beside those that all share. Keys of the scene have hashes of their
# own, so a new key alone redoes nothing.
SHARED = ("core", "state")
PACKAGES: dict[str, tuple[str, ...]] = {
    "land": ("masks",),
    "mask": ("masks", "coupling"),
    "packing": ("packings",),
    "cells": ("packings",),
    "bonds": ("packings",),
    "initial": ("packings", "column", "coupling"),
    "windows": ("forcings", "column", "dynamics", "transfer", "coupling"),
    "fields": ("transfer", "diagnostics"),
    "diagnostics": ("diagnostics",),
    "trajectory": ("diagnostics",),
    "mesh": ("diagnostics",),
    "coast": ("packings",),
    "estimate": ("masks", "forcings", "analysis"),
    "report": ("diagnostics", "report"),
    "studies": ("analysis", "report"),
}


@functools.cache
def package_digest(package: str) -> str:
    """SHA-256 of the names and bytes of a package's modules and data."""
    folder = Path(floeflow.__file__).parent / package
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.suffix in (".py", ".json", ".j2", ".js", ".css"):
            digest.update(f"{path.relative_to(folder)}\n".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def library_digest(stage: str) -> str:
    """Digest (16 hexadecimal digits) of the code behind a stage."""
    parts = [package_digest(package) for package in (*SHARED, *PACKAGES[stage])]
    return hashlib.sha256(" ".join(parts).encode()).hexdigest()[:16]
