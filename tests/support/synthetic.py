# SPDX-License-Identifier: GPL-2.0-or-later
"""A small run that never ran: files as the stages write them, for tests of what reads them.

Some 200 elements (Voronoi cells of a jittered lattice beside a straight coast) turn and drift for
a few windows. The budget terms are made to close to round-off, so that a test can spoil one and
ask whether the diagnostics find just that.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
import xarray as xr
from scipy.spatial import Delaunay

from floeflow.core.records import Record
from floeflow.coupling.chunk import join_series
from floeflow.diagnostics.diagnostics import RunFiles
from floeflow.scene import Scene, load_scene
from floeflow.scene.windows import window_chunks
from floeflow.state import SCHEMA_VERSION, read_dataset, read_state, write_dataset, write_state
from floeflow.state.snapshots import read_snapshots, write_snapshots

ICE_DENSITY, SNOW_DENSITY = 917.0, 330.0
X0, Y0, WIDTH, SPACING, REFINE = -1.6e6, 4.0e5, 4.0e5, 5.0e4, 4
COAST_X = X0 + 6.0e4
WINDOW = 43200.0
ALL = ("wind", "ocean_drag", "coriolis", "tilt", "friction", "bonds")
ALL += ("thermodynamics", "snow", "shortwave", "lateral_melt", "frazil")
SCENE = """
name: {name}
effects: [{effects}]
seed: 7
domain: {{x_min: {x0}, x_max: {x1}, y_min: {y0}, y_max: {y1}, spacing: {spacing}}}
packing: {{elements: 200}}
time: {{windows: {windows}, window: {window}}}
forcing: {{cyclone: {{wind_speed: 12}}}}
workflow: {{windows_per_job: 2}}
state: {{keep: all}}
report: {{title: {title!r}, text: "A pack beside a coast.", dpi: 60}}
"""


@dataclass(frozen=True)
class Run:
    """Where the files lie, and the scene."""

    root: Path
    scene_file: Path
    scene: Scene
    windows: list[int]

    @property
    def folder(self) -> Path:
        """``results/<scene>``."""
        return self.root / "results" / self.scene.name

    @property
    def chunks(self) -> dict[str, list[str]]:
        """Windows of each chunk, by its name."""
        return window_chunks(len(self.windows), self.scene.workflow.windows_per_job)

    @property
    def files(self) -> RunFiles:
        """What diagnostics read."""
        return RunFiles(
            first=self.state(0),
            elements=self.of_chunks("elements"),
            series=self.of_chunks("series"),
            cost=self.of_chunks("cost", ".json"),
            grid=self.grid,
        )

    @property
    def grid(self) -> Path:
        """Fields at all boundaries."""
        return self.folder / "grid.nc"

    def state(self, window: int) -> Path:
        """A window's state."""
        return self.folder / "state" / f"{window:04d}.nc"

    def of_chunks(self, kind: str, suffix: str = ".nc") -> list[Path]:
        """The files of a kind, one a chunk."""
        return [self.folder / kind / f"{chunk}{suffix}" for chunk in self.chunks]

    def chunk_of(self, kind: str, window: int, suffix: str = ".nc") -> Path:
        """The file of a kind that holds a window."""
        names = [name for name, windows in self.chunks.items() if f"{window:04d}" in windows]
        return self.folder / kind / f"{names[0]}{suffix}"

    def change_series(self, window: int, name: str, delta: float) -> None:
        """Add to a budget scalar of a window."""
        path = self.chunk_of("series", window)
        series = read_dataset(path)
        series[name].values[series["window"].values == window] += delta
        write_dataset(series, path)

    def change_elements(self, window: int, change: Callable[[xr.Dataset], None]) -> None:
        """Change the snapshot of the elements at a window's end in its place."""
        path = self.chunk_of("elements", window)
        parts = list(read_snapshots([path]))
        for part in parts:
            if part.attrs["window"] == window:
                change(part)
        write_snapshots(parts, path)


