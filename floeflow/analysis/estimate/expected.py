# SPDX-License-Identifier: GPL-2.0-or-later
"""What a run will take, said before it begins, and how well that was met, said at its end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from floeflow.analysis.estimate.cost import Sizes, coefficients, run_seconds, sizes
from floeflow.analysis.estimate.resources import outline

if TYPE_CHECKING:
    from floeflow.scene import Scene

# Bytes on disk: of an element in a state, for each category, and for each of its layers; of an
# element in a snapshot (kept twice, by window and by chunk), for each category, and of its outline
# and drift where cells are remapped; of a cell of the grid in all fields of a time (twice too);
# of a cell of the mask's grid in preprocessing; of what every run has (report, figures, logs).
# Measured with `du` on the default scene, three days of the Arctic year, and `smoke`, and good to a
# factor of 1.5 there.
STATE, STATE_CATEGORY, STATE_LAYER = 350.0, 40.0, 8.0
SNAPSHOT, SNAPSHOT_CATEGORY, SNAPSHOT_CELL = 200.0, 60.0, 600.0
FIELDS, MASK, EVERY_RUN = 70.0, 200.0, 7e6


@dataclass(frozen=True)
class Expected:
    """What is expected of a run.

    Parameters
    ----------
    elements, windows, steps : int
        Elements with the coast's, coupling windows, steps of the element model.
    window : float
        Length of a window, s.
    seconds : float
        Wall time of all jobs, s, where the machine has nothing else to do.
    size : float
        Of the results, bytes.
    """

    elements: int
    windows: int
    steps: int
    window: float
    seconds: float
    size: float


def expected(scene: Scene, ranks: int) -> Expected:
    """Sizes, time and disk space of a run of a scene, from its keys alone.

    Parameters
    ----------
    scene : Scene
        With concrete effects.
    ranks : int
        MPI ranks of its windows.
    """
    fit, pack = coefficients(), outline(scene)
    s = sizes(pack, scene, scene.effects, fit)
    seconds = run_seconds(pack, scene, scene.effects, ranks, fit)
    return Expected(
        round(s.elements), s.windows, int(s.steps), scene.time.window, seconds, disk_size(scene, s)
    )


def disk_size(scene: Scene, s: Sizes) -> float:
    """Bytes of the results of a run.

    Parameters
    ----------
    scene : Scene
        Its keys.
    s : Sizes
        Sizes of the run.

    Returns
    -------
    float
        bytes.
    """
    column = scene.column
    many = column.categories if "thermodynamics" in scene.effects else 1
    # Mushy ice keeps the salinity of its layers too.
    layers = {"zero_layer": 0, "bl99": 1, "mushy": 2}[column.scheme] * (1 + column.layers)
    state = STATE + many * (STATE_CATEGORY + layers * STATE_LAYER)
    snapshot = SNAPSHOT + many * SNAPSHOT_CATEGORY
    if {"remap", "merge"} & set(scene.effects):
        snapshot += SNAPSHOT_CELL
    states = s.windows if scene.state.keep == "all" else s.launches
    size = EVERY_RUN + MASK * s.mask_cells
    size += s.elements * ((states + 1) * state + s.windows * snapshot)
    if "grid_output" in scene.effects:
        size += (s.windows + 1) * s.cells * FIELDS
    return size


def expectation(found: Expected, ranks: int) -> str:
    """The expectation in a sentence.

    Parameters
    ----------
    found : Expected
        What is expected.
    ranks : int
        Number of MPI ranks.

    Returns
    -------
    str
        One sentence, with units.
    """
    on = f"{ranks} rank{'s' if ranks > 1 else ''}"
    windows = f"{found.windows} window{'s' if found.windows > 1 else ''}"
    return (
        f"Expected: {found.elements:,} elements, {windows} of "
        f"{as_time(found.window)} in {two_digits(found.steps)} steps; about "
        f"{as_time(found.seconds)} on {on}, {as_size(found.size)} on disk"
    )


def outcome(found: Expected, seconds: float, size: float) -> str:
    """How well it was met, in a sentence.

    Parameters
    ----------
    found : Expected
        What was expected.
    seconds : float
        Wall time (s).
    size : float
        Results on disk (bytes).

    Returns
    -------
    str
        One sentence, with units.
    """
    return (
        f"Took {as_time(seconds)} (expected: {as_time(found.seconds)}) and {as_size(size)} on disk "
        f"(expected: {as_size(found.size)})"
    )


def two_digits(value: float) -> str:
    """A number in two digits, which is more than an estimate has.

    Parameters
    ----------
    value : float
        In any unit.
    """
    if value < 10.0:
        return f"{value:.2g}"
    return f"{round(value, 2 - len(str(int(value)))):,.0f}"


def as_time(seconds: float) -> str:
    """A time in its best unit, to two digits.

    Parameters
    ----------
    seconds : float
        Of a time.
    """
    for unit, name in ((86400.0, "d"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2 * unit:
            return f"{two_digits(seconds / unit)} {name}"
    return f"{two_digits(seconds)} s"


def as_size(size: float) -> str:
    """Bytes in their best unit, to two digits.

    Parameters
    ----------
    size : float
        Bytes.
    """
    for unit, factor in (("TB", 1e12), ("GB", 1e9)):
        if size >= factor:
            return f"{two_digits(size / factor)} {unit}"
    return f"{two_digits(size / 1e6)} MB"
