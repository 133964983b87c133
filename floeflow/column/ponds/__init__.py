# SPDX-License-Identifier: GPL-2.0-or-later
"""Melt ponds and the flushing of meltwater."""