def make_run(
    root: Path,
    effects: tuple[str, ...] = ALL,
    windows: int = 3,
    elements: bool = True,
    title: str = "A synthetic pack",
    name: str = "pack",
) -> Run:
    """Write a whole run under ``root`` and return it."""
    text = SCENE.format(
        name=name,
        effects=", ".join(effects),
        x0=X0,
        x1=X0 + WIDTH,
        y0=Y0,
        y1=Y0 + WIDTH,
        spacing=SPACING,
        windows=windows,
        window=WINDOW,
        title=title,
    )
    root.mkdir(parents=True, exist_ok=True)
    scene_file = root / f"{name}.yaml"
    scene_file.write_text(text)
    run = Run(root, scene_file, load_scene(scene_file), list(range(1, windows + 1)))
    packing = make_packing(elements)
    write_dataset(packing, run.folder / "preprocess" / "packing.nc")
    write_dataset(make_mask(), run.folder / "preprocess" / "mask.nc")
    write_state(first_state(packing, run.scene), run.state(0))
    states, series, cost = [read_state(run.state(0))], {}, {}
    for window in run.windows:
        after, series[window] = advance(states[-1], window, run.scene)
        series[window].attrs["window"] = window
        write_state(after, run.state(window))
        records = _cost(after.sizes["element"], window)
        cost[window] = [{**record.as_dict(), "window": window} for record in records]
        states.append(read_state(run.state(window)))
    for name, members in run.chunks.items():
        numbers = [int(window) for window in members]
        write_dataset(join_series([series[w] for w in numbers]), run.folder / f"series/{name}.nc")
        write_snapshots([states[w] for w in numbers], run.folder / f"elements/{name}.nc")
        text = json.dumps([record for w in numbers for record in cost[w]])
        _made(run.folder / f"cost/{name}.json").write_text(text)
    write_dataset(xr.concat([_grid(s) for s in states], "time", data_vars="minimal"), run.grid)
    _benchmarks(run)
    return run


def _made(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def make_packing(elements: bool = True) -> xr.Dataset:
    """Voronoi cells of a jittered lattice, and coast discs with no cell."""
    rng = np.random.default_rng(7)
    water = shapely.box(COAST_X, Y0, X0 + WIDTH, Y0 + WIDTH)
    ice = shapely.box(COAST_X, Y0 + 3e4, X0 + WIDTH - 4e4, Y0 + WIDTH - 5e4)
    step = 2.1e4
    px, py = np.meshgrid(
        np.arange(COAST_X + step / 2, X0 + WIDTH - 4e4, step),
        np.arange(Y0 + 3e4 + step / 2, Y0 + WIDTH - 5e4, step),
    )
    points = np.stack([px.ravel(), py.ravel()], axis=1)
    points += rng.uniform(-0.3, 0.3, points.shape) * step
    if not elements:
        points = points[:0]
    cells: list[np.ndarray] = []
    if len(points):
        parts = shapely.voronoi_polygons(
            shapely.multipoints(points), extend_to=ice.buffer(1e5), ordered=True
        )
        for part in shapely.get_parts(parts):
            ring = shapely.orient_polygons(shapely.intersection(part, ice))
            cells.append(shapely.get_coordinates(ring)[:-1])
    area = np.array([shapely.polygons(cell).area for cell in cells])
    coast_y = np.arange(Y0 + 1e4, Y0 + WIDTH, 2e4)
    coast = len(coast_y) if elements else 0
    n = len(points) + coast
    fraction = np.concatenate([rng.uniform(0.75, 1.0, len(points)), np.zeros(coast)])
    thick = np.concatenate([0.5 + 2.0 * (points[:, 1] - Y0) / WIDTH, np.zeros(coast)])
    start = np.concatenate([[0], np.cumsum([len(cell) for cell in cells], dtype=int)])
    start = np.concatenate([start, np.full(coast, start[-1])]).astype(np.int64)
    vertices = np.concatenate(cells) if cells else np.zeros((0, 2))
    pairs = _neighbours(points)
    return xr.Dataset(
        {
            "id": ("element", np.arange(1, n + 1)),
            "type": ("element", np.repeat([1, 2], [len(points), coast]).astype(np.int8)),
            "x": ("element", np.concatenate([points[:, 0], np.full(coast, COAST_X - 1e4)])),
            "y": ("element", np.concatenate([points[:, 1], coast_y[:coast]])),
            "radius": ("element", np.concatenate([np.sqrt(area / np.pi), np.full(coast, 1e4)])),
            "area": ("element", np.concatenate([area, np.zeros(coast)])),
            "ice_fraction": (("element", "category"), fraction[:, None]),
            "ice_volume": (("element", "category"), (fraction * thick)[:, None]),
            "cell_start": ("corner", start),
            "cell_x": ("vertex", vertices[:, 0]),
            "cell_y": ("vertex", vertices[:, 1]),
            "edge_lo": ("edge", pairs[:, 0]),
            "edge_hi": ("edge", pairs[:, 1]),
        },
        attrs={"ocean_area": float(water.area), "unclaimed_water": float(water.area - area.sum())},
    )


def _neighbours(points: np.ndarray) -> np.ndarray:
    """Pairs of ids of Delaunay neighbours nearer than 30 km, sorted, (n, 2)."""
    if len(points) < 4:
        return np.zeros((0, 2), dtype=np.int64)
    corners = Delaunay(points).simplices
    pairs = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [0, 2]]])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    gap = points[pairs[:, 0]] - points[pairs[:, 1]]
    return pairs[np.hypot(gap[:, 0], gap[:, 1]) < 3e4].astype(np.int64) + 1


