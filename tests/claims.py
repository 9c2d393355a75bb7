"""Numbers of documents and where they come from.

`experiments/claims.toml` says for each number of a text, in their order, which number of a results'
file it is:

    [[claims]]
    page = "experiments/FINDINGS.md"
    text = "- **Waiting.**"
    numbers = '''
    02_waiting/table.md: 86 gcm | W; 30 gcm | Q
    '''

`text` is the beginning of a paragraph, a list item or a row of a table, and names it alone. Files
are named as links of the page would be; a line that begins with a file goes on to the next one.
After each number:

- a place of `experiments.common.cells`; a share of a JSON file may be told in percent
- ``"words"``: the number stands in the file in these words
- ``-``: a condition, and no result
- ``~``: a result of a run whose results are not kept
"""

from __future__ import annotations

import re
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from experiments.common.cells import number_at, value

ROOT = Path(__file__).parents[1]
CLAIMS = ROOT / "experiments" / "claims.toml"
NUMBER = re.compile(r"(?<![\w.,^])[-+−]?\d+(?:,\d{3})*(?:\.\d+)?(?![\w^])")
BLOCK = re.compile(r"\n\s*\n|\n(?=\s*[-*] )|\n(?=#)|\n(?=\|)")
FILE = re.compile(r"^(\S+\.(?:md|json|toml)):\s*")


class Claim(NamedTuple):
    """A number that a text tells."""

    told: str
    file: Path
    source: str
    """Where it is in the file."""

    @property
    def is_result(self) -> bool:
        """Whether it comes from a file."""
        return self.source not in ("-", "~")


class Text(NamedTuple):
    """A text with numbers, and what is said of them."""

    page: Path
    begins: str
    numbers: str

    def block(self) -> str:
        """Return the paragraph, list item or row that begins so."""
        blocks = BLOCK.split(self.page.read_text("utf-8"))
        hits = [block for block in map(str.strip, blocks) if block.startswith(self.begins)]
        if len(hits) != 1:
            raise LookupError(f"{self.page}: {len(hits)} texts begin with {self.begins!r}")
        return hits[0]

    def claims(self) -> Iterator[Claim]:
        """Return what is said of each number."""
        file = self.page
        for part in re.split(r"[;\n]\s*", self.numbers.strip()):
            if (other := FILE.match(part)) is not None:
                file, part = self.page.parent / other[1], part[other.end() :]
            told, _, source = part.partition(" ")
            if told:
                yield Claim(told, file, source.strip())


@cache
def claimed(path: Path = CLAIMS, root: Path = ROOT) -> dict[Path, list[Text]]:
    """Return the texts of a file of claims, by page."""
    found: dict[Path, list[Text]] = defaultdict(list)
    for one in tomllib.loads(path.read_text("utf-8"))["claims"]:
        page = root / one["page"]
        found[page].append(Text(page, one["text"], one["numbers"]))
    return found


def numbers_of(text: str) -> list[str]:
    """Return the numbers that readers see in a text."""
    unseen = r"```.*?```|`[^`]*`|<[^>]*>|\]\([^)]*\)"
    text = re.sub(rf"{unseen}|\d+e-\d+", " ", text, flags=re.S)  # nor probabilities
    return NUMBER.findall(text)


def uncovered(page: Path, texts: list[Text]) -> list[str]:
    """Numbers of a page's paragraphs and items that nothing is said of."""
    covered = {text.block() for text in texts}
    blocks = map(str.strip, BLOCK.split(page.read_text("utf-8")))
    return [n for block in blocks if block not in covered for n in numbers_of(block)]


def agrees(claim: Claim) -> bool:
    """Whether the file says so, to the digits that are told."""
    told = value(claim.told)
    half = 0.5 * 10.0 ** -len(claim.told.partition(".")[2])
    if claim.source.startswith('"'):
        words = claim.source.strip('"')
        return told in map(value, numbers_of(words)) and words in _words(claim.file)
    found = number_at(claim.file, claim.source)
    scales = (1.0, 100.0) if claim.file.suffix == ".json" and abs(found) <= 1.0 else (1.0,)
    joint = " minus " in claim.source or " over " in claim.source
    if not joint and claim.told[0] not in "+-−":  # a loss may be told as so many points less
        found = abs(found)
    return any(abs(scale * found - told) <= half + 1e-9 for scale in scales)


@cache
def _words(file: Path) -> str:
    return " ".join(file.read_text("utf-8").split())


def tables_of(file: Path) -> dict[str, list[str]]:
    """Lines of every table by the line of its heads."""
    out: dict[str, list[str]] = {}
    head = ""
    for line in map(str.strip, file.read_text("utf-8").splitlines()):
        if not line.startswith("|"):
            head = ""
        elif not head:
            head = line
            out.setdefault(head, [])
        else:
            out[head].append(line)
    return out
