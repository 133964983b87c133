# SPDX-License-Identifier: GPL-2.0-or-later
"""Foundations: constants, errors, CF files, grids, polygons, records, atomic files, locks."""
