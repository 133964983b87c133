# SPDX-License-Identifier: GPL-2.0-or-later
"""Every key of a scene: unit, default, allowed values and a line of help.

The models below are the single source. The loader validates with them; ``config/README.md``,
``config/default.yaml`` and the JSON schema are generated from them (``floeflow.scene.docs``).
"""

from __future__ import annotations

import math
from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr, StringConstraints, WithJsonSchema, model_validator

from floeflow.core.period import Period
from floeflow.scene.block import Block, key
from floeflow.scene.effects import EFFECTS
from floeflow.scene.physics import ColumnPhysics
from floeflow.scene.softness import softened

# A plus sign stands in the names of studies' variants, which no user gives.
PlainName = Annotated[
    str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}(\+[a-z0-9_-]{1,127})?$")
]


EffectNames = Annotated[
    tuple[str, ...],
    WithJsonSchema(
        {"anyOf": [{"const": "auto"}, {"type": "array", "items": {"enum": list(EFFECTS)}}]}
    ),
]


# No projection of the earth reaches further (m).
FARTHEST = 2.0e8
Place = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
# Nothing in air, sea or ice is faster (m/s).
Speed = Annotated[float, Field(ge=-100, le=100)]
Velocity = tuple[Speed, Speed]


class Domain(Block):
    """Where the scene is: a rectangle in projected metres and its grid."""

    crs: str = key("EPSG:6931", "Projected coordinate system in metres (pyproj name).")
    x_min: float = key(-4.0e6, "Left edge of the scene.", "m", ge=-FARTHEST, le=FARTHEST)
    x_max: float = key(4.0e6, "Right edge of the scene.", "m", ge=-FARTHEST, le=FARTHEST)
    y_min: float = key(-4.0e6, "Lower edge of the scene.", "m", ge=-FARTHEST, le=FARTHEST)
    y_max: float = key(4.0e6, "Upper edge of the scene.", "m", ge=-FARTHEST, le=FARTHEST)
    spacing: float = key(
        1.0e5, "Cell size of the scene grid (forcing, gridded output).", "m", ge=0.01
    )


class Flags(Block):
    """Stored numbers of a mask that are no concentration, for files that do not say so."""

    land: tuple[int, ...] = key((), "Numbers that mean land or coast.")
    pole_hole: tuple[int, ...] = key((), "Numbers that mean the satellite's hole at the pole.")
    missing: tuple[int, ...] = key((), "Numbers that mean no data.")
    water: tuple[int, ...] = key((), "Numbers that mean open water.")


class Labels(Block):
    """A labelled image of floes, which then is the mask (read with packing.generator floes)."""

    file: str = key(
        "",
        "GeoTIFF, PNG or NetCDF file whose pixels hold the number of their floe, 0 for none; path "
        "from the project's folder.",
    )
    variable: str = key("", "Variable of a NetCDF file; empty: the only one on two dimensions.")
    crs: str = key("", "Projection of an image that does not say its own (pyproj name).")
    pixel: float = key(
        0.0,
        "Side of a pixel of an image that does not say where it lies: its upper left corner is the "
        "scene's.",
        "m",
        ge=0,
    )


