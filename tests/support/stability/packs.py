# SPDX-License-Identifier: GPL-2.0-or-later
"""The packs of the catalogue: pair, chain, lattice and random discs; seeded, touching, at rest."""

from __future__ import annotations

import numpy as np

from floeflow.packings.discs import radii
from floeflow.state.bonds import Arrays
from support.rafts import ICE, bonded, discs, lattice


def random_pack(
    n: int = 120, spread: float = 3.0, thickness: tuple[float, float] = (0.3, 3.0), seed: int = 4
) -> Arrays:
    """Discs of unlike radii and thicknesses that touch their neighbours.

    Parameters
    ----------
    n : int
        Number of discs.
    spread : float
        Largest radius over the mean distance of centres.
    thickness : tuple of float
        Least and most, m; evenly spread in their logarithm.
    seed : int
        Of the places.
    """
    random = np.random.default_rng(seed)
    side = 2000.0 * np.sqrt(n)
    points = random.uniform(0.0, side, (n, 2))
    radius = radii(points, np.full(n, 1000.0 * spread))
    h = np.exp(random.uniform(*np.log(thickness), n))
    return discs(points[:, 0], points[:, 1], radius, h)


def pair() -> Arrays:
    """Two equal discs."""
    return discs([0.0, 2000.0], [0.0, 0.0])


def chain(n: int = 20) -> Arrays:
    """Equal discs in a row."""
    return discs(2000.0 * np.arange(n), np.zeros(n))


def mixed_lattice() -> Arrays:
    """Equal discs in a triangular lattice, thicknesses at random."""
    pack = lattice(8, 8)
    pack["thickness"] = np.random.default_rng(7).uniform(0.2, 3.0, len(pack["id"]))
    pack["mass"] = ICE * pack["thickness"] * np.pi * pack["radius"] ** 2
    return pack


PACKS = {
    "pair": pair,
    "chain": chain,
    "lattice": lambda: lattice(8, 8),
    "lattice, mixed thickness": mixed_lattice,
    "random": random_pack,
}


def neighbours(pack: Arrays) -> Arrays:
    """Bonds between all discs that touch."""
    return bonded(pack, gap=0.02 * float(pack["radius"].mean()))


def squeezed(pack: Arrays, share: float) -> Arrays:
    """The same pack with centres drawn together by a share."""
    return pack | {"x": pack["x"] * (1.0 - share), "y": pack["y"] * (1.0 - share)}


def shaken(pack: Arrays, speed: float, seed: int = 1) -> Arrays:
    """The same pack with small random velocities and spins."""
    random = np.random.default_rng(seed)
    n = len(pack["id"])
    return pack | {
        "u": speed * random.normal(size=n),
        "v": speed * random.normal(size=n),
        "omega": speed / pack["radius"] * random.normal(size=n),
    }
