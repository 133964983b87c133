# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene's input files hold for it: variable, file, level, times, cover and units of each.

Reads headers and coordinates alone; the fields themselves are read only for a picture of them.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floeflow.analysis.file_checks import check_files
from floeflow.core import area_means, fields, times
from floeflow.core import cf_reading as cf
from floeflow.core.grids import mask_grid, scene_crs, scene_grid, to_lonlat
from floeflow.coupling.sea.reading import (
    SEA_FIELDS,
    find_sea,
    sea_hints,
    sea_path,
)
from floeflow.forcings.forcing import FINER
from floeflow.forcings.inputs import opened
from floeflow.forcings.tracks import Track
from floeflow.forcings.window import window_forcing
from floeflow.masks.labels import read_labels
from floeflow.masks.mask import make_mask
from floeflow.masks.mask_file import (
    Wanted,
    mask_hints,
    nearest_time,
    wanted_variables,
)
from floeflow.masks.thickness import thickness_kind
from floeflow.report.figures.frame import Frame
from floeflow.report.figures.inputs import input_maps
from floeflow.report.figures.style import write_png
from floeflow.scene.blocks import Scene

LAND = {"mask": "from the file", "none": "none"}
FORMULAE = {
    "analytic": "analytic: cyclone, gyre and weather of the scene",
    "climatology": "climatology: a synthetic year from monthly tables, with storms of a seed",
}


@dataclass(frozen=True)
class Finding:
    """Where a quantity comes from.

    Parameters
    ----------
    quantity : str
        Of the scene.
    source : str
        Variables and file, or what stands in for them.
    notes : tuple of str
        Units, level, times, cover, and what else was decided.
    """

    quantity: str
    source: str
    notes: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """For people."""
        return [f"{self.quantity}: {self.source}", *(f"    {note}" for note in self.notes)]


def find_inputs(scene: Scene) -> list[Finding]:
    """Check a scene's files and say what was found in them.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Raises
    ------
    FloeError
        As `check_files`.
    """
    check_files(scene)
    found = [*_of_mask(scene), Finding("mask land", LAND.get(scene.mask.land, scene.mask.land))]
    found += _of_polygons(scene)
    if "mixed_layer" in scene.effects:
        found += _of_sea(scene)
    return [*found, *_of_forcing(scene)]


def say(findings: list[Finding]) -> str:
    """All findings as text.

    Parameters
    ----------
    findings : list of Finding
        Of one scene.
    """
    return "\n".join(line for finding in findings for line in finding.lines())


def draw(scene: Scene, path: Path) -> None:
    """Draw small maps of the mask, and of the forcing at the scene's start.

    Land is the file's own, or none: the 1 km mask takes seconds.

    Parameters
    ----------
    scene : Scene
        Its mask and forcing.
    path : Path
        PNG file.

    Raises
    ------
    FloeError
        For what is wrong with the fields.
    """
    land = "none" if scene.mask.land == "none" else "mask"
    block = scene.mask.model_copy(update={"land": land})
    mask = make_mask(scene.model_copy(update={"mask": block}), None)
    with tempfile.TemporaryDirectory() as scratch:
        forcing = window_forcing(scene, 1, Path(scratch))
    figure = input_maps(Frame(scene.domain, mask["land"]), mask, forcing)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_png(figure, path, 110)


def _of_labels(scene: Scene) -> Finding:
    """How many floes a labelled image has over the scene, so that a wrong place or pixel shows."""
    floes = read_labels(scene.mask.labels, scene.domain)
    taken = floes.numbers > 0
    share = 100.0 * float(taken.mean()) if taken.size else 0.0
    note = (
        f"{np.unique(floes.numbers[taken]).size:,} numbers on {taken.shape[1]:,} by "
        f"{taken.shape[0]:,} pixels of {floes.grid.spacing:g} m over the scene; "
        f"{share:.0f} % of them are ice"
    )
    return Finding("mask", f"floes of {scene.mask.labels.file}", (note,))


def _of_polygons(scene: Scene) -> list[Finding]:
    """Shoreline and region, where the scene names them."""
    named = (("shoreline", scene.mask.shoreline), ("ice only in", scene.mask.region))
    return [Finding(quantity, source) for quantity, source in named if source]


