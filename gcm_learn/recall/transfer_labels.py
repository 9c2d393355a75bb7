"""What an encoder learns from: which memories, adapted to a situation, catch in it.

Memories are the catches of a dataset. Situations are those of its records, each once, and when
these are used up others that are drawn from the same specification: they need no plan to learn
from, only labels, and those are cheap. Where a straight line catches, most memories do, so most of
these are left out.
"""

from __future__ import annotations

import gc
import io
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from gcm_learn import seeding
from gcm_learn.dataset import Dataset, quantities_of, uncollected
from gcm_learn.errors import RecallError
from gcm_learn.planners.completion import Problem, straight_plan
from gcm_learn.recall import trials
from gcm_learn.recall.adaptation import DEFAULT, query_of
from gcm_learn.recall.clearance_features import Looks, gathered, look
from gcm_learn.recall.kernels import KNOTS
from gcm_learn.recall.memory_features import picture_of, ways
from gcm_learn.recall.waypoints import trace_of
from gcm_learn.scene.bodies import TOP_SPEED
from gcm_learn.situation import Situation
from gcm_learn.storage import write_whole

Best = Callable[[Looks, int], np.ndarray]
"""From looks at n situations and a number k, the memories (n, k) that fit best by what is known so
far, the best first."""


class Lesson(NamedTuple):
    """Situations, memories, and which of them hold."""

    looks: Looks
    """Of n situations."""
    rows: np.ndarray
    """Memories that were tried: (m,) int64 on all situations, or (n, m) on each its own."""
    holds: np.ndarray
    """(n, m) bool"""
    own: np.ndarray
    """(n,) int64: column of a situation's own memory, -1 for those without."""

    def save(self, path: Path) -> None:
        """Write it into a file."""
        stream = io.BytesIO()
        looks, *rest = self
        np.savez(stream, *looks, *rest)
        write_whole(path, stream.getvalue())

    @classmethod
    def load(cls, path: Path) -> Lesson:
        """Read it from a file."""
        with np.load(path) as file:
            arrays = [file[f"arr_{k}"] for k in range(len(file.files))]
        size = len(Looks._fields)
        return cls(Looks(*arrays[:size]), *arrays[size:])


class Teacher(Protocol):
    """Gives lessons about memories, and examines."""

    @property
    def ways(self) -> np.ndarray:
        """Features (m, f) float32 of the memories' ways, see `ways.ways`."""

    @property
    def pictures(self) -> np.ndarray | None:
        """Features (m, pictures.COUNT) float32 of their maps; None if none are wanted."""

    def lesson(self, index: int, best: Best | None) -> Lesson:
        """Lesson number `index`; on the memories that seem best if `best` is given."""

    def exam(self, best: Best) -> dict[str, float]:
        """Marks by name, on situations that no lesson has."""


SITUATIONS = 512  # of a lesson
ALONE = 0.4  # share of them that are others of the same lesson with one of their obstacles alone
ANY = 160  # memories of a lesson about any
TOP, WIDE = 40, 16  # of a lesson about the best: the first ones, and some of those that follow
DEPTH = 600  # how far these follow
EASY = 0.15  # share of situations that are kept although a straight line catches
EXAMINED = 300  # situations of each stratum in an exam
PLACES = (1, 5, 20)  # up to which a memory that holds is looked for in an exam
_LESSON, _SAMPLE, _ORDER = 7, 8, 9  # purposes of random numbers


