# SPDX-License-Identifier: GPL-2.0-or-later
"""Where the LIGGGHTS plugin lies."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from floeflow.core.errors import FloeError

BUILT = Path("build/liggghts_models/libfloe.so")


def plugin_path(workflow: Path | None = None) -> Path:
    """Where the plugin lies: FLOEFLOW_PLUGIN, else in a ``build`` folder, else installed.

    Parameters
    ----------
    workflow : Path, optional
        Folder of the Snakefile, whose own build comes before that of the library's checkout.

    Returns
    -------
    Path
        Of a file that is there.

    Raises
    ------
    FloeError
        Where there is none at any of these places, or not where FLOEFLOW_PLUGIN says.
    """
    named = os.environ.get("FLOEFLOW_PLUGIN")
    if named:
        if not Path(named).is_file():
            raise FloeError(
                f"FLOEFLOW_PLUGIN={named}: there is no such file; leave FLOEFLOW_PLUGIN out for "
                "the one that 'make setup' builds"
            )
        return Path(named)
    roots = [root for root in (workflow, Path(__file__).resolve().parents[2]) if root is not None]
    places = [root / BUILT for root in roots]
    places += [Path(sys.prefix) / "lib" / BUILT.name, Path("/usr/local/lib") / BUILT.name]
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        raise FloeError(
            f"{places[0]}: the LIGGGHTS plugin is not built; 'make setup' builds it, and "
            "FLOEFLOW_PLUGIN=/path/to/libfloe.so names one elsewhere"
        )
    return found
