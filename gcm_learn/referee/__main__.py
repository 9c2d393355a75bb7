"""Judge answers in files: ``python -m gcm_learn.referee SITUATIONS SOLUTIONS``.

Exit code 0 if every answer keeps every promise, 1 if not, 2 if a file cannot be judged.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from gcm_learn.referee.judging import judge_files
from gcm_learn.referee.tolerances import Complaint, Unreadable


def main(arguments: Sequence[str] | None = None) -> int:
    """Judge two files; print a line for each complaint, then the counts."""
    given = _parser().parse_args(arguments)
    try:
        count, verdicts = judge_files(given.situations, given.solutions, given.end)
        found = _judged(verdicts, quiet=given.json)
    except Unreadable as error:
        print(f"gcm_learn.referee: {error}", file=sys.stderr)
        return 2
    complaints = [complaint for verdict in found for complaint in verdict]
    broken = sum(map(bool, found[:-1]))
    if given.json:
        report = {"judged": count, "broken": broken}
        print(json.dumps(report | {"complaints": [c.as_json() for c in complaints]}))
    else:
        print(f"{count} judged, {broken} broken, {len(complaints)} complaints")
    return 1 if complaints else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m gcm_learn.referee",
        description="Judge solutions by the promises of the exchange formats.",
    )
    parser.add_argument("situations", type=Path, help="situations, .json or .jsonl")
    parser.add_argument("solutions", type=Path, help="their solutions, .json or .jsonl")
    ends = "judge situations of arms in space as @4 that end at rest"
    parser.add_argument("--end", choices=["rest"], help=ends)
    parser.add_argument("--json", action="store_true", help="print one object")
    return parser


def _judged(verdicts: Iterator[list[Complaint]], quiet: bool) -> list[list[Complaint]]:
    """Collect complaints; print each as soon as it is found."""
    found = []
    for verdict in verdicts:
        found.append(verdict)
        for complaint in () if quiet else verdict:
            print(complaint)
    return found


if __name__ == "__main__":
    sys.exit(main())
