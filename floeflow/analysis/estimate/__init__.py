# SPDX-License-Identifier: GPL-2.0-or-later
"""What each effect would change and cost in a scene, estimated before anything runs."""
