# SPDX-License-Identifier: GPL-2.0-or-later
"""The registry of effects: what is not named is absent."""

from __future__ import annotations

from dataclasses import fields

import pytest

from floeflow.core.errors import FloeError
from floeflow.scene.effects import (
    EFFECTS,
    check_effects,
    diagnostic_series,
    forcing_variables,
    plugin_switches,
    state_variables,
)
from floeflow.state import VARIABLES


def test_no_effects_add_nothing():
    for ask in (
        plugin_switches,
        forcing_variables,
        state_variables,
        diagnostic_series,
    ):
        assert ask(()) == ()


def test_what_two_effects_share_is_asked_for_once():
    assert forcing_variables(("ocean_drag", "tilt")) == ("ocean_u", "ocean_v", "coriolis")


def test_every_effect_says_its_physics_and_source():
    for effect in EFFECTS.values():
        assert effect.physics.endswith(".") and effect.source
        added = [getattr(effect, field.name) for field in fields(effect)[4:-1]]
        assert any(added), f"{effect.name} adds nothing anywhere"
        assert set(effect.state) <= set(VARIABLES)
        assert set(effect.needs) <= set(EFFECTS)


def test_unknown_effects_without_a_near_name_list_the_known():
    with pytest.raises(FloeError, match="known are wind, ocean_drag"):
        check_effects(["zzz"])
