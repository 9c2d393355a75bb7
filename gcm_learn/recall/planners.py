"""Planners that recall: memories are bent to a situation, the first that holds is the plan."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

import numpy as np

from gcm_learn.motion.failures import Failure
from gcm_learn.planners.completion import Attempt, Problem, checked
from gcm_learn.planners.plan import Plan, Planner
from gcm_learn.planners.registry import get_planner, register
from gcm_learn.recall.adaptation import DEFAULT, Adaptation, adapt, attempt_at, query_of
from gcm_learn.recall.raw_features import raw_features
from gcm_learn.recall.shipped import shipped_memory
from gcm_learn.recall.splines import random_traces
from gcm_learn.recall.store import Memory
from gcm_learn.recall.trial import Offer, first_that_holds
from gcm_learn.recall.waypoints import Trace
from gcm_learn.situation import Situation
from gcm_learn.storage import content_number

CANDIDATES = 20
POOL = (
    4  # memories that are recalled for each that is checked, so that twins of failures are left out
)
NOVELTY = 0.05  # a path this near to one that failed is not checked [forearm lengths]
REGRET = 1.0  # what a memory loses by the failure of one in the same direction [log-odds]


@dataclass(frozen=True)
class Recollection:
    """How a plan was recalled."""

    plan: Plan
    memory: int | None
    """Which memory held."""
    checked: int
    """Paths that were checked."""


@dataclass(frozen=True)
class RecallPlanner:
    """Recalls memories and verifies them in order, until one holds.

    Nothing is searched: a situation in which none holds is answered with "unreachable".
    """

    memory: Memory
    candidates: int = CANDIDATES
    """Paths that are checked at most."""
    name: str = "recall"
    how: Adaptation = field(default_factory=Adaptation)
    novelty: float = NOVELTY
    """Paths this near to one that failed are passed over [forearm lengths]; 0 checks all."""
    regret: float = REGRET
    """How much a failure says about memories that lie near, where scores are odds, as those of
    the learned index are; 0 keeps the order of recall."""

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation."""
        return self.recollect(situation).plan

    def recollect(self, situation: Situation) -> Recollection:
        """Answer a situation and say which memory the answer came from."""
        problem = Problem(situation, self.name)
        answer = problem.early_answer()
        if answer is not None or len(self.memory) == 0:
            return Recollection(answer or problem.answer(Failure.NO_MEMORY), None, 0)
        place = self.memory.index.embed_query(situation, problem.scene)
        pool = self.candidates * (POOL if max(self.novelty, self.regret) > 0.0 else 1)
        chosen = self.memory.recall(place, pool)
        regret = self.regret if self.memory.index.name == "learned" else 0.0
        offer = _offer(chosen, self.memory.embeddings, place if regret > 0.0 else None)
        plan, k, tried = _first(
            problem, self.memory.traces, self.memory.goals, offer, self.how, self.candidates,
            self.novelty, regret,
        )  # fmt: skip
        return Recollection(plan, None if k < 0 else int(chosen[k]), tried)


def _offer(chosen: np.ndarray, places: np.ndarray, query: np.ndarray | None = None) -> Offer:
    """Memories to be tried in the order given, or by what the query's odds are for them."""
    left = np.ones(len(chosen), dtype=bool)
    if query is None:
        scores = -np.arange(len(chosen), dtype=float)
        return Offer(chosen, scores, np.zeros((len(chosen), 1), np.float32), left)
    near = places[chosen]
    return Offer(chosen, (near @ query).astype(float), near, left)


@dataclass(frozen=True)
class SplinesPlanner:
    """Random movements in place of memories: the control for what verification does alone."""

    candidates: int = CANDIDATES
    seed: int = 0
    name: str = "splines-random"
    how: Adaptation = field(default_factory=Adaptation)

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation."""
        problem = Problem(situation, self.name)
        answer = problem.early_answer()
        if answer is not None:
            return answer
        numbers = np.round(raw_features(situation, problem.scene).astype(float), 4) + 0.0
        item = content_number(numbers.tobytes())
        start = query_of(problem).ring
        traces, goals = random_traces(self.seed, item, self.candidates, start, situation.horizon)
        offer = _offer(np.arange(self.candidates), traces)
        return _first(problem, traces, goals, offer, self.how, self.candidates, 0.0, 0.0)[0]


@dataclass(frozen=True)
class HybridPlanner:
    """Recall first, plan when recall fails."""

    recall: RecallPlanner
    fallback: Planner = field(default_factory=lambda: get_planner("layered"))
    name: str = "hybrid"

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation; the time of both is counted."""
        first = self.recall.plan(situation)
        if first.status != "unreachable":
            return replace(first, planner=self.name)
        second = self.fallback.plan(situation)
        elapsed = first.planning_ms + second.planning_ms
        return replace(second, planner=self.name, planning_ms=elapsed)


def _first(
    problem: Problem,
    traces: np.ndarray,
    goals: np.ndarray,
    offer: Offer,
    how: Adaptation,
    tries: int,
    novelty: float,
    regret: float,
) -> tuple[Plan, int, int]:
    """Plan of the first trace that holds, its place in the offer or -1, and paths checked."""
    query, total = query_of(problem), 0
    while total < tries:
        k, body, tried, time, hand = first_that_holds(
            traces, goals, offer, query, how.ways, how.mends, tries - total, novelty, regret
        )
        total += tried
        if k < 0:
            break
        plan, _ = checked(problem, attempt_at(problem, time, hand, body))
        if plan is not None:
            return plan, k, total
        # The verification has the last word: what is left is tried.
    return problem.answer(Failure.NO_VALID_MEMORY.with_numbers(count=total)), -1, total


@dataclass(frozen=True)
class Rollout:
    """The first choice, acted on without a check."""

    attempt: Attempt | None
    """None if it cannot be bent to any target in time."""
    worked: bool
    """Whether it would have caught."""


def unverified(
    memory: Memory,
    situation: Situation,
    how: Adaptation = DEFAULT,
) -> Rollout:
    """What comes of the first memory that is recalled, if it is not verified before acting."""
    problem = Problem(situation, "recall-1")
    chosen = memory.recall(memory.index.embed_query(situation, problem.scene), 1)
    if len(chosen) == 0:
        return Rollout(None, False)
    k = int(chosen[0])
    attempt = adapt(problem, Trace(memory.traces[k], memory.goals[k]), how)
    return Rollout(attempt, attempt is not None and checked(problem, attempt)[0] is not None)


@lru_cache(maxsize=8)
def _memory(name: str) -> Memory:
    return shipped_memory(name)


def _recalling(name: str) -> RecallPlanner:
    return RecallPlanner(_memory(name), name=name)


def _first_choice() -> RecallPlanner:
    return RecallPlanner(_memory("recall"), 1, "recall-1", novelty=0.0)


def _hybrid() -> HybridPlanner:
    return HybridPlanner(RecallPlanner(_memory("recall"), name="hybrid"))


for _name in ("recall", "recall-raw", "recall-pca", "recall-random"):
    register(_name, partial(_recalling, _name))
register("recall-1", _first_choice)
register("hybrid", _hybrid)
register("splines-random", SplinesPlanner)