class Mask(Block):
    """Where there is ice, how much, and where there is land."""

    file: str = key(
        "data/oisst_arctic_1981-12-31.nc",
        "File with ice concentration, path from the project's folder: NetCDF, Zarr, GRIB, GeoTIFF, "
        "PNG, or NSIDC's binary.",
    )
    crs: str = key(
        "", "Projection of x and y in a file that names none (pyproj name); empty: the file's."
    )
    flags: Flags = key(Flags(), "Stored numbers that are no concentration.")
    scale: float = key(
        0.0,
        "Share of ice that 1 in the file means, as in a PNG of bare counts, or where units are not "
        "to be trusted; 0: as its units say.",
        "1",
        ge=0,
    )
    days_off: float = key(
        16.0, "A mask further from the scene's start than this is refused.", "day", ge=0
    )
    concentration: str = key(
        "",
        "Name of the concentration variable; empty: the one with standard_name "
        "sea_ice_area_fraction.",
    )
    thickness: str = key("", "Name of the ice thickness variable (m); empty: see thickness_rule.")
    thickness_is: Literal["", "in_ice", "cell_mean"] = key(
        "",
        "What that thickness is: of the ice where there is any, or ice volume over the cell's "
        "area; empty: as its cell_methods, names and long_name say.",
    )
    water: str = key(
        "",
        "Name of a variable that is there on all water and missing on land (such as the sea "
        "surface temperature): where it is there but concentration is missing, the water is open.",
    )
    fill_reach: float = key(
        3.0e5,
        "Missing concentration takes the nearest known one up to this far; beyond it there is "
        "no ice.",
        "m",
        ge=0,
    )
    refine: int = key(4, "Mask cells per cell of the scene grid, each way.", ge=1, le=32)
    minimum_concentration: float = key(
        0.15, "Cells with less ice than this count as open water.", "1", ge=0, lt=1
    )
    land: Literal["global_land_mask", "mask", "none"] = key(
        "global_land_mask",
        "Land from the 1 km mask of global-land-mask, from missing values of the mask, or none.",
    )
    land_fraction: float = key(
        0.5, "Mask cells with more land than this are land.", "1", gt=0, lt=1
    )
    thickness_rule: Literal["constant", "concentration", "climatology"] = key(
        "concentration",
        "Thickness where the file has none: ice_thickness everywhere, or times concentration; or "
        "a table by place and month (docs/masks.md) times concentration.",
    )
    ice_thickness: float = key(2.0, "Ice thickness at full concentration.", "m", gt=0, le=20)
    thickness_distribution: Literal["single", "gamma"] = key(
        "single",
        "Thickness of the ice within an element at the start: the mean everywhere, or a gamma "
        "distribution about it, whose thickest part is ridged (docs/masks.md; read with "
        "thermodynamics, column.categories above 1).",
    )
    snow_thickness: float = key(
        0.2, "Snow on the ice at the start (read with thermodynamics).", "m", ge=0, le=5
    )
    lead_ice: float = key(
        0.0,
        "Thickness of the young ice on the leads of ice of 80 % and more at the start, which "
        "radiometers take for water in winter; 0: open leads (read with thermodynamics).",
        "m",
        ge=0,
        le=0.3,
    )
    level_share: float = key(
        1.0,
        "Share of the ice's area that no ridge covers at the start (read with ponds, which lie on "
        "it).",
        "1",
        ge=0,
        le=1,
    )
    labels: Labels = key(Labels(), "Labelled image of floes.")
    uniform: float = key(
        0.0, "Concentration of all water, instead of a file; 0: the file.", "1", ge=0, le=1
    )
    region: str = key(
        "",
        "Ice is kept inside of this only: a named sea (docs/masks.md) or a GeoJSON file or "
        "shapefile (.shp) of polygons, path from the project's folder.",
    )
    shoreline: str = key(
        "",
        "GeoJSON file or shapefile (.shp) of polygons that are land too, path from the project's "
        "folder.",
    )


class Sizes(Block):
    """Where elements are smaller than elsewhere, and how much they differ among themselves."""

    coast: float = key(
        1.0, "Size of elements at the coast, as a share of that far away.", "1", gt=0, le=1
    )
    edge: float = key(
        1.0, "Size of elements at the ice edge, as a share of that far away.", "1", gt=0, le=1
    )
    across: float = key(
        0.0, "Elements across a strait, as many at least; 0: not asked for.", "1", ge=0, le=100
    )
    polygons: str = key(
        "",
        "GeoJSON file of polygons with a property `size`: the size of elements in each, as a share "
        "of that far away.",
    )
    reach: float = key(
        3.0e5, "Elements grow from coast, edge or polygon to full size over this.", "m", gt=0
    )
    smallest: float = key(
        0.1, "No element is smaller than this share of those far away.", "1", gt=0, le=1
    )
    spread: float = key(
        0.0,
        "Spread of sizes of neighbours: standard deviation of the logarithm of the diameter.",
        "1",
        ge=0,
        le=0.4,
    )


