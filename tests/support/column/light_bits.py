# SPDX-License-Identifier: GPL-2.0-or-later
"""Print whether Numba had cached a function of the column's light, and a checksum of its results.

`test_compiled_bits` runs this in processes of their own, with an empty and with a filled cache.
"""

from __future__ import annotations

import hashlib

import numba
import numpy as np

from floeflow.column.physics import Physics, as_records
from floeflow.column.records import FORCING, INFRARED, SUN_HEIGHT, VISIBLE
from floeflow.column.shortwave.delta_eddington import MEDIA, Surface, ice_media, shine
from floeflow.column.shortwave.scattering import new_rays
from floeflow.column.thermodynamics.enthalpy import salinity_profile
from floeflow.column.thermodynamics.profile import new_profile

LAYERS, CASES, VALUES = 7, 500, 6


@numba.njit(cache=True, error_model="numpy")
def absorbed(values, forcing, profile, constants, results):  # type: ignore[no-untyped-def]
    """Light that snow, bare ice and ponds absorb and pass, for each row of ``values``."""
    p = constants[0]
    w, rays = new_profile(profile, 1, constants), new_rays(profile.size + 1, MEDIA)
    ice_media(rays.media, profile.size, p)
    for e in range(values.shape[0]):
        ice, snow, pond, warmth = values[e, 0], values[e, 1], values[e, 2], values[e, 3]
        forcing[VISIBLE], forcing[INFRARED] = 52.0, 48.0
        forcing[SUN_HEIGHT] = values[e, 4]
        w.source[:] = 0.0
        surface = Surface(e % 3, values[e, 5], ice, snow, pond, warmth)
        passed = shine(surface, 1, w, rays, forcing, p)
        results[e, 0], results[e, 1] = passed
        results[e, 2:] = w.source


if __name__ == "__main__":
    values = np.random.default_rng(1).uniform(size=(CASES, VALUES))
    values *= [4.0, 0.5, 0.5, -5.0, 0.9, 1.0]
    p, results = Physics(), np.empty((CASES, 2 + LAYERS + 1))
    profile = salinity_profile(LAYERS, p)
    absorbed(values, np.full(len(FORCING), 0.4), profile, as_records(p), results)
    if not (np.isfinite(results).all() and results.max() > 1.0):
        raise SystemExit("the light is not what a sun of 100 W/m2 gives")
    hits = sum(absorbed.stats.cache_hits.values())
    print(hits, hashlib.sha256(results.tobytes()).hexdigest())
