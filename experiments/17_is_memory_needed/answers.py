"""Answers of memories: their catches, and the verdicts of the tests' referee on them."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from experiments.common.judging import Referee
from experiments.common.questions import Question
from gcm_learn.planners import Plan
from gcm_learn.recall import Memory, RandomIndex, RecallPlanner
from gcm_learn.storage import write_whole

CHECKS = 20


class Answer(NamedTuple):
    """Plan that answers a question."""

    plan: Plan
    checks: int
    """Paths that were checked."""


Ask = Callable[[Question, int], Answer]
"""Of a question and the number of checks that are granted."""


def by(memory: Memory) -> Ask:
    """Recall: one check is of the first choice, whatever it is like."""

    def ask(question: Question, checks: int) -> Answer:
        how = {"novelty": 0.0} if checks == 1 else {}
        found = RecallPlanner(memory, checks, **how).recollect(question.situation)
        return Answer(found.plan, found.checked)

    return ask


def among_equals(memory: Memory, what: Callable[[Question], str], column: int) -> Ask:
    """Memories at random, of the same kind as the question by one of their labels or both."""
    words = np.array(memory._words)[memory.labels]
    told = ["/".join(row) if column < 0 else row[column] for row in words.tolist()]
    parts: dict[str, Ask] = {}
    for word in sorted(set(told)):
        part = memory.refiled(RandomIndex())
        part.forget(np.array(told) != word)
        parts[word] = by(part)
    nothing = by(Memory(RandomIndex()))
    return lambda question, checks: parts.get(what(question), nothing)(question, checks)


def answered(file: Path, ask: Ask, rows: Sequence[Question], referee: Referee) -> dict[str, Any]:
    """Catches with one check and with twenty, kept in a file."""
    if file.exists():
        return json.loads(file.read_text("utf-8"))
    for question in rows[:5]:
        ask(question, CHECKS)  # compiled, cells made
    first, whole, checks, ms, broken = [], [], [], [], 0
    for question in rows:
        one = ask(question, 1)
        began = time.process_time()
        many = ask(question, CHECKS)
        ms.append(round(1e3 * (time.process_time() - began), 3))
        first.append(one.plan.caught)
        whole.append(many.plan.caught)
        checks.append(many.checks)
        for plan in (one.plan, many.plan):
            broken += plan.caught and referee.broken(question.situation, plan)
    found = {"first": first, "caught": whole, "checks": checks, "ms": ms, "broken": int(broken)}
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, json.dumps(found))
    print(file.stem, f"{np.mean(first):.3f} {np.mean(whole):.3f} broken {broken}", flush=True)
    return found


def within(found: dict[str, Any], checks: int) -> np.ndarray:
    """Which questions (n,) are caught with so many checks."""
    if checks == 1:
        return np.array(found["first"])
    return np.array(found["caught"]) & (np.array(found["checks"]) <= checks)
