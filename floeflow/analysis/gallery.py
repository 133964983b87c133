# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of the packings of example scenes, and the page that shows them: `make gallery`.

Usage: python -m floeflow.analysis.gallery [name ...]
Each scene goes through land, mask, packing and bonds, in this process. A scene whose file is not
there is skipped, with the file's name; files are also looked for by name under the folder that
FLOEFLOW_SHARED names.
"""

from __future__ import annotations

import os
import sys
import tempfile
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from floeflow.core.period import period_of, shifts
from floeflow.coupling.first_state import Pack, first_pack
from floeflow.report.figures.frame import Frame, draw_land, draw_scale_bar, prepare_axes
from floeflow.report.figures.maps import element_shapes
from floeflow.report.figures.style import CONCENTRATION, look, new_figure, write_png
from floeflow.report.report_text import number
from floeflow.scene import Scene, load_scene
from floeflow.scene.docs import PROJECT
from floeflow.state.schema import MOBILE

SCENES = PROJECT / "config/scenes"
PAGE, PICTURES = PROJECT / "docs/gallery.md", PROJECT / "docs/images/gallery"
SHARED = "FLOEFLOW_SHARED"
DPI = 100


@dataclass(frozen=True)
class View:
    """What the picture of a scene shows beside the whole.

    Parameters
    ----------
    scene : str
        Name of its file in config/scenes.
    x, y, width : float
        Centre and width (km) of the part that is drawn large.
    text : str
        What there is to see.
    """

    scene: str
    x: float
    y: float
    width: float
    text: str


VIEWS = (
    View("arctic_february_2015", -900.0, 100.0, 700.0,
         "The Arctic of 1 February 2015 (NSIDC-0051) in 62,000 elements of 15 km. Nares Strait, "
         "narrower than two cells of the mask, is open as on the 1 km mask."),
    View("arctic_august_2015", -1400.0, 300.0, 900.0,
         "The Arctic of 18 August 2015 (NSIDC-0081). Ice under 80 % has no bonds."),
    View("fram_strait", -330.0, -1130.0, 160.0,
         "Fram Strait in elements of 3 km, finer at the coast and at the ice edge. Ice flows in "
         "over the northern side and leaves over the others."),
    View("modis_floes", -1560.0, -215.0, 80.0,
         "Floes segmented from a MODIS scene of 1 August 2012. Each is a bonded cluster with the "
         "floe's area, centroid and second moments; none is bonded to another."),
    View("antarctic", -2100.0, 1300.0, 1300.0,
         "The Antarctic in September, within an ice edge drawn by hand: finer at the coast, sizes "
         "of neighbours spread."),
    View("dense_pack_pressed", 10.0, 5.0, 6.0,
         "Floes of two sizes, compacted by the element model to 0.82 of the area, a little below "
         "where they jam; the right wall will press them."),
    View("periodic_pack_pressed", 10.0, 9.0, 6.0,
         "The same sizes in a rectangle that repeats itself in y, frozen together: bonds reach "
         "across the sides (right: across y = 10 km). The right wall will press them."),
    View("drift_ice", 0.0, -980.0, 12.0,
         "Three tenths of ice as whole floes whose radii follow a power law."),
    View("ice_arch", 0.0, -1210.0, 90.0,
         "A channel drawn as a shoreline of the user's; twelve elements across at least."),
)  # fmt: skip


def found_file(path: str) -> str:
    """A file of a scene: its own path, or one of that name under the shared folder; or empty.

    Parameters
    ----------
    path : str
        As the scene names it, from the project's folder.
    """
    if not path or (PROJECT / path).is_file():
        return path and str(PROJECT / path)
    shared = os.environ.get(SHARED)
    for found in sorted(Path(shared).rglob(Path(path).name)) if shared else []:
        return str(found)
    return ""


def with_files(scene: Scene) -> Scene | None:
    """The scene with its files where they are; None where one is missing.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    mask = scene.mask
    labels = mask.labels.model_copy(update={"file": found_file(mask.labels.file)})
    changes = {"labels": labels, "file": found_file(mask.file)}
    changes |= {name: found_file(getattr(mask, name)) for name in ("region", "shoreline")}
    wanted = mask.labels.file if scene.packing.generator == "floes" else mask.file
    if mask.uniform == 0.0 and not found_file(wanted):
        return None
    return scene.model_copy(update={"mask": mask.model_copy(update=changes)})