class Discs(Block):
    """Whole floes as discs (read with packing.generator dense)."""

    sizes: Literal["equal", "bidisperse", "lognormal", "power_law"] = key(
        "lognormal", "Distribution of the radii."
    )
    ratio: float = key(1.4, "Radius of the larger half over that of the smaller.", "1", ge=1, le=5)
    spread: float = key(
        0.3, "Standard deviation of the logarithm of lognormal radii.", "1", ge=0, le=1
    )
    exponent: float = key(
        3.0, "Of a power law: floes of radius r are in number as r to minus this.", "1", ge=0, le=6
    )
    smallest: float = key(
        0.5, "Lower cut-off, over the median radius, or of the power law.", "1", gt=0, lt=1
    )
    largest: float = key(
        2.0, "Upper cut-off, over the median radius, or of the power law.", "1", gt=1, le=20
    )
    fill: float = key(
        0.8,
        "Largest share of the plane that discs fill; random packs jam near 0.84 (two sizes).",
        "1",
        gt=0,
        le=0.88,
    )
    overlap: float = key(
        1.0e-3, "Largest overlap after compaction, over two radii.", "1", ge=1e-6, le=0.05
    )


class Packing(Block):
    """How the ice is cut into elements."""

    generator: Literal["tessellation", "dense", "floes"] = key(
        "tessellation",
        "Cells that fill the ice, discs packed densely, or the floes of a labelled image.",
    )
    elements: int = key(5000, "Number of elements to aim at.", ge=1, le=2_000_000)
    relaxations: int = key(20, "Lloyd relaxations of the first points.", ge=0, le=1000)
    size: Sizes = key(Sizes(), "Sizes of the elements of a tessellation.")
    discs: Discs = key(Discs(), "Whole floes of a dense pack.")
    bond_gap: float = key(
        0.2,
        "Neighbours bond where the gap of their discs is under this share of their radii's sum.",
        "1",
        ge=0,
        le=1,
    )
    bond_concentration: float = key(
        0.8, "Elements with less ice than this are floes apart: no bonds.", "1", ge=0, le=1
    )
    coast_bonds: bool = key(
        False, "Fast ice: elements beside the coast are frozen to it, and refreeze to it."
    )


class Cyclone(Block):
    """A travelling cyclone of Rankine form."""

    wind_speed: float = key(15.0, "Largest wind of the cyclone.", "m/s", ge=0, le=80)
    radius: float = key(
        6.0e5, "Distance of the largest wind from the centre.", "m", gt=0, le=FARTHEST
    )
    x: Place = key(-1.5e6, "Place of the centre at the start.", "m")
    y: Place = key(-5.0e5, "Place of the centre at the start.", "m")
    u: Speed = key(5.0, "Speed of the centre.", "m/s")
    v: Speed = key(1.0, "Speed of the centre.", "m/s")
    inflow_angle: float = key(20.0, "Turn of the wind towards the centre.", "degree", ge=0, le=90)


class Gyre(Block):
    """A steady gyre in the ocean."""

    current_speed: float = key(0.08, "Largest current of the gyre.", "m/s", ge=0, le=3)
    radius: float = key(
        6.0e5, "Distance of the largest current from the centre.", "m", gt=0, le=FARTHEST
    )
    x: Place = key(-9.0e5, "Centre of the gyre.", "m")
    y: Place = key(1.0e6, "Centre of the gyre.", "m")
    clockwise: bool = key(True, "Turns clockwise, as the Beaufort Gyre does.")


