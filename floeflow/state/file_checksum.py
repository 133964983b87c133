# SPDX-License-Identifier: GPL-2.0-or-later
"""Checksum of a file: the SHA-256 of its bytes, as a line behind them.

HDF5 trusts what it opens: about one in a hundred flipped bits in a state's first 8 kB makes it loop
for ever. So a file's bytes are verified before HDF5 sees them. HDF5 itself ignores what stands
behind its own end of the file: other readers open such a file as any NetCDF-4 file.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from floeflow.core.errors import FloeError

_HEAD = b"\nFloeFlow SHA-256 "
_LENGTH = len(_HEAD) + 2 * hashlib.sha256().digest_size + 1
_CHUNK = 1 << 20


def _line(path: Path, size: int) -> bytes:
    """Line with the checksum of the first bytes of a file."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while size > 0 and (chunk := file.read(min(size, _CHUNK))):
            digest.update(chunk)
            size -= len(chunk)
    return _HEAD + digest.hexdigest().encode() + b"\n"


def append_file_checksum(path: Path) -> None:
    """Put the checksum behind the bytes of a file that has none.

    Parameters
    ----------
    path : Path
        Of a file, which is changed.

    Raises
    ------
    OSError
        Where it cannot be written.
    """
    line = _line(path, path.stat().st_size)
    with path.open("ab") as file:
        file.write(line)


def check_file_checksum(path: Path) -> None:
    """Verify that a file's bytes are those of its checksum.

    Parameters
    ----------
    path : Path
        Of the file.

    Raises
    ------
    FloeError
        Where the file has no checksum at its end, or its bytes have changed.
    OSError
        Where it cannot be read.
    """
    body = path.stat().st_size - _LENGTH
    found = b""
    if body >= 0:
        with path.open("rb") as file:
            file.seek(body)
            found = file.read()
    if not (found.startswith(_HEAD) and found.endswith(b"\n")):
        raise FloeError(f"{path}: has no checksum at its end: it is cut off or not FloeFlow's")
    if found != _line(path, body):
        raise FloeError(f"{path}: its checksum does not match, the file is damaged or was changed")