def _of_mask(scene: Scene) -> list[Finding]:
    if scene.packing.generator == "floes":
        return [_of_labels(scene)]
    if scene.mask.uniform > 0.0:
        return [Finding("mask", f"concentration {scene.mask.uniform:g} on all water, no file")]
    path = Path(scene.mask.file)
    found = []
    with fields.open_file(path, mask_hints(scene)) as data:
        variables = cf.variables_of(data)
        wanted = wanted_variables(scene, data, variables, path)
        first = wanted["concentration"]
        source = fields.source_grid(variables, first.variable, first.layout, data, path)
        how = _transfer(scene, source, scene.mask.refine, 1.0)
        for name, item in wanted.items():
            notes = [_units(item.variable), _mask_time(scene, item)]
            if name == "thickness":
                notes.append(f"is {thickness_kind(scene.mask.thickness_is, item.variable, path)}")
            level = fields.surface_level(data, item.variable.name, item.layout, True, path)
            notes += [f"level {level.said}"] if level and item.layout.level else []
            text = f"'{item.variable.name}' of {path}"
            found.append(Finding(f"mask {name}", text, (*notes, _grid(source), how)))
    return found


def _of_sea(scene: Scene) -> list[Finding]:
    """Temperature and salinity of a mixed layer at the start."""
    path, found = sea_path(scene), []
    with fields.open_file(path, sea_hints(scene)) as data:
        variables = cf.variables_of(data)
        for _, quantity, key in SEA_FIELDS:
            variable = find_sea(variables, scene, quantity, key)
            what = quantity.replace("_", " ")
            if variable is None:
                stand_in = "the freezing point" if key == "temperature" else "column.ocean_salinity"
                found.append(Finding(what, f"{path} has none; {stand_in} stands in"))
                continue
            layout = cf.layout(variables, variable, path)
            source = fields.source_grid(variables, variable, layout, data, path)
            _, days = nearest_time(data, variables, layout, scene, path)
            when = f"{days:.1f} days from the scene's start" if np.isfinite(days) else "no time"
            how = _transfer(scene, source, scene.mask.refine, 1.0)
            notes = _units(variable), when, _grid(source), how
            found.append(Finding(what, f"'{variable.name}' of {path}", notes))
    return found


def _mask_time(scene: Scene, item: Wanted) -> str:
    if not np.isfinite(item.days_off):
        return "of no known time"
    records = item.variable.shape[item.variable.dims.index(item.layout.time)] if (
        item.layout.time in item.variable.dims
    ) else 1  # fmt: skip
    which = f"record {item.index + 1} of {records}" if records > 1 else "one record"
    return f"{which}, {item.days_off:.1f} days from the scene's start"


def _of_forcing(scene: Scene) -> list[Finding]:
    if scene.forcing.source != "file":
        return [Finding("forcing", FORMULAE[scene.forcing.source])]
    found = []
    with opened(scene) as sources:
        for name, item in sources.tracks.items():
            tracks = item if isinstance(item, tuple) else (item,)
            names = ", ".join(f"'{track.name}'" for track in tracks)
            files = list(dict.fromkeys(str(f.path) for track in tracks for f in track.files))
            more = f" and {len(files) - 1} more" if len(files) > 1 else ""
            notes = [_units(tracks[0].variable), _span(scene, tracks[0])]
            level = tracks[0].level()
            notes += [f"level {level}"] if level else []
            notes += [tracks[0].note()] if tracks[0].note() else []
            if isinstance(item, tuple):
                notes.append("east and north" if sources.east_north[name] else "along its grid")
            source = tracks[0].source()
            notes += [_grid(source), _transfer(scene, source, 1, FINER)]
            found.append(Finding(name, f"{names} of {files[0]}{more}", tuple(notes)))
        for name, stand_in in sources.fallbacks.items():
            found.append(Finding(name, f"no file has it; {stand_in} stands in"))
    return found


def _units(variable: cf.Variable) -> str:
    given = variable.text("units")
    return f"units '{given}'" if given else "no units"


def _span(scene: Scene, track: Track) -> str:
    if not track.layout.time:
        return "steady"
    kinds = {"instant": "", "mean": ", means over time", "sum": ", sums over time"}
    ends = [times.say(scene.time.start, float(track.seconds[k])) for k in (0, -1)]
    return f"{ends[0]} to {ends[1]}, {track.seconds.size} records{kinds[track.kind]}"


def _grid(source: fields.AnySource) -> str:
    rows, columns = fields.shape_of(source)
    if isinstance(source, fields.Curvilinear):
        return f"curvilinear grid of {rows} x {columns}"
    kind = "longitude and latitude" if source.crs is None else f"projected ({source.crs.name})"
    return f"{kind}, {rows} x {columns}"


def _transfer(scene: Scene, source: fields.AnySource, refine: int, finer: float) -> str:
    grid = mask_grid(scene.domain, refine) if refine > 1 else scene_grid(scene.domain)
    crs = scene_crs(scene.domain)
    lon, lat = to_lonlat(crs, *grid.mesh())
    found = area_means.transfer(source, grid, crs, lon, lat, finer)
    how = "area means" if isinstance(found, area_means.AreaMeans) else "interpolated"
    return f"covers {100.0 * found.inside.mean():.1f} % of the scene, {how}"
