# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 10: damaged, foreign and unwritable files, and hostile names.

What must hold: one clear sentence that names the file, the input kept as it was, nothing written
outside of the results.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import netCDF4
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from floeflow.core.errors import FloeError
from floeflow.scene import load_scene
from floeflow.state import SCHEMA_VERSION, read_state, write_state
from floeflow.state.file_checksum import append_file_checksum
from unit.state.test_state import a_state

PAGE = 4096


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("files") / "s.nc"
    write_state(a_state(n=400), path)
    return path.read_bytes()


def refusal(path: Path) -> str:
    """The sentence with which a state is refused; the file is as it was."""
    before = path.read_bytes()
    with pytest.raises(FloeError) as caught:
        read_state(path)
    assert path.read_bytes() == before
    said = str(caught.value)
    assert str(path) in said and "\n" not in said
    return said


def test_a_state_cut_at_every_page_is_refused(written: bytes, tmp_path: Path, record):
    cuts = range(0, len(written), PAGE)
    assert len(cuts) > 20
    for cut in cuts:
        path = tmp_path / f"{cut}.nc"
        path.write_bytes(written[:cut])
        refusal(path)
    record(places=len(cuts), refused=len(cuts))


# HDF5 loops for ever on some of these, were it to open them: its tables lie in the first 8 kB.
@given(where=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7), early=st.booleans())
def test_a_flipped_bit_is_refused(written: bytes, tmp_path_factory, where, bit, early):
    path = tmp_path_factory.mktemp("flip") / "s.nc"
    raw = bytearray(written)
    raw[int(where * (8192 if early else len(raw)))] ^= 1 << bit
    path.write_bytes(raw)
    assert "checksum" in refusal(path)


def run_python(
    code: str, *arguments: object, before: Sequence[str] = ()
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*before, sys.executable, "-c", code, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(
    ("target", "runs"),
    [("bytes", 500), ("fields", 40), pytest.param("fields", 150, marks=pytest.mark.slow)],
)
def test_a_guided_fuzzer_breaks_no_reader(target: str, runs: int, tmp_path: Path, record):
    """Inputs that atheris tries, guided by the code they reach; `make fuzz` goes on for longer."""
    pytest.importorskip("atheris", reason="atheris has no wheel for this Python or platform")
    program = Path(__file__).with_name("fuzz_state.py")
    options = (f"-runs={runs}", "-seed=1", "-timeout=60")
    done = subprocess.run(
        [sys.executable, program, target, tmp_path, *options],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    reached = [int(n) for n in re.findall(r"cov: (\d+)", done.stderr)]
    # All seeds are run, be they more than asked for.
    ran = int(re.findall(r"^Done (\d+) runs", done.stderr, re.M)[0])
    assert ran >= runs
    assert reached[-1] > 50, "the reader is not instrumented"
    record(runs=ran, lines_reached=reached[-1])


_SMALL_DISK = """
import resource
import signal
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from unit.state.test_state import a_state
from floeflow.core.errors import FloeError
from floeflow.state import write_state
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]), resource.RLIM_INFINITY))
try:
    write_state(a_state(n=4000), Path(sys.argv[2]))
except FloeError as error:
    print("refused:", error)
"""


@pytest.mark.parametrize("room", [0, 10_000, 300_000])
def test_a_disk_that_fills_up_leaves_the_older_state(tmp_path: Path, room: int):
    # A limit on the size of files fails a write in its midst as a full disk does.
    path = tmp_path / "s.nc"
    write_state(a_state(), path)
    before = path.read_bytes()
    tests = Path(__file__).parents[1]
    done = run_python(_SMALL_DISK, tests, path, room)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"refused: {path}: cannot be written"), done.stdout
    assert path.read_bytes() == before
    assert [item.name for item in tmp_path.iterdir()] == ["s.nc"]


def test_read_only_results_are_named(tmp_path: Path):
    path = tmp_path / "results" / "s.nc"
    write_state(a_state(), path)
    before = path.read_bytes()
    path.parent.chmod(0o555)
    tests = Path(__file__).parents[1]
    # Root may write everywhere, unless it gives that right up.
    humble = ["setpriv", "--bounding-set=-dac_override"] if os.geteuid() == 0 else []
    if humble and shutil.which(humble[0]) is None:
        pytest.skip("root may write everywhere, and setpriv (util-linux) is not there")
    try:
        done = run_python(_SMALL_DISK, tests, path, 10**9, before=humble)
    finally:
        path.parent.chmod(0o755)
    assert done.stdout.startswith(f"refused: {path}: cannot be written: Permission"), done.stderr
    assert path.read_bytes() == before


def test_a_file_where_the_results_should_lie_is_named(tmp_path: Path):
    (tmp_path / "results").write_text("a file")
    with pytest.raises(FloeError, match="s.nc: cannot be written: (File exists|Not a dir)"):
        write_state(a_state(), tmp_path / "results" / "s.nc")
    assert (tmp_path / "results").read_text() == "a file"


def test_a_state_of_a_newer_version_is_named(tmp_path: Path):
    path = tmp_path / "s.nc"
    write_state(a_state(), path)
    with netCDF4.Dataset(path, "a") as file:
        file.schema_version = SCHEMA_VERSION + 1
    assert "checksum" in refusal(path)
    append_file_checksum(path)  # as a newer program would write it
    said = refusal(path)
    assert f"version is {SCHEMA_VERSION + 1}" in said and f"versions 1 to {SCHEMA_VERSION}" in said


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-32", "latin-1"])
def test_a_scene_in_another_encoding_is_named(tmp_path: Path, encoding: str):
    path = tmp_path / "scene.yaml"
    path.write_bytes("report: {title: Ä}\n".encode(encoding))
    with pytest.raises(FloeError, match=r"scene\.yaml: .*(UTF-8|special characters)"):
        load_scene(path)


HOSTILE = [
    "my scene",
    "../up",
    "/etc/x",
    "a/b",
    "x;touch y",
    "$(touch y)",
    "`touch y`",
    "a\nb",
    "-rf",
    ".hidden",
    "",
    "x" * 65,
    "ä",
    "{window}",
    "x\x00y",
]


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_scene_name_is_refused(tmp_path: Path, name: str):
    path = tmp_path / "scene.yaml"
    path.write_text(yaml.safe_dump({"name": name}))
    with pytest.raises(FloeError, match="name: .* is not a plain name"):
        load_scene(path)
    assert list(tmp_path.iterdir()) == [path]


def test_a_hostile_file_name_gives_its_scene_no_name(tmp_path: Path):
    path = tmp_path / "my scene; touch y.yaml"
    path.write_text("seed: 1\n")
    with pytest.raises(FloeError, match="is not a plain name"):
        load_scene(path)
