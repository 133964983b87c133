# SPDX-License-Identifier: GPL-2.0-or-later
"""How LIGGGHTS is set up for a state: box, neighbour lists and their reach, styles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from floeflow.core.errors import FloeError
from floeflow.core.period import distances_of, sides
from floeflow.dynamics.engine.params import EngineParams
from floeflow.state.bonds import Arrays

# The furthest that neighbours are sought for, as a multiple of the sum of two radii.
LONGEST_REACH = 4.0
# Steps that a neighbour list should last, and the speed (m/s) that ice driven by wind reaches.
LIST_LIFE = 300
DRIFT_SPEED = 0.3
# Discs in a plane, in the order of their places; ghosts carry velocities.
PLANE = (
    "units si",
    "dimension 2",
    "atom_style granular",
    "atom_modify sort 1000 0",
    # The box follows the elements and is at least what it is now: none can leave it.
    "boundary m m p",
    "newton off",
    "communicate single vel yes",
)
# LIGGGHTS' own division of the box among the ranks.
EVEN = "processors * * 1"


@dataclass(frozen=True)
class Box:
    """The box of a state, and how far ranks and neighbour lists see in it.

    Parameters
    ----------
    x, y : tuple of float
        Lowest and highest, m.
    skin : float
        Extra distance of the neighbour lists, m.
    margin : float
        The furthest that neighbours are sought for, m.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    skin: float
    margin: float


def box_of(elements: Arrays, params: EngineParams, reach: float) -> Box:
    """The box for a state.

    Parameters
    ----------
    elements, params, reach
        As for `setup_commands`.

    Returns
    -------
    Box
        Bounds along x and y, skin and margin (m): all elements lie inside by the margin; along a
        periodic axis the bounds are those of the period.
    """
    skin = params.skin if params.skin is not None else choose_skin(elements, params)
    margin = 2.0 * float(elements["radius"].max()) * reach + skin
    low, high = (
        np.array([pick(elements["x"]), pick(elements["y"])]) + sign * margin
        for pick, sign in ((np.min, -1.0), (np.max, 1.0))
    )
    if params.period is not None:
        repeats = np.isfinite(sides(params.period))
        low = np.where(repeats, params.period[:2], low)
        high = np.where(repeats, params.period[2:], high)
    x, y = zip(low.tolist(), high.tolist(), strict=True)
    return Box(x, y, skin, margin)


def setup_commands(
    elements: Arrays, params: EngineParams, reach: float, division: str = EVEN
) -> list[str]:
    """LIGGGHTS commands before elements are created.

    Parameters
    ----------
    elements : dict of ndarray, shape (n,)
        As `Engine.load` takes them.
    params : EngineParams
        Laws, switches and time step.
    reach : float
        Neighbours are kept up to this multiple of the sum of radii.
    division : str
        The command that says how many ranks lie along each axis.

    Returns
    -------
    list of str
        In their order.
    """
    box = box_of(elements, params, reach)
    plane: tuple[str, ...] = PLANE
    if params.period is not None:
        ends = " ".join("p" if math.isfinite(side) else "m" for side in sides(params.period))
        plane = tuple(
            f"boundary {ends} p" if line.startswith("boundary") else line for line in PLANE
        )
    return [
        *plane,
        division,
        # As deep as wide neighbourhoods: LIGGGHTS refuses to bin a flat box.
        f"region box block {box.x[0]!r} {box.x[1]!r} {box.y[0]!r} {box.y[1]!r}"
        f" {-box.margin!r} {box.margin!r} units box",
        "create_box 2 box",
        f"neighbor {box.skin!r} bin",
        # Not `one` or `page`: with other than their defaults LIGGGHTS 3.8 makes new lists at
        # each `run` and forgets all pairs.
        "neigh_modify delay 0 every 1 check yes",
        "neigh_modify exclude type 2 2",
        params.pair_style(reach),
        "pair_coeff * *",
        f"timestep {params.time_step!r}",
        params.fix_style(),
        "thermo_style custom step atoms",
        "thermo_modify lost ignore norm no",
        "thermo 1000000000",
    ]


def choose_skin(elements: Arrays, params: EngineParams) -> float:
    """Extra distance (m) of the neighbour lists, from speed and step.

    A list should last some hundreds of steps, neither rebuilt often nor full of pairs that never
    meet; the skin stays between 2 % and 50 % of the mean radius.

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.
    params : EngineParams
        Parameters of the engine.

    Returns
    -------
    float
        m.
    """
    speed = max(DRIFT_SPEED, float(np.hypot(elements["u"], elements["v"]).max()))
    mean = float(elements["radius"].mean())
    return float(np.clip(2.0 * LIST_LIFE * speed * params.time_step, 0.02 * mean, 0.5 * mean))


