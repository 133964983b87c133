# SPDX-License-Identifier: GPL-2.0-or-later
"""Coverage-guided fuzzing of the reader of states (atheris, on libFuzzer).

    python tests/stability/fuzz_state.py bytes|fields FOLDER [options of libFuzzer]

`bytes`: whatever a file holds, it is read as it was written or refused in one line that names it.
`fields`: a state whose names, types, shapes, values and attributes the fuzzer has changed, with a
checksum as if FloeFlow had written it, is refused in one line, or is a state that can be written
again.
FOLDER gets the inputs that reached new code (`corpus-...`) and those that broke something.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import atheris
import numpy as np
import xarray as xr

with atheris.instrument_imports(include=["floeflow.state", "floeflow.scene.effects"]):
    from floeflow.core.errors import FloeError
    from floeflow.state import check_state, read_state, write_state
    from floeflow.state.file_checksum import append_file_checksum

sys.path.insert(0, str(Path(__file__).parents[1]))
from unit.state.test_state import a_state  # noqa: E402

EFFECTS = (
    ("wind",),
    ("wind", "bonds", "thermodynamics", "snow"),
    ("wind", "bonds", "friction", "ridging", "thermodynamics", "snow"),
)
DTYPES = ("float64", "float32", "int64", "int32", "int8", "uint8", "S3", "<U4")
SPECIAL = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e300, 1e-300, 2.0**63)


def refused(path: Path, read: Callable[[Path], xr.Dataset]) -> xr.Dataset | None:
    """The state that is read, or nothing where it is refused in one line that names the file.

    Raises
    ------
    AssertionError
        Where it is refused in any other way.
    """
    try:
        return read(path)
    except FloeError as error:
        said = str(error)
        assert str(path) in said, f"the file is not named: {said}"
        assert "\n" not in said, f"more than one line: {said}"
        return None


def fuzz_bytes(path: Path, data: bytes, original: xr.Dataset) -> None:
    """Read a file of these bytes; only an undamaged state may come through."""
    path.write_bytes(data)
    state = refused(path, read_state)
    assert state is None or state.equals(original), "a damaged state was read"


def fuzz_fields(path: Path, data: bytes) -> None:
    """Read a file with a checksum of a state that these bytes have changed."""
    source = atheris.FuzzedDataProvider(data)
    state = base(source.PickValueInList(list(EFFECTS)), source.ConsumeIntInRange(1, 3))
    path.unlink(missing_ok=True)
    try:
        for _ in range(source.ConsumeIntInRange(0, 4)):
            state = changed(state, source)
        state.to_netcdf(path, engine="netcdf4", format="NETCDF4")
    except Exception:  # what Xarray or NetCDF cannot hold, no file brings
        return
    append_file_checksum(path)
    found = refused(path, read_state)
    if found is not None:
        check_state(found)
        write_state(found, path)
        assert read_state(path).equals(found), "a state changes when it is written and read"


@cache
def base(effects: tuple[str, ...], n: int) -> xr.Dataset:
    """State that is changed: never itself, always a copy."""
    return a_state(effects, n)


def changed(state: xr.Dataset, source: atheris.FuzzedDataProvider) -> xr.Dataset:
    """The state with one thing of it changed."""
    name = source.PickValueInList(sorted(map(str, state.variables)))
    attr = source.PickValueInList(sorted(state.attrs) or ["scene"])
    values, dims = state[name].values, state[name].dims
    kind = source.ConsumeIntInRange(0, 9)
    state = state.copy(deep=True)
    if kind == 0:
        return state.drop_vars(name)
    if kind == 1:
        other = source.ConsumeUnicodeNoSurrogates(12)
        return state.drop_vars(name).assign({other: (dims, values)})
    if kind == 2:
        with np.errstate(all="ignore"):
            return state.assign({name: (dims, values.astype(source.PickValueInList(list(DTYPES))))})
    if kind == 3:
        return state.assign({name: ((*dims, "more"), values[..., None])})
    if kind == 4:
        return state.assign({name: ((), source.ConsumeFloat())})
    if kind == 5 and values.size:
        value = (
            source.PickValueInList(list(SPECIAL)) if source.ConsumeBool() else source.ConsumeFloat()
        )
        with np.errstate(all="ignore"):
            values = values.copy()
            values.flat[source.ConsumeIntInRange(0, values.size - 1)] = np.array(value).astype(
                values.dtype
            )
        return state.assign({name: (dims, values)})
    if kind == 6:
        dim = source.PickValueInList(sorted(map(str, state.sizes)))
        return state.isel({dim: slice(0, source.ConsumeIntInRange(0, 2))})
    if kind == 7:
        state.attrs.pop(attr, None)
    elif kind == 8:
        state.attrs[attr] = source.ConsumeUnicodeNoSurrogates(20)
    else:
        state.attrs[attr] = source.PickValueInList(
            [source.ConsumeInt(8), source.ConsumeFloat(), np.zeros(2), np.nan, "{}", "[" * 200]
        )
    return state


def main() -> None:
    """Fuzz one target; see above."""
    target, folder, *options = sys.argv[1:]
    corpus = Path(folder) / f"corpus-{target}"
    corpus.mkdir(parents=True, exist_ok=True)
    place = Path(folder) / f"{target}.nc"
    original = a_state(("wind",), n=2)
    if target == "bytes":
        write_state(original, place)
        whole = place.read_bytes()
        original = read_state(place)
        for name, seed in (("whole", whole), ("cut", whole[:3000]), ("unsigned", whole[:-90])):
            (corpus / name).write_bytes(seed)
        options.append(f"-max_len={len(whole) + 200}")
    else:
        for k, seed in enumerate(np.random.default_rng(0).integers(0, 256, (60, 64), np.uint8)):
            (corpus / f"random-{k}").write_bytes(seed.tobytes())
        options.append("-len_control=0")
    run = {"bytes": lambda data: fuzz_bytes(place, data, original)}.get(
        target, lambda data: fuzz_fields(place, data)
    )
    artefacts = f"-artifact_prefix={folder}/"
    atheris.Setup([sys.argv[0], str(corpus), artefacts, *options], run)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
