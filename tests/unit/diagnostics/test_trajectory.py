# SPDX-License-Identifier: GPL-2.0-or-later
"""Trajectories: what MDAnalysis reads back is what the states say."""

import re
import warnings
from types import SimpleNamespace

import numpy as np
import pyproj
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.diagnostics.trajectory import (
    drift_statistics,
    make_frames,
    make_universe,
    write_dump,
    write_xtc,
)
from floeflow.state import read_dataset, read_state, write_dataset, write_state
from support.scripts import load_script
from support.synthetic import make_run, masses

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import MDAnalysis

# Of a coordinate below 2^21 m, and once more where the corner is taken off.
SINGLE = 0.0625 + 0.0625


@pytest.fixture(scope="module")
def frames(states):
    return make_frames(states)


@pytest.fixture(scope="module")
def dump(run, frames, tmp_path_factory):
    path = tmp_path_factory.mktemp("dump") / "new" / "elements.lammpsdump"
    write_dump(frames, run.scene.domain, path)
    return path


def corner(run):
    return run.scene.domain.x_min, run.scene.domain.y_min


def test_frames_are_the_states(frames, states):
    assert frames.sizes["time"] == len(states) == 4
    for index, state in enumerate(states):
        frame = frames.isel(time=index)
        assert float(frame["time"]) == state.attrs["time"]
        for name in ("id", "type", "x", "y", "u", "v", "theta", "radius", "area"):
            np.testing.assert_array_equal(frame[name].values, state[name].values)
        np.testing.assert_allclose(frame["mass"].values, masses(state), rtol=1e-14)
        iced = state["ice_fraction"].values[:, 0] > 0
        per_ice = (state["ice_volume"].values / np.maximum(state["ice_fraction"].values, 0.1))[:, 0]
        np.testing.assert_allclose(frame["thickness"].values, np.where(iced, per_ice, 0.0))


def test_mdanalysis_reads_the_dump_as_the_states(run, dump, states):
    universe = MDAnalysis.Universe(str(dump), dt=1.0, additional_columns=True)
    assert universe.trajectory.n_frames == len(states)
    np.testing.assert_array_equal(universe.atoms.ids, states[0]["id"].values)
    np.testing.assert_array_equal(universe.atoms.types.astype(int), states[0]["type"].values)
    np.testing.assert_allclose(universe.atoms.masses, masses(states[0]), rtol=1e-6)
    width = run.scene.domain.x_max - run.scene.domain.x_min
    for moment, state in zip(universe.trajectory, states, strict=True):
        assert moment.time == state.attrs["time"]
        np.testing.assert_array_equal(moment.dimensions, [width, width, 1, 90, 90, 90])
        for axis, (place, velocity) in enumerate((("x", "u"), ("y", "v"))):
            expected = state[place].values - corner(run)[axis]
            np.testing.assert_allclose(moment.positions[:, axis], expected, rtol=0, atol=SINGLE)
            np.testing.assert_allclose(moment.velocities[:, axis], state[velocity], rtol=1e-6)
        assert (moment.positions[:, 2] == 0).all() and (moment.velocities[:, 2] == 0).all()
        for name in ("radius", "theta", "area"):
            np.testing.assert_allclose(moment.data[name], state[name].values, rtol=1e-8)
        fraction = state["ice_fraction"].values.sum(axis=1)
        np.testing.assert_allclose(moment.data["ice_fraction"], fraction, rtol=1e-8)


def test_the_dump_keeps_millimetres(project, dump, states):
    """MDAnalysis reads any column in double precision when asked for it by name, as a page says."""
    text = (project / "docs/export.md").read_text()
    (line,) = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    there = {"MDAnalysis": MDAnalysis}
    exec(line.replace('"elements.lammpsdump"', repr(str(dump))), there)
    for moment, state in zip(there["universe"].trajectory, states, strict=True):
        for name in ("x", "y"):
            np.testing.assert_allclose(moment.data[name], state[name].values, rtol=0, atol=5.01e-4)


def test_universe_in_memory_is_what_the_dump_gives(run, frames, dump, states):
    here = make_universe(frames, corner(run))
    there = MDAnalysis.Universe(str(dump), dt=1.0)
    assert here.trajectory.n_frames == there.trajectory.n_frames
    np.testing.assert_array_equal(here.atoms.ids, there.atoms.ids)
    np.testing.assert_array_equal(here.atoms.types, there.atoms.types)
    np.testing.assert_allclose(here.atoms.radii, states[0]["radius"].values, rtol=1e-6)
    for one, other in zip(here.trajectory, there.trajectory, strict=True):
        assert one.time == other.time
        np.testing.assert_allclose(one.positions, other.positions, rtol=0, atol=2 * SINGLE)
        np.testing.assert_allclose(one.velocities, other.velocities, rtol=1e-6)
    pairs = np.stack([states[0][f"bond_id_{end}"].values for end in ("lo", "hi")], axis=1)
    found = here.atoms.ids[here.bonds.indices]
    np.testing.assert_array_equal(sorted(found.tolist()), sorted(pairs.tolist()))


