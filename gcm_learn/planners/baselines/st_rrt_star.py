"""ST-RRT* through OMPL, for comparison: two trees in space-time that keep improving their path.

F. Grothe, V. N. Hartmann, A. Orthey, M. Toussaint, ST-RRT*: asymptotically-optimal bidirectional
motion planning through space-time, ICRA 2022.

OMPL's planner knows goals that stand still: it has a goal's place drawn and draws its time itself.
Here an interception is drawn, place and time at once.  Its time replaces OMPL's when OMPL next asks
whether that state is valid (`st_rrt_star_search`).  The alternative is to refuse places that no
target is on at the time that OMPL drew.  It found as many catches, but later ones (within 10 ms
1.14 times as late as `layered`, against 1.07).  A search for each of many instants was not tried:
what it learns for one would be lost for the next.

All settings are OMPL's own.  They were varied on 100 random situations that no straight line
solves.  Ranges down to 0.25 found fewer catches within 10 ms and as many within 100.  Without
rewiring there were a few more within 10 ms (67 against 59 to 63).  They improved less, though (1.04
times as late as `layered` after 100 ms, against 1.00).  Four fifths of the time are spent inside
OMPL, not in our checks.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from types import ModuleType
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from gcm_learn import motion
from gcm_learn.arms import PLANAR, ByKind, Kind, SpatialArm
from gcm_learn.errors import MissingExtraError, PlatformError
from gcm_learn.planners import completion
from gcm_learn.planners.baselines import isolation
from gcm_learn.planners.baselines.isolation import Tell, told
from gcm_learn.planners.baselines.st_rrt_star_joints import near, task_in_space, ways_along
from gcm_learn.planners.baselines.st_rrt_star_moves import HandTask
from gcm_learn.planners.plan import Plan
from gcm_learn.situation import AnySituation, Situation

if TYPE_CHECKING:
    from gcm_learn.planners.baselines.st_rrt_star_search import SpaceTime

ITERATIONS = 1000
LONGEST_MS = 10_000.0
"""Of any search: legs among bodies of absurd sizes and speeds take long to check."""
FOLDED = 0.01
"""With arms of equal length legs stay that far from the shoulder, where the arm would have to turn
round within no time [forearm lengths]."""
NO_END = 2**62  # iterations

Improvement = tuple[float, np.ndarray]  # when it was found [ms], and x, y and time (n, 3)


@dataclass(frozen=True)
class STRRTStarPlanner:
    """ST-RRT* of OMPL 1.7, with goals along the predicted interceptions.

    In the plane states are hand and time, and the elbow keeps its side.  Otherwise they are joints
    and time, each joint in units of what it turns in a second.  A goal is an instant and a place
    where the hand is then within grasp of a target.  Goals are drawn evenly from all instants that
    would improve the catch.  A leg is valid if the continuous clearance that verifies plans says
    so; paths are finished and verified like everybody's.  Without a budget the search ends after a
    number of iterations, so that its answers are the same every time.

    OMPL 1.7.0 now and then crashes when it prunes its trees (fixed in 2.0, whose Python binding has
    no ST-RRT*).  So it runs in a copy of the process, and what it had found before counts.
    """

    name: str = "st-rrt-star"
    budget_ms: float | None = None
    """Processor time for the search [ms]; the time on an otherwise idle core."""
    iterations: int = ITERATIONS
    """Of the search if there is no budget: of growing the trees, or of looking for a goal."""
    seed: int = 0
    postures: tuple[tuple[float, ...], ...] = ()
    """Of chains: postures from which a quarter of the goals are pulled, such as known goals."""

    accelerates = False

    def takes(self, kind: Kind) -> bool:
        """Return whether there is a search for arms of a kind."""
        return _BY_KIND.takes(kind)

    def __post_init__(self) -> None:
        """Raise at once if OMPL is missing, or cannot run in a copy of the process here."""
        if not isolation.POSSIBLE:
            raise PlatformError("st-rrt-star", "a POSIX system, such as Linux or macOS")
        _library()

    @overload
    def plan(self, situation: Situation) -> Plan: ...
    @overload
    def plan(self, situation: Situation[SpatialArm]) -> Plan: ...
    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        if self.budget_ms is not None:
            return self._plans(situation, (self.budget_ms,), NO_END)[0]
        return self._plans(situation, (LONGEST_MS,), self.iterations)[0]

    @overload
    def plan_anytime(
        self, situation: Situation, budgets_ms: Sequence[float] = ...
    ) -> list[Plan]: ...
    @overload
    def plan_anytime(
        self, situation: Situation[SpatialArm], budgets_ms: Sequence[float] = ...
    ) -> list[Plan]: ...
    def plan_anytime(
        self, situation: AnySituation, budgets_ms: Sequence[float] = (10.0, 100.0, 1000.0)
    ) -> Any:
        """Return a plan for each budget, all from one run with the largest budget.

        The planner only ever improves its path.  So its path at some time is the result of a run
        that ends there.  `planning_ms` is that of such a run, without copying the process.
        """
        return self._plans(situation, budgets_ms, NO_END)

    def _plans(
        self, situation: AnySituation, budgets_ms: Sequence[float], iterations: int
    ) -> list[Any]:
        begin, make, finished = _BY_KIND.of(situation)
        problem: Any = begin(situation, self.name)
        answer = problem.early_answer()
        if answer is not None:
            return [answer] * len(budgets_ms)
        task = make(problem, self.seed, min(max(budgets_ms), LONGEST_MS), iterations)
        if self.postures:
            task = near(task, self.postures)
        before = problem.elapsed_ms
        found, used = _search(task)
        plans = []
        for budget in budgets_ms:
            began, thought = clock.perf_counter(), min(budget, used)
            early = [path for when, path in found if when <= budget]
            plan = _best(problem, finished(problem, early))
            after = 1e3 * (clock.perf_counter() - began)
            plans.append(replace(plan, planning_ms=before + thought + after))
        return plans


def _library() -> ModuleType:
    """Import the module that needs OMPL."""
    try:
        from gcm_learn.planners.baselines import st_rrt_star_search
    except ImportError as error:
        if (error.name or "").split(".")[0] != "ompl":
            raise
        raise MissingExtraError("st-rrt-star", "ompl 1.7", "peers") from error
    return st_rrt_star_search


@lru_cache(maxsize=1)
def _warmed() -> ModuleType:
    """Return the search module fully loaded, so that copies of the process need not load it."""
    library = _library()
    library.warm_up()
    return library


def _search(task: SpaceTime) -> tuple[list[Improvement], float]:
    """All improvements, the best last, and the time used [ms]."""
    library = _warmed()
    task.draw(task.scene.limits.horizon, np.full((1, task.draws), 0.5))  # loads kernels, see above
    task.holds(task.start, 0.0, task.start, task.scene.limits.horizon)

    def work(tell: Tell) -> None:
        library.Search(task, lambda *_: None)  # touches the memory that copies share until then
        search = library.Search(task, lambda when, path: tell((when, np.array(path))))
        search.run()
        tell((search.used_ms, None))

    things, _ = told(work, longest=2.0 + 2e-3 * task.budget_ms)
    # Now and then OMPL offers a path on which time goes back where its two trees meet.
    found = [(when, path) for when, path in things if path is not None and _forward(path)]
    return found, things[-1][0] if things else 0.0


def _forward(path: np.ndarray) -> bool:
    """Return whether time, the last number of each state (n, k), never goes back."""
    return bool((np.diff(path[:, -1]) >= 0.0).all())


def _best(problem: completion.Task, attempts: Iterable[completion.Attempt | None]) -> Plan:
    """The first attempt that holds, as a plan."""
    reason: motion.Reason | None = motion.Reason(motion.Failure.NO_TREE)
    for attempt in attempts:
        if attempt is None:
            continue
        plan, reason = completion.checked(problem, attempt)
        if plan is not None:
            return plan
    return problem.answer(reason or motion.Failure.NO_TREE)


def _finished(
    problem: completion.Problem, paths: list[np.ndarray]
) -> Iterator[completion.Attempt | None]:
    """Return an attempt, or None, for each path between states (n, 3), the last path first."""
    return (completion.finish(problem, *_sampled(path)) for path in reversed(paths))


def _sampled(path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Hands (m, 2) and times (m,) along the straight legs between states (n, 3)."""
    hand, time = [path[:1, :2]], [path[:1, 2]]
    for before, after in pairwise(path):
        leg = motion.straight_path(before[:2], after[:2])
        hand.append(leg[1:])
        time.append(np.linspace(before[2], after[2], len(leg))[1:])
    return np.vstack(hand), np.concatenate(time)


