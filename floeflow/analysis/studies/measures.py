# SPDX-License-Identifier: GPL-2.0-or-later
"""The measures in which runs are compared, by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Norm:
    """A norm: its label with unit, and what it is divided by to be relative."""

    label: str
    scale: str = ""


NORMS: Mapping[str, Norm] = {
    "drift": Norm("Position of the elements (m, rms)", "drift"),
    "volume": Norm("Ice volume per area of sea (m)", "volume"),
    "area": Norm("Share of the sea under ice (1)", "area"),
    "siconc": Norm("Concentration on the grid (1, rms)", "siconc"),
    "sithick": Norm("Thickness on the grid (m, rms)", "sithick"),
    "bonds": Norm("Number of broken bonds (relative)"),
    "bonds_elsewhere": Norm("Broken bonds that broke in one run only (share)"),
    "deformation": Norm("Total deformation (relative)"),
}
# Those that a recommendation must keep: they converge. Where bonds break is chaotic.
KEPT = ("drift", "volume", "area")
