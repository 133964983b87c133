# SPDX-License-Identifier: GPL-2.0-or-later
"""Registry of effects: the single source of what a scene may ask for and what that adds.

A scene names its effects. What it does not name is absent: no rule in the workflow, no switch in
the plugin, no variable in the state file, no figure in the report. Every stage asks this registry
instead of keeping a list of its own.

A new effect is one entry here. The dimensionless number that says when it matters stands in the
entry where it is a product or ratio of the scene's conditions; one that takes more is a function of
``floeflow/analysis/estimate/dimensionless_numbers.py``. ``docs/effects.md`` is generated from both.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from floeflow.core.errors import FloeError
from floeflow.core.extensions import load_extensions


@dataclass(frozen=True)
class Number:
    """The dimensionless number of an effect: near or above 1 it matters, far below it does not.

    Parameters
    ----------
    meaning : str
        Its formula and what that compares, without a full stop.
    value : callable
        Of the scene's conditions (`floeflow.analysis.estimate.conditions.Conditions`), 1; nan where
        no estimate can tell.
    """

    meaning: str
    value: Callable[[Any], float]


def no_number(why: str) -> Number:
    """Stands for a number where no estimate can tell when the effect matters.

    Parameters
    ----------
    why : str
        Said after "None:", without a full stop.

    Returns
    -------
    Number
        nan for all conditions.
    """
    return Number(f"None: {why}", lambda _conditions: math.nan)


def ratio(part: float, whole: float) -> float:
    """Quotient of two quantities that are not negative.

    Parameters
    ----------
    part, whole : float
        In the same unit.

    Returns
    -------
    float
        1; where `whole` is 0 infinite, or 0 if `part` is 0 too.
    """
    return part / whole if whole > 0 else (math.inf if part > 0 else 0.0)


@dataclass(frozen=True)
class Effect:
    """One physical effect and what it adds at each stage.

    Parameters
    ----------
    name : str
        The name by which a scene asks for it.
    physics : str
        One line of physics.
    source : str
        Where the equation comes from.
    needs : tuple of str
        Effects without which it makes no sense.
    plugin : tuple of str
        Switches it sets in the LIGGGHTS plugin.
    ledger : tuple of str
        Sums of the plugin that it adds to a window's budget; an ``impulse_`` has two components.
    column : tuple of str
        Processes it adds to the column.
    forcing : tuple of str
        Forcing variables it reads.
    state : tuple of str
        Variables it adds to the state.
    with_state : tuple of (str, tuple of str)
        Variables it adds to the state where another effect is named too.
    output : tuple of str
        Variables it adds to the gridded output.
    diagnostics : tuple of str
        Series it adds to the diagnostics.
    rules : tuple of str
        Rules it adds to the workflow.
    figures : tuple of str
        How the names of the figures begin that it adds to the report.
    excludes : tuple of str
        Effects beside which it makes no sense.
    number : Number, optional
        Says when it matters; where absent, `dimensionless_numbers` has a function of its name.
    """

    name: str
    physics: str
    source: str
    needs: tuple[str, ...] = ()
    plugin: tuple[str, ...] = ()
    ledger: tuple[str, ...] = ()
    column: tuple[str, ...] = ()
    forcing: tuple[str, ...] = ()
    state: tuple[str, ...] = ()
    with_state: tuple[tuple[str, tuple[str, ...]], ...] = ()
    output: tuple[str, ...] = ()
    diagnostics: tuple[str, ...] = ()
    rules: tuple[str, ...] = ()
    figures: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()
    number: Number | None = None


_BOND_STATE = (
    "bond_id_lo",
    "bond_id_hi",
    "bond_length",
    "bond_span",
    "bond_thickness",
    "bond_crack_a",
    "bond_crack_b",
    "bond_lo_ax",
    "bond_lo_ay",
    "bond_lo_bx",
    "bond_lo_by",
    "bond_hi_ax",
    "bond_hi_ay",
    "bond_hi_bx",
    "bond_hi_by",
)

_RIDGE_STATE = ("contact_ridge_closing", "contact_ridge_thickness", "contact_ridge_length")

_WALL_STATE = (
    *(f"wall_face_{name}" for name in ("wall", "plane", "before", "after")),
    *(f"wall_face_{name}" for name in ("ax", "ay", "bx", "by", "u", "v")),
    *("wall_contact_id", "wall_contact_face", "wall_contact_slip", "wall_contact_rest_overlap"),
)

LEVEL_STATE = (
    "level_area",
    "level_volume",
    "pond_area",
    "pond_depth",
    "pond_lid",
    "lid_snow",
    "lid_share",
)

_REGISTERED = (
    Effect(
        name="wind",
        physics="Quadratic wind stress on the ice-covered part of each element.",
        source="Hibler 1979; Turner et al. 2022",
        plugin=("wind",),
        ledger=("impulse_wind", "work_wind"),
        forcing=("wind_u", "wind_v"),
        diagnostics=("impulse_wind",),
        number=Number(
            "N U_a / U_w: free drift by the wind over the current's speed",
            lambda c: ratio(c.nansen * c.wind, c.current),
        ),
    ),
    Effect(
        name="ocean_drag",
        physics="Quadratic drag against the current, fully implicit, and drag on the spin.",
        source="Hibler 1979; Turner et al. 2022",
        plugin=("ocean_drag",),
        ledger=("impulse_ocean", "work_ocean"),
        forcing=("ocean_u", "ocean_v"),
        diagnostics=("impulse_ocean",),
        number=Number(
            "T ρ_w C_w U / (ρ_i h): the run over the time in which the ocean's drag acts",
            lambda c: c.seconds * c.drag_rate,
        ),
    ),
    Effect(
        name="turning_angle",
        physics="Ocean drag turned by the angle of the boundary layer below the ice.",
        source="McPhee 1975; Hibler 1979",
        needs=("ocean_drag",),
        plugin=("turning_angle",),
        # Its sign is that of the Coriolis parameter.
        forcing=("coriolis",),
    ),
    Effect(
        name="coriolis",
        physics="Coriolis acceleration -f k x u, a rotation that keeps the speed.",
        source="Cayley form of the rotation",
        plugin=("coriolis",),
        ledger=("impulse_coriolis", "work_coriolis"),
        forcing=("coriolis",),
        diagnostics=("impulse_coriolis",),
        number=Number(
            "ρ_i h f / (ρ_w C_w U): Coriolis force over ocean drag",
            lambda c: ratio(abs(c.coriolis), c.drag_rate),
        ),
    ),
    Effect(
        name="tilt",
        physics="Slope of the sea surface from the geostrophic current, m f k x u_w.",
        source="Hibler 1979",
        plugin=("tilt",),
        ledger=("impulse_tilt", "work_tilt"),
        forcing=("ocean_u", "ocean_v", "coriolis"),
        diagnostics=("impulse_tilt",),
        number=Number(
            "ρ_i h f U_w / τ_a: slope of the sea over wind stress",
            lambda c: ratio(c.mass * abs(c.coriolis) * c.current, c.wind_stress),
        ),
    ),
    Effect(
        name="grounding",
        physics="Keels of ridges reach the seabed and hold the ice: landfast ice in shallow water.",
        source="Lemieux et al. 2015",
        plugin=("seabed",),
        ledger=("impulse_seabed", "dissipation_seabed"),
        forcing=("sea_floor_depth",),
        diagnostics=("impulse_seabed",),
        number=Number(
            "Share of the ice that the seabed can hold against the mean wind",
            lambda c: c.grounded_share,
        ),
    ),
    Effect(
        name="friction",
        physics="Coulomb friction with history where unbonded elements touch.",
        source="Cundall & Strack 1979",
        plugin=("friction",),
        ledger=("dissipation_friction",),
    ),
    Effect(
        name="bonds",
        physics="Glue lines between neighbours that crack from their ends (Mohr-Coulomb).",
        source="Hopkins, Frankenstein & Thorndike 2004",
        plugin=("bonds",),
        ledger=("dissipation_bond", "dissipation_fracture"),
        state=_BOND_STATE,
        output=("damage",),
        diagnostics=("intact_bonds",),
        rules=("bonds",),
        figures=("elements_bonds", "series_bonds"),
    ),
    Effect(
        name="coast",
        physics="Closed lines around the land, which push back, rub and let no ice pass.",
        source="The contact laws against a rigid partner",
        state=_WALL_STATE,
        with_state=(("ridging", tuple(f"wall_{name}" for name in _RIDGE_STATE)),),
        diagnostics=("impulse_coast", "coast_ashore"),
    ),
    Effect(
        name="ridging",
        physics="Plastic contacts: pressed elements lose area to ridges and keep their ice volume.",
        source="Hopkins 1994, 1996; Turner et al. 2022",
        plugin=("ridging",),
        ledger=("dissipation_ridging",),
        state=_RIDGE_STATE,
        diagnostics=("ridged_area", "merge_elements"),
    ),
    Effect(
        name="refreeze",
        physics="Elements in touch in cold air freeze together; bonds grow thicker from thin.",
        source="Stefan's law; Hopkins & Thorndike 2006",
        needs=("bonds", "thermodynamics"),
        forcing=("air_temperature",),
        state=("contact_touch_time",),
        diagnostics=("bonds_refrozen",),
    ),
    Effect(
        name="walls",
        physics="Rigid walls, also moving ones: sides of the scene, planes, triangle meshes.",
        source="The contact laws against a rigid partner",
        state=_WALL_STATE,
        with_state=(("ridging", tuple(f"wall_{name}" for name in _RIDGE_STATE)),),
        diagnostics=("impulse_wall",),
        figures=("series_walls",),
    ),
    Effect(
        name="thermodynamics",
        physics="Ice conducts heat, grows at its bottom and melts at both sides, between windows.",
        source="Semtner 1976; Bitz & Lipscomb 1999; Turner, Hunke & Bitz 2013",
        column=("vertical",),
        forcing=(
            "wind_u",
            "wind_v",
            "air_temperature",
            "specific_humidity",
            "air_pressure",
            "longwave_down",
            "ocean_heat_flux",
        ),
        state=("surface_temperature", "ice_enthalpy", "ice_salinity"),
        output=("sitemptop",),
        diagnostics=("ice_growth",),
        figures=("budget_column",),
    ),
    Effect(
        name="snow",
        physics="Snow falls on the ice, insulates, brightens, melts, and floods.",
        source="Maykut & Untersteiner 1971; Hunke et al. 2015",
        needs=("thermodynamics",),
        column=("snow",),
        forcing=("snowfall",),
        state=("snow_volume", "snow_enthalpy"),
        output=("sisnthick",),
        diagnostics=("snow_volume",),
        figures=("series_snow", "budget_snow_volume"),
    ),
    Effect(
        name="shortwave",
        physics="The sun warms ice, snow and leads, with albedo and, in layers, light inside.",
        source="Briegleb et al. 2004 (CCSM3)",
        needs=("thermodynamics",),
        column=("shortwave",),
        forcing=("shortwave_down",),
    ),
    Effect(
        name="ponds",
        physics="Melt water gathers in ponds on level ice, drains, flushes salt, and freezes over.",
        source="Hunke, Hebert & Lecomte 2013",
        needs=("thermodynamics", "shortwave"),
        column=("ponds",),
        state=LEVEL_STATE,
        output=("sirdgconc", "sirdgthick", "simpconc"),
        diagnostics=("pond_water",),
        figures=("budget_column_pond",),
    ),
    Effect(
        name="lateral_melt",
        physics="Warm water melts the sides of floes: area goes, thickness stays.",
        source="Maykut & Perovich 1987; Steele 1992",
        needs=("thermodynamics",),
        column=("lateral_melt",),
    ),
    Effect(
        name="frazil",
        physics="Open water that loses heat at its freezing point makes new ice.",
        source="Hibler 1979; Hunke et al. 2015",
        needs=("thermodynamics",),
        column=("frazil",),
    ),
    Effect(
        name="mixed_layer",
        physics="A mixed layer on the grid stores heat and salt: water cools before it freezes.",
        source="Hunke et al. 2015; Maykut & McPhee 1995",
        needs=("thermodynamics",),
        column=("mixed_layer",),
        state=("sea_temperature", "pending_freeze", "sea_salinity", "deep_salinity"),
        diagnostics=("sea_heat", "sea_salt"),
    ),
    Effect(
        name="sea_relaxation",
        physics="The mixed layer is drawn to a given sea surface temperature in a given time.",
        source="Haney 1971",
        needs=("mixed_layer",),
        forcing=("sea_surface_temperature",),
    ),
    Effect(
        name="redistribution",
        physics="Ridging takes thin ice first and piles it up in thick categories.",
        source="Thorndike et al. 1975; Hibler 1980; Lipscomb et al. 2007",
        needs=("ridging", "thermodynamics"),
        column=("redistribution",),
    ),
    Effect(
        name="rims",
        physics="Ice that leaves the rectangle is exported, by side; ice flows in where asked.",
        source="what the elements hold",
        diagnostics=("export_ice_area", "export_ice_volume"),
        number=Number(
            "U T / L: drift over the width of the ice, which is what reaches a side",
            lambda c: ratio(c.slip * c.seconds, c.fetch),
        ),
    ),
    Effect(
        name="gates",
        physics="Area and volume of the ice that passes lines, such as Fram Strait.",
        source="parts of discs beyond a line",
        diagnostics=("gate_area", "gate_volume"),
        number=no_number("it changes no result; name it where ice that passes is to be counted"),
    ),
    Effect(
        name="periodic",
        physics="The rectangle repeats itself: bonds and contacts reach across its sides.",
        source="Allen & Tildesley 2017, section 1.6.2",
        excludes=("coast", "refreeze", "mixed_layer", "rims", "gates", "remap", "merge"),
        # Elements that leave come in again, so places do not tell how far they went.
        state=("drift_x", "drift_y"),
        number=no_number("it says what lies beyond the sides, which no estimate can tell"),
    ),
    Effect(
        name="grid_output",
        physics="Fields of the ice on the scene's grid at each window boundary, as CF NetCDF.",
        source="shares of area, balanced: Sinkhorn & Knopp 1967",
        rules=("fields", "grid"),
        number=no_number("it changes no result; name it where fields on a grid are wanted"),
    ),
    Effect(
        name="trajectory_output",
        physics="Paths of the elements at the window boundaries, for OVITO and MDAnalysis.",
        source="LAMMPS dump format",
        rules=("trajectory_files",),
        number=no_number("it changes no result; name it where paths are wanted"),
    ),
    Effect(
        name="internal_stress",
        physics="Stress in the ice and its force, from contacts, bonds and walls: for fields.",
        source="Love 1927; Bagi 1996",
        state=("internal_force_x", "internal_force_y", "stress_xx", "stress_yy", "stress_xy"),
        number=no_number("it changes no result; name it where stresses in the ice are wanted"),
    ),
    Effect(
        name="ice_age",
        physics="Age of the ice since it froze on open water, or since the start: for fields.",
        source="Hunke et al. 2015",
        state=("ice_age",),
        number=no_number("it changes no result; name it where the age of the ice is wanted"),
    ),
    Effect(
        name="remap",
        physics="Distorted elements are replaced by fresh ones that hold the same, conservatively.",
        source="Turner et al. 2022, GMD 15, 1953; Zalesak 1979; Levine & Peres 2009",
        excludes=("walls",),
        state=("cell_corners", "corner_x", "corner_y", "drift_x", "drift_y"),
        diagnostics=("remap_done", "remap_overlap"),
        rules=("cells",),
        number=Number(
            "N |∇u_a| T: shear of the pack over the run; elements are distorted at 1",
            lambda c: c.nansen * c.wind_gradient * c.seconds,
        ),
    ),
    Effect(
        name="merge",
        physics="Elements that became too small join their largest neighbour.",
        source="Turner et al. 2018 (DEMSI)",
        diagnostics=("merge_elements",),
        number=Number(
            "ε: share of the area that closes, which makes elements too small",
            lambda c: c.closing,
        ),
    ),
)

EFFECTS: dict[str, Effect] = {effect.name: effect for effect in _REGISTERED}


def add_effect(effect: Effect) -> None:
    """Register an effect, from an extension (`floeflow.core.extensions`) for instance.

    Parameters
    ----------
    effect : Effect
        It comes after those that are there.

    Raises
    ------
    ValueError
        Where its name is taken, or it needs or excludes what is not there.
    """
    lost = [name for name in (*effect.needs, *effect.excludes) if name not in EFFECTS]
    if effect.name in EFFECTS or lost:
        fault = f"names '{lost[0]}', which is no effect" if lost else "is there already"
        raise ValueError(f"the effect '{effect.name}' {fault}")
    EFFECTS[effect.name] = effect


def known_effects() -> dict[str, Effect]:
    """All effects by name, those of extensions included."""
    load_extensions()
    return EFFECTS


# Variables that only some column schemes have; the others of an effect come with every scheme.
SCHEME_STATE: dict[str, tuple[str, ...]] = {
    "ice_enthalpy": ("bl99", "mushy"),
    "snow_enthalpy": ("bl99", "mushy"),
    "ice_salinity": ("mushy",),
    **dict.fromkeys(LEVEL_STATE, ("bl99", "mushy")),
}


def check_effects(names: Iterable[str]) -> tuple[str, ...]:
    """Return the named effects in the registry's order.

    Parameters
    ----------
    names : iterable of str
        Of effects, as a scene names them.

    Returns
    -------
    tuple of str
        The same names.

    Raises
    ------
    FloeError
        For a name that is unknown (with the nearest valid one), named twice, or whose needs
        are not named.
    """
    names = list(names)
    for name in names:
        if name not in EFFECTS:
            near = get_close_matches(name, EFFECTS, n=1)
            hint = f"did you mean '{near[0]}'?" if near else "known are " + ", ".join(EFFECTS)
            raise FloeError(f"effects: unknown effect '{name}'; {hint}")
        if names.count(name) > 1:
            raise FloeError(f"effects: '{name}' is listed twice")
        for other in EFFECTS[name].excludes:
            if other in names:
                raise FloeError(f"effects: '{name}' and '{other}' cannot be used together")
        for need in EFFECTS[name].needs:
            if need not in names:
                raise FloeError(f"effects: '{name}' requires '{need}', which is not listed")
    return tuple(name for name in EFFECTS if name in names)


def compatible(names: Iterable[str], first: str = "") -> tuple[str, ...]:
    """Those effects, in the registry's order, that none before them excludes; ``first`` stays.

    Parameters
    ----------
    names : iterable of str
        Effects.
    first : str, optional
        Effect that is kept whatever it excludes.

    Returns
    -------
    tuple of str
        Without those that are excluded.
    """
    names, kept = set(names), [first] if first else list[str]()
    for name in EFFECTS:
        clash = (other for other in kept if name in EFFECTS[other].excludes)
        if name in names and not set(EFFECTS[name].excludes) & set(kept) and not any(clash):
            kept.append(name)
    return tuple(name for name in EFFECTS if name in kept)


def _collect(field: str, names: Iterable[str]) -> tuple[str, ...]:
    found = (item for name in names for item in getattr(EFFECTS[name], field))
    return tuple(dict.fromkeys(found))


def plugin_switches(names: Iterable[str]) -> tuple[str, ...]:
    """Switches of the LIGGGHTS plugin that these effects set.

    Parameters
    ----------
    names : iterable of str
        Of effects.

    Returns
    -------
    tuple of str
        Each once.
    """
    return _collect("plugin", names)


def ledger_sums(names: Iterable[str]) -> tuple[str, ...]:
    """Sums of the plugin that these effects add to a window's budget, components apart.

    Parameters
    ----------
    names : iterable of str
        Of effects.

    Returns
    -------
    tuple of str
        Each once; an impulse as its components ``_x`` and ``_y``.
    """
    return tuple(
        f"{name}{axis}"
        for name in _collect("ledger", names)
        for axis in (("_x", "_y") if name.startswith("impulse_") else ("",))
    )


def forcing_variables(names: Iterable[str]) -> tuple[str, ...]:
    """Forcing variables that these effects read.

    Parameters
    ----------
    names : iterable of str
        Of effects.

    Returns
    -------
    tuple of str
        Each once.
    """
    return _collect("forcing", names)


def state_variables(names: Iterable[str], scheme: str = "zero_layer") -> tuple[str, ...]:
    """Variables that these effects add to the state under a column scheme.

    Parameters
    ----------
    names : iterable of str
        Effects.
    scheme : str, optional
        Of the column.

    Returns
    -------
    tuple of str
        Without what all states have.
    """
    names = tuple(names)
    both = (
        variable
        for name in names
        for other, variables in EFFECTS[name].with_state
        if other in names
        for variable in variables
    )
    found = dict.fromkeys((*_collect("state", names), *both))
    return tuple(name for name in found if scheme in SCHEME_STATE.get(name, (scheme,)))


def diagnostic_series(names: Iterable[str]) -> tuple[str, ...]:
    """Series that these effects add to the diagnostics.

    Parameters
    ----------
    names : iterable of str
        Of effects.

    Returns
    -------
    tuple of str
        Each once.
    """
    return _collect("diagnostics", names)


# What a column knows of the mixed layer below it. In a run it comes from the sea on the scene's
# grid, and goes back there.
SEA_VARIABLES = ("sea_temperature", "pending_freeze")
# Every column has these; its effects add the others.
_COLUMN_STATE = ("ice_fraction", "ice_volume")


def _column_effects(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(name for name in names if EFFECTS[name].column)


def column_processes(names: Iterable[str]) -> tuple[str, ...]:
    """Processes that these effects add to the column.

    Parameters
    ----------
    names : iterable of str
        Of effects.

    Returns
    -------
    tuple of str
        Each once.
    """
    return _collect("column", names)


def column_variables(names: Iterable[str], scheme: str) -> tuple[str, ...]:
    """Variables that a column reads and writes under these effects; see `SEA_VARIABLES`.

    Parameters
    ----------
    names : iterable of str
        Effects.
    scheme : str
        Of the column.

    Returns
    -------
    tuple of str
        Names of the state's schema.
    """
    grid = EFFECTS["mixed_layer"].state
    found = _COLUMN_STATE + state_variables(_column_effects(names), scheme)
    return tuple(name for name in found if name not in grid or name in SEA_VARIABLES)


def column_forcing_variables(names: Iterable[str]) -> tuple[str, ...]:
    """Forcing variables that the columns read under these effects.

    Parameters
    ----------
    names : iterable of str
        Of effects.

    Returns
    -------
    tuple of str
        Each once.
    """
    return forcing_variables(_column_effects(names))
