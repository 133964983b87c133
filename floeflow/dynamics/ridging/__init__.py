# SPDX-License-Identifier: GPL-2.0-or-later
"""Area that ridges take from elements."""
