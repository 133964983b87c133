# SPDX-License-Identifier: GPL-2.0-or-later
"""Checks of a scene's forcing files before any job, from headers and coordinates alone.

The stage finds its variables through the same functions, so what passes here is what it reads.
Values are checked by the stage.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from floeflow.core import cf_reading as cf
from floeflow.forcings.files import depth_files, forcing_files
from floeflow.forcings.fixed_fields import sea_floor_depth
from floeflow.forcings.forcing import describe, places_of
from floeflow.forcings.sources import Sources, find_sources, forcing_hints
from floeflow.forcings.tracks import Track, open_files
from floeflow.scene.blocks import Scene


def tracks_of(sources: Sources) -> list[Track]:
    """All variables behind a forcing, components apart.

    Parameters
    ----------
    sources : Sources
        Open files of the forcing.

    Returns
    -------
    list of Track
        Two for a vector.
    """
    found: list[Track] = []
    for item in sources.tracks.values():
        found += item if isinstance(item, tuple) else (item,)
    return found


@contextmanager
def opened(scene: Scene) -> Iterator[Sources]:
    """The sources of a scene's forcing, its files open.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Yields
    ------
    Sources
        While its files are open.
    """
    files = open_files(forcing_files(scene), forcing_hints(scene))
    try:
        yield find_sources(scene, files)
    finally:
        for file in files:
            file.data.close()


def described(scene: Scene) -> list[str]:
    """Where each quantity of a scene's forcing comes from, one a line; none if it is analytic.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    list of str
        With those that a fallback stands for.
    """
    if scene.forcing.source != "file":
        return []
    with opened(scene) as found:
        lines = [f"{name}: {describe(item)}" for name, item in found.tracks.items()]
        stand_ins = found.fallbacks.items()
        return [*lines, *(f"{name}: forcing.fallback: {word}" for name, word in stand_ins)]


def check_forcing_file(scene: Scene) -> None:
    """Refuse forcing files that the forcing stage could not use.

    Does nothing where the forcing is analytic. The depth of the sea is read, whatever the source
    of the forcing is.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Raises
    ------
    FloeError
        One sentence: no file, not readable, quantities missing, units unknown, no map, a level
        that is no surface, or a time axis that does not cover the scene.
    """
    if depth_files(scene):
        sea_floor_depth(scene)
    if scene.forcing.source != "file":
        return
    with opened(scene) as found:
        end = scene.time.windows * scene.time.window
        places = places_of(scene, (0.0, end))
        for track in tracks_of(found):
            if not track.layout.lonlat and not track.layout.places:
                cf.projection(track.first.variables, track.variable, track.path)
            track.level()
            track.records((0.0, end))
            places.transfer(track)
