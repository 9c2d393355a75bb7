"""The demo's web page: plain HTML that opens from a folder, without a server."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

STYLE = """
body { font: 16px/1.55 system-ui, sans-serif; color: #2d3748; background: #f7fafc; margin: 0; }
main { max-width: 1080px; margin: 0 auto; padding: 1.5rem 1.2rem 4rem; }
h1 { font-size: 1.9rem; margin: .6rem 0 .2rem; } h2 { margin: 2.6rem 0 .4rem; font-size: 1.35rem; }
p, li { max-width: 46rem; } nav a { margin-right: .9rem; } a { color: #2b6cb0; }
figure { margin: 1rem 0; background: white; border: 1px solid #e2e8f0; border-radius: 8px;
         padding: .8rem; text-align: center; }
figure img { max-width: 100%; height: auto; }
figcaption { color: #4a5568; font-size: .9rem; text-align: left; margin-top: .5rem; }
table { border-collapse: collapse; margin: 1rem 0; background: white; display: block;
        overflow-x: auto; }
th, td { border-bottom: 1px solid #e2e8f0; padding: .35rem .8rem; text-align: right; }
th { color: #4a5568; font-weight: 600; font-size: .9rem; } td:first-child, th:first-child
{ text-align: left; } .swatch { display: inline-block; width: .9em; height: .9em;
border-radius: 3px; margin: 0 .35em -.1em 0; } .key span { white-space: nowrap;
margin-right: 1.1rem; } code { background: #edf2f7; border-radius: 4px; padding: .1em .3em; }
"""


@dataclass(frozen=True)
class Picture:
    """An image file beside the page and what it shows."""

    file: str
    caption: str


@dataclass(frozen=True)
class Table:
    """Column names and rows of text."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Section:
    """A part of the page: heading, paragraphs, then tables, then pictures."""

    anchor: str
    heading: str
    paragraphs: Sequence[str]
    tables: Sequence[Table] = field(default=())
    pictures: Sequence[Picture] = field(default=())


def render(title: str, lead: Sequence[str], key: Sequence[tuple[str, str]],
           sections: Sequence[Section]) -> str:  # fmt: skip
    """Return the page as HTML.

    Parameters
    ----------
    title : str
    lead : sequence of str
        Opening paragraphs.
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
        *(_paragraph(text) for text in lead),
        f'<p class="key">{swatches}</p>',
        f"<nav>{links}</nav>",
        *(_section(section) for section in sections),
        "</main></body></html>",
    ]
    return "\n".join(parts) + "\n"


def _section(section: Section) -> str:
    parts = [f'<h2 id="{section.anchor}">{escape(section.heading)}</h2>']
    parts += [_paragraph(text) for text in section.paragraphs]
    parts += [_table(table) for table in section.tables]
    parts += [_picture(picture) for picture in section.pictures]
    return "\n".join(parts)


def _paragraph(text: str) -> str:
    return f"<p>{escape(text)}</p>"


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in table.columns)
    rows = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in table.rows
    )
    return f"<table><tr>{head}</tr>{rows}</table>"


def _picture(picture: Picture) -> str:
    caption = escape(picture.caption)
    return (
        f'<figure><img src="{escape(picture.file)}" alt="{caption}" loading="lazy">'
        f"<figcaption>{caption}</figcaption></figure>"
    )
