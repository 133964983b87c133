# SPDX-License-Identifier: GPL-2.0-or-later
"""Gridded fields beside the published table of CMIP6 for sea ice, and what CF asks of the file."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np
import pint
import pytest
import xarray as xr
from cf_xarray.units import units as registry

from floeflow.column.thickness.categories import category_bounds
from floeflow.diagnostics.cf_output import DESCRIPTIONS, join_files, join_times, write_grid
from floeflow.diagnostics.collect import read_grid, with_shares
from floeflow.diagnostics.gridded import make_grid
from unit.diagnostics.test_gridded import ALL, make_mask, make_state, scene_of

# Standard name, unit and the first cell method of the CMIP6 table SImon, data request 01.00.31
# (github.com/PCMDI/cmip6-cmor-tables, Tables/CMIP6_SImon.json). The table's fields are monthly
# means; ours are instants, as its sidivvel and sishevel are.
ICE, SEA = "area: mean where sea_ice (comment: mask=siconc)", "area: mean where sea"
SHEAR = "maximum_over_coordinate_rotation_of_sea_ice_horizontal_shear_strain_rate"
SIMON = {
    "siconc": ("sea_ice_area_fraction", "%", SEA),
    "sithick": ("sea_ice_thickness", "m", ICE),
    "sivol": ("sea_ice_thickness", "m", SEA),
    "simass": ("sea_ice_amount", "kg m-2", SEA),
    "sisnthick": ("surface_snow_thickness", "m", ICE),
    "sitemptop": ("sea_ice_surface_temperature", "K", ICE),
    "siitdconc": ("sea_ice_area_fraction", "%", SEA),
    "siitdthick": (
        "sea_ice_thickness", "m", "area: mean where sea_ice (comment: mask=siitdconc)",
    ),
    "sirdgconc": ("area_fraction", "1", ICE),
    "sirdgthick": (
        "sea_ice_thickness", "m", "area: mean where sea_ice_ridges (comment: mask=sirdgconc)",
    ),
    "simpconc": ("area_fraction", "%", ICE),
    "siu": ("sea_ice_x_velocity", "m s-1", ICE),
    "siv": ("sea_ice_y_velocity", "m s-1", ICE),
    "sispeed": ("sea_ice_speed", "m s-1", ICE),
    # Sums over the cell: the table has no mean over an area.
    "sidmasstranx": ("sea_ice_x_transport", "kg s-1", ""),
    "sidmasstrany": ("sea_ice_y_transport", "kg s-1", ""),
    "sidivvel": ("divergence_of_sea_ice_velocity", "s-1", ICE),
    "sishevel": (SHEAR, "s-1", ICE),
    "sistrxdtop": ("surface_downward_x_stress", "N m-2", ICE),
    "sistrydtop": ("surface_downward_y_stress", "N m-2", ICE),
    "sistrxubot": ("upward_x_stress_at_sea_ice_base", "N m-2", ICE),
    "sistryubot": ("upward_y_stress_at_sea_ice_base", "N m-2", ICE),
    "siforcecoriolx": ("sea_ice_x_force_per_unit_area_due_to_coriolis_effect", "N m-2", ICE),
    "siforcecorioly": ("sea_ice_y_force_per_unit_area_due_to_coriolis_effect", "N m-2", ICE),
    "siforcetiltx": ("sea_ice_x_force_per_unit_area_due_to_sea_surface_tilt", "N m-2", ICE),
    "siforceintstrx": ("sea_ice_x_internal_stress", "N m-2", ICE),
    "siforceintstry": ("sea_ice_y_internal_stress", "N m-2", ICE),
    "sistresave": ("sea_ice_average_normal_horizontal_stress", "N m-1", ICE),
    "sistremax": (
        "maximum_over_coordinate_rotation_of_sea_ice_horizontal_shear_stress", "N m-1", ICE,
    ),
    "siage": ("age_of_sea_ice", "s", ICE),
    "siforcetilty": ("sea_ice_y_force_per_unit_area_due_to_sea_surface_tilt", "N m-2", ICE),
}  # fmt: skip
# Wind along x, current along y.
FORCING = {
    name: np.full((8, 8), value)
    for name, value in (
        ("wind_u", 10.0), ("wind_v", 0.0), ("ocean_u", 0.0), ("ocean_v", 0.2), ("coriolis", 1.4e-4),
    )
}  # fmt: skip
# Per area of ice: uniaxial compression along x, and a force along x.
INSIDE = {
    "internal_force_x": -0.3, "internal_force_y": 0.0,
    "stress_xx": -5e3, "stress_yy": 0.0, "stress_xy": 0.0,
}  # fmt: skip
# Ours alone: CMIP6 has no name for it.
OWN = {"lead_fraction", "damage"}


def rich_state() -> xr.Dataset:
    """Five categories of thickness, ridges and ponds."""
    state = make_state()
    category = np.array([0.1, 0.2, 0.3, 0.2, 0.2])
    middle = np.array([0.3, 1.0, 2.0, 3.5, 6.0])
    share = state["ice_fraction"].values.sum(axis=1)[:, None] * category
    dims = ("element", "category")
    state = state.drop_vars(["ice_fraction", "ice_volume", "snow_volume", "surface_temperature"])
    ones = np.ones(share.shape)
    return state.assign(
        ice_fraction=(dims, share),
        ice_volume=(dims, share * middle),
        snow_volume=(dims, 0.1 * share),
        surface_temperature=(dims, 250.0 + 2.0 * np.arange(5) * ones),
        level_area=(dims, 0.75 * ones),
        level_volume=(dims, 0.5 * ones),
        pond_area=(dims, 0.2 * ones),
        **{name: ("element", value * share.sum(axis=1)) for name, value in INSIDE.items()},
        ice_age=("element", np.full(len(share), 86400.0)),
    )


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tables")
    scene = scene_of(folder, f"{ALL}, tilt, turning_angle")
    parts = []
    for window in (1, 2):
        state = rich_state()
        state.attrs |= {"window": window, "time": 86400.0 * window}
        parts.append(folder / f"{window}.nc")
        made = make_grid(scene, state, make_mask(2), FORCING)
        write_grid(join_times([made]), parts[-1])
    join_files(parts, folder / "grid.nc")
    return folder / "grid.nc"


def test_names_units_and_methods_are_those_of_the_table(file: Path):
    assert set(DESCRIPTIONS) == set(SIMON) | OWN
    with netCDF4.Dataset(file) as data:
        for name, (standard_name, unit, mean) in SIMON.items():
            found = data[name]
            assert (found.standard_name, found.units) == (standard_name, unit), name
            assert found.cell_methods == f"{mean} time: point".strip(), name
        for name in OWN & set(data.variables):
            assert not hasattr(data[name], "standard_name")


def test_everything_that_attributes_name_is_there(file: Path):
    with netCDF4.Dataset(file) as data:
        assert data.Conventions == "CF-1.11"
        for name, found in data.variables.items():
            if hasattr(found, "units") and found.units:
                try:
                    registry(found.units)
                except pint.UndefinedUnitError:
                    assert " since " in found.units, name
            for kind in ("coordinates", "grid_mapping", "bounds"):
                for other in getattr(found, kind, "").split():
                    assert other in data.variables, (name, other)
            if hasattr(found, "cell_measures"):
                assert found.cell_measures.split(": ")[1] in data.variables
            if hasattr(found, "bounds"):
                assert data[found.bounds].dimensions == (*found.dimensions, "bnds")
        assert data["sirdgconc"].coordinates.split()[-1] == "typesirdg"
        assert data["typesirdg"][...] == "sea_ice_ridges"
        assert data["typemp"].standard_name == "area_type"


def test_what_does_not_change_has_no_time(file: Path):
    with xr.open_dataset(file) as data:
        for name in ("crs", "cell_area", "sea_area", "lat", "lon", "iceband_bnds", "typemp"):
            assert "time" not in data[name].dims, name
        assert data["time"].dtype.kind == "M" and data.sizes["time"] == 2
        assert data["siitdconc"].dims == ("time", "iceband", "y", "x")


def test_categories_add_up_and_keep_their_thickness(file: Path):
    with xr.open_dataset(file) as data:
        total = data["siitdconc"].sum("iceband", skipna=False)
        np.testing.assert_allclose(total, data["siconc"], rtol=1e-9, atol=1e-9)
        ice = data["sithick"].notnull()
        for band, thickness in enumerate((0.3, 1.0, 2.0, 3.5, 6.0)):
            found = data["siitdthick"].isel(iceband=band).values[ice.values]
            np.testing.assert_allclose(found, thickness, rtol=1e-6)
        np.testing.assert_allclose(data["iceband_bnds"][:, 0], category_bounds(5)[:-1])


def test_ridges_ponds_and_temperature_are_means_over_the_ice(file: Path):
    with xr.open_dataset(file) as data:
        ice = data["sithick"].notnull().values
        for name, expected in (
            ("sirdgconc", 0.25),
            ("simpconc", 100.0 * 0.75 * 0.2),
            # Half of the volume on a quarter of the area.
            ("sirdgthick", 2.0 * (0.03 + 0.2 + 0.6 + 0.7 + 1.2)),
            ("sitemptop", 250.0 + 2.0 * (0.2 + 0.6 + 0.6 + 0.8)),
        ):
            np.testing.assert_allclose(data[name].values[ice], expected, rtol=1e-6, err_msg=name)
        np.testing.assert_allclose(data["simass"], 917.0 * data["sivol"])


def test_transport_is_the_mass_that_passes_a_section(file: Path):
    """Of a cell: mass per area of its sea, times the sea, times speed over the width."""
    with xr.open_dataset(file) as data:
        snow = 330.0 * data["siconc"] / 100.0 * data["sisnthick"]
        mass = ((data["simass"] + snow) * data["sea_area"]).values
        width = np.sqrt(data["cell_area"].values)
        ice = data["sithick"].notnull().values
        for axis, name in (("x", "siu"), ("y", "siv")):
            found = data[f"sidmasstran{axis}"].values
            expected = (mass * data[name].values / width)[ice]
            np.testing.assert_allclose(found[ice], expected, rtol=1e-9)
            sea = np.broadcast_to(data["sea_area"].values > 0.0, found.shape)
            assert (found[sea & ~ice] == 0.0).all() and np.isnan(found[~sea]).all()


def test_invariants_of_uniaxial_compression_and_shear(file: Path, tmp_path: Path):
    """Half of an only stress is its mean normal and its largest shear stress."""
    with xr.open_dataset(file) as data:
        ice = data["sithick"].notnull().values
        for name, expected in (
            ("sistresave", -2.5e3),
            ("sistremax", 2.5e3),
            ("siforceintstrx", -0.3),
            ("siforceintstry", 0.0),
            ("siage", 86400.0),
        ):
            found = data[name].values
            np.testing.assert_allclose(found[ice], expected, rtol=1e-6, atol=1e-9, err_msg=name)
            assert np.isnan(found[~ice]).all()
    state = rich_state()
    # Pure shear: the axes turned by 45 degrees see tension and compression of 3 and 4 kN/m at right
    # angles to each other, hypot of both.
    total = state["ice_fraction"].values.sum(axis=1)
    state["stress_xx"], state["stress_yy"] = (("element", s * 4e3 * total) for s in (1.0, -1.0))
    state["stress_xy"] = ("element", 3e3 * total)
    data = make_grid(scene_of(tmp_path, ALL), state, make_mask())
    ice = data["sithick"].notnull().values
    np.testing.assert_allclose(data["sistresave"].values[ice], 0.0, atol=1e-6)
    np.testing.assert_allclose(data["sistremax"].values[ice], 5e3, rtol=1e-6)


def test_fields_of_absent_effects_are_absent(tmp_path: Path):
    bare = make_grid(scene_of(tmp_path, "wind"), make_state(snow=False), make_mask())
    there = set(DESCRIPTIONS) & set(map(str, bare.data_vars))
    assert there == {
        "siconc", "sithick", "sivol", "simass", "lead_fraction",
        "siu", "siv", "sispeed", "sidivvel", "sishevel", "sidmasstranx", "sidmasstrany",
    }  # fmt: skip


def test_damage_is_the_outline_that_no_bond_holds(file: Path, tmp_path: Path):
    """Half of each hexagon's outline is held."""
    state = make_state()
    half = 0.5 * np.sqrt(8.0 * np.sqrt(3.0)) * np.sqrt(state["area"].values)
    state["bonded_length"] = ("element", half)
    data = make_grid(scene_of(tmp_path, ALL), state, make_mask())
    ice = data["sithick"].notnull().values
    np.testing.assert_allclose(data["damage"].values[ice], 0.5, rtol=1e-9)
    with xr.open_dataset(file) as unbonded:
        assert "damage" not in unbonded


def test_concentration_is_a_share_where_the_program_reads_it(file: Path):
    with xr.open_dataset(file) as data:
        raw = data["siconc"].values
    shares = with_shares(read_grid(file))
    np.testing.assert_allclose(shares["siconc"], raw / 100.0)
    assert shares["siconc"].attrs["units"] == "1" and float(np.nanmax(raw)) > 50.0
