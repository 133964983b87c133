# SPDX-License-Identifier: GPL-2.0-or-later
"""Heat and phase change in ice and snow: zero-layer, Bitz-Lipscomb, mushy."""
