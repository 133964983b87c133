# SPDX-License-Identifier: GPL-2.0-or-later
"""A run beside what was observed: buoys, concentration, thickness; and beside other runs."""
