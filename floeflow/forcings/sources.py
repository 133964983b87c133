# SPDX-License-Identifier: GPL-2.0-or-later
"""Which file holds which quantity of the forcing, and what stands in for those that none holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError
from floeflow.core.input_files import Hints
from floeflow.forcings import cf_variables
from floeflow.forcings.fixed_fields import FIXED
from floeflow.forcings.tracks import Clock, InputFile, Track
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import forcing_variables

# What two quantities make up for a missing one.
SUBSTITUTES = {
    "specific_humidity": ("dew_point", "air_pressure"),
    "snowfall": ("precipitation", "air_temperature"),
}
# Heights above the ground (m) of winds, and of temperature and humidity, where a file has several.
WIND_HEIGHT, AIR_HEIGHT = 10.0, 2.0
# Quantities that forcing.weather always stands in for: few files have them, and they matter little.
DEFAULTS = ("ocean_heat_flux", "air_pressure")


@dataclass(frozen=True)
class Sources:
    """Where the quantities of a scene's forcing come from.

    Parameters
    ----------
    tracks : dict of Track or tuple of Track
        Scalars by their name (dew point and precipitation among them, where they stand for
        others), ``wind`` and ``ocean`` as pairs of components.
    east_north : dict of bool
        Whether a vector's components point east and north; else along its grid.
    fallbacks : dict of str
        What no file has, and what stands in for it: ``rest``, ``cyclone``, ``gyre``, ``weather``
        or ``climatology``.
    """

    tracks: dict[str, Track | tuple[Track, Track]]
    east_north: dict[str, bool]
    fallbacks: dict[str, str]


def clock_of(scene: Scene) -> Clock:
    """What of a scene decides about times.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    Clock
        Start, midnight before it (s since the start), and how sums and days off are meant.
    """
    start = scene.time.start
    since = 3600.0 * start.hour + 60.0 * start.minute + start.second + 1e-6 * start.microsecond
    return Clock(start, -since, scene.forcing.accumulation, scene.forcing.days_off)


def forcing_hints(scene: Scene) -> Hints:
    """What the scene says of its forcing files.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    Hints
        Projection of the files, where the scene names one.
    """
    return Hints("forcing", scene.forcing.crs)


def find_sources(scene: Scene, files: Sequence[InputFile], advise: bool = True) -> Sources:
    """Look for what the effects need; ``advise`` adds which keys of a scene help.

    Parameters
    ----------
    scene : Scene
        Its effects.
    files : sequence of InputFile
        Of the forcing, in the order in which they count.
    advise : bool, optional
        Whether messages name keys of a scene that help.

    Returns
    -------
    Sources
        Variable of each quantity that the effects need, or what stands for it.

    Raises
    ------
    FloeError
        Names all that no file has and nothing stands in for, with the standard names to give it;
        or what is there twice, or without its other component.
    """
    search = _Search(scene, list(files))
    wanted = dict.fromkeys(
        name.rsplit("_", 1)[0] if name.endswith(("_u", "_v")) else name
        for name in forcing_variables(scene.effects)
        if name not in FIXED
    )
    for name in wanted:
        if name in cf_variables.VECTORS:
            search.vector(name)
        else:
            search.scalar(name)
    if search.missing:
        raise FloeError(
            f"{label(files)}: has "
            + "; ".join(search.missing)
            + (search.advice() if advise else "")
        )
    return Sources(search.tracks, search.east_north, search.fallbacks)


def label(files: Sequence[InputFile]) -> str:
    """Files in words.

    Parameters
    ----------
    files : sequence of InputFile
        Files of the forcing.

    Returns
    -------
    str
        The only file, or the first and how many more.
    """
    if len(files) == 1:
        return str(files[0].path)
    return f"{files[0].path} and {len(files) - 1} more"


class _Search:
    def __init__(self, scene: Scene, files: list[InputFile]) -> None:
        self.scene, self.files, self.clock = scene, files, clock_of(scene)
        self.tracks: dict[str, Track | tuple[Track, Track]] = {}
        self.east_north: dict[str, bool] = {}
        self.fallbacks: dict[str, str] = {}
        self.missing: list[str] = []
        self.without: set[str] = set()

    def advice(self) -> str:
        """What to do about what is missing."""
        kinds = [kind for kind in ("wind", "ocean", "weather") if kind in self.without]
        keys = ", ".join(f"forcing.fallback.{kind}" for kind in kinds)
        return f". Add files to forcing.files, or name what stands in for it in {keys}"

    def find(self, name: str) -> Track | None:
        """The first file's variable of a scalar's name."""
        quantity = cf_variables.QUANTITIES[name]
        for number, file in enumerate(self.files):
            variable = cf_variables.find_scalar(file.variables, name, file.path)
            if variable is not None:
                summed = cf_variables.scalar_conversion(variable, quantity, file.path)[2]
                return Track(
                    *(self.files[number:], variable.name, summed, quantity.ocean, self.clock),
                    AIR_HEIGHT,
                )
        return None

    def scalar(self, name: str) -> None:
        """Find a scalar, what it can be made of, or what stands in for it."""
        found = self.find(name)
        if found is not None:
            self.tracks[name] = found
            return
        said = f"no {name}: no standard_name {cf_variables.QUANTITIES[name].standard[0]}"
        if name in SUBSTITUTES:
            first, second = SUBSTITUTES[name]
            pair = self.find(first), self.find(second)
            if pair[0] is not None and (pair[1] is not None or second in DEFAULTS):
                self.tracks[first] = pair[0]
                if pair[1] is not None:
                    self.tracks[second] = pair[1]
                else:
                    self.fallbacks[second] = "weather"
                return
            said = (
                f"no {name}: neither standard_name {cf_variables.QUANTITIES[name].standard[0]} nor "
                f"{cf_variables.QUANTITIES[first].standard[0]} with {second.replace('_', ' ')}"
            )
        self._fall_back(name, "weather", "weather" if name in DEFAULTS else "", said)

    def _fall_back(self, name: str, kind: str, default: str, said: str) -> None:
        named = getattr(self.scene.forcing.fallback, kind) or default
        if named:
            self.fallbacks[name] = named
        else:
            self.missing.append(said)
            self.without.add(kind)

    def vector(self, name: str) -> None:
        """Find both components of a vector, in one file or apart, or what stands in for it.

        Raises
        ------
        FloeError
            As `find_vector`, where no file has it.
        """
        fault: FloeError | None = None
        for number, file in enumerate(self.files):
            try:
                found = cf_variables.find_vector(file.variables, name, file.path, file.on_lonlat)
            except FloeError as error:
                fault = fault or error
                continue
            if found is not None:
                files = [self.files[number:]] * 2
                self._take(name, found, files)
                return
        if self._apart(name):
            return
        if fault is not None:
            raise fault
        u, v = cf_variables.VECTORS[name].east_north[0]
        self._fall_back(name, name, "", f"no {name}: no standard_names {u} and {v}")

    def _apart(self, name: str) -> bool:
        """Components in files of their own, as NEMO and JRA55-do have them."""
        both = {
            item: file.variables[item]
            for file in reversed(self.files)
            for item in file.variables
            if len(file.variables[item].dims) >= 2
        }
        if len(self.files) == 1:
            return False

        def on_lonlat(variable: cf.Variable) -> bool:
            owner = next(file for file in self.files if variable.name in file.variables)
            return owner.layout(owner.variables[variable.name]).lonlat

        found = cf_variables.find_vector(both, name, label(self.files), on_lonlat)
        if found is None:
            return False
        files = []
        for part in (found.u, found.v):
            number = next(k for k, file in enumerate(self.files) if part.name in file.variables)
            files.append(self.files[number:])
        self._take(name, found, files)
        return True

    def _take(
        self, name: str, found: cf_variables.FoundVector, files: list[list[InputFile]]
    ) -> None:
        pair = []
        for part, rest in zip((found.u, found.v), files, strict=True):
            cf_variables.conversion(
                rest[0].variables[part.name], cf_variables.VECTOR_UNITS, rest[0].path
            )
            ocean = cf_variables.VECTORS[name].ocean
            pair.append(Track(rest, part.name, False, ocean, self.clock, WIND_HEIGHT))
        self.tracks[name] = (pair[0], pair[1])
        self.east_north[name] = found.east_north
