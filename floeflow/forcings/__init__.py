# SPDX-License-Identifier: GPL-2.0-or-later
"""Winds, currents, radiation and weather on the scene's grid, from files or formulae."""
