# SPDX-License-Identifier: GPL-2.0-or-later
"""Every variable says how it is transferred: nobody can sum what should be averaged."""

from __future__ import annotations

from floeflow.state.schema import MASS, VARIABLES

# Labels and places of elements: a transfer makes them anew.
MADE = {"id", "type", "x", "y", "theta", "radius", "cell_corners"}


def test_every_element_variable_is_an_amount_or_a_property_of_one() -> None:
    for name, rule in VARIABLES.items():
        if rule.dims[0] != "element" or name in MADE:
            assert rule.kind == "" and not rule.of and not rule.per, name
        else:
            assert rule.kind in ("extensive", "intensive"), f"{name} says not how it is transferred"


def test_parents_are_amounts_that_do_not_go_in_circles() -> None:
    for name, rule in VARIABLES.items():
        assert (rule.kind == "intensive") == bool(rule.of), name
        if not rule.kind:
            continue
        seen = {name}
        while rule.of and rule.of != MASS:
            for other in (rule.of, rule.per or rule.of):
                assert other in VARIABLES and VARIABLES[other].kind, f"{name}: {other}"
                # A property has the dimensions of its parent, and perhaps more of its own.
                assert rule.dims[: len(VARIABLES[other].dims)] == VARIABLES[other].dims, name
            assert rule.of not in seen, f"{name} is a property of itself"
            seen.add(rule.of)
            rule = VARIABLES[rule.of]
        assert rule.of == MASS or rule.kind == "extensive", f"{name} ends at no amount"


def test_what_sits_on_what() -> None:
    found = {name: rule.of for name, rule in VARIABLES.items() if rule.of}
    assert found["ice_fraction"] == "area"
    assert found["ice_volume"] == found["snow_volume"] == "ice_fraction"
    assert found["u"] == found["v"] == found["omega"] == MASS
    assert VARIABLES["ice_volume"].per == "area"
