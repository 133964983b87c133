# SPDX-License-Identifier: GPL-2.0-or-later
"""What stands above a run: estimates, plans, studies, a column of its own."""
