"""Methods that are asked in space, each made in its turn."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from answers import CHECKS, Answer, Ask, Entrant, by
from entrants import with_controls
from regressor import WAITS, Paths, regressor, told
from space_lessons import OF, PROTOTYPES, SEEDS, SIZES, TURNS, Catches
from torch import argsort, no_grad

from experiments.common.questions import Question
from gcm_learn.arms import SPATIAL
from gcm_learn.planners import SpatialProblem
from gcm_learn.recall import (
    MEMORIES,
    Adaptation,
    EncoderConfig,
    LearnedIndex,
    Memory,
    RandomIndex,
    RawIndex,
    Waypoints,
    load_encoder,
    shipped_memory,
)
from gcm_learn.recall.features import batched
from gcm_learn.recall.index import nearest_rows
from gcm_learn.recall.joint_moves import EARLIEST, TIME
from gcm_learn.recall.planners import _first_plan, _offer
from gcm_learn.recall.raw_features import Scale
from gcm_learn.recall.trials import Budget

MOVEMENTS = MEMORIES.of(SPATIAL)


def equal(whole: Catches, out: Path) -> Iterator[Entrant]:
    """Yield the same N catches, filed by their own encoder, by raw parameters and at random."""
    for seed in SEEDS:
        for size in SIZES:
            folder = out / "encoders" / f"strict-{size}-{seed}"
            part = partial(whole.part, size, seed)
            yield Entrant(f"raw-{size}", seed, lambda part=part: by(_raw(part())))
            yield Entrant(f"learned-{size}", seed, lambda folder=folder: by(_learned(folder)))
            if seed == SEEDS[0]:
                yield Entrant(f"random-{size}", seed, lambda part=part: by(_any(part())))


def needed(whole: Catches, out: Path) -> Iterator[Entrant]:
    """Yield substitutes for a memory, learned from the same labels."""
    for seed in SEEDS:
        at = out / "encoders" / f"prototypes-{PROTOTYPES}-{seed}"
        yield Entrant("prototypes", seed, lambda at=at: by(_learned(at)))
        yield Entrant("prototypes, random", seed, lambda at=at: by(_any(_paths(at))))
        yield Entrant("regressor", seed, partial(_regressor, out, seed))


def shipped(whole: Catches, out: Path) -> Iterator[Entrant]:
    """Yield the memory that is shipped and its controls."""
    yield from with_controls(shipped_memory("recall", SPATIAL))


def _paths(folder: Path) -> Catches:
    """Return the movements that an encoder was trained on."""
    with np.load(folder / "paths.npz") as file:
        knots, goals = file["knots"], file["goals"]
    nothing = np.zeros(len(knots))
    return Catches(nothing, knots, goals, nothing, nothing)


def _learned(folder: Path) -> Memory:
    index, some = LearnedIndex(load_encoder(folder)), _paths(folder)
    places = index.encoder.embed_memories([], some.knots, some.goals)
    return Memory.of(index, places, some.knots, some.goals, kind=SPATIAL)


def _raw(some: Catches) -> Memory:
    index = RawIndex(Scale.of(some.raw))
    places = nearest_rows(index.scale(some.raw))
    return Memory.of(index, places, some.knots, some.goals, kind=SPATIAL)


def _any(some: Catches) -> Memory:
    index = RandomIndex()
    paths = [Waypoints(k, g) for k, g in zip(some.knots, some.goals, strict=True)]
    places = index.embed_memories([], paths)
    return Memory.of(index, places, some.knots, some.goals, kind=SPATIAL)


def _regressor(out: Path, seed: int) -> Ask:
    """Return one that learns as many steps as an encoder, from its lessons."""
    name = f"strict-{OF}-{seed}"
    some = _paths(out / "encoders" / name)
    paths, steps = told(some.knots, some.goals), TURNS * EncoderConfig().steps
    net = regressor(out / "work" / name, paths, seed, steps)

    def ask(question: Question, checks: int) -> Answer:
        problem = SpatialProblem(question.situation, "regressor")
        answer = MOVEMENTS.early_answer(problem)
        if answer is not None:
            return Answer(answer, 0)
        how, movements = Adaptation(), proposed(net, problem)
        offer = _offer(np.arange(checks), movements[0])
        budget = Budget(how.bends, checks, 0.0, 0.0)
        plan, _, tried = _first_plan(
            problem, MOVEMENTS.tries(problem, how), movements, offer, budget
        )
        return Answer(plan, tried)

    return ask


@no_grad()
def proposed(net: Paths, problem: SpatialProblem) -> tuple[np.ndarray, np.ndarray]:
    """Return knots (CHECKS, KNOTS, COLUMNS) and goals (CHECKS, GOAL), the likeliest first."""
    made, scores = net(batched([MOVEMENTS.features(problem.situation, problem.scene)]))
    numbers = (made[0] * net.spread + net.mean)[argsort(-scores[0])].numpy()
    knots = numbers[:, : -MOVEMENTS.goal].reshape(CHECKS, *MOVEMENTS.knots)
    time = np.maximum.accumulate(np.maximum(knots[:, :, TIME], 0.0), axis=1)
    waits = knots[:, :, EARLIEST] > WAITS * np.maximum(time, 1e-3)
    knots[:, :, TIME], knots[:, :, EARLIEST] = time, np.where(waits, time, 0.0)
    return np.ascontiguousarray(knots), np.ascontiguousarray(numbers[:, -MOVEMENTS.goal :])
