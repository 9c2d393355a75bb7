"""Web pages from templates: plain HTML that opens from a folder, without a server."""

from __future__ import annotations

import base64
import io
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from matplotlib.figure import Figure

SCALE, SHARPNESS = 80, 1.5  # [CSS pixels per inch], pixels of an image per CSS pixel


@dataclass(frozen=True)
class Picture:
    """An image in a file beside the page, or within the page, with its caption."""

    file: str
    caption: str
    width: int
    """Of the image on the page [CSS pixels]; it may have more pixels than that."""


@dataclass(frozen=True)
class PageTable:
    """Column names and rows of text."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    fold: str = ""
    """If there is such a line, the table opens when it is clicked."""


@dataclass(frozen=True)
class Section:
    """A part of the page: heading, paragraphs, then tables, then pictures, then folded tables.

    In paragraphs, `code` and [words](address) are set as in Markdown.
    """

    anchor: str
    heading: str
    paragraphs: Sequence[str]
    tables: Sequence[PageTable] = field(default=())
    pictures: Sequence[Picture] = field(default=())


def render(title: str, lead: Sequence[str], opening: Picture, key: Sequence[tuple[str, str]],
           sections: Sequence[Section], *, back: str = "",
           beside: Sequence[Picture] = ()) -> str:  # fmt: skip
    """Return a page as HTML.

    Parameters
    ----------
    title : str
    lead : sequence of str
        Opening paragraphs, the first of them above the opening picture.
    opening : Picture
    key : sequence of (str, str)
        Colours of the pictures and their meanings.
    sections : sequence of Section
    back : str
        Address of the page that links here.
    beside : sequence of Picture
        Pictures beside the opening one.

    Returns
    -------
    str
    """
    told = {"title": title, "lead": lead, "key": key, "sections": sections}
    told |= {"opening": [opening, *beside]}
    return fill("page.html", told | {"back": back})


def section(
    told_of: Mapping[str, Any],
    anchor: str,
    tables: Sequence[PageTable] = (),
    pictures: Sequence[Picture] = (),
    *,
    text: Sequence[str] | None = None,
    told: Mapping[str, Any] | None = None,
) -> Section:
    """Return a section with the words that a page's text file has under `sections`.

    Parameters
    ----------
    told_of : mapping
        Of `words`.
    anchor : str
    tables : sequence of Table
    pictures : sequence of Picture
    text : sequence of str, optional
        Other paragraphs than those of the file.
    told : mapping, optional
        What is filled into braces.
    """
    entry = told_of["sections"][anchor]
    found = entry["text"] if text is None else text
    paragraphs = [found] if isinstance(found, str) else found
    filled = [paragraph.format(**(told or {})) for paragraph in paragraphs]
    return Section(anchor, entry["heading"].format(**(told or {})), filled, tables, pictures)


def words(page: str) -> dict[str, Any]:
    """Return the texts of a page, from its TOML file among the templates."""
    found = files(__package__).joinpath("templates", f"{page}.toml")
    return tomllib.loads(found.read_text("utf-8"))


def fill(template: str, values: Mapping[str, Any]) -> str:
    """Return one of the package's templates, filled in with values."""
    return _templates().get_template(template).render({"back": ""} | dict(values))


@cache
def _templates() -> Environment:
    found = Environment(
        loader=PackageLoader(__package__), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    found.filters["marked"] = _marked
    found.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}
    return found


def _marked(text: str) -> Markup:
    """A paragraph in which `code` and [words](address) are marked up."""
    linked = re.sub(r"\[([^]]+)\]\(([^)]+)\)", r'<a href="\2">\1</a>', str(escape(text)))
    return Markup(re.sub("`([^`]+)`", r"<code>\1</code>", linked))


def picture_of(figure: Figure, path: Path, caption: str) -> Picture:
    """Write a figure as a PNG file beside the page and return it as a picture of the page."""
    figure.savefig(path, dpi=SHARPNESS * SCALE, format="png")
    return Picture(path.name, caption, round(SCALE * figure.get_figwidth()))


def picture_within(figure: Figure, caption: str) -> Picture:
    """Return a figure as a picture within the page, which then needs no other file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=SHARPNESS * SCALE, format="png")
    source = f"data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}"
    return Picture(source, caption, round(SCALE * figure.get_figwidth()))


def number(value: float | None, form: str = ".2f") -> str:
    """A number, or a dash if there is none."""
    return "–" if value is None or not np.isfinite(value) else format(value, form)
