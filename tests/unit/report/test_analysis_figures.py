# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of analyses: all that a long run supports, and nothing of a few points."""

from __future__ import annotations

from datetime import datetime

import numpy as np
import pytest
import xarray as xr

from floeflow.diagnostics.deformation import ORDERS
from floeflow.diagnostics.thickness_distribution import EDGES
from floeflow.report.figures.analyses import analysis_figures
from floeflow.report.figures.fracture import envelope
from floeflow.report.figures.style import as_svg
from floeflow.report.summary import break_facts, motion_facts

DAY = 86400.0
NAMES = {
    *("ice_thickness_distribution", "ice_edge", "motion_deformation", "motion_wind"),
    *("motion_scaling", "motion_rates", "motion_lags", "floe_sizes_end"),
    *("motion_features", "bonds_stress", "bonds_cracks", "bonds_events"),
}


def made(times: int, periods: tuple[str, ...], samples: int) -> xr.Dataset:
    """What a run of so many windows leaves."""
    rng = np.random.default_rng(0)
    bins, n = EDGES.size - 1, times
    time = np.arange(n) * DAY
    lags = min(n, 8)
    scale = np.array([35e3, 140e3, 280e3, 560e3]) * np.ones((n, 1))
    moment = 1e-7 * (scale / 35e3)[..., None] ** -0.2 * np.ones(ORDERS.size)
    wind, drift = np.arange(0.5, 30.0), np.arange(-0.29, 0.89, 0.02)
    rates = np.logspace(-10, -3, 57)
    fit = {"exponent": 0.2 * ORDERS, "error": 0.01 * ORDERS}
    number = np.full((len(periods), 2), 0.012)
    floes = np.sort(500.0 * rng.random(60) ** -0.7)
    law = {"power_law_exponent": "2.4", "power_law_error": "0.2", "power_law_from": "500"}
    law |= {"power_law_goodness": "0.4", "lognormal_mean": "6.5", "lognormal_spread": "0.9"}
    law |= {"likelihood_ratio": "0.3", "units": "m", "long_name": "diameters"}
    many = 10 * max(times - 3, 1)
    envelope = {"tensile_share": "0.2", "friction_angle_degrees": "30"}
    angles = rng.random(18)
    return xr.Dataset(
        {
            "thickness_time": ("boundary", time),
            "thickness_area": (("boundary", "thickness"), rng.random((n, bins))),
            "thickness_bounds": (("thickness", "bound"), np.stack([EDGES[:-1], EDGES[1:]], 1)),
            "edge_time": ("grid", time),
            **{name: ("grid", 1e12 + 1e9 * time) for name in ("extent", "marginal_area")},
            "lead_fraction": ("grid", 0.01 + 0 * time),
            "period": ("period", list(periods)),
            **{f"wind_{name}": (("period", "ice"), number) for name in ("factor", "turning")},
            "wind_explained": (("period", "ice"), number),
            "wind_weight": (("period", "ice"), 1.0 + 0 * number),
            "wind_drift_area": (("wind", "drift"), rng.random((wind.size, drift.size))),
            "wind": ("wind", wind),
            "drift": ("drift", drift),
            "free_drift_along": ("wind", 0.015 * wind),
            "interval_time": ("interval", time),
            **{f"deformation_{k}": ("interval", 1e-7 + 0 * time) for k in ("total", "shear")},
            "deformation_divergence": ("interval", 1e-7 + 0 * time),
            "deformation_count": (("interval", "scale"), 100.0 + 0 * scale),
            "deformation_scale": (("interval", "scale"), scale),
            "deformation_moment": (("interval", "scale", "order"), moment),
            "order": ("order", ORDERS),
            "season": ("season", ["all"]),
            **{f"scaling_{k}": (("season", "order"), v[None]) for k, v in fit.items()},
            "scaling_low": ("season", [140e3]),
            "scaling_high": ("season", [560e3]),
            "rate_count": (
                ("piece", "rate_kind", "rate"),
                np.full((2, 3, 56), samples / 168.0),
            ),
            "rate_bounds": (("rate", "bound"), np.stack([rates[:-1], rates[1:]], 1)),
            "lag": ("lag", np.arange(lags) * DAY),
            "velocity_correlation_along": ("lag", 0.8 ** np.arange(lags)),
            "velocity_correlation_across": ("lag", np.zeros(lags)),
            "pair_dispersion": ("lag", 1e6 * np.arange(lags) ** 2.0),
            "floe_diameter_end": ("floe_end", floes, law),
            "localised_share": ("interval", 0.1 + 0 * time),
            "feature_density": ("interval", 2e-6 + 0 * time),
            "feature_length": ("feature", 1e5 * rng.random(many)),
            "angle": ("angle", (np.arange(18) + 0.5) * np.pi / 18),
            **{f"{k}_angle_length": ("angle", angles) for k in ("feature", "crack", "line")},
            "crack_size": ("crack", 1e4 * rng.random(many)),
            "break_time": ("break_interval", np.arange(1, n + 1) * 3600.0),
            "break_count": ("break_interval", np.full(n, 2 * many // n)),
            "break_busy_share": 0.25,
            "break_soon_share": 0.375,
            "break_step": ("break_step", [3600.0, 7200.0]),
            "break_blocks": ("break_step", [n, n // 2]),
            "break_fano": ("break_step", [4.0, 6.5]),
            "break_allan": ("break_step", [2.0, 0.0]),
            "burst_size": ("burst", [30, 70]),
            "burst_duration": ("burst", [3600.0, 7200.0]),
            "break_neighbour_ratio": ("break_window", [np.nan, 1.5, 3.25]),
            "break_mean_event": ("break_window", [np.nan, 4.0, 8.0]),
            "break_random_event": ("break_window", [np.nan, 1.0, 2.0]),
            "break_event_elements": ("break_event", [1, 3, 12]),
            "bond_stress_count": (("normal", "shear"), rng.random((76, 50)), envelope),
            "normal": ("normal", np.linspace(-1.01, 0.49, 76)),
            "shear": ("shear", np.linspace(0.01, 0.99, 50)),
        },
        attrs={"deformation": "Take care."},
    )


@pytest.mark.parametrize("periods", [("all", "run"), ("all", "1982-01", "1982-02", "1982-03")])
def test_a_long_run_has_all_figures(periods: tuple[str, ...]):
    found = list(analysis_figures(made(40, periods, 5000), datetime(1982, 1, 1)))
    assert {name for name, _, _ in found} == NAMES
    captions = {name: text for name, text, _ in found}
    assert "β(1): run 0.20 ± 0.01" in captions["motion_scaling"]
    assert "β(q) ≈ 0.00 q² + 0.20 q" in captions["motion_scaling"].replace("-0.00", "0.00")
    assert "diagnostics, no bars" in captions["motion_scaling"]
    assert "Take care." in captions["motion_scaling"]
    assert "1.20 %" in captions["motion_wind"] and "a = 2.40 ± 0.20" in captions["floe_sizes_end"]
    assert all(text.endswith((".", ")")) and "nan" not in text for text in captions.values())
    assert "10 % of the ice" in captions["motion_features"]
    assert "20 km for each 10,000 km²" in captions["motion_features"]
    assert "half of them in 25 % of the time" in captions["bonds_events"]
    assert "38 % of the breaks come in the first 12.5 % of a window" in captions["bonds_events"]
    assert "the largest of 12 elements" in captions["bonds_events"]
    assert "2.4 times as often as by chance" in captions["bonds_events"]
    assert b"<svg" in as_svg(found[0][2])


def test_a_few_points_are_no_figure():
    data = made(3, ("all", "run"), 90).drop_vars(["scaling_exponent", "floe_diameter_end"])
    found = [name for name, _, _ in analysis_figures(data, datetime(1982, 1, 1))]
    assert found == ["ice_thickness_distribution", "motion_wind", "bonds_stress"]


def test_the_envelope_is_that_of_the_law():
    """The tip is the tensile strength; crushing ends it (docs/theory/contact.md)."""
    normal, shear = envelope(0.2, np.radians(30.0))
    assert (normal[0], shear[0]) == (0.2, 0.0) and normal[1] == -1.0
    assert shear[1] == pytest.approx(1.2 * np.tan(np.radians(30.0)))


def test_numbers_of_motion_name_their_source():
    facts = motion_facts(made(3, ("all", "run"), 0))
    assert [round(fact.value, 2) for fact in facts] == [1.2, 0.69]
    assert all(fact.source.startswith("analyses.nc: wind_") for fact in facts)
    assert motion_facts(xr.Dataset()) == []


def test_numbers_of_breaks_name_their_source():
    facts = break_facts(made(8, ("all", "run"), 0))
    assert [fact.value for fact in facts] == [25.0, 37.5, 4.0, 6.5, 70.0, 12, 3.25]
    assert "intervals of 1 h" in facts[2].label and "lasted 2 h" in facts[4].label
    assert [fact.source.split(": ")[1] for fact in facts] == [
        "break_busy_share", "break_soon_share", "break_fano", "break_fano", "burst_size",
        "break_event_elements", "break_neighbour_ratio",
    ]  # fmt: skip
    assert break_facts(xr.Dataset()) == []
