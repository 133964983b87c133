# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene: its keys (``blocks``), loader (``load``), stage hashes and generated docs."""

from floeflow.scene.blocks import Scene
from floeflow.scene.hashes import STAGE_KEYS, stage_hash
from floeflow.scene.load import load_scene, parse_scene

__all__ = ["STAGE_KEYS", "Scene", "load_scene", "parse_scene", "stage_hash"]
