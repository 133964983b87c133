# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages of commands have LAMMPS' form."""

from __future__ import annotations

import re
from pathlib import Path

PARTS = ["Syntax", "Examples", "Description", "Restrictions", "Related", "Default"]
# fix floe/walls is FloeFlow's own, for scenes.
WITHOUT_PAGE = {"fix_floe_walls"}


def test_each_command_has_a_page_with_all_parts(project: Path) -> None:
    source = (project / "liggghts_models" / "plugin.cpp").read_text()
    pages = {"pair_floe", "fix_wall_floe", "floe_bonds"}
    for kind, prefix in (("fixes", "fix"), ("computes", "compute")):
        styles = re.findall(rf'{kind}\["([a-z/]+)"\] =', source)
        pages |= {f"{prefix}_{style.replace('/', '_')}" for style in styles}
    pages -= WITHOUT_PAGE
    assert len(pages) == 7
    for page in sorted(pages):
        text = (project / "docs" / "models" / f"{page}.md").read_text()
        assert re.findall(r"^## (.*)", text, re.MULTILINE) == PARTS, page