class School:
    """Makes lessons of a dataset's training records; examines on those for validation.

    Parameters
    ----------
    records : Dataset
    seed : int
        Decides which records are taken, and all lessons.
    most : int, optional
        Records that are read at most; by default all.
    maps : bool
        Whether pictures of maps are wanted, which takes a march for each memory.
    progress : callable
        Called with the number of records read since the last call.
    """

    def __init__(
        self,
        records: Dataset,
        seed: int = 0,
        *,
        most: int | None = None,
        maps: bool = False,
        progress: Callable[[int], None] = lambda done: None,
    ) -> None:
        self.spec, self.seed = records.spec, seed
        train, self._held = records.where(split="train"), records.where(split="validation")
        order = np.arange(len(train))
        if most is not None and most < len(order):
            order = np.sort(seeding.rng(seed, _SAMPLE).permutation(len(order))[:most])
        self.situations: list[Situation] = []
        traces, goals, pictures, easy = [], [], [], []
        with uncollected():
            for k in order.tolist():
                record = train[k]
                plans = [plan for plan in record.plans.values() if plan.caught]
                progress(1)
                if not plans:
                    continue
                knots, goal = trace_of(
                    record.situation, min(plans, key=lambda p: p.catch_time or 0.0)
                )
                self.situations.append(record.situation)
                traces.append(knots)
                goals.append(goal)
                easy.append(record.stratum == "L")
                if maps:
                    pictures.append(picture_of(record.situation))
        if len(traces) < 2:
            raise RecallError("the dataset has no catches to learn from")
        self.traces = np.array(traces, np.float32).reshape(-1, KNOTS, 4)
        self.goals = np.array(goals, np.float32)
        self.ways = ways(self.traces, self.goals)
        self.pictures = np.array(pictures) if maps else None
        lots = seeding.rng(seed, _ORDER)
        kept = ~np.array(easy) | (lots.random(len(easy)) < EASY)
        gc.freeze()  # these objects stay: no need to look through them again and again
        self._order = lots.permutation(np.flatnonzero(kept))
        """Records whose situations lessons are about, in this order."""
        self._exam = [(r.stratum, r.situation) for r in self._examined()]

    def _examined(self) -> Iterator:
        """Held-out records of each stratum that can be caught."""
        for stratum in ("L", "W", "Q"):
            some = self._held.where(stratum=stratum)
            yield from (some[k] for k in range(min(EXAMINED, len(some))))

    def lesson(self, index: int, best: Best | None) -> Lesson:
        """A lesson of situations that no other lesson has, but for those of records."""
        rng, size = seeding.rng(self.seed, _LESSON, index), SITUATIONS - int(ALONE * SITUATIONS)
        own = self._order[index * size : (index + 1) * size]
        problems = [Problem(self.situations[k], "lesson") for k in own.tolist()]
        if len(problems) < size:
            problems += islice(self._drawn(index, rng), size - len(problems))
        problems += self._alone(problems, rng)
        seen = gathered([look(p.situation, p.scene) for p in problems])
        if best is None:
            others = np.setdiff1d(rng.permutation(len(self.traces))[: 2 * ANY], own)
            rows = np.concatenate([own[: ANY // 2], rng.permutation(others)])[:ANY]
            each = np.broadcast_to(rows, (len(problems), len(rows)))
        else:
            each = rows = _hard(_without(best(seen, DEPTH), own), rng)
        holds = np.array([self._holds(p, r) for p, r in zip(problems, each, strict=True)])
        column = np.full(len(problems), -1)
        if best is None:
            mine = min(len(own), ANY // 2)
            column[:mine] = np.arange(mine)
        return Lesson(seen, rows, holds, column)

    def exam(self, best: Best) -> dict[str, float]:
        """Share of held-out situations in which one of the first k memories holds."""
        marks: dict[str, float] = {}
        if not self._exam:
            return marks
        problems = [Problem(situation, "exam") for _, situation in self._exam]
        strata = np.array([stratum for stratum, _ in self._exam])
        seen = gathered([look(p.situation, p.scene) for p in problems])
        found = best(seen, max(PLACES))
        holds = np.array([self._holds(p, r) for p, r in zip(problems, found, strict=True)])
        for stratum in np.unique(strata):
            some = holds[strata == stratum]
            for k in PLACES:
                marks[f"{stratum}/first {k}"] = float(some[:, :k].any(axis=1).mean())
        return marks

    def _holds(self, problem: Problem, rows: np.ndarray) -> np.ndarray:
        """Which memories hold in a situation (m,) bool."""
        (style, tempo), query = DEFAULT.ways[0], query_of(problem)
        chosen = np.ascontiguousarray(rows, dtype=np.int64)
        times = trials.transfer(self.traces, self.goals, chosen, query, style, tempo, 0)
        held: np.ndarray = times >= 0.0
        return held

    def _drawn(self, index: int, rng: np.random.Generator) -> Iterator[Problem]:
        """Situations of the specification that nothing is held out of, most of them not easy."""
        k = 0
        while True:
            source = seeding.rng(self.seed, _LESSON, index, k)
            k += 1
            family = self.spec.choose(source)
            problem = Problem(family.draw(source, "drawn"), "lesson")
            if problem.early_answer() is not None or self._is_held_out(family.family, problem):
                continue
            if rng.random() >= EASY and straight_plan(problem).caught:
                continue
            yield problem

    def _alone(self, problems: list[Problem], rng: np.random.Generator) -> list[Problem]:
        """Some of the situations with one obstacle alone: which one a path failed at is told so."""
        several = [p.situation for p in problems if len(p.situation.obstacles) > 1]
        out = []
        for k in rng.permutation(len(several))[: int(ALONE * SITUATIONS)].tolist():
            situation = several[k]
            one = situation.obstacles[int(rng.integers(len(situation.obstacles)))]
            alone = replace(situation, bodies=(*situation.targets, one))
            out.append(Problem(alone, "lesson"))
        return out

    def _is_held_out(self, family: str, problem: Problem) -> bool:
        situation = problem.situation
        top = float(problem.bodies.rows[:, TOP_SPEED].max())
        quantities = quantities_of(situation, top)
        return any(holdout.holds(family, quantities) for holdout in self.spec.holdouts)


def _without(found: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Lists of memories (n, m) without the first situations' own, one shorter."""
    mine = np.full((len(found), 1), -1)
    mine[: len(own), 0] = own
    order = np.argsort(found == mine, axis=1, kind="stable")
    return np.take_along_axis(found, order, axis=1)[:, :-1]


def _hard(found: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Of the best memories (n, k) the first TOP and, of those that follow, WIDE (n, m)."""
    top = min(TOP, found.shape[1])
    rest = found.shape[1] - top
    wide = min(WIDE, rest)
    after = top + np.argsort(rng.random((len(found), rest)), axis=1)[:, :wide]
    rows = np.hstack([found[:, :top], np.take_along_axis(found, after, axis=1)])
    return np.ascontiguousarray(rows, dtype=np.int64)
