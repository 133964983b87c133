# SPDX-License-Identifier: GPL-2.0-or-later
"""Recorded columns of the reference in the terms of the layered column."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from floeflow.column.layered import LayeredState, pack_forcing
from floeflow.column.physics import Physics
from floeflow.column.records import Array

DT = 3600.0  # s
YEAR = 365  # days
STATE = ("aicen", "vicen", "vsnon", "Tsfc", "qice", "qsno", "sice")


def open_case(shared: Path, case: str, file: str) -> xr.Dataset:
    """Open a file of a case, `bl99_n1_ccsm3` or another."""
    return xr.open_dataset(shared / "reference/icepack" / case / file)


def physics(categories: int, mushy: bool = False) -> Physics:
    """Constants of the recorded cases."""
    return Physics(mushy=mushy, least_thickness=0.1 if categories == 1 else 0.01)


def starts(data: xr.Dataset) -> LayeredState:
    """Every recorded state but the last as one element each: where the next step starts."""
    values = [data[f"s2_{name}"].values[:-1] for name in STATE]
    pending = np.maximum(data["frzmlt_beg"].values[1:], 0.0) * DT
    return LayeredState(*values, data["sst_beg"].values[1:], pending)


def first(data: xr.Dataset) -> LayeredState:
    """State at the start of the first recorded step."""
    values = [data[f"s0_{name}"].values for name in STATE]
    return LayeredState(*values, data["sst_beg"].values[:1], np.zeros(1))


def forcing(data: xr.Dataset) -> dict[str, Array]:
    """Recorded forcing by the names that the column knows, each (time,)."""
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
    }


def year(data: xr.Dataset) -> Array:
    """Forcing of one element through a recorded year, packed, (8760, 1, ...)."""
    values = {name: value[:, None] for name, value in forcing(data).items()}
    return pack_forcing(values, YEAR * 24, 1)


def each_step(data: xr.Dataset) -> Array:
    """Forcing of the elements of `starts`, packed, (1, time - 1, ...)."""
    values = {name: value[1:] for name, value in forcing(data).items()}
    return pack_forcing(values, 1, data.sizes["time"] - 1)
