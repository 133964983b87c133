# SPDX-License-Identifier: GPL-2.0-or-later
"""A winter month of the central Arctic beside satellites, buoys and models.

Usage: python benchmarks/central_arctic.py [--scene FILE] [--keep] [--largest 15] [--figure FILE]
Runs the scene to its report (with ``--keep`` it reads a run that lies there) and prints a table;
with ``--figure`` it draws the deformation of all elements in three intervals of three days.
Deformation is sampled as RGPS does, from displacements over three days of elements that are
followed, of those up to ``--largest`` km alone: the scene refines the central Arctic. Exponents are
fitted from 2.5 elements up. They are diagnostics, no bars: they depend on how triangles are chosen
and filtered (Hutchings et al. 2024), and signed gradients cancel in boxes (Beaudry and Tremblay
2026).
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from itertools import chain
from pathlib import Path

import cmocean
import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm
from tables import show
from year import run

from floeflow.diagnostics.analyses import Winds
from floeflow.diagnostics.deformation import (
    ORDERS,
    curvature,
    fit_scaling,
    triangle_strain,
    triangles,
)
from floeflow.diagnostics.followed import Frame, frame_of, step_between
from floeflow.diagnostics.motion_analyses import INTERVAL, Motion
from floeflow.diagnostics.wind_drift import WindSums, wind_fit
from floeflow.scene import Scene, load_scene
from floeflow.state import read_dataset, read_state
from floeflow.state.snapshots import read_snapshots

RESULTS = Path("results")
PER_DAY = 100.0 * 86400.0  # % per day of 1/s
# Wind at 10 m over the geostrophic one, and its turn to the left of it, in the synthetic climate.
SURFACE_WIND, SURFACE_TURN = 0.7, 25.0

Rows = list[tuple[str, str, str, str]]


def fine_part(frame: Frame, largest: float) -> Frame:
    """Elements of a frame that are at most so large (m)."""
    kept = frame.area <= largest**2
    names = ("id", "x", "y", "path_x", "path_y", "area", "share", "velocity")
    return replace(frame, **{name: getattr(frame, name)[kept] for name in names})


def follow(scene: Scene, folder: Path, largest: float) -> Motion:
    """Motion of the elements that are at most so large (m)."""
    time = scene.time
    motion = Motion(time.window, time.windows, set(), Winds(scene))
    snapshots = read_snapshots(sorted((folder / "elements").glob("*.nc")))
    for state in chain([read_state(folder / "state/0000.nc")], snapshots):
        motion.take(fine_part(frame_of(state), largest))
    return motion


def draw(scene: Scene, folder: Path, path: Path) -> None:
    """Map the total deformation of triangles in the first, middle and last interval."""
    step = max(1, round(INTERVAL / scene.time.window))
    snapshots = read_snapshots(sorted((folder / "elements").glob("*.nc")))
    states = chain([read_state(folder / "state/0000.nc")], snapshots)
    frames = [frame_of(state) for state in states][::step]
    shown = sorted({0, (len(frames) - 2) // 2, len(frames) - 2})
    figure, panels = plt.subplots(
        1, len(shown), figsize=(4.2 * len(shown), 4.6), squeeze=False, layout="constrained"
    )
    for axes, first in zip(panels[0], shown, strict=True):
        one, two = frames[first], frames[first + 1]
        step_of = step_between(one, two)
        x, y = one.x[step_of.before], one.y[step_of.before]
        # Elements of all sizes: the longest sides go by the coarse ones.
        corners = triangles(x, y, float(np.sqrt(np.percentile(one.area, 90.0))))
        seconds = step_of.seconds
        strain = triangle_strain(x, y, step_of.dx / seconds, step_of.dy / seconds, corners)
        mesh = axes.tripcolor(
            x / 1e3, y / 1e3, corners, PER_DAY * np.maximum(strain.total, 1e-12),
            norm=LogNorm(0.1, 100.0), cmap=cmocean.cm.amp, rasterized=True,
        )  # fmt: skip
        axes.set_aspect("equal")
        axes.set_title(f"days {one.time / 86400.0:.0f} to {two.time / 86400.0:.0f}", loc="left")
        axes.set_xlabel("x (km)")
    panels[0, 0].set_ylabel("y (km)")
    figure.colorbar(mesh, ax=panels[0].tolist(), label="Total deformation (% per day)", pad=0.01)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def alignment(angle: np.ndarray, length: np.ndarray) -> tuple[float, float]:
    """How far lines share a direction, 0 to 1, and which (degrees, 0 to 180)."""
    if not length.sum() > 0.0:
        return np.nan, np.nan
    mean = (length * np.exp(2j * angle)).sum() / length.sum()
    return float(abs(mean)), float(np.degrees(0.5 * np.angle(mean)) % 180.0)


def span(values: np.ndarray, form: str) -> str:
    """Mean, and least and largest, as text."""
    return f"{values.mean():{form}} ({values.min():{form}} to {values.max():{form}})"


def deformation_rows(motion: Motion) -> Rows:
    """Scaling, size and localisation of deformation: what, observed, here, in models."""
    counts, scales = np.stack(motion.counts), np.stack(motion.scales)
    fit = fit_scaling(counts, scales, motion.moment_array, motion.spacing)
    first = int(np.flatnonzero(ORDERS == 1.0)[0])
    a, b = curvature(ORDERS, fit.exponent)
    total, opening, shear = (np.array(each) for each in zip(*motion.means, strict=True))
    share = np.array([found.share for found in motion.features])
    small = float(scales[:, 0].sum() / counts[:, 0].sum()) / 1e3
    low, high = fit.low / 1e3, fit.high / 1e3
    both = (
        "VP and brittle models can have it (Bouchat et al. 2022); neXtSIM has (Rampal et al. 2019)"
    )
    return [
        (
            f"exponent of mean deformation over 3 days, {low:.0f} to {high:.0f} km",
            "0.20, 10 to 1000 km (Marsan et al. 2004)",
            f"{fit.exponent[first]:.2f} ± {fit.error[first]:.2f}",
            both,
        ),
        ("a, b of a q² + b q", "0.13, 0.07 (Marsan et al. 2004)", f"{a:.2f}, {b:.2f}", both),
        (
            f"mean total deformation, triangles of {small:.0f} km (% per day)",
            "no figure of the same sampling",
            span(PER_DAY * total, ".1f"),
            "",
        ),
        (
            "mean absolute divergence over mean shear",
            "no figure of the same sampling",
            f"{opening.mean() / shear.mean():.2f}",
            "",
        ),
        (
            "share of the area with half of the deformation (%)",
            "strongly localised (Marsan et al. 2004)",
            f"{100.0 * np.nanmin(share):.0f} to {100.0 * np.nanmax(share):.0f}",
            "",
        ),
    ]


def feature_rows(motion: Motion) -> Rows:
    """Linear features."""
    angle, length = (
        np.concatenate([getattr(found, name) for found in motion.features])
        for name in ("angle", "length")
    )
    density = np.array([found.length.sum() / found.area for found in motion.features])
    along, way = alignment(angle, length)
    other = "other rules (Hutter et al. 2019)"
    return [
        (
            "linear features, length in 10,000 km² (km)",
            other,
            span(1e7 * density, ".0f"),
            "",
        ),
        (
            "median length of a feature (km); their number",
            other,
            f"{np.median(length) / 1e3:.0f}; {length.size}" if length.size else "none",
            "",
        ),
        (
            "alignment of features (0 none, 1 all); direction from the x axis",
            "acute angles of crossing features 48° (Ringeisen et al. 2023)",
            f"{along:.2f}; {way:.0f}° (angles of crossing not measured)",
            "crossing angles not as observed (Ringeisen et al. 2023)",
        ),
    ]


def drift_rows(motion: Motion) -> Rows:
    """Drift against the wind of ice of 80 % and more."""
    sums = WindSums()
    for _, parts in motion.winds:
        sums += parts["pack"]
    fit = wind_fit(sums)
    turn = -np.degrees(fit.turning)
    return [
        (
            "drift over the wind at 10 m; to its right; variance explained",
            "free drift 1.5 to 2.5 % (Leppäranta 2011)",
            f"{100.0 * fit.factor:.2f} %; {turn:.0f}°; {100.0 * fit.explained:.0f} %",
            "",
        ),
        (
            "the same over the geostrophic wind",
            "0.8 %, 8° (Thorndike & Colony 1982)",
            f"{100.0 * SURFACE_WIND * fit.factor:.2f} %; {turn - SURFACE_TURN:.0f}°",
            "",
        ),
    ]


def break_rows(data: xr.Dataset) -> Rows:
    """How breaks of bonds cluster, of the whole scene."""
    if "break_fano" not in data:
        return []
    hours, fano = data["break_step"].values / 3600.0, data["break_fano"].values
    ratio = float(np.nanmedian(data["break_neighbour_ratio"].values))
    return [
        (
            f"Fano factor of breaks, {hours[0]:.0f} h; {hours[-1]:.0f} h",
            "independent breaks: 1",
            f"{fano[0]:.0f}; {fano[-1]:.0f}",
            "",
        ),
        ("neighbours that both lose bonds in a day, over chance", "random: 1", f"{ratio:.1f}", ""),
    ]


def main() -> None:
    """Run the scene if it is asked for, and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scene", type=Path, default=Path("config/scenes/central_arctic.yaml"))
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--keep", action="store_true", help="read the run that lies there")
    parser.add_argument("--largest", type=float, default=15.0, help="largest element (km)")
    parser.add_argument("--figure", type=Path, help="picture to draw")
    given = parser.parse_args()
    if not given.keep:
        print(f"{run(given.scene, given.ranks) / 60.0:.1f} minutes")
    scene = load_scene(given.scene)
    folder = RESULTS / scene.name
    motion = follow(scene, folder, 1e3 * given.largest)
    data = read_dataset(folder / "analyses.nc")
    rows = [
        *deformation_rows(motion),
        *feature_rows(motion),
        *drift_rows(motion),
        *break_rows(data),
    ]
    if given.figure:
        draw(scene, folder, given.figure)
    show(("quantity", "observed", "this run", "published models"), rows)


if __name__ == "__main__":
    main()
