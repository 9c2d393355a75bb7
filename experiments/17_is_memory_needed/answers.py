"""Answers of memories, and outcomes of them with one check and with twenty."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from experiments.common.judging import Referee
from experiments.common.outcomes import kept
from experiments.common.questions import Question
from gcm_learn.errors import EncoderError
from gcm_learn.planners import Plan
from gcm_learn.recall import Memory, RandomIndex, RecallPlanner

CHECKS = 20


class Answer(NamedTuple):
    """Plan that answers a question."""

    plan: Plan
    checks: int
    """Number of verified paths."""


Ask = Callable[[Question, int], Answer]
"""Answers a question with a number of checks."""


class Entrant(NamedTuple):
    """Method that is asked, made in its turn."""

    method: str
    seed: int | None
    """Seed of the training, None if there is one training only."""
    make: Callable[[], Ask]


class Judged(NamedTuple):
    """Situations whose catches are judged."""

    referee: Referee
    each: int
    """One of so many: the referee takes ten times as long as an answer."""


def by(memory: Memory) -> Ask:
    """Return recall; with one check it takes the first choice, however novel the situation."""

    def ask(question: Question, checks: int) -> Answer:
        how = {"novelty": 0.0} if checks == 1 else {}
        found = RecallPlanner(memory, checks, **how).recollect(question.situation)
        return Answer(found.plan, found.checked)

    return ask


def among_equals(memory: Memory, label: Callable[[Question], str], column: int) -> Ask:
    """Return memories at random that share one label with the question, or both (column -1)."""
    words = np.array(memory._words)[memory.labels]
    labels = np.array(["/".join(row) if column < 0 else row[column] for row in words.tolist()])
    parts: dict[str, Ask] = {}
    for word in sorted(set(labels.tolist())):
        part = memory.refiled(RandomIndex())
        part.forget(labels != word)
        parts[word] = by(part)
    nothing = by(Memory(RandomIndex()))
    return lambda question, checks: parts.get(label(question), nothing)(question, checks)


def answered(
    folder: Path, split: str, who: Entrant, rows: Sequence[Question], judged: Judged
) -> list[dict[str, Any]]:
    """Return the outcomes of an entrant, kept in a folder; empty before it is trained."""
    seed = "" if who.seed is None else f"-{who.seed}"
    make = partial(_outcomes, split, who, rows, judged)
    try:
        return kept(folder / split / f"{who.method}{seed}.jsonl", make)
    except (EncoderError, FileNotFoundError) as error:
        print(f"{who.method}{seed}: not asked ({error})", flush=True)
        return []


def _outcomes(
    split: str, who: Entrant, rows: Sequence[Question], judged: Judged
) -> list[dict[str, Any]]:
    """Outcomes: `caught` within twenty checks, `first` if one check is all there is."""
    ask, found = who.make(), []
    for number, question in enumerate(rows):
        one, many = ask(question, 1).plan, ask(question, CHECKS)
        row = question.about() | {"split": split, "method": who.method, "seed": who.seed}
        row |= {"first": int(one.caught), "caught": many.plan.caught, "checks": many.checks}
        if number % judged.each == 0:
            plans = [plan for plan in (one, many.plan) if plan.caught]
            row["complaints"] = sum(judged.referee.broken(question.situation, p) for p in plans)
        found.append(row)
    return found
