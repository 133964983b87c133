# SPDX-License-Identifier: GPL-2.0-or-later
"""The sea on the scene's grid: a mixed layer that elements read and feed, and ice at its rims."""
