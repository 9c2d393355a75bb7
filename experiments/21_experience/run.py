"""Does a memory of catches do more than movements that were never tried? Writes outcomes.

python -m experiments 21_experience draw [WORLD]     records and fresh situations
python -m experiments 21_experience train [WORLD]    the encoders, one after the other
python -m experiments 21_experience ask [WORLD]      the answers, then the outcomes

Finished parts are kept in out/ and not repeated. Ask on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from memories import Method, methods, train_all, without_memory
from report import write_figure
from worlds import OUT, WORLDS, World

from experiments.common.asking import ask_in_turns, publish
from experiments.common.charging import after
from experiments.common.judging import Referee, judged
from experiments.common.questions import Question

HERE = Path(__file__).resolve().parent
SHORT = 20.0  # one period of perception [ms]
PARTS = ("world", "method")  # of the outcomes, which are kept until they are asked anew
WARM = 3  # situations that are asked first and not counted


def ask(world: World) -> None:
    """Ask all methods what is missing."""
    mine, fresh = list(methods(world)), list(world.fresh())
    half = hurry(world)

    def both(number: int, question: Question, asked: Sequence[Method]) -> Iterator[dict[str, Any]]:
        return answers(world, question, asked, half, Referee())

    for question in fresh[:WARM]:  # kernels are loaded now
        list(both(question.index, question, mine))
    cases = [(question.index, question) for question in fresh]
    ask_in_turns(OUT / "answers" / f"{world.spec}.jsonl", cases, mine, both)


def hurry(world: World) -> float:
    """Return half the median time that the search takes on known situations of W [ms]."""
    search, times = without_memory(world), []
    for question in [*islice(world.known(), WARM), *world.known()]:
        since = process_time()
        search.plan(question.situation)
        times.append(1e3 * (process_time() - since))
    return round(0.5 * float(np.median(times[WARM:])), 3)


def answers(
    world: World, question: Question, asked: Sequence[Method], half: float, referee: Referee
) -> Iterator[dict[str, Any]]:
    """Yield the outcomes of a situation with both budgets."""
    for name, budget in (("short", SHORT), ("half", half)):
        moved = after(question.situation, 1e-3 * budget)
        for method in asked:
            if name == "half" and not method.hurried:
                continue
            row = question.about() | {"world": world.name, "budget": name, "budget_ms": budget}
            row |= {"method": method.name, "seed": method.seed}
            if isinstance(moved, str):
                yield row | {"caught": moved == "caught", "ms": None, "fate": moved}
                continue
            since = process_time()
            plan = method.planner.plan(moved)
            took = 1e3 * (process_time() - since)
            yield row | judged(plan, moved, referee, took)


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=("draw", "train", "ask"))
    parser.add_argument("world", nargs="?", choices=tuple(WORLDS), help="all by default")
    parser.add_argument("--workers", type=int, default=2, help="processes that draw")
    given = parser.parse_args()
    for world in [WORLDS[given.world]] if given.world else WORLDS.values():
        if given.part == "draw":
            world.draw(given.workers)
        elif given.part == "train":
            train_all(world)
        else:
            ask(world)
    if given.part == "ask":
        publish(HERE, sorted((OUT / "answers").glob("*.jsonl")), write_figure, PARTS)


if __name__ == "__main__":
    main()
