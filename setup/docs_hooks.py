# SPDX-License-Identifier: GPL-2.0-or-later
"""What MkDocs does with links out of docs/: pages come along, other files become plain names."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File

# Pages of the project that lie elsewhere, by their path from its root: name on the site.
MORE = {"config/README.md": "config.md"}
LINK = re.compile(r"\[([^\]]*)\]\((?!\w+:|#)([^)#\s]+)(#[^)]*)?\)")


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that lie outside of docs/."""
    root = Path(config["config_file_path"]).parent
    for source, name in MORE.items():
        files.append(File.generated(config, name, abs_src_path=str(root / source)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Turn links that leave docs/."""
    root = Path(config["config_file_path"]).parent
    docs = Path(config["docs_dir"])
    name = page.file.src_uri
    outside = {on_site: source for source, on_site in MORE.items()}
    here = (root / outside[name]).parent if name in outside else (docs / name).parent

    def turned(match: re.Match[str]) -> str:
        text, link, anchor = match[1], match[2], match[3] or ""
        target = Path(posixpath.normpath(here.as_posix() + "/" + link))
        if target.is_relative_to(docs):
            if name not in outside and "/README" not in link:
                return match[0]
            path = target.relative_to(docs).as_posix()
        else:
            path = (
                MORE.get(target.relative_to(root).as_posix(), "")
                if target.is_relative_to(root)
                else ""
            )
        if not path:
            return f"{text} (`{link.lstrip('./')}`)" if text.strip("`") != link else text
        return f"[{text}]({posixpath.relpath(path, posixpath.dirname(name) or '.')}{anchor})"

    return LINK.sub(turned, markdown)
