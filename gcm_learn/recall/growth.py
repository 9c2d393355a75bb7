"""Memories that are made: of datasets, or by experience.

A memory that grows with experience remembers what it could not recall and what was then planned
anew. It skips what is already covered, as Thunder does (Coleman, Sucan, Moll, Okada and Correll,
ICRA 2015). So the memory grows ever more slowly, and is filled with hard cases. Under a limit it
drops entries that others cover: it keeps a book of its situations, and of which memories catch
there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gcm_learn import seeding
from gcm_learn.arms import Kind
from gcm_learn.errors import RecallError
from gcm_learn.planners import Plan, Planner, get_planner
from gcm_learn.processes import crew_of
from gcm_learn.recall.adaptation import Adaptation
from gcm_learn.recall.book import WORKS
from gcm_learn.recall.index import Index
from gcm_learn.recall.indexes import index_class
from gcm_learn.recall.kinds import MEMORIES, waypoints_of
from gcm_learn.recall.planners import RecallPlanner, Recollection
from gcm_learn.recall.store import Forgotten, Memory
from gcm_learn.recall.synthetic import Synthetic, habits_of
from gcm_learn.recall.waypoints import Waypoints
from gcm_learn.situation import Situation, canonical

if TYPE_CHECKING:
    from gcm_learn.dataset import Dataset, Record

CHUNK = 500  # records that are filed at once
FITTED = 5000  # situations at most that an index is fitted to
Source = Callable[["Record"], "Waypoints | None"]
"""Movement of a record, if it has one."""
RETRIED = 64  # situations of the book at most in which a fresh memory is tried


def remember(
    records: Dataset,
    index: str | Index = "raw",
    planner: str = "",
    *,
    synthetic: bool = False,
    seed: int = 0,
    most: int | None = None,
    workers: int | None = 1,
    cluster: str | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> Memory:
    """Make a memory of the catches of a dataset.

    Parameters
    ----------
    records : Dataset
        Those without a catch are left out; choose a split with `where` before.
    index : str or Index
        A registered name, which is fitted to a sample of the situations, or an index of your own.
    planner : str
        Whose catches; by default of all planners the earliest.
    synthetic : bool
        Take a synthetic movement for each record in place of its catch; see `recall.synthetic`.
    seed : int
        Decides the sample, synthetic movements, and which records are taken if there are more than
        `most`.
    most : int, optional
        Records that are read at most.
    workers, cluster
        See `processes.crew_of`; by default this process.  Whoever reads must find the dataset
        where it is found here.
    progress : callable
        Called with the number of records read since the last call.
    """
    if planner and planner not in records.spec.planners:
        known = ", ".join(records.spec.planners)
        raise RecallError(f"planner: {planner!r} has no plans in the dataset (it has {known})")
    order = np.arange(len(records))
    if most is not None and most < len(order):
        order = np.sort(seeding.rng(seed, 0).permutation(len(order))[:most])
    if isinstance(index, str):
        index = _fitted(records, index, order, seed)
    kind = records.spec.kind
    memory = Memory(index, kind=kind)
    source = source_of(records, planner, synthetic=synthetic, seed=seed)
    parts = [order[start : start + CHUNK] for start in range(0, len(order), CHUNK)]
    with crew_of(workers, cluster) as crew:
        filed = crew.map(partial(_filed, index, kind, source), map(records.part, parts))
        for part, more in zip(parts, filed, strict=True):
            memory.extend(more)
            progress(len(part))
    return memory


def _fitted(records: Dataset, name: str, order: np.ndarray, seed: int) -> Index:
    """A registered index, fitted to situations of the records."""
    if len(order) == 0:
        raise RecallError("the dataset has no records to remember")
    made = index_class(name)
    sample = np.sort(seeding.rng(seed, 1).permutation(order)[:FITTED])
    return made.fit([records[int(k)].situation for k in sample], seed)


def _filed(index: Index, kind: Kind, source: Source, records: Iterable[Record]) -> Memory:
    """A memory of some records."""
    memory = Memory(index, kind=kind)
    found = [(record, waypoints) for record in records if (waypoints := source(record))]
    memory.add(
        [record.situation for record, _ in found],
        [waypoints for _, waypoints in found],
        [record.family for record, _ in found],
        [record.stratum for record, _ in found],
    )
    return memory


def source_of(
    records: Dataset, planner: str = "", *, synthetic: bool = False, seed: int = 0
) -> Source:
    """Return what a memory keeps of a record: a planner's catch, or a synthetic movement.

    Synthetic movements are as long as catches of the records for training.
    """
    if not synthetic:
        return partial(catch_of, planner=planner)
    return Synthetic(habits_of(records.where(split="train")), seed)


def catch_of(record: Record, planner: str = "") -> Waypoints | None:
    """Waypoints of a record's catch, of the earliest if no planner is named."""
    plan = record.earliest(planner)
    return None if plan is None else waypoints_of(record.situation, plan)