class Weather(Block):
    """Uniform weather for the column."""

    air_temperature: float = key(248.15, "Air temperature.", "K", ge=180, le=330)
    relative_humidity: float = key(0.9, "Relative humidity over ice.", "1", ge=0, le=1)
    air_pressure: float = key(101000.0, "Air pressure.", "Pa", ge=80000, le=110000)
    shortwave_down: float = key(0.0, "Short-wave radiation.", "W/m2", ge=0, le=1400)
    longwave_down: float = key(170.0, "Long-wave radiation.", "W/m2", ge=0, le=600)
    snowfall: float = key(2.0e-6, "Snowfall.", "kg/m2/s", ge=0, le=0.01)
    ocean_heat_flux: float = key(2.0, "Heat from the ocean to the ice.", "W/m2", ge=0, le=1000)
    sea_surface_temperature: float = key(
        271.35,
        "Temperature to which the sea is drawn (effect sea_relaxation).",
        "K",
        ge=265,
        le=310,
    )


class Climatology(Block):
    """A synthetic year from monthly tables (read with source climatology)."""

    seed: int = key(1, "Seed of the storms.", ge=0, lt=2**32)
    storminess: float = key(1.0, "Factor of the number of storms; 0: none.", "1", ge=0, le=5)
    temperature_offset: float = key(0.0, "Added to the air's temperature.", "K", ge=-30, le=30)


class Fallback(Block):
    """What stands in for quantities that none of the forcing files has."""

    wind: Literal["", "rest", "cyclone", "climatology"] = key(
        "",
        "Wind without a file: none, the analytic cyclone, or the synthetic year's; empty: refused.",
    )
    ocean: Literal["", "rest", "gyre", "climatology"] = key(
        "",
        "Current without a file: none, the analytic gyre, or the synthetic year's; empty: refused.",
    )
    weather: Literal["", "weather", "climatology"] = key(
        "",
        "Weather and sea without a file: those of forcing.weather, or the synthetic year's; empty: "
        "refused.",
    )


class Forcing(Block):
    """Wind, current and weather: analytic, or from files of the user."""

    source: Literal["analytic", "file", "climatology"] = key(
        "analytic",
        "Written from cyclone, gyre and weather; read from file; or a synthetic year of monthly "
        "tables and storms (docs/climatology.md).",
    )
    file: str = key("", "CF file with the forcing, path from the project's folder.")
    files: tuple[str, ...] = key(
        (),
        "Further files or patterns of files (era5_*.nc, archives of ERA5 too): each quantity comes "
        "from the first that has it, its times from all that have it.",
    )
    fallback: Fallback = key(Fallback(), "What stands in for quantities that no file has.")
    crs: str = key(
        "", "Projection of x and y in files that name none (pyproj name); empty: the files'."
    )
    days_off: float = key(
        31.0,
        "A field of one time further from the scene's start than this is refused.",
        "day",
        ge=0,
    )
    accumulation: Literal["", "hour", "step", "day"] = key(
        "",
        "Interval of sums over time: the hour up to a record (ERA5), the step between records, or "
        "the day so far (ERA5-Land); empty: hourly records, each of its hour.",
    )
    step: float = key(21600.0, "Time between fields that are not read from a file.", "s", gt=0)
    at: Literal["centre", "cell"] = key(
        "centre",
        "What elements meet of wind, current and weather: what is at their centres, or the means "
        "over their discs, at some cost (docs/forcing.md).",
    )
    wind_mean: Literal["velocity", "stress"] = key(
        "velocity",
        "What means of the wind and what lies between its points keep: its velocity, or its stress "
        "(speed times velocity), which gusts and turns within a cell raise.",
    )
    cyclone: Cyclone = key(Cyclone(), "Wind of the analytic forcing.")
    gyre: Gyre = key(Gyre(), "Current of the analytic forcing.")
    weather: Weather = key(Weather(), "Weather of the analytic forcing.")
    climatology: Climatology = key(Climatology(), "The synthetic year.")


class Time(Block):
    """When, and in how many coupling windows."""

    start: datetime = key(datetime(1981, 12, 31), "Start of the scene (UTC).")
    windows: int = key(5, "Number of coupling windows.", ge=1, le=100_000)
    window: float = key(86400.0, "Length of a coupling window.", "s", gt=0, le=3.2e7)


