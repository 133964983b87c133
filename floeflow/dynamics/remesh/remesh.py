# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene asks for at a window's end: nothing, merging, or remapping when it is time."""

from __future__ import annotations

import xarray as xr

from floeflow.dynamics.motion import engine_params
from floeflow.dynamics.remesh.absorb import absorbed, ashore
from floeflow.dynamics.remesh.merge import merge, merge_targets
from floeflow.dynamics.remesh.remap import lay, overlapping, remap
from floeflow.scene import Scene
from floeflow.state.cells import Cells
from floeflow.state.elements import element_arrays
from floeflow.state.schema import MOBILE

Terms = dict[str, float]


def remesh(scene: Scene, state: xr.Dataset, cells: Cells | None) -> tuple[xr.Dataset, Terms]:
    """Merge or remap a state's elements, where the scene asks for it.

    Parameters
    ----------
    scene : Scene
        Its effects say whether elements are merged, remapped or both, its keys when.
    state : xarray.Dataset
        State at a window's end, with the number of that window.
    cells : Cells or None
        Fresh cells, with ``remap``.

    Returns
    -------
    tuple of xarray.Dataset and dict
        The state, and terms of the window's budgets by their names: what was done, and what it
        did to kinetic energy and momentum.
    """
    if not (state["type"].values == MOBILE).any():
        return state, {}
    overlap = 0.0
    merged = state
    if "ridging" in scene.effects:
        on_land = ashore(scene, merged)
        merged = merge(merged, absorbed(merged, engine_params(scene), on_land))
    if "merge" in scene.effects:
        merged = merge(merged, merge_targets(merged, scene.merge.radius))
    remeshed = merged
    if "remap" in scene.effects and cells is not None:
        laid = lay(merged, cells)
        overlap = overlapping(laid, cells)
        every = scene.remap.every
        due = every > 0 and int(state.attrs["window"]) % every == 0
        if due or overlap > scene.remap.overlap:
            gap, slopes = scene.packing.bond_gap, scene.remap.order == 2
            remeshed = remap(merged, cells, laid, gap, slopes)
    terms = _terms(scene, state, merged, "merge") | _terms(scene, merged, remeshed, "remap")
    if "remap_done" in terms:
        terms["remap_overlap"] = overlap
    return remeshed, terms


def _terms(scene: Scene, before: xr.Dataset, after: xr.Dataset, kind: str) -> Terms:
    """Terms of merging or of remapping; none where the scene does not ask for it."""
    if kind == "remap" and "remap" in scene.effects:
        terms = {"remap_done": float(after is not before)}
    elif kind == "merge" and may_merge(scene):
        terms = {"merge_elements": float(before.sizes["element"] - after.sizes["element"])}
    else:
        return {}
    least = scene.dynamics.minimum_thickness
    momenta, energies = zip(*(_motion(state, least) for state in (before, after)), strict=True)
    for axis, first, last in zip("xy", *momenta, strict=True):
        terms[f"{kind}_momentum_{axis}"] = last - first
    terms[f"{kind}_energy"] = energies[1] - energies[0]
    return terms


def may_merge(scene: Scene) -> bool:
    """Whether elements may join others: where they are asked to, and where ridges use them up.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    return bool({"merge", "ridging"} & set(scene.effects))


def _motion(state: xr.Dataset, minimum_thickness: float) -> tuple[tuple[float, float], float]:
    """Momentum (kg m/s) and kinetic energy (J) of the mobile elements."""
    arrays = element_arrays(state, minimum_thickness)
    mobile = arrays["type"] == MOBILE
    mass, u, v, omega, radius = (
        arrays[name][mobile] for name in ("mass", "u", "v", "omega", "radius")
    )
    energy = 0.5 * mass * (u**2 + v**2 + 0.5 * (radius * omega) ** 2)
    return (float(mass @ u), float(mass @ v)), float(energy.sum())