def colours(packing: xr.Dataset) -> np.ndarray:
    """Of each element: by its floe, or by concentration; those of the coast are left out.

    Parameters
    ----------
    packing : xarray.Dataset
        Elements of the packing.

    Returns
    -------
    ndarray
        RGBA of the mobile elements, (n, 4).
    """
    mobile = packing["type"].values == MOBILE
    if "floe" in packing:
        tones = np.random.default_rng(3).uniform(0.45, 0.98, (int(packing["floe"].max()) + 1, 3))
        return np.asarray(tones[packing["floe"].values])
    share = packing["ice_fraction"].values.sum(axis=1)
    if "concentration" in packing:
        share = np.where(mobile, 0.9, 0.0)
    return np.asarray(CONCENTRATION.cmap(share))


def draw(view: View, scene: Scene, mask: xr.Dataset, packing: xr.Dataset) -> Figure:
    """Whole packing on the left, a part of it with discs on the right.

    Parameters
    ----------
    view : View
        Which part is enlarged.
    scene : Scene
        Its keys.
    mask : xarray.Dataset
        With land.
    packing : xarray.Dataset
        Elements.

    Returns
    -------
    Figure
        Two maps, axes in km.
    """
    frame = Frame(scene.domain, mask["land"])
    unturned = packing.assign(theta=("element", np.zeros(packing.sizes["element"])))
    shapes = element_shapes(unturned, packing)
    with look():
        figure = new_figure(11.0, 5.2)
        whole, part = figure.subplots(1, 2)
        prepare_axes(whole, frame, scene.report.title, CONCENTRATION.water)
        tones = colours(packing)[shapes.of_polygon]
        cells = PolyCollection(shapes.polygons, facecolors=tones, edgecolors=tones, linewidths=0.2)
        cells.set_zorder(3)
        whole.add_collection(cells)
        half = 0.5 * view.width
        corner = (view.x - half, view.y - half)
        box = Rectangle(corner, view.width, view.width, fill=False, edgecolor="#c0392b", zorder=9)
        whole.add_patch(box)
        part.set_facecolor(CONCENTRATION.water)
        draw_land(part, mask["land"])
        for shift in copies(packing):
            drawn = [polygon + shift for polygon in shapes.polygons]
            lines = PolyCollection(drawn, facecolors=tones, edgecolors="white")
            lines.set(linewidths=0.7, zorder=3)
            part.add_collection(lines)
        part.set(xlim=(view.x - half, view.x + half), ylim=(view.y - half, view.y + half))
        part.set(aspect="equal", xticks=[], yticks=[], title=f"{view.width:g} km of it")
        draw_scale_bar(part, view.width)
    return figure


def copies(packing: xr.Dataset) -> list[np.ndarray]:
    """Shifts (km), (2,), at which a packing is drawn: where it is, and where it repeats itself.

    Parameters
    ----------
    packing : xarray.Dataset
        Elements, and the period as attributes.
    """
    return [shift / 1e3 for shift in shifts(period_of(packing.attrs))]


