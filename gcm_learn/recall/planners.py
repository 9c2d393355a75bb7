"""Planners that recall: memories are adapted to a situation, the first valid one is the plan."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

import numpy as np

from gcm_learn import artifacts, seeding
from gcm_learn.errors import RecallError
from gcm_learn.motion.failures import Failure
from gcm_learn.planners.completion import Attempt, Problem, checked
from gcm_learn.planners.plan import Plan, Planner
from gcm_learn.planners.registry import get_planner, register
from gcm_learn.recall.adaptation import DEFAULT, Adaptation, adapt, attempt_at, query_of
from gcm_learn.recall.index import index_class
from gcm_learn.recall.kernels import ANGLE, EARLIEST, KNOTS, RING, TIME
from gcm_learn.recall.raw_features import raw_features
from gcm_learn.recall.store import MANIFEST, Memory
from gcm_learn.recall.trials import Offer, first_that_holds
from gcm_learn.recall.waypoints import Trace
from gcm_learn.situation import Situation
from gcm_learn.storage import content_number

CANDIDATES = 20
POOL = 4  # memories recalled for each that is checked: twins of failures are left out
NOVELTY = 0.05  # a path this near to one that failed is not checked [forearm lengths]
REGRET = 1.0  # what a memory loses by the failure of one in the same direction [log-odds]
HALF_TURN = 1.8  # largest change of the hand's direction [rad]
RIMS = (0.15, 0.98)  # shares of the ring
TIMES = (0.2, 1.0)  # of the end [horizons]
WAITERS = 4  # one in so many waits on its way
_REFILED = {"recall-raw": "raw", "recall-pca": "pca", "recall-random": "random"}
WHOLE = "recall"


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


def random_traces(
    seed: int, index: int, count: int, start: float, horizon: float
) -> tuple[np.ndarray, np.ndarray]:
    """Random movements in the form of traces.

    Parameters
    ----------
    seed, index : int
        Decide all that is random.
    count : int
    start : float
        Share of the ring where the hand is at t = 0.
    horizon : float
        [s]

    Returns
    -------
    traces, goals : (count, KNOTS, 4), (count, 2) ndarray of float32
    """
    rng = seeding.rng(seed, index)
    s = np.linspace(0.0, 1.0, KNOTS)[None]
    angles = rng.uniform(-HALF_TURN, HALF_TURN, (2, count, 1))
    rings = rng.uniform(*RIMS, (2, count, 1))
    ends = horizon * rng.uniform(*TIMES, (count, 1))
    waits = rng.integers(WAITERS, size=(count, 1)) == 0
    traces = np.zeros((count, KNOTS, 4), np.float32)
    traces[:, :, ANGLE] = 2.0 * s * (1.0 - s) * angles[0] + s * s * angles[1]
    way = (1.0 - s) ** 2 * start + 2.0 * s * (1.0 - s) * rings[0] + s * s * rings[1]
    traces[:, :, RING] = way
    traces[:, :, TIME] = s * ends
    half = KNOTS // 2
    traces[:, half, EARLIEST] = np.where(waits, 0.5 * ends, 0.0)[:, 0]
    goals = traces[:, -1, [ANGLE, RING]]
    return traces, np.ascontiguousarray(goals)


@dataclass(frozen=True)
class SplinesPlanner:
    """Random movements in place of memories: the control for what verification does alone.

    A spline's hand starts where the query's does. Its direction and its share of the ring follow
    quadratic Bezier curves from there, whose middle control point and end are drawn: directions
    evenly within HALF_TURN of the first, shares within RIMS, the time of the end within TIMES; one
    in WAITERS waits half way until half of that time. Ends are then adapted to the target like
    those of memories, so what is random is the way there.
    """

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


def has_memory() -> bool:
    """Whether there is a memory that planners can ask."""
    return artifacts.model(WHOLE, MANIFEST) is not None


def shipped_memory(name: str) -> Memory:
    """The memory of a planner's name, e.g. ``recall``.

    Controls that have none of their own file that of ``recall`` anew, by their own index.

    Raises
    ------
    RecallError
        One line that says how to make one.
    """
    folder = artifacts.model(name, MANIFEST) or artifacts.model(WHOLE, MANIFEST)
    if folder is None:
        make = f"gcm-learn remember DATASET --out {artifacts.own('models') / name}"
        reason = artifacts.missing("models", f"memory {name!r}", make)
        raise RecallError(f"planner {name!r}: {reason}")
    memory = Memory.load(folder)
    if folder.name == name or name not in _REFILED:
        return memory
    kind = index_class(_REFILED[name])
    return memory.refiled(kind.fit(memory.situations(), 0))


_memory = lru_cache(maxsize=8)(shipped_memory)


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
