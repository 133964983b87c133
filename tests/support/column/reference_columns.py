# SPDX-License-Identifier: GPL-2.0-or-later
"""Recorded columns of the reference in the terms of the layered column."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import xarray as xr

from floeflow.column.layered import LayeredState, pack_forcing
from floeflow.column.physics import Physics
from floeflow.column.records import Array
from floeflow.core.sun import sun_height

DT = 3600.0  # s
LATITUDE = {"icefree": 90.0, "slab": 89.5, "itd": 89.0}  # of the initial states' cells
YEAR = 365  # days
LEVEL = {
    "alvl": "level_area",
    "vlvl": "level_volume",
    "apnd": "pond_area",
    "hpnd": "pond_depth",
    "ipnd": "pond_lid",
}
STATE = ("aicen", "vicen", "vsnon", "Tsfc", "qice", "qsno", "sice", *LEVEL)


def open_case(shared: Path, case: str, file: str) -> xr.Dataset:
    """Open a file of a case, `bl99_n1_ccsm3` or another."""
    return xr.open_dataset(shared / "reference/icepack" / case / file)


def physics(shared: Path, case: str) -> Physics:
    """Constants of a recorded case, from its parameters."""
    found = json.loads((shared / "reference/icepack" / case / "params.json").read_text())
    name = {
        key: value.strip("'") if isinstance(value, str) else value
        for group in found["namelist"].values()
        for key, value in group.items()
    }

    def number(key: str) -> float:
        return float(name[key].replace("d", "e"))

    def switch(key: str) -> bool:
        return bool(name[key] == ".true.")

    return Physics(
        mushy=name["ktherm"] == "2",
        bubbly=name["conduct"] == "bubbly",
        least_thickness=0.1 if found["ncat"] == 1 else number("hi_min"),
        # With ponds Icepack's driver takes this light whatever is asked for.
        delta_eddington=name["shortwave"] == "dEdd" or switch("tr_pond_lvl"),
        redistribute_light=switch("sw_redist"),
        ponds=switch("tr_pond_lvl"),
        pond_lids=name["frzpnd"] == "hlid",
        snow_conductivity=number("ksno"),
        albedo_ice_visible=number("albicev"),
        albedo_ice_infrared=number("albicei"),
        albedo_snow_visible=number("albsnowv"),
        albedo_snow_infrared=number("albsnowi"),
        albedo_thickness=number("ahmax"),
        snow_grain_tuning=number("R_snw"),
        ice_scatter_tuning=number("R_ice"),
        pond_scatter_tuning=number("R_pnd"),
        melting_grain=number("rsnw_mlt"),
        fresh_grain=number("rsnw_fall"),
        grain_warming=number("dT_mlt"),
        algae=number("kalg"),
        snow_cover_depth=number("hs0"),
        lid_snow_depth=number("hs1"),
        least_catch=number("rfracmin"),
        most_catch=number("rfracmax"),
        pond_aspect=number("pndaspect"),
        pond_drain_time=number("tscale_pnd_drain") * 86400.0,
        pond_seepage=number("dpscale"),
        emissivity=number("emissivity"),
        stability_iterations=int(name["natmiter"]),
        least_friction_velocity=number("ustar_min"),
        floe_diameter=number("floediam"),
        new_ice_thickness=number("hfrazilmin"),
        channel_radius=number("a_rapid_mode"),
        critical_rayleigh=number("Rac_rapid_mode"),
        channel_aspect=number("aspect_rapid_mode"),
        slow_drainage=number("dSdt_slow_mode"),
        slow_liquid=number("phi_c_slow_mode"),
        bottom_liquid=number("phi_i_mushy"),
        warmest_frazil=number("Tliquidus_max"),
    )


def starts(data: xr.Dataset) -> LayeredState:
    """Every recorded state but the last as one element each: where the next step starts."""
    values = {name: data[f"s2_{name}"].values[:-1] for name in STATE}
    pending = np.maximum(data["frzmlt_beg"].values[1:], 0.0) * DT
    return as_state(data, values, data["sst_beg"].values[1:], pending, slice(0, -1))


def first(data: xr.Dataset) -> LayeredState:
    """State at the start of the first recorded step."""
    values = {name: data[f"s0_{name}"].values for name in STATE}
    return as_state(data, values, data["sst_beg"].values[:1], np.zeros(1), None)


def as_state(
    data: xr.Dataset, values: dict[str, Array], sea: Array, pending: Array, part: slice | None
) -> LayeredState:
    """Recorded values in the column's terms; snow on lids as recorded, or none at the start."""
    level = {name: values.pop(key) for key, name in LEVEL.items()}
    for key, name in {"dhsn": "lid_snow", "ffracn": "lid_share"}.items():
        level[name] = np.zeros_like(level["pond_lid"])
        if part is not None:
            level[name] = data[key].values[part]
    # Cases without level ice record none: there all ice is level.
    known = level if level["level_area"].any() else {}
    return LayeredState(*values.values(), sea, pending, **known)


def forcing(data: xr.Dataset) -> dict[str, Array]:
    """Recorded forcing by the names that the column knows, each (time,).

    The sun stands where it does at the start of a step.
    """
    steps = data["istep"].values
    latitude = LATITUDE[(Path(data.encoding["source"]).parent / "CELL").read_text().strip()]
    return {
        "potential_temperature": data["potT"].values,
        "humidity": data["Qa"].values,
        "density": data["rhoa"].values,
        "wind": data["wind"].values,
        "longwave": data["flw"].values,
        "visible": data["swvdr"].values + data["swvdf"].values,
        "infrared": data["swidr"].values + data["swidf"].values,
        "snowfall": data["fsnow"].values,
        "sea_salinity": data["sss"].values,
        "deep_heat": -data["qdp"].values,
        "mixed_depth": data["hmix"].values,
        "ocean_friction": np.hypot(data["strocnxT"].values, data["strocnyT"].values),
        "rain": data["frain"].values,
        "sun_height": sun_height((steps - 1) / 24.0 % YEAR + 1.0, latitude),
    }


def year(data: xr.Dataset) -> Array:
    """Forcing of one element through a recorded year, packed, (8760, 1, ...)."""
    values = {name: value[:, None] for name, value in forcing(data).items()}
    return pack_forcing(values, YEAR * 24, 1)


def each_step(data: xr.Dataset) -> Array:
    """Forcing of the elements of `starts`, packed, (1, time - 1, ...)."""
    values = {name: value[1:] for name, value in forcing(data).items()}
    return pack_forcing(values, 1, data.sizes["time"] - 1)


def worst(ours: Array, theirs: Array) -> float:
    """Largest difference."""
    return float(np.abs(ours - theirs).max())
