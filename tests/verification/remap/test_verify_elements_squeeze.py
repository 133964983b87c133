# SPDX-License-Identifier: GPL-2.0-or-later
"""A pack squeezed to half of its width with remapping, with merging, and with neither."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.transfer import remap_figures
from support.transfer.squeeze import Squeeze, squeeze

REMESHING = ("remap", "merge", "")


def assert_runs_on(run: Squeeze, windows: int) -> None:
    """To the end, to half of the width, with the volume and a step of the size of the first."""
    assert run.fault == "" and len(run.step) == windows
    assert run.width[-1] < 0.55
    np.testing.assert_allclose(run.volume, run.volume[0], rtol=1e-12)
    np.testing.assert_allclose(run.sea, 1.0, rtol=1e-12)
    assert min(run.step) > 0.5 * run.step[0]


@pytest.mark.parametrize("remesh", ["remap", "merge"])
def test_a_small_pack_runs_on(remesh: str, tmp_path: Path) -> None:
    assert_runs_on(squeeze(remesh, 60, 6, tmp_path), 6)


@pytest.mark.slow
def test_step_and_cost_of_a_squeezed_pack(tmp_path: Path, show) -> None:
    windows = 40
    runs = {remesh: squeeze(remesh, 300, windows, tmp_path) for remesh in REMESHING}
    for remesh, run in runs.items():
        print(
            f"{remesh or 'no remeshing'}: width {run.width[-1]:.2f}, step {run.step[0]:.2f} s to "
            f"{run.step[-1]:.2f} s, least {min(run.step):.2f} s, elements {run.elements[-1]}, "
            f"element-steps {np.dot(run.steps, run.elements) / 1e6:.1f} million {run.fault}"
        )
    show("remap_squeeze", remap_figures.squeezed, runs)
    show("remap_squeeze_cost", remap_figures.cost, runs)
    for remesh in ("remap", "merge"):
        assert_runs_on(runs[remesh], windows)
    # Without remeshing the step shrinks on and on.
    bare = runs[""]
    assert bare.fault or bare.step[-1] < 0.8 * max(bare.step[windows // 4 :])