@pytest.mark.filterwarnings("error")
def test_universe_has_the_fields_of_the_elements_at_each_frame(run, states):
    """In any order of frames; an element that is gone is parked, and flagged."""
    gone = states[-1].isel(element=slice(1, None))
    frames = make_frames([*states[:-1], gone])
    universe = make_universe(frames, corner(run))
    seen = [(step.frame, step.aux.thickness.copy()) for step in universe.trajectory]
    assert [frame for frame, _ in seen] == list(range(len(states)))
    for frame, thickness in seen:
        np.testing.assert_array_equal(thickness, frames["thickness"].values[frame])
    ids = universe.atoms.ids
    for frame in (len(states) - 1, 0, 1):
        step = universe.trajectory[frame]
        there = np.isin(ids, frames["id"].values[frames["present"].values[frame]])
        np.testing.assert_array_equal(step.aux.present, there)
        np.testing.assert_array_equal(step.aux.area, frames["area"].values[frame])
    aux = universe.trajectory[-1].aux
    assert not aux.present[0] and aux.mass[0] == aux.thickness[0] == aux.radius[0] == 0.0
    assert aux.present[1:].all()
    # A Universe of one frame has them too.
    alone = make_universe(make_frames(states[:1]), corner(run))
    np.testing.assert_array_equal(alone.trajectory.ts.aux.radius, states[0]["radius"].values)


def test_places_beyond_the_reach_of_xtc_are_refused(run, frames, tmp_path):
    far = frames.assign(x=frames["x"] + 3e7)
    with pytest.raises(FloeError, match=r"elements\.xtc: an element is 3\d{4} km off the domain"):
        write_xtc(far, run.scene.domain, tmp_path / "elements.xtc")
    assert not list(tmp_path.iterdir())


def test_statistics_are_those_of_the_mobile_elements(frames, states):
    data = drift_statistics(frames)
    mobile = states[0]["type"].values == 1
    np.testing.assert_array_equal(data["id"].values, states[0]["id"].values[mobile])
    gone = sum(
        np.hypot(after["x"].values - before["x"].values, after["y"].values - before["y"].values)
        for before, after in zip(states[:-1], states[1:], strict=True)
    )
    np.testing.assert_allclose(data["drift_distance"].values[-1], gone[mobile], rtol=1e-12)
    square = sum((states[-1][name].values - states[0][name].values) ** 2 for name in "xy")
    msd = data["mean_squared_displacement"].values
    assert msd[-1] == pytest.approx(square[mobile].mean(), rel=1e-5)
    dispersion = data["relative_dispersion"].values
    assert dispersion[0] == 0 and (np.diff(dispersion) > 0).all()


def test_without_bonds_there_is_no_dispersion_of_pairs(tmp_path):
    run = make_run(tmp_path, effects=("wind", "ocean_drag"), windows=1)
    frames = make_frames(read_state(run.state(window)) for window in (0, 1))
    assert frames.sizes["bond"] == 0
    assert len(make_universe(frames, corner(run)).bonds) == 0
    assert "relative_dispersion" not in drift_statistics(frames)


def test_elements_that_come_or_go_are_in_all_frames(run, states, tmp_path):
    # The first is there from the second frame on, the second until then.
    late = states[0].isel(element=slice(1, None), bond=slice(2, None))
    gone = [state.isel(element=np.arange(state.sizes["element"]) != 1) for state in states[2:]]
    frames = make_frames([late, states[1], *gone])
    np.testing.assert_array_equal(frames["id"].values, states[0]["id"].values)
    assert frames["present"].values[:, 0].tolist() == [False, *[True] * (len(states) - 1)]
    for name in ("x", "y"):
        assert frames[name].values[0, 0] == states[1][name].values[0]
        assert (frames[name].values[1:, 1] == states[1][name].values[1]).all()
    for name in ("radius", "area", "mass"):
        assert frames[name].values[0, 0] == 0 == frames[name].values[-1, 1]
    # So MDAnalysis reads the dump, and statistics are of those that are always there.
    write_dump(frames, run.scene.domain, tmp_path / "some.lammpsdump")
    there = MDAnalysis.Universe(str(tmp_path / "some.lammpsdump"), dt=1.0)
    assert there.trajectory.n_frames == len(states) and len(there.atoms) == len(frames["id"])
    assert not np.isin([1, 2], drift_statistics(frames)["id"].values).any()