def make_mask() -> xr.Dataset:
    """Mask grid with a straight coast at the left and a round island in open water."""
    size = SPACING / REFINE
    axis = (np.arange(int(WIDTH / size)) + 0.5) * size
    x, y = X0 + axis, Y0 + axis
    land = (x[None, :] < COAST_X) | (np.hypot(x - X0 - 3.8e5, (y - Y0 - 2e4)[:, None]) < 1.5e4)
    ice = np.where(land, 0.0, 0.9)
    return xr.Dataset(
        {
            "siconc": (("y", "x"), ice),
            "sithick": (("y", "x"), 1.5 * (ice > 0)),
            "land": (("y", "x"), land.astype(np.int8)),
            "cell_area": (("y", "x"), np.full(land.shape, size**2)),
        },
        coords={"x": x, "y": y},
        attrs={"crs": "EPSG:6931"},
    )


def first_state(packing: xr.Dataset, scene: Scene) -> xr.Dataset:
    """State 0: at rest, all neighbours bonded."""
    n = packing.sizes["element"]
    zero = np.zeros(n)
    data = packing[["id", "type", "x", "y", "radius", "area", "ice_fraction", "ice_volume"]].copy()
    for name in ("theta", "u", "v", "omega"):
        data[name] = ("element", zero.copy())
    if "thermodynamics" in scene.effects:
        data["snow_volume"] = 0.1 * data["ice_fraction"]
        data["surface_temperature"] = 250.0 + 0.0 * data["ice_fraction"]
    if "bonds" in scene.effects:
        data = data.merge(_bonds(packing))
    for kind in ("id_lo", "id_hi"):
        data[f"contact_{kind}"] = ("contact", np.zeros(0, dtype=np.int64))
    for kind in ("slip", "rest_overlap"):
        data[f"contact_{kind}"] = ("contact", np.zeros(0))
    data.attrs = {
        "schema_version": SCHEMA_VERSION,
        "scene": scene.name,
        "effects": " ".join(scene.effects),
        "window": 0,
        "time": 0.0,
        "start": scene.time.start.isoformat(),
        "seed": scene.seed,
        "crs": scene.domain.crs,
        "ocean_area": float(packing.attrs["ocean_area"]),
        "unclaimed_water": float(packing.attrs["unclaimed_water"]),
        "provenance": '{"floeflow": "0.1.0", "liggghts": "3.8.0"}',
    }
    return data


def _bonds(packing: xr.Dataset) -> xr.Dataset:
    lo, hi = packing["edge_lo"].values, packing["edge_hi"].values
    place = np.stack([packing["x"].values, packing["y"].values], axis=1)
    along = place[hi - 1] - place[lo - 1]
    span = np.hypot(along[:, 0], along[:, 1])
    half = 0.25 * np.stack([-along[:, 1], along[:, 0]], axis=1)
    middle = along / 2
    ends = {"a": middle - half, "b": middle + half}
    data = {"bond_id_lo": lo, "bond_id_hi": hi, "bond_length": 0.5 * span, "bond_span": span}
    data |= {"bond_thickness": np.full(len(lo), 1.5)}
    data |= {f"bond_crack_{end}": np.zeros(len(lo)) for end in "ab"}
    for end, vector in ends.items():
        for column, axis in enumerate("xy"):
            data[f"bond_lo_{end}{axis}"] = vector[:, column]
            data[f"bond_hi_{end}{axis}"] = (vector - along)[:, column]
    return xr.Dataset({name: ("bond", values) for name, values in data.items()})


