"""Ask methods side by side about problems that others made; write outcomes, table and figure.

python -m experiments 18_outside --motionbenchmaker problems.tar.bz2 --table-tennis rallies.json
    --si-rrt scene_task.json mass_test.json --seed 7
python -m experiments 18_outside --development ...   the part of the suites for development

The environment variables MOTIONBENCHMAKER, SI_RRT and TABLE_TENNIS name the files as well.  A suite
without files is left out.  Answers are kept in out/ and reused.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

import numpy as np
import suites
from methods import Method, methods, rows_of
from suites import Question

from experiments import recompute
from experiments.common import outcomes
from gcm_learn.evaluation import passes

HERE = Path(__file__).resolve().parent
SEED = 0x1542C6D1
"""First eight hexadecimal digits of the commit that froze code and draws."""


def questions(given: argparse.Namespace) -> Iterator[Question]:
    """Yield the questions of all suites that have files, in turn."""
    drawn = []
    if given.motionbenchmaker is not None:
        some = suites.problems(given.motionbenchmaker, given.seed, given.each, given.development)
        drawn.append(list(some))
    if given.si_rrt:
        drawn.append(list(suites.scenes(given.si_rrt)))
    if given.table_tennis is not None:
        some = suites.balls(given.table_tennis, given.seed, given.balls, given.development)
        drawn.append(list(some))
    for turn in zip_longest(*drawn):
        yield from (one for one in turn if one is not None)


def answered(question: Question, asked: dict[str, Method]) -> list[dict[str, Any]]:
    """Return all answers to a question as rows."""
    return list(rows_of(question, asked))


def main() -> None:
    """Ask what is missing; write the outcomes, and the tables from them."""
    given = _arguments().parse_args()
    part = "development" if given.development else f"{given.seed:08x}"
    file, started = HERE / "out" / f"{part}.jsonl", perf_counter()
    file.parent.mkdir(exist_ok=True)
    lines = file.read_text("utf-8").splitlines() if file.exists() else []
    known = {key: rows for key, rows in map(json.loads, lines)}
    asked, warm = methods(), True
    print(f"{', '.join(asked)}; calibration {median(passes()):.0f} ms", flush=True)
    with file.open("a", encoding="utf-8") as stream:
        for question in questions(given):
            if question.key in known or perf_counter() - started > 60.0 * given.minutes:
                continue
            if warm:
                answered(question, asked)  # kernels are loaded now
                warm = False
            known[question.key] = answered(question, asked)
            stream.write(json.dumps([question.key, known[question.key]]) + "\n")
            stream.flush()
    print(f"{len(known)} situations, {process_time():.0f} s of processor time")
    if not given.development:
        outcomes.write(HERE / "outcomes.csv.gz", (row for rows in known.values() for row in rows))
        recompute.update(HERE)
        from report import figure

        figure(outcomes.read(HERE / "outcomes.csv.gz"), HERE / "figure.png")


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])

    def paths(name: str) -> list[Path]:
        return [Path(one) for one in os.environ.get(name, "").split(os.pathsep) if one]

    def path(name: str) -> Path | None:
        return next(iter(paths(name)), None)

    parser.add_argument("--motionbenchmaker", type=Path, default=path("MOTIONBENCHMAKER"))
    parser.add_argument("--si-rrt", type=Path, nargs="*", default=paths("SI_RRT"))
    parser.add_argument("--table-tennis", type=Path, default=path("TABLE_TENNIS"))
    parser.add_argument("--seed", type=lambda text: int(text, 16), default=SEED, help="hexadecimal")
    parser.add_argument("--each", type=int, default=suites.EACH, help="problems of each set")
    parser.add_argument("--balls", type=int, default=suites.BALLS)
    parser.add_argument("--development", action="store_true", help="the part for development")
    parser.add_argument("--minutes", type=float, default=np.inf, help="no new one after that")
    return parser


if __name__ == "__main__":
    main()
