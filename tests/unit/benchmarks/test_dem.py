# SPDX-License-Identifier: GPL-2.0-or-later
"""The DEM benchmark in its short form: the shape of its records, and that its peers are alike."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from floeflow.core.mpi import mpi_environment


@pytest.fixture(scope="module")
def records(project: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    out = tmp_path_factory.mktemp("bench") / "dem.json"
    command = [sys.executable, str(project / "benchmarks" / "dem.py"), "--quick", "--out", str(out)]
    done = subprocess.run(
        command, env=mpi_environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "unbonded_friction" in done.stdout
    return {record["name"]: record for record in json.loads(out.read_text())}


@pytest.mark.mpi
def test_every_case_is_there_with_its_peer_and_its_figures(records: dict[str, Any]) -> None:
    peers = {
        "stock_hooke_history": "",
        "unbonded": "stock_hooke_history",
        "unbonded_friction": "stock_hooke_history",
        "bonded": "stock_hooke_history",
        "deterministic": "unbonded_friction",
        "deterministic_bonded": "bonded",
        "exact_losses": "unbonded_friction",
        "exact_losses_bonded": "bonded",
        "ridging": "unbonded_friction",
        "ridging_bonded": "bonded",
        "driven_centre": "unbonded_friction",
        "driven_cell": "driven_centre",
        "unbonded_friction_10x": "unbonded_friction",
        "bonded_10x": "bonded",
        "unbonded_friction_2_ranks": "unbonded_friction",
        "bonded_2_ranks": "bonded",
    }
    assert {name: record["peer"] for name, record in records.items()} == peers
    for name, record in records.items():
        assert record["repeats"] >= 5
        assert record["element_steps_per_s"] > 0
        assert record["ranks"] == (2 if name.endswith("2_ranks") else 1)
        if record["peer"]:
            assert len(record["peer_seconds"]) == record["repeats"]
            assert record["ratio_median"] > 0


@pytest.mark.mpi
def test_the_lattice_is_full_of_pairs(records: dict[str, Any]) -> None:
    # 15 rows of 20 discs: 15 x 19 neighbours along the rows, 14 x 39 between them
    for name in ("bonded", "bonded_2_ranks"):
        assert records[name]["pairs"] == 15 * 19 + 14 * 39
    assert 2 * 300 < records["unbonded_friction"]["pairs"] <= 15 * 19 + 14 * 39


@pytest.mark.mpi
def test_stock_and_own_discs_start_alike(records: dict[str, Any]) -> None:
    record = records["unbonded_friction"]
    assert record["kinetic_energy_over_peer"] == pytest.approx(1.0, abs=1e-3)
    assert record["position_apart_m"] < 0.01