def advance(state: xr.Dataset, window: int, scene: Scene) -> tuple[xr.Dataset, xr.Dataset]:
    """Turn and drift the pack for a window; the new state and the window's series."""
    mobile = (state["type"].values == 1).astype(float)
    after = state.copy(deep=True)
    x, y = state["x"].values - (X0 + WIDTH / 2), state["y"].values - (Y0 + WIDTH / 2)
    # The right half turns: bonds break between it and the rest.
    turns = mobile * (x > 2e4)
    u = mobile * 0.04 * window - 1.2e-6 * y * turns
    v = 0.02 * mobile + 1.2e-6 * x * turns
    after["u"], after["v"] = ("element", u), ("element", v)
    after["omega"] = ("element", 1.2e-6 * turns)
    for name, rate in (("x", u), ("y", v), ("theta", 1.2e-6 * turns)):
        after[name] = ("element", state[name].values + rate * WINDOW)
    series = _series(state, after, window, scene)
    if "thermodynamics" in scene.effects:
        grown = 0.01 * state["ice_fraction"].values * mobile[:, None]
        after["ice_volume"] = (("element", "category"), state["ice_volume"].values + grown)
        after["snow_volume"] = 1.5 * state["snow_volume"]
    if "bonds" in scene.effects:
        after = _break(after, turns)
    after.attrs = {**state.attrs, "window": window, "time": window * WINDOW}
    series["ice_volume_end"] = _total(after, "ice_volume")
    if "thermodynamics" in scene.effects:
        series = _column_terms(series, state, after)
    if "intact_bonds" in series:
        count = np.linspace(state.sizes["bond"], after.sizes["bond"], series.sizes["sample"])
        series["intact_bonds"] = ("sample", np.round(count).astype(np.int64))
    return after, series


def _break(state: xr.Dataset, turns: np.ndarray) -> xr.Dataset:
    lo, hi = state["bond_id_lo"].values - 1, state["bond_id_hi"].values - 1
    across = turns[lo] != turns[hi]
    # Those across the edge of the turning part crack by half a window, and go at 1.
    state["bond_crack_a"] = ("bond", state["bond_crack_a"].values + 0.5 * across)
    return state.isel(bond=np.flatnonzero(state["bond_crack_a"].values < 1.0))


def _total(state: xr.Dataset, name: str) -> float:
    return float((state["area"].values * state[name].values.sum(axis=1)).sum())


def masses(state: xr.Dataset) -> np.ndarray:
    """Mass of each element (kg)."""
    per_area = ICE_DENSITY * state["ice_volume"].values.sum(axis=1)
    if "snow_volume" in state:
        per_area = per_area + SNOW_DENSITY * state["snow_volume"].values.sum(axis=1)
    return np.asarray(state["area"].values * per_area)


def _series(state: xr.Dataset, after: xr.Dataset, window: int, scene: Scene) -> xr.Dataset:
    mass, count = masses(state), 9
    share = np.linspace(0.0, 1.0, count)
    first, last = (np.hypot(s["u"].values, s["v"].values) for s in (state, after))
    speed = first[None, :] + share[:, None] * (last - first)[None, :]
    area = state["area"].values
    drift = speed @ area / area.sum() if area.sum() > 0 else np.zeros(count)
    kinetic = 0.5 * (speed**2) @ mass
    data: dict[str, object] = {
        "time": ("sample", (window - 1 + share) * WINDOW),
        "kinetic_energy": ("sample", kinetic),
        "elastic_energy": ("sample", 0.1 * kinetic),
        "drift_speed": ("sample", drift),
        "largest_speed": ("sample", speed.max(axis=1, initial=0.0)),
    }
    if "bonds" in scene.effects:
        data["intact_bonds"] = ("sample", np.zeros(count, dtype=np.int64))
    for axis, name in (("x", "u"), ("y", "v")):
        start, end = (float((mass * s[name].values).sum()) for s in (state, after))
        data |= {f"momentum_{axis}_start": start, f"momentum_{axis}_end": end}
        data |= _impulses(end - start, axis, scene.effects)
    gained = 1.1 * (kinetic[-1] - kinetic[0])
    data |= {"dissipation_contact": 0.5 * gained, "work_wind": 1.5 * gained}
    for name in ("area", "volume"):
        total = _total(state, {"area": "ice_fraction", "volume": "ice_volume"}[name])
        data |= {f"ice_{name}_start": total, f"ice_{name}_end": total}
    data["ice_volume_dynamics"] = data["ice_volume_start"]
    return xr.Dataset(data)


def _impulses(change: float, axis: str, effects: tuple[str, ...]) -> dict[str, float]:
    """Impulses whose sum is the change to round-off."""
    shares = {"ocean": -0.6, "coriolis": 0.15, "tilt": 0.05}
    named = {"ocean_drag": "ocean"}
    used = {named.get(e, e) for e in effects} & set(shares)
    parts = {name: shares[name] * change for name in sorted(used)}
    parts["coast"] = -0.1 * change
    rest = "wind" if "wind" in effects else "coast"
    others = sum(value for name, value in parts.items() if name != rest)
    parts[rest] = change - others
    return {f"impulse_{name}_{axis}": value for name, value in parts.items()}


