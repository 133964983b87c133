# SPDX-License-Identifier: GPL-2.0-or-later
"""Cures for distortion between windows: elements to fresh elements, and merging.

`overlap` cuts old cells by fresh ones, `transport` carries what the elements hold along the
pieces, `spread` makes room where too much came together, `pairs` makes bonds and contacts anew,
`remap` puts it all together; `merge` joins elements that became too small. docs/theory/remap.md
has the equations.
"""
