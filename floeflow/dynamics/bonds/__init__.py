# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds that form and grow between windows."""