def _column_terms(series: xr.Dataset, state: xr.Dataset, after: xr.Dataset) -> xr.Dataset:
    grown = float(series["ice_volume_end"] - series["ice_volume_dynamics"])
    stored = -3.0e8 * grown
    snow = [_total(each, "snow_volume") for each in (state, after)]
    return series.assign(
        growth_base=1.2 * grown,
        growth_new_ice=0.1 * grown,
        growth_surface_melt=-0.05 * grown,
        growth_sublimation=grown - 1.25 * grown,
        energy_atmosphere=1.1 * stored,
        energy_ocean=stored - 1.1 * stored,
        energy_stored=stored,
        snow_snowfall=1.2 * (snow[1] - snow[0]),
        snow_melt=-0.2 * (snow[1] - snow[0]),
        snow_volume_start=snow[0],
        snow_volume_end=snow[1],
    )


def _cost(elements: int, window: int) -> list[Record]:
    steps = 4000
    seconds = 0.9 + 0.1 * window
    return [
        Record("setup", elements, 2, [0.21]),
        Record(
            "dynamics",
            elements,
            2,
            [seconds],
            extra={
                "steps": steps,
                "element_steps_per_s": elements * steps / seconds,
                "time_step": 10.8,
                "cpu_seconds": 2.0 * seconds,
                "limited_by": "bond",
            },
        ),
        Record("column", elements, 2, [0.05]),
        Record("exchange", elements, 2, [0.02]),
    ]


def _benchmarks(run: Run) -> None:
    """Benchmark files as Snakemake writes them."""
    head = "s\th:m:s\tmax_rss\tmax_vms\tmax_uss\tmax_pss\tio_in\tio_out\tmean_load\tcpu_time\n"
    for name, seconds in (("mask", 3.2), ("packing", 7.9), ("windows/0003", 12.5), ("grid", 1.1)):
        path = _made(run.folder / "benchmarks" / f"{name}.tsv")
        row = (
            f"{seconds}\t0:00:0{int(seconds) % 10}\t312.5\t900\t280\t281\t0\t1.5\t99.1\t{seconds}\n"
        )
        path.write_text(head + row)


def _grid(state: xr.Dataset) -> xr.Dataset:
    """CF-like grid: each element's totals put into the cell of its centre, shares of the cell."""
    size = int(WIDTH / SPACING)
    axis = (np.arange(size) + 0.5) * SPACING
    mobile = state.isel(element=np.flatnonzero(state["type"].values == 1))
    column = np.clip((mobile["x"].values - X0) // SPACING, 0, size - 1).astype(int)
    row = np.clip((mobile["y"].values - Y0) // SPACING, 0, size - 1).astype(int)

    def gather(values: np.ndarray) -> np.ndarray:
        total = np.zeros((size, size))
        np.add.at(total, (row, column), values)
        return total

    area = mobile["area"].values
    cell = np.full((size, size), SPACING**2)
    ice = gather(area * mobile["ice_fraction"].values.sum(axis=1))
    volume = gather(area * mobile["ice_volume"].values.sum(axis=1))
    none = ice <= 0

    def per(total: np.ndarray, base: np.ndarray) -> np.ndarray:
        return np.where(none, np.nan, total / np.where(none, 1.0, base))

    weight = area * mobile["ice_fraction"].values.sum(axis=1)
    fields = {
        "siconc": (ice / cell, "1"),
        "sithick": (per(volume, ice), "m"),
        "sivol": (volume / cell, "m"),
        "siu": (per(gather(weight * mobile["u"].values), ice), "m s-1"),
        "siv": (per(gather(weight * mobile["v"].values), ice), "m s-1"),
    }
    if "snow_volume" in mobile:
        snow = gather(area * mobile["snow_volume"].values.sum(axis=1))
        fields["sisnthick"] = (per(snow, ice), "m")
    data = xr.Dataset(
        {name: (("time", "y", "x"), v[None], {"units": u}) for name, (v, u) in fields.items()},
        coords={"x": X0 + axis, "y": Y0 + axis, "time": [float(state.attrs["time"])]},
    )
    for name in ("x", "y"):
        bounds = data[name].values[:, None] + 0.5 * SPACING * np.array([-1.0, 1.0])
        data[f"{name}_bnds"] = ((name, "bnds"), bounds)
    data["areacello"] = (("y", "x"), cell, {"units": "m2"})
    data["window"] = (("time",), np.array([int(state.attrs["window"])]))
    data["siconc"].attrs["cell_measures"] = "area: areacello"
    return data
