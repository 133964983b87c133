# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that are written whole: after a fault the old one stays, and nothing beside it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from floeflow.core.atomic_write import spare_inputs, write_atomically, write_text
from floeflow.core.errors import FloeError


@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), ValueError("odd")])
def test_a_fault_leaves_the_old_file_alone(tmp_path: Path, fault: Exception) -> None:
    path = tmp_path / "deep" / "a.txt"
    write_text("old", path)
    told = isinstance(fault, OSError)
    words = r"a\.txt: cannot be written: No space" if told else "odd"
    with (
        pytest.raises(FloeError if told else ValueError, match=words),
        write_atomically(path) as new,
    ):
        new.write_text("half")
        raise fault
    assert path.read_text() == "old" and list(path.parent.iterdir()) == [path]


def test_others_may_read_what_the_mask_lets_them(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_text("ä", tmp_path / "a.txt")
    finally:
        os.umask(before)
    assert (tmp_path / "a.txt").stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "a.txt").read_bytes() == "ä".encode()


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FloeError, match=r"a\.txt: cannot be written: Not a directory|File exists"):
        write_text("", tmp_path / "file" / "a.txt")


def test_a_device_stays_what_it_is(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe.nc")
    for place in (tmp_path / "pipe.nc", tmp_path):
        with pytest.raises(
            FloeError, match="cannot be written: it is a folder, a pipe or a device"
        ):
            write_text("new", place)
    assert [path.name for path in tmp_path.iterdir()] == ["pipe.nc"]
    assert (tmp_path / "pipe.nc").is_fifo()
    with pytest.raises(FloeError, match="cannot be written: File name too long"):
        write_text("new", tmp_path / ("x" * 300))


def test_what_is_read_is_not_written_over(tmp_path: Path):
    there = tmp_path / "mask.nc"
    there.write_text("ice")
    (tmp_path / "same.nc").symlink_to(there)
    spare_inputs("--output", tmp_path / "new.nc", [there, tmp_path / "none.nc"])
    for place in (there, tmp_path / "same.nc"):
        with pytest.raises(FloeError, match=r"--output .*nc: this is a file that is read"):
            spare_inputs("--output", place, [there])