class Dynamics(Block):
    """The discrete element model."""

    step_share: float = key(0.65, "Time step as a share of the critical one.", "1", gt=0, le=10)
    allow_unstable_step: bool = key(
        False, "Allow a step_share above 1, at which ice may blow up; the run warns."
    )
    stiffness: Literal["auto", "full"] = key(
        "auto",
        "auto: moduli that are not named are as low as they may be (docs/theory/contact.md); full: "
        "those of sea ice.",
    )
    young_modulus: float = key(
        1.5e7,
        "Young's modulus of the ice in bonds; where not named: auto 150 times the compressive "
        "strength, full 1e9.",
        "Pa",
        derived=True,
        ge=1e3,
        le=1e12,
    )
    poisson_ratio: float = key(0.3, "Poisson's ratio of the ice.", "1", ge=0, lt=0.5)
    contact_modulus: float = key(
        2.0e7,
        "Modulus of unbonded contact; where not named: auto 200 times the compressive strength, "
        "full 1e8.",
        "Pa",
        derived=True,
        ge=1e3,
        le=1e12,
    )
    friction_coefficient: float = key(0.3, "Coulomb friction of ice on ice.", "1", ge=0, le=2)
    contact_damping: float = key(
        0.3, "Damping of unbonded contact, as a share of critical.", "1", ge=0, le=2
    )
    ridge_force: float = key(
        26126.0,
        "Ridging force per contact length and ridge thickness, thin ice.",
        "N/m2",
        gt=0,
        le=1e12,
    )
    ridge_hardening: float = key(
        928.0,
        "Growth of that force with closing, per ridge thickness squared.",
        "N/m4",
        ge=0,
        le=1e12,
    )
    ridge_thickness: float = key(
        0.3,
        "Ridge thickness from which on ice is crushed (compressive_strength).",
        "m",
        gt=0,
        le=1e3,
    )
    lead_softening: float = key(
        20.0,
        "Open water weakens ridging: by exp(-20 (1 - a)) where ice covers the share a; 0: not.",
        "1",
        ge=0,
        le=100,
    )
    refreeze_time: float = key(
        86400.0, "Elements in touch in freezing air for so long freeze together.", "s", gt=0
    )
    refreeze_temperature: float = key(
        263.15, "Air colder than this freezes elements together.", "K", ge=200, le=271.35
    )
    refreeze_thickness: float = key(0.05, "Thickness of a new bond.", "m", gt=0, le=1)
    bond_damping: float = key(0.1, "Damping of bonds, as a share of critical.", "1", ge=0, le=2)
    strength: Literal["constant", "kovacs_sodhi"] = key(
        "constant", "Compressive strength: constant, or 1285 kPa (h / 1 m)^(2/3)."
    )
    compressive_strength: float = key(1.0e5, "Compressive strength of a bond.", "Pa", gt=0, le=1e9)
    tensile_share: float = key(
        0.2, "Tensile strength as a share of the compressive.", "1", gt=0, le=1
    )
    friction_angle: float = key(
        35.0, "Angle of internal friction (Mohr-Coulomb).", "degree", gt=0, lt=90
    )
    air_drag: float = key(1.2e-3, "Drag coefficient of the air.", "1", ge=0, le=0.1)
    ocean_drag: float = key(5.5e-3, "Drag coefficient of the ocean.", "1", ge=0, le=0.1)
    turning_angle: float = key(
        25.0,
        "Turning angle of the ocean drag, to the left of the current in the northern hemisphere "
        "and to its right in the southern (read with turning_angle).",
        "degree",
        ge=-90,
        le=90,
    )
    relative_wind: bool = key(False, "Wind stress from the wind relative to the ice.")
    minimum_thickness: float = key(
        5.0e-2,
        "Elements with less ice than this move as if they had this much.",
        "m",
        ge=1e-4,
        le=0.1,
    )
    deterministic: bool = key(
        False,
        "The same bits on any number of MPI ranks: forces add up without round-off, at some cost.",
    )
    exact_losses: bool = key(
        False, "Losses of damping to second order in the step, for energy budgets, at some cost."
    )
    samples: int = key(24, "Samples of the time series in a window.", ge=1, le=10_000)

    @model_validator(mode="before")
    @classmethod
    def _soften(cls, data: Any) -> Any:
        return softened(data) if isinstance(data, dict) else data


