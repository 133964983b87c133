# SPDX-License-Identifier: GPL-2.0-or-later
"""Digests of the reference results, which lie in tests/data; as a program it writes them.

.venv/bin/python tests/support/reference_digests.py FOLDER-WITH-REFERENCES
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import xarray as xr

HERE = Path(__file__).resolve().parents[1] / "data"

COLUMNS = ("bl99_n1_ccsm3", "mushy_n1_ccsm3")
STEPS = 24
# What `support.column.reference_columns` and the tests read of a recorded year.
RECORDED = (
    *(f"s2_{name}" for name in ("aicen", "vicen", "vsnon", "Tsfc", "qice", "qsno", "sice")),
    *(f"s2_{name}" for name in ("alvl", "vlvl", "apnd", "hpnd", "ipnd")),
    *("dhsn", "ffracn", "sst_beg", "sst_end", "frzmlt_beg", "frzmlt_end"),
    *("congel", "meltt", "meltb", "meltl", "frazil", "snoice"),
    *("potT", "Qa", "rhoa", "wind", "flw", "swvdr", "swvdf", "swidr", "swidf", "fsnow", "sss"),
    *("qdp", "hmix", "strocnxT", "strocnyT", "frain", "istep"),
)
PARAMETERS = (
    *("ktherm", "conduct", "hi_min", "shortwave", "tr_pond_lvl", "sw_redist", "frzpnd", "ksno"),
    *("albicev", "albicei", "albsnowv", "albsnowi", "ahmax", "R_snw", "R_ice", "R_pnd"),
    *("rsnw_mlt", "rsnw_fall", "dT_mlt", "kalg", "hs0", "hs1", "rfracmin", "rfracmax"),
    *("pndaspect", "tscale_pnd_drain", "dpscale", "emissivity", "natmiter", "ustar_min"),
    *("floediam", "hfrazilmin", "a_rapid_mode", "Rac_rapid_mode", "aspect_rapid_mode"),
    *("dSdt_slow_mode", "phi_c_slow_mode", "phi_i_mushy", "Tliquidus_max"),
)
PAIRS = ("tension", "shear", "tension_shear", "compression", "compression_shear")
PAIRS += ("compression_force",)
BOND = ("x", "bondLength", "bondEndPoint1Particle1", "bondEndPoint1Particle2")
DRIFTS, TIMES = ("thick", "thin"), 24


def digests(shared: Path) -> dict[str, xr.Dataset | str]:
    """Digests of the references in a folder, by their path in tests/data."""
    made: dict[str, xr.Dataset | str] = {}
    for case in COLUMNS:
        folder = f"reference/icepack/{case}"
        cell = (shared / folder / "CELL").read_text()
        made |= {f"{folder}/CELL": cell, f"{folder}/params.json": parameters(shared / folder)}
        with xr.open_dataset(shared / folder / "state_y01.nc") as data:
            # Spread over the year, each step with the record before it, which is its start.
            last = np.linspace(1, data.sizes["time"] - 1, STEPS).astype(int)
            rows = np.stack([last - 1, last], axis=1).ravel()
            made[f"{folder}/state_y01.nc"] = bare(data[list(RECORDED)].isel(time=rows))
    for name in PAIRS:
        path = f"reference/demsi/two_elements/bonded_{name}.nc"
        with xr.open_dataset(shared / path, decode_times=False) as data:
            gone = int(np.argmax(data["bondLength"].values[:, 0] == 0))
            rows = np.array([0, gone - 1, gone])
            made[path] = bare(data[["time", *BOND]].isel(time=rows))
    for name in DRIFTS:
        path = f"reference/demsi/terminal_drift_{name}.nc"
        with xr.open_dataset(shared / path, decode_times=False) as data:
            rows = np.linspace(0, data.sizes["time"] - 1, TIMES).astype(int)
            made[path] = bare(data[["time", "v"]].isel(time=rows))
    return made


def parameters(folder: Path) -> str:
    """The parameters that the tests read, as JSON in the form of the reference."""
    found = json.loads((folder / "params.json").read_text())
    groups = {
        group: {key: value for key, value in values.items() if key in PARAMETERS}
        for group, values in found["namelist"].items()
    }
    kept = {
        "ncat": found["ncat"],
        "namelist": {name: keys for name, keys in groups.items() if keys},
    }
    return json.dumps(kept, indent=1) + "\n"


def bare(data: xr.Dataset) -> xr.Dataset:
    """The numbers, compressed, without what programs wrote beside them."""
    data = data.load().copy()
    data.attrs = {}
    for name in data.variables:
        kept = ("units",) if "units" in data[name].attrs else ()
        data[name].attrs = {key: data[name].attrs[key] for key in kept}
        data[name].encoding = {"zlib": True, "complevel": 9, "_FillValue": None}
    return data


def main() -> None:
    """Write all of them."""
    if len(sys.argv) != 2:
        sys.exit("usage: reference_digests.py FOLDER-WITH-REFERENCES")
    for path, made in digests(Path(sys.argv[1])).items():
        target = HERE / path
        target.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(made, str):
            target.write_text(made)
        else:
            made.to_netcdf(target, engine="netcdf4", format="NETCDF4")


if __name__ == "__main__":
    main()
