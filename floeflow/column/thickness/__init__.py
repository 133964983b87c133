# SPDX-License-Identifier: GPL-2.0-or-later
"""The thickness distribution: categories, ridging, new ice, leads."""
