# SPDX-License-Identifier: GPL-2.0-or-later
"""What the discrete element model needs to know: law parameters, switches, forcing, in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Literal

import numpy as np

from floeflow.core.constants import AIR_DENSITY, CONTACT_SHEAR_RATIO, SEAWATER_DENSITY
from floeflow.core.errors import FloeError
from floeflow.core.period import Period, sides
from floeflow.scene.blocks import Dynamics
from floeflow.state.bonds import CONTACT_COLUMNS, RIDGE_COLUMNS

FIXED = 2  # type of elements that never move
# What is not given is as in a scene that does not name it.
_SCENE = Dynamics()
# Fields of the forcing that do not change in time.
STEADY = ("coriolis", "sea_floor_depth")
VELOCITIES = ("wind_u", "wind_v", "ocean_u", "ocean_v")


@dataclass(frozen=True)
class Force:
    """A force of `fix floe/integrate` beyond wind, water and the rotation of the earth.

    Parameters
    ----------
    switch : str
        The keyword that turns it on.
    settings : tuple of (str, float)
        Further keywords and their values, in the plugin's units.
    fields : tuple of str
        Fields of the forcing that it reads.
    """

    switch: str
    settings: tuple[tuple[str, float], ...] = ()
    fields: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name, value in self.settings:
            if not math.isfinite(value):
                raise FloeError(f"{name} must be finite, not {value}.")

    @property
    def words(self) -> str:
        """Keywords and values of the LIGGGHTS command."""
        values = (f" {name} {float(value)!r}" for name, value in self.settings)
        return f" {self.switch} yes" + "".join(values)


@dataclass(frozen=True)
class EngineParams:
    """Parameters of laws and integrator; angles in radians, everything else in SI units.

    Parameters
    ----------
    time_step : float
        s.
    bonds, friction, ridging, wind, ocean_drag, coriolis, tilt : bool
        Switches; what is off is not computed.
    young_modulus, poisson_ratio, bond_damping : float
        Bonds: Pa, 1, share of critical damping.
    strength : {"constant", "kovacs_sodhi"}
        Compressive strength of bonds: constant, or 1285 kPa (h / 1 m)^(2/3).
    compressive_strength, tensile_share, friction_angle : float
        Pa (where constant), tensile over compressive strength, rad.
    contact_modulus, contact_shear_ratio, contact_damping, friction_coefficient : float
        Unbonded contact: Pa, tangential over normal stiffness, share of critical damping, 1.
    ridge_force, ridge_hardening, ridge_thickness : float
        Ridging force per contact length and ridge thickness, N/m2; its growth with closing per
        squared thickness, N/m4; thickness from which on ice crushes instead, m.
    lead_softening : float
        Ridging force falls by exp(-lead_softening (1 - cover)) with open water.
    wind_stress_factor, ocean_stress_factor : float
        Density times drag coefficient of air and of water, kg/m3.
    turning_angle : float
        By which the ocean drag is turned, rad: to the left where the Coriolis parameter is
        positive, to the right where it is negative.
    forces : tuple of Force
        Further forces of the integrator.
    relative_wind : bool
        Wind stress from the wind relative to the ice.
    fixed_contacts : bool
        Whether ice touches fixed elements; else it only bonds with them, and walls hold it.
    walls : bool
        Whether there are walls: the critical step counts them.
    deterministic : bool
        Sums of forces that do not depend on the order of pairs, nor on the number of ranks.
    exact_losses : bool
        Losses of damping to second order in the step instead of first, at some cost.
    skin : float, optional
        Extra distance of the neighbour lists, m; chosen from speed and step where absent.
    reach : float, optional
        Neighbours are kept up to this multiple of the sum of radii; from what a bond survives
        where absent.
    period : tuple of float, optional
        Bounds (m) of a rectangle that repeats itself (`floeflow.core.period`); absent: the plane
        has no ends.
    """

    time_step: float
    bonds: bool = False
    friction: bool = True
    ridging: bool = False
    wind: bool = False
    ocean_drag: bool = False
    coriolis: bool = False
    tilt: bool = False
    young_modulus: float = _SCENE.young_modulus
    poisson_ratio: float = _SCENE.poisson_ratio
    bond_damping: float = _SCENE.bond_damping
    strength: Literal["constant", "kovacs_sodhi"] = _SCENE.strength
    compressive_strength: float = _SCENE.compressive_strength
    tensile_share: float = _SCENE.tensile_share
    friction_angle: float = math.radians(_SCENE.friction_angle)
    contact_modulus: float = _SCENE.contact_modulus
    contact_shear_ratio: float = CONTACT_SHEAR_RATIO
    contact_damping: float = _SCENE.contact_damping
    friction_coefficient: float = _SCENE.friction_coefficient
    ridge_force: float = _SCENE.ridge_force
    ridge_hardening: float = _SCENE.ridge_hardening
    ridge_thickness: float = _SCENE.ridge_thickness
    lead_softening: float = _SCENE.lead_softening
    wind_stress_factor: float = AIR_DENSITY * _SCENE.air_drag
    ocean_stress_factor: float = SEAWATER_DENSITY * _SCENE.ocean_drag
    turning_angle: float = 0.0
    forces: tuple[Force, ...] = ()
    relative_wind: bool = False
    fixed_contacts: bool = True
    walls: bool = False
    deterministic: bool = False
    exact_losses: bool = False
    skin: float | None = None
    reach: float | None = None
    period: Period | None = None

    def __post_init__(self) -> None:
        positive = {
            "time_step",
            "young_modulus",
            "compressive_strength",
            "friction_angle",
            "contact_modulus",
            "contact_shear_ratio",
            "ridge_force",
            "ridge_thickness",
            "skin",
        }
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, bool | str | tuple) or value is None:
                continue
            # NumPy's scalars do not print as the plain numbers that LIGGGHTS reads.
            object.__setattr__(self, item.name, float(value))
            if not math.isfinite(value):
                raise FloeError(f"{item.name} must be finite, not {value}.")
            if item.name in positive and value <= 0:
                raise FloeError(f"{item.name} must be above 0, not {value}.")
            if item.name != "turning_angle" and value < 0:
                raise FloeError(f"{item.name} must not be negative, not {value}.")
        if self.period is not None:
            _check_period(self.period)
        if self.poisson_ratio >= 0.5:
            raise FloeError(f"poisson_ratio must be below 0.5, not {self.poisson_ratio}.")
        if self.friction_angle >= math.pi / 2:
            raise FloeError(f"friction_angle must be below pi/2, not {self.friction_angle}.")
        if abs(self.turning_angle) >= math.pi / 2:
            raise FloeError(f"turning_angle must lie within +-pi/2, not {self.turning_angle}.")
        if self.reach is not None and self.reach < 1:
            raise FloeError(f"reach must be at least 1, not {self.reach}.")
        if self.strength not in ("constant", "kovacs_sodhi"):
            raise FloeError(f"strength must be constant or kovacs_sodhi, not {self.strength}.")

    @property
    def shear_modulus(self) -> float:
        """Shear modulus of bonds, Pa."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    def bond_strength(self, thickness: np.ndarray) -> np.ndarray:
        """Compressive strength of bonds of a thickness (m), Pa (Kovacs & Sodhi, if chosen).

        Parameters
        ----------
        thickness : ndarray
            Of the bonds (m), (n,).

        Returns
        -------
        ndarray
            Pa, (n,).
        """
        if self.strength == "kovacs_sodhi":
            return 1285.0e3 * np.asarray(thickness) ** (2.0 / 3.0)
        return np.full(np.shape(thickness), self.compressive_strength)

    @property
    def contact_columns(self) -> tuple[str, ...]:
        """Columns of the contact table besides the ids."""
        return (*CONTACT_COLUMNS, *RIDGE_COLUMNS) if self.ridging else CONTACT_COLUMNS

    @property
    def external(self) -> tuple[str, ...]:
        """Names of the forcing fields that the switches need."""
        names: set[str] = set()
        if self.wind:
            names |= {"wind_u", "wind_v"}
        if self.ocean_drag or self.tilt:
            names |= {"ocean_u", "ocean_v"}
        if self.coriolis or self.tilt or self.turning_angle:
            names |= {"coriolis"}
        for force in self.forces:
            names |= set(force.fields)
        return tuple(sorted(names))

    def pair_style(self, reach: float) -> str:
        """LIGGGHTS command that sets the pair style up.

        Parameters
        ----------
        reach : float
            Distance up to which neighbours are kept (m).

        Returns
        -------
        str
            One line; angles in degrees, everything else in SI units.
        """
        strength = (
            "kovacs_sodhi" if self.strength == "kovacs_sodhi" else repr(self.compressive_strength)
        )
        return (
            f"pair_style gran model floe bonds {_yes(self.bonds)} friction {_yes(self.friction)}"
            f" ridging {_yes(self.ridging)} ridge_force {self.ridge_force!r}"
            f" ridge_hardening {self.ridge_hardening!r} ridge_thickness {self.ridge_thickness!r}"
            f" lead_softening {self.lead_softening!r}"
            f" bond_young {self.young_modulus!r} poisson {self.poisson_ratio!r}"
            f" bond_damping {self.bond_damping!r} compressive_strength {strength}"
            f" tensile_share {self.tensile_share!r}"
            f" friction_angle {math.degrees(self.friction_angle)!r}"
            f" contact_young {self.contact_modulus!r}"
            f" contact_shear_ratio {self.contact_shear_ratio!r}"
            f" contact_damping {self.contact_damping!r}"
            f" friction_coefficient {self.friction_coefficient!r} reach {reach!r}"
            f" fixed_contacts {_yes(self.fixed_contacts)}"
            f" deterministic {_yes(self.deterministic)} exact_losses {_yes(self.exact_losses)}"
        )

    def fix_style(self) -> str:
        """LIGGGHTS command that sets the integrator up."""
        return (
            f"fix motion all floe/integrate fused yes stop_at_fault no wind {_yes(self.wind)}"
            f" wind_relative {_yes(self.relative_wind)} ocean_drag {_yes(self.ocean_drag)}"
            f" coriolis {_yes(self.coriolis)} tilt {_yes(self.tilt)}"
            f" air_drag {self.wind_stress_factor!r} water_drag {self.ocean_stress_factor!r}"
            f" turning_angle {math.degrees(self.turning_angle)!r}"
            + "".join(force.words for force in self.forces)
        )