# Part of a vector of any length, and places on the earth (degree).
Normal = Annotated[float, Field(ge=-1e6, le=1e6)]
Longitude = Annotated[float, Field(ge=-360, le=360)]
Latitude = Annotated[float, Field(ge=-90, le=90)]


class Walls(Block):
    """Walls that hold the ice in (read with the effect walls). They move from time 0 on."""

    rim: tuple[Literal["left", "right", "bottom", "top"], ...] = key(
        ("left", "right", "bottom", "top"), "Sides of the scene's rectangle that are walls."
    )
    left_velocity: Velocity = key((0.0, 0.0), "Velocity of that wall in x and y.", "m/s")
    right_velocity: Velocity = key((0.0, 0.0), "Velocity of that wall in x and y.", "m/s")
    bottom_velocity: Velocity = key((0.0, 0.0), "Velocity of that wall in x and y.", "m/s")
    top_velocity: Velocity = key((0.0, 0.0), "Velocity of that wall in x and y.", "m/s")
    planes: tuple[tuple[Place, Place, Normal, Normal, Speed, Speed], ...] = key(
        (),
        "Further endless walls, each as [x, y, normal_x, normal_y, u, v]: a point, the side of the "
        "ice, a velocity.",
        "m, 1, m/s",
    )
    mesh: str = key(
        "",
        "Triangle mesh (STL) that stands in the ice as a wall, path from the project's folder; its "
        "z = 0 is the plane of the ice.",
    )
    mesh_velocity: Velocity = key((0.0, 0.0), "Velocity of the mesh in x and y.", "m/s")

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each wall, in their order."""
        planes = (f"plane_{number}" for number in range(1, len(self.planes) + 1))
        return (*self.rim, *planes, *(("mesh",) if self.mesh else ()))


class Column(Block):
    """Thermodynamics of the elements' columns."""

    scheme: Literal["zero_layer", "bl99", "mushy"] = key(
        "zero_layer",
        "Vertical thermodynamics: no heat stored, Bitz and Lipscomb 1999, or mush with salt.",
    )
    categories: int = key(1, "Thickness categories of each element.", ge=1, le=20)
    light: Literal["ccsm3", "delta_eddington"] = key(
        "ccsm3", "Light in snow and ice (bl99, mushy): of CCSM3, or of many directions."
    )
    variant: Literal["convergent", "icepack"] = key(
        "convergent",
        "Ponds, flushing and light in melting layers (bl99, mushy) in a form that converges with "
        "step, layers and categories; or as in Icepack, to compare (docs/theory/column_ponds.md).",
    )
    layers: int = key(7, "Layers of ice (bl99, mushy).", ge=2, le=50)
    step: float = key(3600.0, "Longest time step of the column.", "s", ge=1)
    splitting: Literal["after", "around"] = key(
        "after",
        "Column after the dynamics of each window (first order in the window), or half before and "
        "half after (Strang, second order).",
    )
    new_ice_thickness: float = key(
        0.1, "Thickness at which new ice gathers in open water.", "m", gt=0, le=1
    )
    ocean_salinity: float = key(
        34.0, "Salinity of the ocean (sets its freezing point).", "1e-3", ge=0, le=45
    )
    mixed_layer_depth: float = key(
        20.0, "Depth of the sea that an element warms and cools.", "m", ge=1, le=500
    )
    initial_surface: float = key(
        258.15, "Temperature of the ice's surface at the start (bl99, mushy).", "K", ge=200, le=273
    )


