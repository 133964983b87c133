# SPDX-License-Identifier: GPL-2.0-or-later
"""Windows of discrete element dynamics: drives LIGGGHTS with the plugin as a library."""
