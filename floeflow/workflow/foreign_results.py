# SPDX-License-Identifier: GPL-2.0-or-later
"""Results that Snakemake has no record of: copied from elsewhere, or ``.snakemake`` was removed.

Snakemake compares ages of files, and parameters only where it has a record of them: without one it
takes whatever lies there for the results of today's scene. States say themselves what they were
made from, and ``scene.yaml`` beside them says it of grid and report.
"""

from __future__ import annotations

from base64 import urlsafe_b64encode
from collections.abc import Iterable
from pathlib import Path

from floeflow.core.errors import FloeError
from floeflow.coupling.origin import check_origin
from floeflow.scene import Scene
from floeflow.scene.hashes import STAGE_KEYS, stage_hash
from floeflow.scene.load import read_resolved
from floeflow.workflow.library import library_digest

RECORDS = (Path(".snakemake/metadata"), Path(".snakemake/incomplete"))
# The estimate is one of the whole run, which may be extended.
NOT_COMPARED = ("estimate",)


def check_results(scene: Scene, folder: Path, windows: Iterable[str]) -> None:
    """Refuse results without a record that another scene, or other code, has made.

    Parameters
    ----------
    scene : Scene
        With concrete effects.
    folder : Path
        ``results/<scene>``.
    windows : iterable of str
        Windows of which states are published, from ``0000`` on.

    Raises
    ------
    FloeError
        Names the file and what does not fit.
    """
    states = {window: folder / "state" / f"{window}.nc" for window in windows}
    unknown = {window: path for window, path in states.items() if _is_foreign(path)}
    if unknown:
        # What reads states is large, and hardly ever needed at the start of a workflow.
        from floeflow.state import read_state
    for window, path in unknown.items():
        attrs = read_state(path).attrs
        check_origin(attrs, path, scene, int(window), library_digest("windows"))
    before = folder / "scene.yaml"
    if _is_foreign(folder / "report.html") and before.is_file():
        old = read_resolved(before)
        other = [
            stage
            for stage in STAGE_KEYS
            if stage not in NOT_COMPARED and stage_hash(old, stage) != stage_hash(scene, stage)
        ]
        if other:
            raise FloeError(
                f"{folder}: was made with other keys ({', '.join(other)}) than this scene's, and "
                "Snakemake has no record of it: move it away, or give the scene another name"
            )


def _is_foreign(path: Path) -> bool:
    """Whether a file is there of which Snakemake has no record."""
    if not path.is_file():
        return False
    name = urlsafe_b64encode(path.as_posix().encode()).decode()
    # A name of more than 254 characters is a folder's; see Snakemake's persistence.
    parts = [name[at : at + 254] for at in range(0, len(name), 254)]
    place = Path(*[f"@{part}" for part in parts[:-1]], parts[-1])
    return not any((records / place).exists() for records in RECORDS)
