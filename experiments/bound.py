"""Numbers in documents, bound to the files of results that they come from.

A comment after a number names its place: ``80.0<!--table.md: recall > W [2]--> %``. The file is
relative to the document; without one it is the file named before. Places are

- ``row > column``, a cell of a table; several cells may name the row, and ``table 2`` the table.
  ``[2]`` is the second number in the cell; alone, in the cell named before
- ``key > key`` of a JSON file, with ``%`` in percent; ``"takes # ms"``, a number in these words
- ``A minus B``, ``minus A``, ``A over B``: a difference, a loss, a share in percent
"""

import json
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LIVING = "*.md docs/*.md experiments/*.md experiments/[0-9]*/*.md models/*/*.md"
PAGES = [page for some in LIVING.split() for page in sorted(ROOT.glob(some))]
NUMBER = r"[-+−]?\d[\d,]*(?:\.\d+)?"
BOUND = re.compile(rf"(?<![\w.,])({NUMBER})<!--(?:(\S+\.(?:md|json)): )?(.+?)-->")


def renewed(page: Path) -> str:
    """Return a document with its numbers as their files have them, as precisely as before."""
    file, last = page, ""

    def written(match: re.Match[str]) -> str:
        nonlocal file, last
        told, name, place = match.groups()
        file = page.parent / name if name else file
        last = re.sub(r"( \[\d\])?$", f" {place}", last, count=1) if place[0] == "[" else place
        form = f"{'+' * (told[0] == '+')}{',' * (',' in told)}.{len(told.partition('.')[2])}f"
        number = format(number_at(file, last) * (1.0 + 1e-12), form)  # halves are rounded up
        if (number[0] == "-") != (told[0] in "-−"):
            raise LookupError(f"{page}: {told} is {number} by {file.name}: {last}")
        return match[0].replace(told, number, 1)

    return BOUND.sub(written, page.read_text("utf-8"))


def number_at(file: Path, place: str) -> float:
    """Return the number at a place of a file; a LookupError says that it is none, or several."""
    if joint := re.fullmatch(r"(.*?) ?\b(minus|over) (.+)", place):
        one, two = number_at(file, joint[1]) if joint[1] else 0.0, number_at(file, joint[3])
        return one - two if joint[2] == "minus" else 100.0 * one / two
    text = file.read_text("utf-8")
    if file.suffix == ".json":
        content = json.loads(text)
        for key in place.removesuffix(" %").split(" > "):
            content = content[int(key) if isinstance(content, list) else key]
        return float(content) * (100.0 if place.endswith(" %") else 1.0)
    name, which = re.fullmatch(r"(.+?)(?: \[(\d)\])?", place).groups()
    *row, column = name.split(" > ")
    words = re.escape(name.strip('"')).replace(r"\#", f"({NUMBER})")
    cells = [c[h.index(column)] for h, c in rows(text) if column in h and {*row} <= {*c}]
    hits = re.findall(words, " ".join(text.split())) if name[0] == '"' else cells
    if len(hits) != 1:
        raise LookupError(f"{file}: {len(hits)} places are {place!r}")
    numbers = re.findall(NUMBER, re.sub(r"(?<=\d)[-–…]", " ", hits[0]))
    return float(numbers[int(which or 1) - 1].replace(",", "").replace("−", "-"))


def rows(text: str) -> list[tuple[list[str], list[str]]]:
    """Return the rows of all tables: their heads, and their cells with the name of the table."""
    tables = re.findall(r"(?:^\|.*\n?)+", re.sub("[`*]", "", text), re.M)
    cells = [[[c.strip() for c in row.split("|")[1:-1]] for row in t.splitlines()] for t in tables]
    return [(t[0], [*row, f"table {k}"]) for k, t in enumerate(cells, 1) for row in t[2:]]
