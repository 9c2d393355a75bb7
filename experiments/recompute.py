"""Compute all tables from the outcomes of single situations, and numbers in documents from those.

    python -m experiments recompute                     every experiment that has outcomes
    python -m experiments recompute 14_body             one of them
    python -m experiments recompute --check             say what differs, and fail if anything does

Nothing is planned. How documents bind numbers is told in `experiments/bound.py`.

An experiment with files `outcomes*.csv.gz` may have modules `*report` with a function `results`. It
returns texts by name of file from the folder of the outcomes. These modules import nothing of their
folder. Answered experiments have no code here; they are named with the commit that has it.
"""

from __future__ import annotations

import argparse
import importlib
import re
import sys
from pathlib import Path

from experiments import bound

HERE = Path(__file__).resolve().parent
STARTS = "def results("
STANDS = re.compile(r"The code stands at commit `(\w+)`")


def with_outcomes() -> list[str]:
    """Return the names of the experiments whose outcomes are kept."""
    return sorted({file.parent.name for file in HERE.glob("*/outcomes*.csv.gz")})


def answered() -> dict[str, str]:
    """Return a line for each answered experiment: the commit that has its code."""
    texts = {p.parent.name: p.read_text("utf-8") for p in sorted(HERE.glob("answered/*/README.md"))}
    commits = {name: STANDS.findall(text)[0] for name, text in texts.items()}
    return {n: f"{n}: answered; its code stands at commit {c}" for n, c in commits.items()}


def results(folder: Path) -> dict[Path, str]:
    """Return the texts that an experiment's outcomes give, by file."""
    found: dict[Path, str] = {}
    for file in sorted(folder.glob("*report.py")):
        if STARTS in file.read_text("utf-8"):
            report = importlib.import_module(f"experiments.{folder.name}.{file.stem}")
            found |= {folder / name: text for name, text in report.results(folder).items()}
    return found


def update(folder: Path) -> None:
    """Write what an experiment's outcomes give."""
    for file, text in results(folder).items():
        file.write_text(text, "utf-8")


def differing(folder: Path) -> list[Path]:
    """Return the files that are not what an experiment's outcomes give."""
    return [
        file
        for file, text in results(folder).items()
        if not file.exists() or file.read_text("utf-8") != text
    ]


def main() -> None:
    """Write or check the tables of the experiments named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="experiments; all by default")
    parser.add_argument("--check", action="store_true", help="write nothing")
    given = parser.parse_args()
    known, archived = with_outcomes(), answered()
    unknown = sorted(set(given.names) - set(known))
    if unknown:
        if unknown[0] in archived:
            parser.error(archived[unknown[0]])
        parser.error(f"no outcomes of {', '.join(unknown)}; known are {', '.join(known)}")
    wrong = []
    for name in given.names or known:
        if not given.check:
            update(HERE / name)
        wrong += differing(HERE / name)
    for page in bound.PAGES:
        if (text := bound.renewed(page)) != page.read_text("utf-8"):
            wrong.append(page) if given.check else page.write_text(text, "utf-8")
    if not given.names:
        print(*archived.values(), sep="\n")
    for file in wrong:
        print(f"{file.relative_to(HERE.parent)}: not what the results give")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
