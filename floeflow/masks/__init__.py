# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice and land on the scene's grids, from mask files."""
