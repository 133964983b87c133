# SPDX-License-Identifier: GPL-2.0-or-later
"""From states to what people and models read: grids, remapping, diagnostics, report."""
