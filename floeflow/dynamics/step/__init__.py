# SPDX-License-Identifier: GPL-2.0-or-later
"""The largest stable time step."""
