# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies of one scene through many runs of it: ablation of effects, accuracy against cost."""
