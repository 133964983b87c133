# SPDX-License-Identifier: GPL-2.0-or-later
"""``python -m floeflow.analysis.studies.hard_cases``: docs/hard_cases.md of `make stability`."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from floeflow.core.errors import FloeError, answer
from floeflow.core.records import machine
from floeflow.diagnostics.study_summaries import DIGEST, read_summary
from floeflow.report.study_page import Table, as_markdown
from floeflow.scene.docs import PROJECT

PAGE, IMAGES = PROJECT / "docs/hard_cases.md", PROJECT / "docs/images/stability"
HEAD = """# Hard cases, measured

What each of the [hard cases](stability.md) showed. Made by `make stability` on {machine}.
"""


def write_document(
    results: Path = Path("results/stability"), page: Path = PAGE, images: Path = IMAGES
) -> Path:
    """Write docs/hard_cases.md and copy its figures beside it.

    Parameters
    ----------
    results : Path, optional
        Folder of the hard cases' results.
    page : Path, optional
        Markdown file.
    images : Path, optional
        Folder of the figures.

    Raises
    ------
    FloeError
        Where the hard cases were not run.
    """
    if not (results / DIGEST).is_file():
        raise FloeError(f"{results}: the hard cases were not run; 'make stability' does it")
    digest = read_summary(results / DIGEST)
    parts = [HEAD.format(machine=machine()), *(f"- {said}" for said in digest["cards"]), ""]
    for entry in digest["tables"]:
        table = Table(**entry)
        parts += [as_markdown(table), ""]
    images.mkdir(parents=True, exist_ok=True)
    for drawing in digest["drawings"]:
        file = f"{drawing['name']}.png"
        shutil.copyfile(results / "figures" / file, images / file)
        place = (images / file).relative_to(page.parent).as_posix()
        parts += [drawing["caption"], "", f"![{drawing['name']}]({place})", ""]
    parts += ["## All tests", "", (results / "table.md").read_text()]
    page.write_text("\n".join(parts))
    return page


if __name__ == "__main__":
    sys.exit(answer(write_document))