class Sea(Block):
    """The mixed layer on the scene's grid (read with the effect mixed_layer)."""

    file: str = key(
        "",
        "NetCDF file with the sea's temperature and salinity at the start, path from the project's "
        "folder; empty: mask.file.",
    )
    temperature: str = key(
        "",
        "Name of the sea surface temperature variable; empty: the only one with standard_name "
        "sea_surface_temperature; where there is none the sea starts at its freezing point.",
    )
    salinity: str = key(
        "",
        "Name of the sea surface salinity variable; empty: the only one with standard_name "
        "sea_surface_salinity, else column.ocean_salinity.",
    )
    salinity_time: float = key(
        2.592e6,
        "Time in which water from below renews the layer's salinity; 0: it does not.",
        "s",
        ge=0,
    )
    relaxation_time: float = key(
        2.592e6,
        "Time in which the layer is drawn to the given temperature (read with sea_relaxation).",
        "s",
        gt=0,
    )


class Rims(Block):
    """The sides of the scene's rectangle (read with the effect rims)."""

    inflow: tuple[Literal["left", "right", "bottom", "top"], ...] = key(
        (), "Sides beyond which the ice of the mask goes on, and from which it flows in."
    )


class Periodic(Block):
    """A rectangle that repeats itself (read with the effect periodic)."""

    axes: tuple[Literal["x", "y"], ...] = key(
        ("x", "y"), "Along which axes; sides across the others are open, or walls.", min_length=1
    )


class Gates(Block):
    """Lines over which passing ice is counted (read with the effect gates)."""

    names: tuple[PlainName, ...] = key((), "A name for each gate.")
    lines: tuple[tuple[Longitude, Latitude, Longitude, Latitude], ...] = key(
        (),
        "Ends of each gate as [longitude, latitude, longitude, latitude]; what passes to the "
        "right, as seen from the first end to the second, counts as positive.",
        "degree",
    )


class Grounding(Block):
    """Ridges whose keels reach the seabed hold the ice (effect grounding)."""

    file: str = key(
        "",
        "File with the depth of the sea, or the height of the ground (below 0 at sea); path from "
        "the project's folder; empty: depth.",
    )
    variable: str = key(
        "", "Its variable; empty: the one whose standard_name or common name is that of a depth."
    )
    crs: str = key("", "Projection of x and y in a file that names none (pyproj name).")
    depth: float = key(
        0.0, "Depth of the sea everywhere, where no file is named.", "m", ge=0, le=12_000
    )
    keel_ratio: float = key(
        8.0,
        "Depth that keels reach, over the mean thickness of ice that covers all (k1 of Lemieux et "
        "al. 2015).",
        "1",
        gt=0,
        le=100,
    )
    strength: float = key(
        15.0,
        "Largest seabed stress for each metre of mean thickness above the critical one (k2).",
        "N/m3",
        ge=0,
        le=1e4,
    )
    creep: float = key(5.0e-5, "Speed at which half of that stress acts (u0).", "m/s", gt=0, le=1.0)
    openness: float = key(
        20.0, "Open water weakens the stress: by exp(-20 (1 - A)) at concentration A.", "1", ge=0
    )


class Remap(Block):
    """When distorted elements are replaced by fresh ones (effect remap)."""

    every: int = key(0, "Remap at the end of every n-th window; 0: only by overlap.", ge=0)
    order: Literal[1, 2] = key(
        2, "Order of the transfer: 1 donor cells, 2 limited linear slopes in the elements."
    )
    overlap: float = key(
        0.05, "Remap where elements overlap by more than this share of their area.", "1", ge=0
    )


class Merge(Block):
    """When elements join their largest neighbour (effect merge)."""

    radius: float = key(
        0.5, "Elements of a radius under this share of the mean one are merged.", "1", gt=0, lt=1
    )


class State(Block):
    """How the state is kept between windows."""

    precision: Literal["double", "single"] = key(
        "double",
        "Precision of floating variables in state files; single: half the size, budgets close to "
        "1e-7. Places, areas and the sea's temperature stay double.",
    )
    keep: Literal["chunks", "all"] = key(
        "chunks",
        "Which states stay: those at the ends of chunks (see workflow.windows_per_job), or all. "
        "Elements, series and fields of every window stay in any case.",
    )


