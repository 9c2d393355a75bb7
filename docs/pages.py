"""Sphinx extension: pages of the documentation that are made from other files of the repository."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
ELSEWHERE = re.compile(r"\]\((?!https?:|#)([^)\s]+)\)")
COMMENT = re.compile("<!--.*?-->")
COPIES = {
    "results.md": "experiments/FINDINGS.md",
    "changelog.md": "CHANGELOG.md",
    "datasets.md": "data/README.md",
    "memories.md": "models/README.md",
}
"""Pages that are other documents of the repository."""


def setup(app: Any) -> dict[str, bool]:
    """Register the pages with Sphinx."""
    app.connect("builder-inited", lambda app: write_pages())
    app.connect("source-read", _without_paths)
    return {"parallel_read_safe": True}


def write_pages() -> None:
    """Write the pages that are no files of this folder."""
    for name, source in COPIES.items():
        _write(name, COMMENT.sub("", (ROOT / source).read_text("utf-8")))
    _write("schemas.md", schemas_page())


def schemas_page() -> str:
    """Return the JSON Schemas of situations and arms as a page."""
    from gcm_learn.situation import schemas

    parts = [
        "# JSON Schemas",
        "Schemas of the [formats](exchange.md). The package derives them from its records: "
        "`gcm_learn.situation.schemas()`.",
    ]
    for name, schema in schemas().items():
        parts += [f"## {name}", f"```json\n{json.dumps(schema, indent=1)}\n```"]
    return "\n\n".join(parts) + "\n"


def _write(name: str, text: str) -> None:
    """Write a page if it differs, so that Sphinx reads it again only then."""
    path = DOCS / name
    if not path.exists() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")


def _without_paths(app: Any, page: str, content: list[str]) -> None:
    """Replace links to files outside of the site by their names."""
    content[0] = ELSEWHERE.sub(
        lambda link: link[0] if _is_page(link[1]) else f"] (`{Path(link[1]).name}`)", content[0]
    )


def _is_page(target: str) -> bool:
    place = target.partition("#")[0]
    return place.startswith("images/") or ((DOCS / place).is_file() and ".." not in place)