def contact_reach(elements: Arrays, contacts: Arrays, params: EngineParams) -> float:
    """Furthest that centres in contact can be apart, over the sum of their radii.

    With ridging a contact may reach across a gap: that of the bond which broke there, or one that
    ridging on other sides of its elements left (negative rest overlap).

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.
    contacts : Arrays
        Contact table of k contacts.
    params : EngineParams
        Parameters of the engine.

    Returns
    -------
    float
        1 where contacts reach across no gap.
    """
    if not params.ridging or len(contacts["id_lo"]) == 0:
        return 1.0
    lo, hi = (np.searchsorted(elements["id"], contacts[name]) for name in ("id_lo", "id_hi"))
    radii = elements["radius"][lo] + elements["radius"][hi]
    distance = distances_of(elements, lo, hi, params.period)
    touching = radii - np.minimum(contacts["rest_overlap"], 0.0)
    return float(np.max(np.maximum(touching, distance) / radii)) * 1.002


def bond_reach(elements: Arrays, bonds: Arrays, params: EngineParams) -> float:
    """Furthest that a bonded pair's centres can be apart, over the sum of its radii.

    A point of a bond survives a displacement of at most the strength over the stiffness; the
    centres are then no further apart than the two arms to the line and that displacement.

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.
    bonds : Arrays
        Bond table.
    params : EngineParams
        Parameters of the engine.

    Returns
    -------
    float
        1 or more; 1 without bonds.

    Raises
    ------
    FloeError
        If that lies beyond what the neighbour lists can cover, naming the pair.
    """
    if len(bonds["id_lo"]) == 0:
        return 1.0
    if params.reach is not None:
        return params.reach
    reach = pair_reach(elements, bonds, params)
    worst = int(np.argmax(reach))
    if reach[worst] > LONGEST_REACH:
        raise FloeError(
            f"The bond between elements {bonds['id_lo'][worst]} and {bonds['id_hi'][worst]} "
            f"survives until its centres are {reach[worst]:.3g} times the sum of the radii apart, "
            f"beyond the {LONGEST_REACH:g} that neighbour lists cover: lower the strengths, raise "
            "young_modulus, or set reach."
        )
    return float(reach[worst]) * 1.002


def within_reach(elements: Arrays, bonds: Arrays, params: EngineParams) -> Arrays:
    """Bonds that neighbour lists can hold; those of discs too small for their lines are let go.

    Where ridges use up elements these join others before (`remesh/absorb.py`); what is left are
    bonds of elements that have none to join, as with the coast.

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    params : EngineParams
        Parameters of the engine.

    Returns
    -------
    Arrays
        The bonds that are held.
    """
    if len(bonds["id_lo"]) == 0:
        return bonds
    held = pair_reach(elements, bonds, params) <= LONGEST_REACH
    return {name: values[held] for name, values in bonds.items()}


def pair_reach(elements: Arrays, bonds: Arrays, params: EngineParams) -> np.ndarray:
    """Furthest that the centres of each bonded pair can be, over the sum of its radii, (m,).

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    params : EngineParams
        Parameters of the engine.

    Returns
    -------
    ndarray
        Ratio, which neighbour lists are made to hold.
    """
    ids = elements["id"]
    lo, hi = np.searchsorted(ids, bonds["id_lo"]), np.searchsorted(ids, bonds["id_hi"])
    arm = sum(
        np.maximum(
            np.hypot(bonds[f"{side}_ax"], bonds[f"{side}_ay"]),
            np.hypot(bonds[f"{side}_bx"], bonds[f"{side}_by"]),
        )
        for side in ("lo", "hi")
    )
    compressive = params.bond_strength(bonds["thickness"])
    tensile = params.tensile_share * compressive
    shear = (compressive + tensile) * math.tan(params.friction_angle)
    # Tension and shear do not reach their largest values together; both do bound the line.
    normal = np.maximum(tensile, compressive) / params.young_modulus
    stretch = bonds["span"] * np.hypot(normal, shear / params.shear_modulus)
    return np.asarray((arm + stretch) / (elements["radius"][lo] + elements["radius"][hi]))
