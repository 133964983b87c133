# SPDX-License-Identifier: GPL-2.0-or-later
"""Print whether Numba had cached the column, and checksums of two years of each kind of ice.

`test_compiled_bits` runs this in processes of their own, with an empty and with a filled cache. The
columns start as open water in autumn, freeze, gather ponds in summer and melt in part.
"""

from __future__ import annotations

import hashlib
from dataclasses import fields

import numpy as np

from floeflow.column.kernel import advance
from floeflow.column.layered import LayeredState, pack_forcing, step
from floeflow.column.physics import Physics
from floeflow.column.thickness.categories import category_bounds

HOURS, YEARS = 8760, 2
LIGHT = {"ponds": True, "delta_eddington": True}
KINDS = [Physics(), Physics(**LIGHT), Physics(mushy=True), Physics(mushy=True, **LIGHT)]


def seasons() -> np.ndarray:
    """Forcing of one column through years of hours that begin in autumn."""
    phase = 2.0 * np.pi * (np.arange(YEARS * HOURS)[:, None] / HOURS + 0.3)
    sun = np.maximum(0.0, -400.0 * np.sin(phase))
    values = {
        "potential_temperature": 258.0 - 17.0 * np.sin(phase),
        "humidity": 2e-3 - 1.6e-3 * np.sin(phase),
        "density": np.full_like(phase, 1.3),
        "wind": np.full_like(phase, 5.0),
        "longwave": 230.0 - 70.0 * np.sin(phase),
        "visible": 0.52 * sun,
        "infrared": 0.48 * sun,
        "snowfall": np.full_like(phase, 3e-6),
        "sea_salinity": np.full_like(phase, 34.0),
        "deep_heat": np.full_like(phase, 2.0),
        "mixed_depth": np.full_like(phase, 20.0),
        "ocean_friction": np.full_like(phase, 0.005),
        "sun_height": np.maximum(0.0, -0.4 * np.sin(phase)),
    }
    return pack_forcing(values, YEARS * HOURS, 1)


def open_water() -> LayeredState:
    """One column of five categories without ice, half a degree above freezing."""
    shape = (1, 5)
    return LayeredState(
        *np.zeros((3, *shape)), np.full(shape, -1.8), np.zeros((*shape, 7)), np.zeros((*shape, 1)),
        np.zeros((*shape, 7)), np.full(1, -1.3), np.zeros(1),
    )  # fmt: skip


if __name__ == "__main__":
    sums = []
    for p in KINDS:
        state, _ = step(open_water(), seasons(), 3600.0, category_bounds(5), p)
        digest = hashlib.sha256()
        for each in fields(state):
            digest.update(getattr(state, each.name).tobytes())
        if not 0.1 < state.ice_volume.sum() < 10.0:
            raise SystemExit(f"{state.ice_volume.sum()} m of ice are not a cold sea's")
        sums.append(digest.hexdigest())
    print(sum(advance.stats.cache_hits.values()), *sums)
