"""Planners that recall: they adapt memories to a situation; the first valid path is the plan."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, ClassVar, cast

import numpy as np

from gcm_learn import artifacts, planners, seeding
from gcm_learn.arms import PLANAR, Kind, kind_of
from gcm_learn.errors import RecallError
from gcm_learn.motion import Failure
from gcm_learn.recall.adaptation import DEFAULT, Adaptation, HandTries, Tries, adapt, query_of
from gcm_learn.recall.embedding import KEYS, map_encoder
from gcm_learn.recall.files import MANIFEST
from gcm_learn.recall.hand_paths import ANGLE, EARLIEST, KNOTS, RING, TIME
from gcm_learn.recall.index import LearnedIndex, index_class
from gcm_learn.recall.kinds import MEMORIES, raw_features, same_kind
from gcm_learn.recall.store import Memory
from gcm_learn.recall.trials import Offer, TrialLimits
from gcm_learn.recall.waypoints import Waypoints
from gcm_learn.situation import AnySituation, Situation
from gcm_learn.storage import content_number

CANDIDATES = 20
NOVELTY = 0.05  # a path this near to one that failed is not checked [forearm lengths]
HALF_TURN = 1.8  # largest change of the hand's direction [rad]
RIMS = (0.15, 0.98)  # shares of the ring
TIMES = (0.2, 1.0)  # of the end [horizons]
WAITERS = 4  # one in so many waits
HELD = "-held"  # end of the name of a memory of held catches
_FITTED = {"recall-raw": "raw", "recall-pca": "pca", "recall-random": "random"}
_REFILED = ["recall-map", *_FITTED]


@dataclass(frozen=True)
class Recollection:
    """A plan, the memory behind it, and the number of checks."""

    plan: planners.Plan
    memory: int | None
    """Number of the valid memory."""
    checked: int
    """Paths that were checked."""
    begun: Any = None
    """The search that memories began, if they grew its trees."""


@dataclass(frozen=True)
class RecallPlanner:
    """Planner that recalls memories and verifies them in order, until a memory is valid.

    Nothing is searched: a situation without a valid memory is answered with "unreachable".
    """

    memory: Memory
    candidates: int = CANDIDATES
    """Paths that are checked at most."""
    name: str = "recall"
    how: Adaptation = field(default_factory=Adaptation)
    novelty: float = NOVELTY
    """Paths this near to one that failed are passed over [forearm lengths]; 0 checks all."""
    penalty: float | None = None
    """Weight of a failure for memories that lie near, where scores are odds, as those of
    the learned index are; 0 keeps the order of recall. By default that of the kind of arm."""

    other: Callable[[AnySituation], RecallPlanner] | None = None
    """Maker of the planner for situations with another kind of arm, or with holds."""

    def takes(self, kind: Any) -> bool:
        """Return whether there is a memory for arms of a kind."""
        return MEMORIES.takes(kind) if self.other is not None else kind == self.memory.kind

    def plan(self, situation: AnySituation) -> planners.Plan:
        """Answer a situation."""
        return self.recollect(situation).plan

    def recollect(
        self, situation: AnySituation, deadline: planners.Deadline | None = None
    ) -> Recollection:
        """Answer a situation and say which memory the answer came from."""
        memory = self.memory
        strange = kind_of(situation) != memory.kind or not planners.ends_by_touch(situation)
        if strange and self.other is not None:
            return self.other(situation).recollect(situation, deadline)
        same_kind(memory.kind, situation, memory.columns)
        kind = MEMORIES.of(memory.kind)
        problem = kind.problem(situation, self.name, deadline=deadline)
        answer = kind.early_answer(problem)
        if answer is not None or len(memory) == 0:
            return Recollection(answer or problem.answer(Failure.NO_MEMORY), None, 0)
        tries = kind.tries(problem, self.how)
        place = memory.index.embed_query(situation, problem.scene)
        penalty = kind.penalty if self.penalty is None else self.penalty
        pool = self.candidates * (kind.pool if max(self.novelty, penalty) > 0.0 else 1)
        chosen = memory.recall(place, pool)
        penalty = penalty if memory.index.name == "learned" else 0.0
        offer = _offer(chosen, memory.embeddings, place if penalty > 0.0 else None)
        budget = TrialLimits(self.how.bends, self.candidates, self.novelty, penalty)
        plan, k, tried = _first_plan(problem, tries, (memory.knots, memory.goals), offer, budget)
        number = None if k < 0 else int(chosen[k])
        return Recollection(plan, number, tried, tries.begun if k < 0 else None)


def _offer(chosen: np.ndarray, places: np.ndarray, query: np.ndarray | None = None) -> Offer:
    """Return the offer of memories, in the order given or by inner product with the query."""
    left = np.ones(len(chosen), dtype=bool)
    if query is None:
        scores = -np.arange(len(chosen), dtype=float)
        return Offer(chosen, scores, np.zeros((len(chosen), 1), np.float32), left)
    near = places[chosen]
    return Offer(chosen, (near @ query).astype(float), near, left)


def _first_plan(
    problem: planners.Task,
    tries: Tries,
    paths: tuple[np.ndarray, np.ndarray],
    offer: Offer,
    budget: TrialLimits,
) -> tuple[planners.Plan, int, int]:
    """Return plan and place in the offer (or -1) of the first valid memory, and paths checked."""
    total = 0
    while total < budget.tries:
        left = budget._replace(tries=budget.tries - total)
        k, tried, attempt = tries.first_valid(paths, offer, left)
        if tried == 0:
            break
        total += tried
        plan = None if attempt is None else planners.checked(problem, attempt)[0]
        plan = None if plan is None else tries.finished(plan)
        if plan is not None and plan.caught:
            return plan, k, total
        # The verification has the last word: what is left is tried.
    return problem.answer(Failure.NO_VALID_MEMORY.with_numbers(count=total)), -1, total


def random_waypoints(
    seed: int, index: int, count: int, start: float, horizon: float
) -> tuple[np.ndarray, np.ndarray]:
    """Random movements in the form of `Waypoints`.

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
    knots, goals : (count, KNOTS, 4), (count, 2) ndarray of float32
    """
    rng = seeding.rng(seed, index)
    s = np.linspace(0.0, 1.0, KNOTS)[None]
    angles = rng.uniform(-HALF_TURN, HALF_TURN, (2, count, 1))
    rings = rng.uniform(*RIMS, (2, count, 1))
    ends = horizon * rng.uniform(*TIMES, (count, 1))
    waits = rng.integers(WAITERS, size=(count, 1)) == 0
    knots = np.zeros((count, KNOTS, 4), np.float32)
    knots[:, :, ANGLE] = 2.0 * s * (1.0 - s) * angles[0] + s * s * angles[1]
    ring = (1.0 - s) ** 2 * start + 2.0 * s * (1.0 - s) * rings[0] + s * s * rings[1]
    knots[:, :, RING] = ring
    knots[:, :, TIME] = s * ends
    half = KNOTS // 2
    knots[:, half, EARLIEST] = np.where(waits, 0.5 * ends, 0.0)[:, 0]
    goals = knots[:, -1, [ANGLE, RING]]
    return knots, np.ascontiguousarray(goals)


@dataclass(frozen=True)
class SplinesPlanner:
    """Planner with random movements as memories: control for the effect of verification alone.

    A spline's hand starts where the query's does. Its direction and its share of the ring follow
    quadratic Bezier curves from there, whose middle control point and end are drawn. Directions are
    drawn evenly within HALF_TURN of the first, shares within RIMS, the time of the end within
    TIMES. One in WAITERS waits at its middle until half of that time.

    The ends are then adapted to the target as in memories, so only the path is random.
    """

    candidates: int = CANDIDATES
    seed: int = 0
    name: str = "splines-random"
    how: Adaptation = field(default_factory=Adaptation)

    def plan(self, situation: Situation) -> planners.Plan:
        """Answer a situation."""
        problem = planners.Problem(situation, self.name)
        answer = problem.early_answer()
        if answer is not None:
            return answer
        tries = HandTries(problem, self.how)
        numbers = np.round(raw_features(situation, problem.scene).astype(float), 4) + 0.0
        item, ring = content_number(numbers.tobytes()), tries.query.ring
        paths = random_waypoints(self.seed, item, self.candidates, ring, situation.horizon)
        offer = _offer(np.arange(self.candidates), paths[0])
        budget = TrialLimits(self.how.bends, self.candidates, 0.0, 0.0)
        return _first_plan(problem, tries, paths, offer, budget)[0]


@dataclass(frozen=True)
class HybridPlanner:
    """Recall first, plan when recall fails; with a deadline, also while there is time left."""

    recall: RecallPlanner
    fallback: planners.Planner | None = None
    """Plans where nothing is recalled; by default the usual one of the kind of arm."""
    name: str = "hybrid"

    def takes(self, kind: Any) -> bool:
        """Return whether the recalling planner takes arms of a kind."""
        return self.recall.takes(kind)

    anytime: ClassVar[bool] = True

    def plan(
        self,
        situation: Any,
        bound: float | None = None,
        deadline: float | planners.Deadline | None = None,
    ) -> planners.Plan:
        """Answer a situation; the time of both is counted.

        Parameters
        ----------
        situation : Situation
        bound : float, optional
            Only catches until then count [s].
        deadline : float or Deadline, optional
            See `Anytime`.  What is recalled bounds the search for an earlier catch.  A fallback
            that is not `Anytime` plans only where nothing is recalled, and gets neither.
        """
        limit, most = planners.deadline_of(deadline), math.inf if bound is None else bound
        recalled = self.recall.recollect(situation, limit)
        first = recalled.plan
        if first.status == "start_blocked":
            return replace(first, planner=self.name)
        caught = first.catch_time is not None and first.catch_time <= most
        bounded: dict[str, Any] = {}
        fallback: Any = self.fallback or _planner("search")
        if hasattr(fallback, "for_arm"):
            fallback = fallback.for_arm(situation)
        if getattr(fallback, "anytime", False):
            asked = {"bound": bound, "deadline": limit}
            bounded = {name: value for name, value in asked.items() if value is not None}
        if caught:
            end = (first.catch_time or 0.0) - planners.GAIN * situation.horizon
            if "deadline" not in bounded or end <= 0.0 or bounded["deadline"].over:
                return replace(first, planner=self.name)
            bounded |= {"bound": end}
        begun = recalled.begun if bound is None else None  # its trees may have later catches
        if begun is not None and isinstance(fallback, planners.TreeSearch):
            # Its clock has run since the recall began.
            first, bounded["begun"] = replace(first, planning_ms=0.0), begun
        second = fallback.plan(situation, **bounded)
        best = first if caught and not second.caught else second
        elapsed = first.planning_ms + second.planning_ms
        return replace(best, planner=self.name, planning_ms=elapsed, nodes=second.nodes)


@dataclass(frozen=True)
class Rollout:
    """The first choice, acted on without a check."""

    attempt: planners.Attempt | None
    """None if it cannot be adapted to any target in time."""
    worked: bool
    """True if it would have caught."""


def unverified(memory: Memory, situation: Situation, how: Adaptation = DEFAULT) -> Rollout:
    """Act on the first memory that is recalled, without verification."""
    problem = planners.Problem(situation, "recall-1")
    query = query_of(problem)
    chosen = memory.recall(memory.index.embed_query(situation, problem.scene), 1)
    if len(chosen) == 0:
        return Rollout(None, False)
    k = int(chosen[0])
    attempt = adapt(problem, Waypoints(memory.knots[k], memory.goals[k]), how, query)
    return Rollout(
        attempt, attempt is not None and planners.checked(problem, attempt)[0] is not None
    )


def has_memory() -> bool:
    """Return whether planners find a memory of the plane."""
    return artifacts.model(MEMORIES.of(PLANAR).shipped, MANIFEST) is not None


def shipped_memory(name: str, kind: Kind = PLANAR, held: bool = False) -> Memory:
    """The memory of a planner's name, e.g. ``recall``, for a kind of arm.

    With `held` the memory of held catches is taken, if there is one.

    Controls that have none of their own file that of ``recall`` anew, by their own index.

    Raises
    ------
    RecallError
        One line that says how to make one.
    """
    whole = MEMORIES.of(kind).shipped
    if held and artifacts.model(whole + HELD, MANIFEST) is not None:
        whole += HELD
    own = name + whole.removeprefix(MEMORIES.of(PLANAR).shipped)
    folder = artifacts.model(own, MANIFEST) or artifacts.model(whole, MANIFEST)
    if folder is None:
        make = f"gcm-learn memory make DATASET --out {artifacts.own('models') / own}"
        reason = artifacts.missing("models", f"memory {own!r}", make)
        raise RecallError(f"planner {name!r}: {reason}")
    memory = Memory.load(folder)
    if memory.kind != kind:
        raise RecallError(f"{folder}: a memory of {memory.kind.name} arms, not of {kind.name} ones")
    if folder.name == own or name not in _REFILED:
        return memory
    return _refiled(memory, name)


_memory = lru_cache(maxsize=8)(shipped_memory)
_planner = lru_cache(maxsize=8)(lambda name: cast(Any, planners.get_planner(name)).planner)


def _by_arm(planner: RecallPlanner, name: str) -> RecallPlanner:
    """The planner, with the memory of a name for situations of other kinds."""
    return replace(planner, other=partial(_of_kind, planner, name))


def _of_kind(planner: RecallPlanner, name: str, situation: AnySituation) -> RecallPlanner:
    held = not planners.ends_by_touch(situation)
    return replace(planner, memory=_memory(name, kind_of(situation), held))


def first_choice() -> RecallPlanner:
    """Make the planner that checks the first memory only."""
    return _by_arm(RecallPlanner(_memory("recall"), 1, "recall-1", novelty=0.0), "recall")


def hybrid() -> HybridPlanner:
    """Make the planner that recalls and then searches."""
    return HybridPlanner(_by_arm(RecallPlanner(_memory("recall"), name="hybrid"), "recall"))


def with_memory(name: str, memory: Memory) -> RecallPlanner | HybridPlanner:
    """Return the planner `name`, with the given memory in place of its own.

    Raises
    ------
    RecallError
        If the planner of that name does not recall.
    """
    if name == "hybrid":
        return planners.as_ours(HybridPlanner(RecallPlanner(memory, name=name)))
    if name == "recall":
        return planners.as_ours(RecallPlanner(memory))
    if name == "recall-1":
        return planners.as_ours(RecallPlanner(memory, 1, name, novelty=0.0))
    if name in _REFILED:
        return planners.as_ours(RecallPlanner(_refiled(memory, name), name=name))
    known = ", ".join(["hybrid", "recall", "recall-1", *_REFILED])
    raise RecallError(f"planner {name!r}: takes no memory (planners that do: {known})")


def _refiled(memory: Memory, name: str) -> Memory:
    """Return the memory under the index of a planner's name."""
    if name in _FITTED:
        return memory.refiled(index_class(_FITTED[name]).fit(memory.situations(), 0))
    folder = map_encoder(memory.kind)
    index = LearnedIndex.load(folder)
    if memory.index.key == index.key:
        return memory
    return memory.refiled(index, stored_keys(folder / KEYS, index.key, memory.digest))


def stored_keys(path: Path, encoder: str, memory: str) -> np.ndarray | None:
    """Return the embeddings in a file if they are of this encoder and this memory, else None."""
    if not path.exists():
        return None
    with np.load(path) as file:
        own = (str(file["key"]), str(file["memory"])) == (encoder, memory)
        return file["embeddings"].astype(np.float32) if own else None


def _recalling(name: str) -> RecallPlanner:
    return _by_arm(RecallPlanner(_memory(name), name=name), name)


recall, recall_map, recall_raw, recall_pca, recall_random = (
    partial(_recalling, name) for name in ("recall", *_REFILED)
)