def _check_period(period: Period) -> None:
    whole = [math.isfinite(side) for side in sides(period)]
    bounds = list(zip(period[:2], period[2:], whole, strict=True))
    if not any(whole) or not all(low < high for low, high, _ in bounds):
        raise FloeError(f"period must be west, south, east and north edges, not {period}.")


def _yes(flag: bool) -> str:
    return "yes" if flag else "no"


@dataclass(frozen=True)
class Forcing:
    """Wind, current and Coriolis parameter on a regular grid.

    Parameters
    ----------
    time : ndarray, shape (nt,)
        s, ascending; a single time holds always.
    x, y : ndarray, shapes (nx,), (ny,)
        Grid axes, m, equally spaced and ascending. Outside of them the edge holds.
    fields : dict of ndarray
        wind_u, wind_v, ocean_u, ocean_v (m/s), shape (nt, ny, nx); coriolis (1/s) and
        sea_floor_depth (m), shape (ny, nx). Only those that the switches need.
    over_discs : bool
        Whether elements meet means over their discs, else what is at their centres.
    wind_stress : bool
        Whether what lies between nodes and times, and means over discs, are those of the wind's
        stress |w| w, else of its velocity.
    """

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    fields: dict[str, np.ndarray] = field(default_factory=dict)
    over_discs: bool = False
    wind_stress: bool = False

    def packed(self, needed: tuple[str, ...]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Arrays for the plugin: velocities (nt, ny, nx, 4) and what is `STEADY`, (ny, nx) each.

        Parameters
        ----------
        needed : tuple of str
            Names of the fields that the switches read.

        Returns
        -------
        velocities : ndarray
            wind_u, wind_v, ocean_u and ocean_v (m/s), (nt, ny, nx, 4); 0 where a field is not
            needed.
        steady : dict of ndarray
            Fields of `STEADY` by name, (ny, nx); coriolis is always there.

        Raises
        ------
        FloeError
            If a field is missing, has a wrong shape or is not finite, or an axis is not regular.
        """
        nt, ny, nx = len(self.time), len(self.y), len(self.x)
        for name in ("time", "x", "y"):
            axis = np.asarray(getattr(self, name), dtype=float)
            if len(axis) == 0 or not np.isfinite(axis).all() or (np.diff(axis) <= 0).any():
                raise FloeError(f"The forcing's {name} axis must be finite and ascending.")
            if name != "time" and len(axis) > 2:
                gaps = np.diff(axis)
                if np.ptp(gaps) > 1e-6 * gaps.mean():
                    raise FloeError(f"The forcing's {name} axis must be equally spaced.")
        for name in needed:
            shape = (ny, nx) if name in STEADY else (nt, ny, nx)
            if name not in self.fields:
                raise FloeError(f"The forcing has no {name}, which the scene's effects need.")
            values = np.asarray(self.fields[name])
            if values.shape != shape:
                raise FloeError(
                    f"The forcing's {name} has the shape {values.shape} instead of {shape}."
                )
            if not np.isfinite(values).all():
                raise FloeError(f"The forcing's {name} is not finite everywhere.")
        velocity = np.zeros((nt, ny, nx, 4))
        for k, name in enumerate(VELOCITIES):
            if name in needed:
                velocity[..., k] = self.fields[name]
        if self.wind_stress:
            velocity[..., :2] *= np.hypot(velocity[..., 0], velocity[..., 1])[..., None]
        steady = {
            name: np.array(self.fields[name], dtype=float, order="C")
            for name in STEADY
            if name in needed
        }
        return velocity, {"coriolis": np.zeros((ny, nx)), **steady}