def draw_discs(axes: Axes, packing: xr.Dataset, bonds: xr.Dataset | None) -> None:
    """Discs as circles, those of the coast filled, and the glue lines of the bonds.

    Parameters
    ----------
    axes : Axes
        In km.
    packing : xarray.Dataset
        Elements (m).
    bonds : xarray.Dataset or None
        None where there are none.
    """
    mobile = packing["type"].values == MOBILE
    places = np.stack([packing["x"].values, packing["y"].values], axis=1) / 1e3
    wide = 2.0 * packing["radius"].values / 1e3
    kinds = ((mobile, "none", "#2c3e50"), (~mobile, "#7f6a55", "none"))
    for shift, (chosen, face, edge) in product(copies(packing), kinds):
        axes.add_collection(
            EllipseCollection(
                wide[chosen], wide[chosen], np.zeros(int(chosen.sum())), units="xy",
                offsets=places[chosen] + shift, offset_transform=axes.transData,
                facecolors=face, edgecolors=edge, linewidths=0.6, zorder=4,
            )
        )  # fmt: skip
    if bonds is not None and bonds.sizes["bond"]:
        row = bonds["bond_id_lo"].values - 1
        ends = [
            places[row] + np.stack([bonds[f"bond_lo_{end}{axis}"] for axis in "xy"], axis=1) / 1e3
            for end in "ab"
        ]
        for shift in copies(packing):
            drawn = list(np.stack(ends, axis=1) + shift)
            axes.add_collection(LineCollection(drawn, colors="#c0392b", linewidths=0.9, zorder=5))


def figures_of(made: Pack) -> str:
    """A line of figures for the page.

    Parameters
    ----------
    made : Pack
        Packing, and what making it took.
    """
    packing, bonds = made.packing, made.bonds
    value = {str(name): float(item) for name, item in packing.data_vars.items() if item.ndim == 0}
    mobile = int((packing["type"].values == MOBILE).sum())
    parts = [f"{mobile:,} elements"]
    if bonds is not None:
        parts.append(f"{bonds.sizes['bond']:,} bonds")
    parts.append(f"cells {number(value['quality_size_median'] / 1e3, 3)} km, spread of the "
                 f"logarithm {number(value['quality_size_spread'], 2)}")  # fmt: skip
    parts.append(f"discs fill {number(value['quality_disc_share'], 3)} of the ice's area")
    parts.append(f"ice area off by {abs(value['quality_area_error']):.0e}")
    if value["quality_ashore"] > 0.0:
        parts.append(f"{number(100 * value['quality_ashore'], 2)} % of it on land")
    if "quality_outline_distance" in value:
        far = number(value["quality_outline_distance"], 3)
        parts.append(f"discs {far} m from the outlines on average")
        worst = number(100 * value["quality_moment_error"], 2)
        parts.append(f"second moments of the floes off by {worst} % of their trace at most")
    return ", ".join(parts)


def main(names: list[str]) -> int:
    """Draw the scenes that are named, or all, and write the page anew.

    Parameters
    ----------
    names : list of str
        Of scenes in ``config/scenes``; empty for all.

    Returns
    -------
    int
        Exit code.
    """
    PICTURES.mkdir(parents=True, exist_ok=True)
    for view in VIEWS:
        if names and view.scene not in names:
            continue
        path = SCENES / f"{view.scene}.yaml"
        scene = with_files(load_scene(path))
        if scene is None:
            wanted = load_scene(path).mask
            file = wanted.labels.file or wanted.file
            print(f"{view.scene}: skipped, {file} is not there; {path} says where to get it")
            continue
        with tempfile.TemporaryDirectory() as scratch:
            made = first_pack(scene, Path(scratch))
        figure = draw(view, scene, made.mask, made.packing)
        with look():
            draw_discs(figure.axes[1], made.packing, made.bonds)
        write_png(figure, PICTURES / f"{view.scene}.png", DPI)
        (PICTURES / f"{view.scene}.txt").write_text(figures_of(made) + "\n")
        print(f"{view.scene}: {figures_of(made)}", flush=True)
    PAGE.write_text(page())
    return 0


def page() -> str:
    """The page, of the pictures that are there."""
    lines = [
        "# Gallery of packings",
        "",
        "Each is a scene in `config/scenes`, drawn by `make gallery`; how they are made stands in",
        "[theory/packing.md](theory/packing.md). Left: the elements at the start, white where the",
        "ice is dense. Right: a part of it, with discs, coast elements (brown) and bonds (red).",
    ]
    for view in VIEWS:
        picture = PICTURES / f"{view.scene}.png"
        if picture.is_file():
            figures = picture.with_suffix(".txt").read_text().strip()
            lines += ["", f"## {view.scene}", "", view.text, "", f"![{view.scene}]"
                      f"(images/gallery/{view.scene}.png)", "", f"{figures}."]  # fmt: skip
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