class Grid(Block):
    """How fields of the elements go to the scene grid (effect grid_output)."""

    transfer: Literal["conservative", "mls", "shepard", "nearest"] = key(
        "conservative",
        "Moving least squares moved to the elements' totals; or, totals open: moving least "
        "squares, Shepard's average, the nearest element.",
    )


class Report(Block):
    """What the report shows."""

    title: str = key("", "Title of the report; empty: the scene's name.")
    text: str = key("", "A paragraph about the scene.")
    dpi: int = key(110, "Resolution of the figures.", "1/inch", ge=50, le=400)
    maximum_velocity: float = key(
        0.0, "Top of the drift speed colour scale; 0: from the data.", "m/s", ge=0
    )


class Exchange(Block):
    """What goes back to models of ocean and atmosphere."""

    fluxes: bool = key(
        False,
        "Write what each window gives to ocean and air on the scene grid: fluxes/<chunk>.nc.",
    )


class Workflow(Block):
    """How the run is cut into jobs; changes no result."""

    windows_per_job: int = key(
        60, "Windows of a chunk: one launch, one file of series, elements and fields.", ge=1
    )


class Scene(Block):
    """A scene: where, when, which ice, which forcing, which effects, how accurate."""

    name: PlainName = key(..., "Plain name of the scene, also its folder under results/.")
    effects: EffectNames = key(
        (
            "wind",
            "ocean_drag",
            "coriolis",
            "tilt",
            "friction",
            "bonds",
            "coast",
            "thermodynamics",
            "snow",
            "shortwave",
            "lateral_melt",
            "frazil",
            "grid_output",
        ),
        "Effects to simulate; what is not named is absent. Or `auto`: see docs/effects.md.",
    )
    seed: int = key(1981, "Seed of everything random.", ge=0, lt=2**32)
    domain: Domain = key(Domain(), "Where.")
    mask: Mask = key(Mask(), "Which ice.")
    packing: Packing = key(Packing(), "Which elements.")
    forcing: Forcing = key(Forcing(), "Which forcing.")
    time: Time = key(Time(), "When.")
    dynamics: Dynamics = key(Dynamics(), "Which mechanics.")
    walls: Walls = key(Walls(), "Which walls.")
    column: Column = key(Column(), "Which thermodynamics.")
    physics: ColumnPhysics = key(ColumnPhysics(), "Which constants of the columns.")
    sea: Sea = key(Sea(), "Which sea.")
    rims: Rims = key(Rims(), "What happens at the sides of the rectangle.")
    periodic: Periodic = key(Periodic(), "Where the rectangle repeats itself.")
    gates: Gates = key(Gates(), "Where passing ice is counted.")
    grounding: Grounding = key(Grounding(), "Where ridges reach the seabed.")
    remap: Remap = key(Remap(), "When elements are remapped.")
    merge: Merge = key(Merge(), "When elements are merged.")
    state: State = key(State(), "How the state is kept.")
    grid: Grid = key(Grid(), "How fields go to the grid.")
    report: Report = key(Report(), "Which report.")
    exchange: Exchange = key(Exchange(), "What goes back to other models.")
    workflow: Workflow = key(Workflow(), "How the run is cut into jobs.")
    _auto: bool = PrivateAttr(default=False)

    @property
    def period(self) -> Period | None:
        """Bounds of the rectangle that repeats itself, or None (`floeflow.core.period`)."""
        if "periodic" not in self.effects:
            return None
        low, high = (
            [
                getattr(self.domain, f"{axis}_{end}") if axis in self.periodic.axes else infinite
                for axis in ("x", "y")
            ]
            for end, infinite in (("min", -math.inf), ("max", math.inf))
        )
        return low[0], low[1], high[0], high[1]

    @property
    def auto(self) -> bool:
        """Whether the effects were chosen by ``effects: auto``."""
        return self._auto
