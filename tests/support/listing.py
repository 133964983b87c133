# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of the project, those that git does not track yet included."""

from __future__ import annotations

import subprocess
from pathlib import Path


def listed(project: Path, *patterns: str) -> list[str]:
    """Names of the files of these patterns that are there, all without patterns."""
    names = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", *patterns],
        cwd=project,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    return [name for name in names if (project / name).is_file()]
