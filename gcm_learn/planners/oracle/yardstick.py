"""The yardstick for spatial arms: catches of all methods at large budgets, and a lower bound.

There is no set of places that could be followed through time, as there is in the plane: the joints
have four dimensions.  So every method searches for catches, each at a budget far beyond its usual
one.  A relaxation rules catches out if it can: it shows that no posture which meets a target is
free and in reach of the joints (`posture_boxes`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.errors import MissingExtraError, PlatformError
from gcm_learn.motion import Failure
from gcm_learn.planners.baselines.potential import PotentialPlanner
from gcm_learn.planners.baselines.st_rrt_star import STRRTStarPlanner
from gcm_learn.planners.baselines.straight import StraightPlanner, StraightWaitPlanner
from gcm_learn.planners.completion import JointProblem, checked
from gcm_learn.planners.joints.marching import HandMarching
from gcm_learn.planners.joints.moves import Study, study_of, time_of
from gcm_learn.planners.joints.straight import any_straight, attempt_along
from gcm_learn.planners.joints.tree_search import search_in_space
from gcm_learn.planners.oracle.posture_boxes import earliest_possible
from gcm_learn.planners.plan import Plan
from gcm_learn.situation import Situation

TREES_MS = 10_000.0  # of processor time for ST-RRT*
EFFORT = 10.0  # of the patient search
TIGHT = 0.02  # share of a catch's time within which nothing earlier is looked for
STILL = 1e-12  # turn of all joints between two samples that is a rest [rad]

SpatialPlan = Plan


@dataclass(frozen=True)
class Yardstick:
    """Knowledge about the catches of a situation with a spatial arm."""

    lower: float
    """No movement catches before [s]; infinite if none does within the horizon."""
    plans: dict[str, SpatialPlan]
    """The plans of all methods that were asked, by what they are."""

    @property
    def plan(self) -> SpatialPlan:
        """The earliest verified plan, or the reason for its absence."""
        return min(self.plans.values(), key=_time)

    @property
    def upper(self) -> float:
        """Catch time of `plan` [s]; infinite if it does not catch."""
        return _time(self.plan)

    @property
    def decided(self) -> bool:
        """Return whether a catch is known to exist, or known not to exist."""
        return self.plan.caught or math.isinf(self.lower)

    @property
    def stratum(self) -> Literal["L", "W", "Q", "U"]:
        """Straight line, a way round, waiting, or nothing found; see `yardstick`."""
        caught = {name for name, plan in self.plans.items() if plan.caught}
        if caught & {"straight", "any straight"}:
            return "L"
        if any(name == "marching" or name.endswith("without waits") for name in caught):
            return "W"
        return "Q" if caught else "U"


def yardstick(
    situation: Situation[SpatialArm], trees_ms: float = TREES_MS, *, earliest: bool = True
) -> Yardstick:
    """Run all methods, and rule out the impossible.

    The strata are as in the plane.

    - **L**: a straight line in joints to some interception, evenly fast, catches.
    - **W**: `marching` catches, which never waits.  Or a plan of another method still does if its
      rests are left out and all its legs except the last are as fast as the limits allow.  Under
      limits of acceleration it is a plan without rests.
    - **Q**: some plan catches.
    - **U**: none does.  A `lower` that is infinite rules catches out, else the question is open.

    Parameters
    ----------
    situation : Situation
        With a spatial arm.
    trees_ms : float
        Processor time for ST-RRT*, which is left out where OMPL is missing [ms]. At 0 nothing
        depends on how fast the machine is.
    earliest : bool
        Whether to go on when a catch is known. If not, no method is asked that could only find an
        earlier one.
    """
    problem = JointProblem(situation, "oracle")
    early = problem.early_answer(keeps_acceleration=True)
    if early is not None:
        return Yardstick(math.inf, {"opening": early})
    study = study_of(problem.scene, problem.rules)
    lower, plans = earliest_possible(study), dict[str, SpatialPlan]()
    if math.isinf(lower):
        return Yardstick(lower, {"relaxation": problem.answer(Failure.IMPOSSIBLE)})
    for name, ask in _methods(situation, trees_ms, earliest):
        plans[name] = ask()
        hurried = without_waits(problem, plans[name], study) if plans[name].caught else None
        if hurried is not None:
            plans[f"{name}, without waits"] = hurried
        known = Yardstick(lower, plans)
        if known.stratum in "LW" and (not earliest or lower >= (1.0 - TIGHT) * known.upper):
            break
    if not known.plan.caught:
        undecided = problem.answer(Failure.UNDECIDED.with_numbers(since=lower))
        return Yardstick(lower, {"all": undecided, **plans})
    return known


def oracle_in_space(situation: Situation[SpatialArm], trees_ms: float = TREES_MS) -> SpatialPlan:
    """Return the plan behind the upper bound, or the reason for its absence."""
    problem = JointProblem(situation, "oracle")
    plan = yardstick(situation, trees_ms).plan
    return replace(plan, planner="oracle", planning_ms=problem.elapsed_ms)


def _methods(
    situation: Situation[SpatialArm], trees_ms: float, earliest: bool
) -> Iterator[tuple[str, Callable[[], SpatialPlan]]]:
    """All methods at their budgets, the cheapest first."""

    def straight() -> SpatialPlan:
        problem = JointProblem(situation, "oracle")
        return problem.early_answer() or any_straight(problem, instants=96)

    yield "straight", lambda: StraightPlanner().plan(situation)
    yield "any straight", straight
    yield "straight-wait", lambda: StraightWaitPlanner(instants=96).plan(situation)
    yield "potential", lambda: PotentialPlanner().plan(situation)
    yield "search", lambda: search_in_space().plan(situation)
    patient = search_in_space(effort=EFFORT)
    yield "search, patient", lambda: patient.plan(situation)
    yield "marching", lambda: HandMarching().plan(situation)
    if trees_ms <= 0.0:
        return
    try:
        trees = STRRTStarPlanner(budget_ms=trees_ms)
    except (MissingExtraError, PlatformError):
        return
    yield "st-rrt-star", lambda: trees.plan(situation)


def without_waits(
    problem: JointProblem, plan: SpatialPlan, study: Study | None = None
) -> SpatialPlan | None:
    """Return a plan without its rests, all legs but the last at full speed; None if it fails.

    Beginnings of the last leg are tried from the end of the way to its start.  Under limits of
    acceleration the plan itself is returned, if it never rests.
    """
    study = study_of(problem.scene, problem.rules) if study is None else study
    moves = plan.trajectory
    assert moves is not None
    if problem.accelerates:
        return None if moves.rests else plan
    moved = np.abs(np.diff(moves.joints, axis=0)).max(axis=1, initial=0.0) > STILL
    postures = moves.joints[np.append(True, moved)]
    took = [time_of(study, q, p)[0] for q, p in pairwise(postures)]
    reached = np.concatenate([[0.0], np.cumsum(took)])
    body = [b.name for b in problem.situation.bodies].index(str(plan.catch_body))
    for k in range(len(postures) - 2, -1, -1):
        if reached[k] + time_of(study, postures[k], postures[-1])[0] > moves.duration:
            continue
        time = np.append(reached[: k + 1], moves.duration)
        joints = np.vstack([postures[: k + 1], postures[-1:]])
        found, _ = checked(problem, attempt_along(problem, study, time, joints, body))
        if found is not None:
            return found
    return None


def _time(plan: SpatialPlan) -> float:
    """Return the catch time of a plan [s]; infinite without a catch."""
    return math.inf if plan.catch_time is None else plan.catch_time
