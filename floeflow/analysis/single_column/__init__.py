# SPDX-License-Identifier: GPL-2.0-or-later
"""One column without elements, driven by a file of forcing."""
