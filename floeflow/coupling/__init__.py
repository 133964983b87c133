# SPDX-License-Identifier: GPL-2.0-or-later
"""Coupling windows: what drives dynamics, column, forcings and transfer together."""
