# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether a file can be read as a mesh at all, asked without what reads meshes."""

from __future__ import annotations

import stat
from pathlib import Path

from floeflow.core.errors import FloeError


def check_mesh_file(path: Path) -> None:
    """Refuse what would hang or fill the memory: no regular file, an STL shorter than it says.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    FloeError
        Names the file.
    """
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise FloeError(f"{path}: is not a file, so no mesh can be read from it")
        with path.open("rb") as file:
            head = file.read(84)
    except OSError as error:
        raise FloeError(f"{path}: the mesh cannot be read: {error.strerror}") from None
    if path.suffix.lower() == ".stl" and len(head) == 84 and not head.startswith(b"solid"):
        triangles = int.from_bytes(head[80:], "little")
        if status.st_size < 84 + 50 * triangles:
            raise FloeError(
                f"{path}: says that it holds {triangles} triangles, but ends before: it is damaged "
                "or not whole"
            )
