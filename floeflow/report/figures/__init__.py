# SPDX-License-Identifier: GPL-2.0-or-later
"""The report's figures, one module per family; each function takes data and returns a figure."""
