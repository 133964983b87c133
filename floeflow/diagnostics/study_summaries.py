# SPDX-License-Identifier: GPL-2.0-or-later
"""Digests of finished studies, for the report of a scene.

A report never asks for a study: it shows those that are there and hold for the scene as it is.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

DIGEST = "digest.json"


def valid_summaries(folder: Path, keys: str) -> dict[str, str]:
    """Digests that hold for a scene, with their SHA-256.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``, with its studies; the hard cases beside it hold for any scene.
    keys : str
        Hash of the scene keys that a study reads.

    Returns
    -------
    dict of str
        SHA-256 in hexadecimal by path.
    """
    found = {}
    wanted = dict.fromkeys(sorted(folder.glob(f"*/{DIGEST}")), keys)
    for path, key in {**wanted, folder.parent / "stability" / DIGEST: ""}.items():
        if path.is_file() and read_summary(path).get("keys") == key:
            found[str(path)] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def read_summary(path: Path) -> dict[str, Any]:
    """Read a digest; an empty one where the file is damaged.

    Parameters
    ----------
    path : Path
        Of the digest.

    Returns
    -------
    dict
        As the file has it.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        return {}
    return data if isinstance(data, dict) else {}
