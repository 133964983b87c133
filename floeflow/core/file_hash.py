# SPDX-License-Identifier: GPL-2.0-or-later
"""What a file holds, in one word."""

from __future__ import annotations

import hashlib
from pathlib import Path

from floeflow.core.errors import FloeError


def file_hash(path: str | Path) -> str:
    """SHA-256 of a file's bytes.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    str
        64 hexadecimal digits.

    Raises
    ------
    FloeError
        Where it cannot be read.
    """
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            while block := file.read(1 << 20):
                digest.update(block)
    except OSError as error:
        raise FloeError(f"{path}: cannot be read: {error.strerror}") from None
    return digest.hexdigest()
