# SPDX-License-Identifier: GPL-2.0-or-later
"""What people read: figures, text and pages."""
