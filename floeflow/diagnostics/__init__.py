# SPDX-License-Identifier: GPL-2.0-or-later
"""What a run showed, as data: budgets, gridded fields, drift, trajectories, costs."""
