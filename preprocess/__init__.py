# SPDX-License-Identifier: GPL-2.0-or-later
"""Preprocessing: from an ice mask and forcing to the packed elements of the state at the start."""
