"""Answers of several methods to many situations, kept in files as they come."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from experiments import recompute
from experiments.common import outcomes

Case = TypeVar("Case")
Method = TypeVar("Method")


def ask_in_turns(
    file: Path,
    cases: Iterable[tuple[int, Case]],
    methods: Sequence[Method],
    answers: Callable[[int, Case, Sequence[Method]], Iterable[dict[str, Any]]],
) -> None:
    """Append the answers to cases that a file lacks; another method begins each time.

    Parameters
    ----------
    file : Path
        Of JSON lines, one for each case: a list of rows with the case's number as `situation`.
    cases : iterable of (int, case)
        Numbers and cases.
    methods : sequence
    answers : callable
        Returns the rows of a case, given its number, itself and the methods in their order.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    known = {row["situation"] for row in rows_of([file])} if file.exists() else set()
    with file.open("a", encoding="utf-8") as stream:
        for k, (number, case) in enumerate(cases):
            if number not in known:
                turn = k % len(methods)  # nobody is always the first
                rows = list(answers(number, case, [*methods[turn:], *methods[:turn]]))
                stream.write(json.dumps(rows) + "\n")
                stream.flush()


def rows_of(files: Iterable[Path]) -> list[dict[str, Any]]:
    """Return the rows of files that `ask_in_turns` has written."""
    lines = [line for file in files for line in file.read_text("utf-8").splitlines()]
    return [row for line in lines for row in json.loads(line)]


def publish(
    folder: Path,
    files: Iterable[Path],
    write_figure: Callable[[Path, outcomes.Outcomes], None],
    parts: Sequence[str] = (),
) -> None:
    """Write an experiment's outcomes, its tables and its figure from files of answers.

    Parameters
    ----------
    folder : Path
        Of the experiment.
    files : iterable of Path
        Written by `ask_in_turns`.
    write_figure : callable
    parts : sequence of str
        Columns by which earlier outcomes are kept: a part that was asked anew replaces its earlier
        rows, other parts stay. Without columns nothing is kept.
    """
    file, rows = folder / "outcomes.csv.gz", rows_of(files)
    if parts and file.exists():
        anew = {tuple(str(row[name]) for name in parts) for row in rows}
        earlier = outcomes.cells(file)
        rows += [row for row in earlier if tuple(row[name] for name in parts) not in anew]
    outcomes.write(file, rows)
    recompute.update(folder)
    write_figure(folder / "figure.png", outcomes.read(file))
