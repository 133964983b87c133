# SPDX-License-Identifier: GPL-2.0-or-later
"""What a window's rule tells the ranks that it starts, as one JSON text."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

from floeflow.scene import Scene


@dataclass(frozen=True)
class Job:
    """Windows to advance in one MPI launch.

    Parameters
    ----------
    scene : dict
        The scene, as ``Scene.model_dump(mode="json")`` gives it.
    state : str
        File of the state to start from.
    windows : list of str
        Names of the chunk's windows.
    done : int
        How many of them, from the first on, are finished.
    hashes : list of str
        Hash of all that makes each window; see ``resume.window_hashes``.
    folder : str
        ``results/<scene>``.
    fixed : dict
        What is the same for all windows of a run, kept in each state's provenance.
    cells : str
        File of the fresh cells; empty where nothing is remapped.
    mask : str
        File of the mask, in which the sea is; empty without a mixed layer.
    """

    scene: dict[str, object]
    state: str
    windows: list[str]
    done: int
    hashes: list[str]
    folder: str
    fixed: dict[str, str]
    cells: str = ""
    mask: str = ""

    def to_json(self) -> str:
        """Return the job as one line of JSON."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Job:
        """Read what `to_json` wrote.

        Parameters
        ----------
        text : str
            JSON.

        Returns
        -------
        Job
            Equal to the one that was written.
        """
        return cls(**json.loads(text))

    def read_scene(self) -> Scene:
        """Return the scene as a model."""
        return Scene.model_validate(self.scene)