def test_remapped_ice_carries_its_displacement(states):
    ways = {"x": 3.0, "y": 4.0}
    size = states[0].sizes["element"]
    carried = [
        state.assign({f"drift_{a}": ("element", np.full(size, c * k)) for a, c in ways.items()})
        for k, state in enumerate(states)
    ]
    data = drift_statistics(make_frames(carried))
    np.testing.assert_allclose(data["drift_distance"].values[-1], 5.0 * (len(states) - 1))
    assert "mean_squared_displacement" not in data


def test_a_run_without_elements_is_refused(tmp_path):
    run = make_run(tmp_path, elements=False, windows=1)
    with pytest.raises(FloeError, match="the run has no elements"):
        make_frames(read_state(run.state(window)) for window in (0, 1))


def test_frames_within_a_second_are_refused(run, frames, tmp_path):
    fast = frames.assign_coords(time=frames["time"] * 1e-5)
    with pytest.raises(FloeError, match="below one second"):
        write_dump(fast, run.scene.domain, tmp_path / "dump")


def test_a_dump_that_cannot_be_written_leaves_nothing(run, frames, tmp_path):
    (tmp_path / "dump").mkdir()
    with pytest.raises(FloeError, match="cannot be written"):
        write_dump(frames, run.scene.domain, tmp_path / "dump")
    assert [path.name for path in tmp_path.iterdir()] == ["dump"]


def rule(run, folder):
    """What Snakemake hands to the rule."""
    output = {"trajectory": folder / "elements.lammpsdump", "drift": folder / "drift.nc"}
    output["places"] = folder / "elements.xtc"
    return SimpleNamespace(
        input=SimpleNamespace(
            scene=str(run.scene_file),
            first=str(run.state(0)),
            elements=[str(path) for path in run.of_chunks("elements")],
        ),
        output=SimpleNamespace(**{name: str(path) for name, path in output.items()}),
    )


def test_rule_reads_all_boundaries_of_all_chunks(run, frames, tmp_path):
    snakemake = rule(run, tmp_path)
    load_script("postprocess/trajectory_files").main(snakemake)
    universe = MDAnalysis.Universe(snakemake.output.trajectory, dt=1.0)
    assert [moment.time for moment in universe.trajectory] == frames["time"].values.tolist()
    short = MDAnalysis.Universe(snakemake.output.trajectory, snakemake.output.places)
    assert [moment.time for moment in short.trajectory] == frames["time"].values.tolist()
    low = run.scene.domain.x_min, run.scene.domain.y_min
    for k, moment in enumerate(short.trajectory):
        for axis, (name, start) in enumerate(zip("xy", low, strict=True)):
            np.testing.assert_allclose(
                moment.positions[:, axis], frames[name].values[k] - start, rtol=3e-7, atol=0.01
            )
    # Pairs of neighbours are those of the start, so no bond is needed after it.
    xr.testing.assert_allclose(read_dataset(snakemake.output.drift), drift_statistics(frames))


def test_tracks_have_dates_and_places_on_the_earth(run, frames, tmp_path):
    write_dataset(drift_statistics(frames), tmp_path / "drift.nc")
    with xr.open_dataset(tmp_path / "drift.nc") as data:
        assert data["time"].values[1] == np.datetime64("1981-12-31T12:00:00")
        to_map = pyproj.Transformer.from_crs("EPSG:4326", run.scene.domain.crs, always_xy=True)
        x, y = to_map.transform(data["lon"].values, data["lat"].values)
        mobile = np.isin(frames["id"].values, data["id"].values)
        np.testing.assert_allclose(x, frames["x"].values[:, mobile], atol=1e-3)
        np.testing.assert_allclose(y, frames["y"].values[:, mobile], atol=1e-3)


def test_rule_names_a_chunk_that_is_missing(tmp_path):
    run = make_run(tmp_path / "run", effects=("wind",))
    run.chunk_of("elements", 2).unlink()
    with pytest.raises(FloeError, match=r"elements/0002.nc: there is no such file"):
        load_script("postprocess/trajectory_files").main(rule(run, tmp_path))


def test_masses_without_ice_are_zero(states, tmp_path):
    bare = states[0].copy()
    for name in ("ice_fraction", "ice_volume", "snow_volume"):
        bare[name] = 0.0 * bare[name]
    write_state(bare, tmp_path / "bare.nc")
    frames = make_frames([read_state(tmp_path / "bare.nc")])
    assert (frames["mass"].values == 0).all() and (frames["thickness"].values == 0).all()
