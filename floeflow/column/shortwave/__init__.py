# SPDX-License-Identifier: GPL-2.0-or-later
"""Albedo and absorption of sunlight: CCSM3 and delta-Eddington."""
