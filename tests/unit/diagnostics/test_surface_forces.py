# SPDX-License-Identifier: GPL-2.0-or-later
"""Forces on the gridded ice: free drift is their balance, the forcing is that of the instant."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.core.constants import ICE_DENSITY
from floeflow.diagnostics.surface_forces import forcing_at, surface_forces
from floeflow.diagnostics.wind_drift import FreeDrift, free_drift
from floeflow.forcings.window import window_forcing
from floeflow.scene import load_scene
from unit.diagnostics.test_gridded import SCENE

EFFECTS = "wind, ocean_drag, turning_angle, coriolis, tilt"


def scene_with(folder, more: str = ""):
    path = folder / "scene.yaml"
    path.write_text(SCENE.format(effects=EFFECTS) + more)
    return load_scene(path)


@pytest.mark.parametrize("coriolis", [1.4e-4, -1.4e-4])
def test_forces_on_freely_drifting_ice_cancel(tmp_path, coriolis):
    scene = scene_with(tmp_path)
    thick = 1.5
    drags = FreeDrift(
        scene.dynamics.air_drag,
        scene.dynamics.ocean_drag,
        np.radians(scene.dynamics.turning_angle),
        coriolis,
        ICE_DENSITY * thick,
    )
    current = 0.05 - 0.02j
    u = free_drift(np.array([12.0]), drags)[0] + current
    one = np.ones((2, 3))
    fields = {"siu": u.real * one, "siv": u.imag * one, "sithick": thick * one}
    fields["siu"][0, 0] = np.nan
    forcing = {"wind_u": 12.0 * one, "wind_v": 0.0 * one, "coriolis": coriolis * one}
    forcing |= {"ocean_u": current.real * one, "ocean_v": current.imag * one}
    found = surface_forces(scene, fields, forcing)
    for axis in "xy":
        parts = ("sistr{}dtop", "sistr{}ubot", "siforcecoriol{}", "siforcetilt{}")
        total = sum(found[name.format(axis)] for name in parts)
        assert np.isnan(total[0, 0])
        np.testing.assert_allclose(total[1], 0.0, atol=1e-12)
    assert found["sistrxdtop"][1, 1] == pytest.approx(1.3 * scene.dynamics.air_drag * 144.0)


def test_the_forcing_is_that_of_the_instant(tmp_path):
    scene = scene_with(tmp_path, "forcing: {source: climatology}\ntime: {window: 86400}\n")
    whole = scene.model_copy(update={"forcing": scene.forcing.model_copy(update={"step": 86400.0})})
    found, window = forcing_at(scene, 2 * 86400.0), window_forcing(whole, 2, tmp_path)
    for name in ("wind_u", "wind_v", "ocean_u", "ocean_v"):
        np.testing.assert_allclose(found[name], window[name].values[-1], err_msg=name)
    np.testing.assert_allclose(found["coriolis"], window["coriolis"].values)


def test_absent_effects_leave_no_force(tmp_path):
    scene = scene_with(tmp_path).model_copy(update={"effects": ("wind",)})
    one = np.ones((2, 2))
    fields = {"siu": one, "siv": one, "sithick": one}
    found = surface_forces(scene, fields, {"wind_u": one, "wind_v": one})
    assert set(found) == {"sistrxdtop", "sistrydtop"}
    assert forcing_at(scene.model_copy(update={"effects": ()}), 0.0) == {}
