# SPDX-License-Identifier: GPL-2.0-or-later
"""Plan a run: settings for an error or a budget, from models fitted to the accuracy studies."""
