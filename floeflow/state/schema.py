# SPDX-License-Identifier: GPL-2.0-or-later
"""Schema of the state: every variable with dimensions, type, unit and meaning.

The state holds all there is at a window boundary and is the restart. Element arrays are sorted by
``id``; bonds and contacts by (``id_lo``, ``id_hi``). Lower id first everywhere, so that each pair
has one form on any number of ranks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.scene.effects import EFFECTS, SCHEME_STATE, state_variables
from floeflow.state.attributes import check_attributes
from floeflow.state.migrations import SCHEMA_VERSION

MOBILE, COAST = 1, 2


@dataclass(frozen=True)
class Variable:
    """One variable of the state.

    Parameters
    ----------
    dims, dtype, units, long_name
        As in the file.
    low, high : float
        Bounds of the values.
    kind : str
        For transfers: an ``extensive`` variable is an amount and is added up, an ``intensive`` one
        is a property of an amount and is averaged over it. Empty for what is neither: labels,
        places, pairs.
    of : str
        Of an intensive variable: what it is a property of. Another variable, or ``mass``.
        Transfers keep the ratio of its amount to that one's within the bounds of their sources:
        thickness (ice_volume of ice_fraction) among them.
    per : str
        By which amount a value has to be multiplied to give this variable's amount; ``of``, if
        empty. Volumes are of the ice, but are kept per effective area: with ``area`` here a value
        falls where an element's area grows by open water.
    """

    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    low: float = -np.inf
    high: float = np.inf
    kind: Literal["", "extensive", "intensive"] = ""
    of: str = ""
    per: str = ""


# Sum of an element's ice and snow; no variable of its own, but velocities are properties of it.
MASS = "mass"


def _element(
    units: str,
    text: str,
    low: float = -np.inf,
    high: float = np.inf,
    of: str = "",
    extensive: bool = False,
    per: str = "",
) -> Variable:
    kind: Literal["", "extensive", "intensive"] = "intensive" if of else ""
    kind = "extensive" if extensive else kind
    return Variable(("element",), "float64", units, text, low, high, kind, of, per)


def _column(
    units: str, text: str, of: str, low: float = 0.0, high: float = np.inf, per: str = ""
) -> Variable:
    dims = ("element", "category")
    return Variable(dims, "float64", units, text, low, high, "intensive", of, per)


def _layers(material: str, units: str, text: str, of: str, low: float, high: float) -> Variable:
    dims = ("element", "category", f"{material}_layer")
    return Variable(dims, "float64", units, text, low, high, "intensive", of)


def _sea(units: str, text: str, low: float, high: float = np.inf) -> Variable:
    return Variable(("sea_y", "sea_x"), "float64", units, text, low, high)


def _corner(text: str) -> Variable:
    return Variable(("corner",), "float64", "m", text)


def _bond(units: str, text: str, low: float = -np.inf, high: float = np.inf) -> Variable:
    return Variable(("bond",), "float64", units, text, low, high)


def _contact(units: str, text: str, low: float = -np.inf) -> Variable:
    return Variable(("contact",), "float64", units, text, low)


def _face(units: str, text: str) -> Variable:
    return Variable(("wall_face",), "float64", units, text)


def _face_number(text: str, low: float, high: float = np.inf) -> Variable:
    return Variable(("wall_face",), "int64", "1", text, low, high)


def _wall_contact(units: str, text: str, low: float = -np.inf) -> Variable:
    return Variable(("wall_contact",), "float64", units, text, low)


VARIABLES: dict[str, Variable] = {
    "id": Variable(("element",), "int64", "1", "identity of the element, from 1", 1),
    "type": Variable(("element",), "int8", "1", "1 mobile ice, 2 fixed coast", 1, 2),
    "x": _element("m", "position in the scene's projection"),
    "y": _element("m", "position in the scene's projection"),
    "theta": _element("rad", "orientation, anticlockwise since the start"),
    "u": _element("m s-1", "velocity along x", of=MASS),
    "v": _element("m s-1", "velocity along y", of=MASS),
    "omega": _element("rad s-1", "spin, anticlockwise", of=MASS),
    "radius": _element("m", "radius of the disc", 0),
    "area": _element(
        "m2", "effective area: the ocean area that the element stands for", 0, extensive=True
    ),
    "ice_fraction": _column(
        "1", "share of the effective area under ice, per category", of="area", low=0, high=1
    ),
    "ice_volume": _column(
        "m", "ice volume per effective area, per category", of="ice_fraction", per="area"
    ),
    "snow_volume": _column(
        "m", "snow volume per effective area, per category", of="ice_fraction", per="area"
    ),
    "surface_temperature": _column(
        "K", "temperature of the ice's or snow's surface", of="ice_fraction", low=100, high=350
    ),
    "ice_enthalpy": _layers(
        "ice", "J m-3", "energy of ice layers against water at 0 degC", "ice_volume", -2e9, 2e8
    ),
    "ice_salinity": _layers(
        "ice", "1e-3", "bulk salinity of ice layers, top first", "ice_volume", 0, 300
    ),
    "snow_enthalpy": _layers(
        "snow", "J m-3", "energy of snow layers against water at 0 degC", "snow_volume", -2e9, 0
    ),
    "level_area": _column(
        "1", "share of the ice's area that is level", of="ice_fraction", low=0, high=1
    ),
    "level_volume": _column(
        "1", "share of the ice's volume that is level", of="ice_volume", low=0, high=1
    ),
    "pond_area": _column("1", "share of the level ice under ponds", of="level_area", high=1),
    "pond_depth": _column("m", "depth of the ponds' water", of="pond_area"),
    "pond_lid": _column("m", "thickness of the ice on ponds", of="pond_area"),
    "lid_snow": _column("m", "snow on the ice less snow on lids", "ice_fraction", -20.0),
    "lid_share": _column("1", "share of the surface's heat that melted lids", of="ice_fraction"),
    "sea_temperature": _sea("K", "temperature of the mixed layer", 255, 330),
    "pending_freeze": _sea("J m-2", "heat that it lacks and of which ice will be made", 0),
    "sea_salinity": _sea("1e-3", "salinity of the mixed layer", 0, 60),
    "deep_salinity": _sea("1e-3", "salinity of the water below it", 0, 60),
    "cell_corners": Variable(("element",), "int64", "1", "corners of the element's outline", 0),
    "drift_x": _element("m", "net displacement of the ice since the start", of="area"),
    "drift_y": _element("m", "net displacement of the ice since the start", of="area"),
    "internal_force_x": _element(
        "N m-2", "force of neighbours and walls along x per effective area", of="area"
    ),
    "internal_force_y": _element(
        "N m-2", "force of neighbours and walls along y per effective area", of="area"
    ),
    "stress_xx": _element("N m-1", "stress in the plane, above 0 in tension", of="area"),
    "stress_yy": _element("N m-1", "stress in the plane, above 0 in tension", of="area"),
    "stress_xy": _element("N m-1", "shear stress in the plane", of="area"),
    "ice_age": _element("s", "age of the ice, mean over its mass", 0, of=MASS),
    "corner_x": _corner("corner of an outline, element after element, in its body frame"),
    "corner_y": _corner("corner of an outline, element after element, in its body frame"),
    "bond_id_lo": Variable(("bond",), "int64", "1", "lower id of the bonded pair", 1),
    "bond_id_hi": Variable(("bond",), "int64", "1", "higher id of the bonded pair", 1),
    "bond_length": _bond("m", "length of the glue line", 0),
    "bond_span": _bond("m", "distance of the centres when the bond was made", 0),
    "bond_thickness": _bond("m", "ice thickness of the bond", 0),
    "bond_crack_a": _bond("1", "crack from end a, as a share of the length", 0, 1),
    "bond_crack_b": _bond("1", "crack from end b, as a share of the length", 0, 1),
    "bond_lo_ax": _bond("m", "end a of the glue line in the body frame of id_lo"),
    "bond_lo_ay": _bond("m", "end a of the glue line in the body frame of id_lo"),
    "bond_lo_bx": _bond("m", "end b of the glue line in the body frame of id_lo"),
    "bond_lo_by": _bond("m", "end b of the glue line in the body frame of id_lo"),
    "bond_hi_ax": _bond("m", "end a of the glue line in the body frame of id_hi"),
    "bond_hi_ay": _bond("m", "end a of the glue line in the body frame of id_hi"),
    "bond_hi_bx": _bond("m", "end b of the glue line in the body frame of id_hi"),
    "bond_hi_by": _bond("m", "end b of the glue line in the body frame of id_hi"),
    "contact_id_lo": Variable(("contact",), "int64", "1", "lower id of the touching pair", 1),
    "contact_id_hi": Variable(("contact",), "int64", "1", "higher id of the touching pair", 1),
    "contact_slip": _contact("m", "elastic tangential displacement of the friction law"),
    "contact_rest_overlap": _contact("m", "overlap that makes no force; below 0: across a gap"),
    "contact_touch_time": _contact("s", "time in touch and in freezing air", 0),
    "contact_ridge_closing": _contact("m", "plastic closing since the pair touched", 0),
    "contact_ridge_thickness": _contact("m", "thickness of the ice in the contact", 0),
    "contact_ridge_length": _contact("m", "contact length", 0),
    "wall_face_wall": _face_number("number of the wall to which the face belongs", 0),
    "wall_face_plane": _face_number("1 endless, with ice to the left of a to b; 0 a line", 0, 1),
    "wall_face_before": _face_number("face that it meets at end a, -1 none", -1),
    "wall_face_after": _face_number("face that it meets at end b, -1 none", -1),
    "wall_face_ax": _face("m", "end a at time 0"),
    "wall_face_ay": _face("m", "end a at time 0"),
    "wall_face_bx": _face("m", "end b at time 0"),
    "wall_face_by": _face("m", "end b at time 0"),
    "wall_face_u": _face("m s-1", "velocity of the face along x"),
    "wall_face_v": _face("m s-1", "velocity of the face along y"),
    "wall_contact_id": Variable(("wall_contact",), "int64", "1", "the element", 1),
    "wall_contact_face": Variable(("wall_contact",), "int64", "1", "number of the face", 0),
    "wall_contact_slip": _wall_contact("m", "elastic tangential displacement at the wall"),
    "wall_contact_rest_overlap": _wall_contact("m", "overlap with the wall that makes no force"),
    "wall_contact_ridge_closing": _wall_contact("m", "plastic closing at the wall", 0),
    "wall_contact_ridge_thickness": _wall_contact("m", "thickness of the ice at the wall", 0),
    "wall_contact_ridge_length": _wall_contact("m", "contact length at the wall", 0),
}

# Floating variables that `state.precision` single does not round. Bonds and contacts are small
# differences of places: 0.25 m at 4000 km, the last place of single precision, strains ice by 1e-5,
# a stress near its tensile strength. Walls are places too. Areas and shares are parts of one whole,
# the sea, and add up to it. What the sea's temperature tells is its difference from freezing.
EXACT = (
    *("x", "y", "area", "ice_fraction"),
    *("sea_temperature", "pending_freeze", "sea_salinity", "deep_salinity"),
    *(name for name in VARIABLES if name.startswith("wall_face_")),
)
ROUNDED = tuple(n for n, rule in VARIABLES.items() if rule.dtype == "float64" and n not in EXACT)

_EFFECT_VARIABLES = set(state_variables(EFFECTS)) | set(SCHEME_STATE)


def expected_variables(effects: tuple[str, ...], scheme: str = "zero_layer") -> tuple[str, ...]:
    """Variables of the state of a scene with these effects and scheme, no more and no less.

    Parameters
    ----------
    effects : tuple of str
        Of the scene.
    scheme : str, optional
        Of the column.

    Returns
    -------
    tuple of str
        In the order of the schema.
    """
    wanted = set(state_variables(effects, scheme))
    return tuple(name for name in VARIABLES if name in wanted or name not in _EFFECT_VARIABLES)


def check_state(state: xr.Dataset) -> None:
    """Check a state against the schema.

    Parameters
    ----------
    state : xarray.Dataset
        The state.

    Raises
    ------
    FloeError
        In one sentence, which names the first variable or attribute at fault.
    """
    version = state.attrs.get("schema_version")
    if version is None:
        raise FloeError("this is not a FloeFlow state: it has no schema_version")
    if version != SCHEMA_VERSION:
        raise FloeError(
            f"its schema version is {version}, this FloeFlow writes version {SCHEMA_VERSION}"
        )
    effects, scheme = check_attributes(state.attrs)
    expected = expected_variables(effects, scheme)
    for name in expected:
        if name not in state:
            raise FloeError(f"variable '{name}' is missing")
        _check_variable(name, state[name])
    for extra in state.variables:
        if extra not in expected:
            raise FloeError(f"variable '{extra}' is not of this scene's effects")
    _check_order(state)
    if "cell_corners" in state and int(state["cell_corners"].sum()) != state.sizes["corner"]:
        raise FloeError("the elements' numbers of corners do not add up to the corners")


def _check_variable(name: str, array: xr.DataArray) -> None:
    rule = VARIABLES[name]
    if array.dims != rule.dims:
        raise FloeError(f"variable '{name}' has dimensions {array.dims}, not {rule.dims}")
    if array.dtype != np.dtype(rule.dtype):
        raise FloeError(f"variable '{name}' is of type {array.dtype}, not {rule.dtype}")
    values = array.values
    # Written so that a NaN fails too.
    bad = ~((values >= rule.low) & (values <= rule.high))
    if rule.dtype == "float64":
        bad |= ~np.isfinite(values)
    if bad.any():
        place = np.argwhere(bad)[0]
        raise FloeError(
            f"variable '{name}' is {values[tuple(place)]} at {rule.dims[0]} {place[0]}, outside "
            f"[{rule.low}, {rule.high}]"
        )


def _check_order(state: xr.Dataset) -> None:
    ids = state["id"].values
    if np.any(np.diff(ids) <= 0):
        raise FloeError("the elements are not sorted by id, or an id stands twice")
    for kind in ("bond", "contact"):
        if f"{kind}_id_lo" not in state:
            continue
        lo, hi = state[f"{kind}_id_lo"].values, state[f"{kind}_id_hi"].values
        if np.any(lo >= hi):
            raise FloeError(f"a {kind} does not name its lower id first")
        if not (np.isin(lo, ids).all() and np.isin(hi, ids).all()):
            raise FloeError(f"a {kind} names an element that does not exist")
        step_lo, step_hi = np.diff(lo), np.diff(hi)
        if np.any((step_lo < 0) | ((step_lo == 0) & (step_hi <= 0))):
            raise FloeError(f"the {kind}s are not sorted, or one stands twice")
    if "wall_contact_id" in state:
        _check_wall_contacts(state, ids)


def _check_wall_contacts(state: xr.Dataset, ids: np.ndarray) -> None:
    held, face = state["wall_contact_id"].values, state["wall_contact_face"].values
    if not np.isin(held, ids).all():
        raise FloeError("a wall_contact names an element that does not exist")
    if (face >= state.sizes["wall_face"]).any():
        raise FloeError("a wall_contact names a face that does not exist")
    step, step_face = np.diff(held), np.diff(face)
    if np.any((step < 0) | ((step == 0) & (step_face <= 0))):
        raise FloeError("the wall_contacts are not sorted, or one stands twice")
