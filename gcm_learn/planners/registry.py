"""Planners by name."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any, cast, overload

from gcm_learn.arms import SpatialArm
from gcm_learn.errors import UnknownNameError
from gcm_learn.motion import SpatialTrajectory
from gcm_learn.planners.baselines.potential import PotentialPlanner
from gcm_learn.planners.baselines.st_rrt_star import STRRTStarPlanner
from gcm_learn.planners.baselines.straight import StraightPlanner
from gcm_learn.planners.baselines.straight_wait import StraightWaitPlanner
from gcm_learn.planners.by_arm import ByArm
from gcm_learn.planners.deadline import Deadline
from gcm_learn.planners.fronts import gcm, marching
from gcm_learn.planners.layered import layered
from gcm_learn.planners.layered_wave import layered_wave
from gcm_learn.planners.oracle.bounds import OraclePlanner
from gcm_learn.planners.plan import AnyPlan, Anytime, Plan, Planner, taken
from gcm_learn.planners.space.layered import LayeredInSpace
from gcm_learn.planners.space.marching import gcm_in_space, marching_in_space
from gcm_learn.situation import AnySituation, Situation

_PLANNERS: dict[str, Callable[[], Planner]] = {
    "gcm": lambda: ByArm(gcm(), gcm_in_space()),
    "layered": lambda: ByArm(layered(), LayeredInSpace()),
    "layered-wave": layered_wave,
    "marching": lambda: ByArm(marching(), marching_in_space()),
    "oracle": OraclePlanner,
    "potential": PotentialPlanner,
    "st-rrt-star": STRRTStarPlanner,
    "straight": StraightPlanner,
    "straight-wait": StraightWaitPlanner,
}


# Planners of folders above this one, by the module that registers them. It is imported when one of
# them is asked for; its name is all that is known of it here.
_ABOVE = dict.fromkeys(
    ("hybrid", "recall", "recall-1", "recall-pca", "recall-random", "recall-raw", "splines-random"),
    "gcm_learn.recall.planners",
)


def register(name: str, factory: Callable[[], Planner]) -> None:
    """Make a planner known by name.

    Parameters
    ----------
    name : str
        A name that is taken already gets the new planner.
    factory : callable
        Makes the planner with its default settings.
    """
    _PLANNERS[name] = factory


def planner_names() -> list[str]:
    """Names of the planners that need nothing but a situation."""
    return sorted(set(_PLANNERS) - set(_ABOVE))


def get_planner(name: str) -> Planner:
    """A planner with its default settings.

    Raises
    ------
    UnknownNameError
        With the known names.
    MissingExtraError
        If the planner needs a library that is not installed.
    """
    if name not in _PLANNERS and name in _ABOVE:
        importlib.import_module(_ABOVE[name])
    if name not in _PLANNERS:
        known = f"{', '.join(planner_names())}; with a memory: {', '.join(sorted(_ABOVE))}"
        raise UnknownNameError(f"planner: {name!r} is not one of {known}")
    return _PLANNERS[name]()


@overload
def solve(situation: Situation, planner: str | Planner = "gcm") -> Plan: ...
@overload
def solve(
    situation: Situation[SpatialArm], planner: str | Planner = "gcm"
) -> Plan[SpatialTrajectory]: ...
def solve(situation: AnySituation, planner: str | Planner = "gcm") -> AnyPlan:
    """Plan a catch and verify it.

    Parameters
    ----------
    situation : Situation
    planner : str or Planner
        A registered name ("gcm", "marching", "straight") or a planner of your own.

    Returns
    -------
    Plan
        Its status is "caught" only if the trajectory has been verified.

    Raises
    ------
    ArmKindError
        If the planner does not take the situation's arm.

    Examples
    --------
    >>> from gcm_learn import Arm, Body, Disc, PlanarQuadratic, Situation, solve
    >>> still = PlanarQuadratic((1.2, 0.9), (0, 0), (0, 0))
    >>> ball = Body("target", "ball", Disc(0.08), still)
    >>> solve(Situation("reach", 1.0, Arm((1.1, -0.4), 3.1), (ball,)), "straight").status
    'caught'
    """
    chosen = get_planner(planner) if isinstance(planner, str) else planner
    return plan_with(chosen, situation)


def plan_with(
    planner: Planner, situation: AnySituation, deadline: float | Deadline | None = None
) -> AnyPlan:
    """Let a planner answer a situation, if it takes the arm; a deadline is for those `Anytime`.

    Raises
    ------
    ArmKindError
    """
    given: Any = taken(planner, situation)
    if deadline is None:
        return planner.plan(given)
    return cast(Anytime, planner).plan(given, deadline=deadline)
