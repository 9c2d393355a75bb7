"""Tables in Markdown, and shares and differences as their cells show them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from gcm_learn.evaluation import Interval


def table(head: Sequence[str], rows: Iterable[Sequence[Any]] = ()) -> str:
    """Return a table in Markdown.

    Parameters
    ----------
    head : sequence of str
        Names of the columns.
    rows : iterable of sequence
        Cells of each row, written as text.
    """
    return "\n".join([line(head), "|---" * len(head) + "|", *map(line, rows)])


def line(cells: Sequence[Any]) -> str:
    """Return a row of a table."""
    return "| " + " | ".join(map(str, cells)) + " |"


def percent(found: Interval, digits: int = 0) -> str:
    """Return a share with its interval [%]."""
    value, low, high = (100.0 * one for one in found)
    return f"{value:.1f} ({low:.{digits}f}–{high:.{digits}f})"


def points(found: Interval) -> str:
    """Return a difference with its interval [points]."""
    return "{:+.1f} ({:+.1f} to {:+.1f})".format(*(100.0 * one for one in found))


def rounded(found: Interval) -> str:
    """Return a difference with its interval, whose ends are rounded to points."""
    return "{:+.1f} ({:+.0f}…{:+.0f})".format(*(100.0 * one for one in found))


def sections(tables: Mapping[str, str]) -> str:
    """Return tables below their titles."""
    return "\n\n".join(f"## {title}\n\n{text}" for title, text in tables.items()) + "\n"
