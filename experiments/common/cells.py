"""Numbers of results' files by their places.

A place is of one of these forms:

- ``row | column``: a cell of a table; where it takes several cells to tell the row, all are named,
  and ``table 2`` is the second of the file. ``[2]`` is the second number of the cell, e.g. of an
  interval
- ``key | key``: a value of a JSON file
- ``A minus B``, ``A over B``: the difference, or the share in percent
"""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path
from typing import Any


def number_at(file: Path, place: str) -> float:
    """Return the number at a place of a file.

    Raises
    ------
    LookupError
        If the place is none, or several.
    """
    for joint in (" minus ", " over "):
        if joint in place:
            one, other = (_found(file, key) for key in place.split(joint))
            return one - other if joint == " minus " else 100.0 * one / other
    return _found(file, place)


def value(number: str) -> float:
    """Return a number as it is written."""
    return float(number.replace(",", "").replace("−", "-"))


def _found(file: Path, source: str) -> float:
    if file.suffix == ".json":
        return _in_json(json.loads(file.read_text("utf-8")), source.split(" | "))
    which = re.search(r"\s*\[(\d)\]$", source)
    *row, column = source[: which.start() if which else None].split(" | ")
    hits = [
        cells[head.index(column)]
        for table, head, cells in _rows(file)
        if column in head and all(part in (*cells, table) for part in row)
    ]
    if len(hits) != 1:
        raise LookupError(f"{file}: {len(hits)} cells are {source!r}")
    numbers = re.findall(r"[-+−]?\d[\d,]*(?:\.\d+)?", re.sub(r"(?<=\d)[-–…]", " ", hits[0]))
    return value(numbers[int(which[1]) - 1 if which else 0])


def _in_json(content: Any, keys: list[str]) -> float:
    for key in keys:
        content = content[int(key)] if isinstance(content, list) else content[key]
    return float(content)


@cache
def _rows(file: Path) -> list[tuple[str, list[str], list[str]]]:
    """Return rows of all tables: which table, the heads of its columns, the cells."""
    out: list[tuple[str, list[str], list[str]]] = []
    head: list[str] = []
    count = 0
    for line in file.read_text("utf-8").splitlines():
        if not line.lstrip().startswith("|"):
            head = []
            continue
        cells = [re.sub(r"[`*]", "", cell).strip() for cell in line.strip().strip("|").split("|")]
        if not head:
            head, count = cells, count + 1
        elif not set(line) <= set("|-: "):
            out.append((f"table {count}", head, cells))
    return out
