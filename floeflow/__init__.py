# SPDX-License-Identifier: GPL-2.0-or-later
"""FloeFlow: a sea-ice discrete element model that runs as a workflow.

This package holds the contracts that all stages share: the scene (``config``), the registry of
``effects``, the ``state`` at a window boundary, the ``bench`` record, and the small services
(``stage``, ``lock``, ``errors``) through which a rule becomes a program.
"""

__version__ = "0.1.0"