@dataclass(frozen=True)
class Coverage:
    """Rule by which a situation counts as covered by what is remembered."""

    slack: float = math.inf
    """A recalled catch may come this share later than the planned one. Infinite: any recalled catch
    covers, and no planning is needed to know; -1: none does, and all catches are remembered."""

    def covers(self, recalled: Plan, planned: Plan | None) -> bool:
        """Return whether a recalled catch makes the planned one superfluous."""
        if not recalled.caught or recalled.catch_time is None:
            return False
        if planned is None or planned.catch_time is None:
            return True
        return recalled.catch_time <= planned.catch_time * (1.0 + self.slack)


@dataclass(frozen=True)
class Step:
    """The state of a memory after an experience."""

    experience: int
    """Situations met so far."""
    size: int
    """Memories."""
    recalled: bool
    """True if this situation was caught from memory, before anything was learned from it."""
    caught: bool
    """True if it was caught at all."""


def grow(
    memory: Memory,
    situations: Iterable[Situation],
    planner: str | Planner = "layered",
    covered: Coverage | None = None,
    *,
    recall: RecallPlanner | None = None,
    most: int | None = None,
    forget: Forgotten = "covered",
    progress: Callable[[int], None] = lambda done: None,
) -> list[Step]:
    """Meet situations one after the other; remember what was not covered.

    Parameters
    ----------
    memory : Memory
        Grows in place.
    situations : iterable of Situation
    planner : str or Planner
        Solves what memory does not.
    covered : Coverage, optional
        What need not be remembered; by default everything that is recalled.
    recall : RecallPlanner, optional
        How is recalled; its memory is replaced by this one.
    most : int, optional
        Entries at most.
    forget : {"covered", "least used", "oldest", "random"}
        What is forgotten first if there are more, see `Memory.forget_to`. For "covered" what is met
        is noted in the memory's book, which is saved with it, so that growth can go on later.
    progress : callable
        Called with the number of situations met since the last call.

    Returns
    -------
    list of Step
        One for each situation.
    """
    rule = Coverage() if covered is None else covered
    solver = get_planner(planner)
    how = RecallPlanner(memory) if recall is None else replace(recall, memory=memory)
    steps: list[Step] = []
    for situation in situations:
        found, before = how.recollect(situation), len(memory)
        caught = _learned(memory, situation, found, solver, rule)
        if most is not None:
            valid = before if len(memory) > before else found.memory
            if forget == "covered" and valid is not None:
                _booked(memory, situation, valid, valid == before, how.how)
            memory.forget_to(most, forget, seed=len(steps))
        step = Step(len(steps) + 1, len(memory), found.plan.caught, caught)
        steps.append(step)
        progress(1)
    return steps


def _learned(
    memory: Memory, situation: Situation, found: Recollection, solver: Planner, rule: Coverage
) -> bool:
    """Remember a situation's catch unless it is covered; whether there is a catch."""
    if found.memory is not None:
        memory.used(found.memory)
    if found.plan.status == "start_blocked":
        return False
    if found.plan.caught and math.isinf(rule.slack):
        return True
    planned = solver.plan(situation)
    if planned.caught and not rule.covers(found.plan, planned):
        memory.add([situation], [waypoints_of(situation, planned)])
    return planned.caught or found.plan.caught


def _booked(memory: Memory, situation: Situation, valid: int, fresh: bool, how: Adaptation) -> None:
    """Note which memories catch in a situation, and where else a fresh one does."""
    book = memory.book
    page = book.offered()
    if page is not None:
        turned = canonical(situation)[0]  # what is kept, so what is noted is true of it
        problem = MEMORIES.of(memory.kind).problem(turned, "book")
        query = memory.index.embed_query(turned, problem.scene)
        near = memory.recall(query, WORKS)
        others = near[_catching(memory, problem, near, how) & (near != valid)]
        book.write(page, turned, query, np.append(valid, others))
    if fresh:
        for page in book.thin(memory.embeddings[valid], RETRIED):
            problem = MEMORIES.of(memory.kind).problem(book.situation(page), "book")
            if _catching(memory, problem, np.array([valid]), how)[0]:
                book.note(page, valid)


def _catching(memory: Memory, problem: Any, which: np.ndarray, how: Adaptation) -> np.ndarray:
    """Return whether memories (m,) catch in the situation of a problem."""
    tries = MEMORIES.of(memory.kind).tries(problem, how)
    times = tries.catch_times(memory.knots, memory.goals, which)
    return np.asarray(times >= 0.0)
