# SPDX-License-Identifier: GPL-2.0-or-later
"""Foundations: constants, errors, reading of CF files, grids, polygons, records, atomic files, locks."""
