# SPDX-License-Identifier: GPL-2.0-or-later
"""LIGGGHTS with the plugin, driven from Python."""
