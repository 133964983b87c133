# SPDX-License-Identifier: GPL-2.0-or-later
"""From a mask to elements: cells, discs, bonds."""
