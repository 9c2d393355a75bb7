"""The demo's web page: plain HTML that opens from a folder, without a server."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

STYLE = """
body { font: 16px/1.55 system-ui, sans-serif; color: #2d3748; background: #f7fafc; margin: 0; }
main { max-width: 1142px; margin: 0 auto; padding: 1.5rem 1.2rem 4rem; }
h1 { font-size: 1.9rem; margin: .6rem 0 .2rem; } h2 { margin: 2.6rem 0 .4rem; font-size: 1.35rem; }
p, li { max-width: 46rem; } a { color: #2b6cb0; }
nav a { margin-right: .9rem; display: inline-block; }
.row { display: flex; flex-wrap: wrap; gap: 1rem; margin: 1rem 0; }
figure { flex: 1 1 auto; margin: 0; background: white; border: 1px solid #e2e8f0;
         border-radius: 8px; padding: .8rem; text-align: center; box-sizing: border-box;
         max-width: 100%; }
figure img { max-width: 100%; height: auto; }
figcaption { color: #4a5568; font-size: .9rem; text-align: left; margin-top: .5rem;
             width: 0; min-width: 100%; }
table { border-collapse: collapse; margin: 1rem 0; background: white; display: block;
        overflow-x: auto; width: fit-content; max-width: 100%; }
summary { cursor: pointer; color: #2b6cb0; }
th, td { border-bottom: 1px solid #e2e8f0; padding: .35rem .8rem; text-align: right; }
th { color: #4a5568; font-weight: 600; font-size: .9rem; } td:first-child, th:first-child
{ text-align: left; white-space: nowrap; } td:nth-child(2):last-child, th:nth-child(2):last-child
{ text-align: left; } .swatch { display: inline-block; width: .9em; height: .9em;
border-radius: 3px; margin: 0 .35em -.1em 0; } .key span { white-space: nowrap;
margin-right: 1.1rem; } .key { max-width: none; }
code { background: #e2e8f0; border-radius: 4px; padding: .1em .3em; }
"""


@dataclass(frozen=True)
class Picture:
    """An image file beside the page and what it shows."""

    file: str
    caption: str
    width: int
    """Of the image on the page [CSS pixels]; it may have more pixels than that."""


@dataclass(frozen=True)
class Table:
    """Column names and rows of text."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    fold: str = ""
    """If there is such a line, the table opens when it is clicked."""


@dataclass(frozen=True)
class Section:
    """A part of the page: heading, paragraphs, then tables, then pictures, then folded tables.

    In paragraphs, `words between backticks` are set as code.
    """

    anchor: str
    heading: str
    paragraphs: Sequence[str]
    tables: Sequence[Table] = field(default=())
    pictures: Sequence[Picture] = field(default=())


def render(title: str, lead: Sequence[str], opening: Picture, key: Sequence[tuple[str, str]],
           sections: Sequence[Section]) -> str:  # fmt: skip
    """Return the page as HTML.

    Parameters
    ----------
    title : str
    lead : sequence of str
        Opening paragraphs, the first of them above the opening picture.
    opening : Picture
    key : sequence of (str, str)
        Colours of the pictures and their meanings.
    sections : sequence of Section

    Returns
    -------
    str
    """
    links = "".join(f'<a href="#{s.anchor}">{escape(s.heading)}</a>' for s in sections)
    swatches = "".join(
        f'<span><i class="swatch" style="background:{colour}"></i>{escape(meaning)}</span>'
        for colour, meaning in key
    )
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body><main>",
        f"<h1>{escape(title)}</h1>",
        *(_paragraph(text) for text in lead[:1]),
        _pictures([opening]),
        f'<p class="key">{swatches}</p>',
        *(_paragraph(text) for text in lead[1:]),
        f"<nav>{links}</nav>",
        *(_section(section) for section in sections),
        "</main></body></html>",
    ]
    return "\n".join(parts) + "\n"


def _section(section: Section) -> str:
    parts = [f'<h2 id="{section.anchor}">{escape(section.heading)}</h2>']
    parts += [_paragraph(text) for text in section.paragraphs]
    parts += [_table(table) for table in section.tables if not table.fold]
    parts.append(_pictures(section.pictures))
    parts += [_folded(table) for table in section.tables if table.fold]
    return "\n".join(part for part in parts if part)


def _paragraph(text: str) -> str:
    """A paragraph; `code` and [text](address) are set as in Markdown."""
    linked = re.sub(r"\[([^]]+)\]\(([^)]+)\)", r'<a href="\2">\1</a>', escape(text))
    return "<p>" + re.sub("`([^`]+)`", r"<code>\1</code>", linked) + "</p>"


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in table.columns)
    rows = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in table.rows
    )
    return f"<table><tr>{head}</tr>{rows}</table>"


def _folded(table: Table) -> str:
    return f"<details><summary>{escape(table.fold)}</summary>{_table(table)}</details>"


def _pictures(pictures: Sequence[Picture]) -> str:
    """Set pictures side by side as far as the window is wide enough."""
    figures = "\n".join(_picture(picture) for picture in pictures)
    return f'<div class="row">{figures}</div>' if figures else ""


def _picture(picture: Picture) -> str:
    caption = escape(picture.caption)
    return (
        f'<figure><img src="{escape(picture.file)}" alt="{caption}" width="{picture.width}">'
        f"<figcaption>{caption}</figcaption></figure>"
    )
