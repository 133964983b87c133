# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene: its keys (``blocks``), loader (``load``), stage hashes and generated docs."""

from floeflow.config.blocks import Scene
from floeflow.config.load import load_scene, parse_scene
from floeflow.config.stages import STAGE_KEYS, stage_hash

__all__ = ["STAGE_KEYS", "Scene", "load_scene", "parse_scene", "stage_hash"]
