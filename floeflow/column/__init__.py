# SPDX-License-Identifier: GPL-2.0-or-later
"""Column physics: growth and melt of ice and snow on each element between two DEM windows."""
