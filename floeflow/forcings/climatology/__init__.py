# SPDX-License-Identifier: GPL-2.0-or-later
"""A synthetic year of forcing from monthly tables, pressure centres and a process of storms.

`fields` gives any of the forcing's variables at any places and times, `window_forcing` those of a
coupling window on the scene's grid. What is synthetic about it: docs/climatology.md.
"""

from floeflow.forcings.climatology.fields import NAMES, fields
from floeflow.forcings.climatology.window import scene_fields, window_forcing

__all__ = ["NAMES", "fields", "scene_fields", "window_forcing"]
