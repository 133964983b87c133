# SPDX-License-Identifier: GPL-2.0-or-later
"""Files written whole or not at all: beside their place, then renamed into it."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from floeflow.core.errors import FloeError


@contextlib.contextmanager
def write_atomically(path: Path) -> Iterator[Path]:
    """Give the place of a temporary file that becomes a file when its content is there.

    A reader sees the old file or the new one, never a half; after a fault the old one stays.

    Parameters
    ----------
    path : Path
        The file; its folder is made.

    Yields
    ------
    Path
        Of an empty file in the same folder.

    Raises
    ------
    FloeError
        Where it cannot be written.
    """
    temporary = None
    try:
        # A name could be put over a device, and for an administrator it would be.
        if path.exists() and not path.is_file():
            raise FloeError(f"{path}: cannot be written: it is a folder, a pipe or a device")
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        temporary = Path(name)
        os.close(handle)
        yield temporary
        # mkstemp makes files that only their owner reads.
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        os.replace(temporary, path)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise FloeError(f"{path}: cannot be written: {reason}") from None
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                temporary.unlink()


def spare_inputs(option: str, path: Path, inputs: Iterable[Path]) -> None:
    """Refuse to write over a file that is read.

    Parameters
    ----------
    option : str
        That names the file to write.
    path : Path
        The file to write.
    inputs : iterable of Path
        Files that are read.

    Raises
    ------
    FloeError
        Names the option and the file.
    """
    if path.exists() and any(each.exists() and path.samefile(each) for each in inputs):
        raise FloeError(f"{option} {path}: this is a file that is read, and would be lost")


def write_text(text: str, path: Path) -> None:
    """Write a text file; see `write_atomically`.

    Parameters
    ----------
    text : str
        Written as UTF-8.
    path : Path
        Replaced in one step.

    Raises
    ------
    FloeError
        Where it cannot be written.
    """
    with write_atomically(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
