# SPDX-License-Identifier: GPL-2.0-or-later
"""Names of files of polygons, known without a library that reads them."""

from __future__ import annotations

from pathlib import Path

SHAPEFILE, GEOJSON = ".shp", (".json", ".geojson")


def is_polygon_file(name: str) -> bool:
    """Whether a name is that of a file of polygons, by its ending.

    Parameters
    ----------
    name : str
        Of a file.

    Returns
    -------
    bool
        True for GeoJSON and shapefiles.
    """
    return Path(name).suffix.lower() in (*GEOJSON, SHAPEFILE)


def files_of_polygons(name: str) -> list[str]:
    """Files that are read for polygons of a file, or of none: of a shapefile its .prj too.

    Parameters
    ----------
    name : str
        Of a file; empty for none.

    Returns
    -------
    list of str
        Empty for an empty name.
    """
    path = Path(name)
    beside = [str(path.with_suffix(".prj"))] if path.suffix.lower() == SHAPEFILE else []
    return [name, *beside] if name else []
