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
from floeflow.core.records import Record


@pytest.fixture(scope="module")
def records(project: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    out = tmp_path_factory.mktemp("bench") / "dem.json"
    script = project / "benchmarks" / "dem.py"
    command = [sys.executable, str(script), "--quick", "--out", str(out), "--against", str(project)]
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
        "unbonded_friction_huge": "",
        "bonded_huge": "",
        "unbonded_friction_beside": "other version",
        "bonded_beside": "other version",
        "unbonded_friction_10x_beside": "other version",
        "bonded_10x_beside": "other version",
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
def test_what_memory_allows_is_told_of_large_rafts(records: dict[str, Any]) -> None:
    for name, pair in (("unbonded_friction_huge", 72), ("bonded_huge", 104)):
        record = records[name]
        n, pairs = record["n"], record["pairs"]
        # Three pairs an element but at the rim; an element's own numbers are the same.
        assert record["bytes_per_step"] - pair * pairs == 444 * n
        assert 0.0 < record["share_of_bandwidth"]
        assert record["stream_bytes_per_s"] > 1e8
        assert min(record[f"{what}_s"] for what in ("set_up", "read_out")) > 0.0


@pytest.mark.mpi
def test_stock_and_own_discs_start_alike(records: dict[str, Any]) -> None:
    record = records["unbonded_friction"]
    assert record["kinetic_energy_over_peer"] == pytest.approx(1.0, abs=1e-3)
    assert record["position_apart_m"] < 0.01


def test_the_last_release_is_told_by_ratios_to_stock(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(project / "benchmarks")
    import dem

    def bonded(size: tuple[int, int]) -> Record:
        extra = {"element_steps_per_s": 1.0}
        return Record(
            "bonded", dem.count(size), 1, [1.0], "stock", [2 * dem.RELEASED["bonded"]], extra
        )

    text = dem.table([bonded(dem.FULL.size)])
    assert f"bonded: 2.00 x release {dem.RELEASE}" in text
    assert "release" not in dem.table([bonded(dem.QUICK.size)])