def task_of(problem: completion.Problem, seed: int, budget_ms: float, iterations: int) -> HandTask:
    """Return the search space and the search budget for a planar arm."""
    situation, arm, scene = problem.situation, problem.situation.arm, problem.scene
    rules = problem.rules._replace(speed=arm.max_hand_speed)
    t, *_ = motion.first_interception(
        motion.anywhere(scene), rules, *arm.hand, 0.0, 0.0, situation.horizon
    )
    nearest = math.hypot(*arm.hand)
    limb = scene.limb._replace(far=max(arm.reach, nearest))
    return HandTask(
        scene=scene._replace(limb=limb),
        rules=rules,
        hole=_hole(arm.inner_reach, nearest),
        unhindered=max(float(t) - rules.instant, 0.0),
        seed=seed,
        budget_ms=budget_ms,
        iterations=iterations,
    )


def _hole(inner: float, nearest: float) -> float:
    """Distance that legs keep from the shoulder, given the ring's hole and the hand's distance."""
    folded = min(FOLDED, 0.5 * nearest)
    return max(min(inner + motion.HOLE_MARGIN, nearest * (1.0 - 1e-9)), folded)


_BY_KIND: ByKind[tuple[Any, Any, Any]] = ByKind(
    {PLANAR: (completion.Problem, task_of, _finished)},
    default=(completion.JointProblem, task_in_space, ways_along),
    who="planner 'st-rrt-star'",
)
