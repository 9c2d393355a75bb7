"""Planners by name."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable
from typing import Any, cast, overload

from gcm_learn.arms import PLANAR, SPATIAL, ByKind, SpatialArm
from gcm_learn.errors import UnknownNameError
from gcm_learn.planners.baselines.potential import PotentialPlanner
from gcm_learn.planners.baselines.st_rrt_star import STRRTStarPlanner
from gcm_learn.planners.baselines.straight import StraightPlanner
from gcm_learn.planners.baselines.straight_wait import StraightWaitPlanner
from gcm_learn.planners.by_arm import ByArm
from gcm_learn.planners.deadline import Deadline
from gcm_learn.planners.fronts import gcm, marching
from gcm_learn.planners.joints.layered import LayeredInSpace
from gcm_learn.planners.joints.marching import gcm_in_space, posture_marching
from gcm_learn.planners.joints.tree_search import TreeSearch
from gcm_learn.planners.layered import layered
from gcm_learn.planners.layered_wave import layered_wave
from gcm_learn.planners.oracle.bounds import OraclePlanner
from gcm_learn.planners.plan import Anytime, Plan, Planner, taken
from gcm_learn.situation import AnySituation, Situation

_PLANNERS: dict[str, Callable[[], Planner]] = {
    "gcm": lambda: ByArm("gcm", ByKind({PLANAR: gcm(), SPATIAL: gcm_in_space()})),
    "layered": lambda: ByArm("layered", ByKind({PLANAR: layered(), SPATIAL: LayeredInSpace()})),
    "layered-wave": layered_wave,
    "marching": lambda: ByArm(
        "marching", ByKind({PLANAR: marching(), SPATIAL: posture_marching()})
    ),
    "oracle": OraclePlanner,
    "potential": PotentialPlanner,
    "search": lambda: ByArm(
        "search",
        ByKind(
            {PLANAR: layered(name="search"), SPATIAL: LayeredInSpace(name="search")},
            default=TreeSearch(),
        ),
    ),
    "st-rrt-star": STRRTStarPlanner,
    "straight": StraightPlanner,
    "straight-wait": StraightWaitPlanner,
}

_ABOVE = {
    "hybrid": "gcm_learn.recall.planners:hybrid",
    "recall": "gcm_learn.recall.planners:recall",
    "recall-1": "gcm_learn.recall.planners:first_choice",
    "recall-pca": "gcm_learn.recall.planners:recall_pca",
    "recall-random": "gcm_learn.recall.planners:recall_random",
    "recall-raw": "gcm_learn.recall.planners:recall_raw",
    "splines-random": "gcm_learn.recall.planners:SplinesPlanner",
}
"""Factories in higher folders, imported at the first use."""


def planner_names() -> list[str]:
    """Names of the planners that need only a situation."""
    return sorted(_PLANNERS)


def get_planner(name: str) -> Planner:
    """A planner with its default settings.

    Raises
    ------
    UnknownNameError
        With the known names.
    MissingExtraError
        If the planner needs a library that is not installed.
    """
    if name in _PLANNERS:
        return _PLANNERS[name]()
    if name in _ABOVE:
        planner: Planner = pkgutil.resolve_name(_ABOVE[name])()
        return planner
    raise UnknownNameError.among("planner", name, [*planner_names(), *sorted(_ABOVE)])


@overload
def solve(situation: Situation, planner: str | Planner = "search") -> Plan: ...
@overload
def solve(situation: Situation[SpatialArm], planner: str | Planner = "search") -> Plan: ...
def solve(situation: AnySituation, planner: str | Planner = "search") -> Plan:
    """Plan a catch and verify it.

    Parameters
    ----------
    situation : Situation
    planner : str or Planner
        A registered name ("search", "gcm", "straight") or a planner of your own.

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
) -> Plan:
    """Let a planner answer a situation, if it takes the arm; a deadline is for those `Anytime`.

    Raises
    ------
    ArmKindError
    """
    given: Any = taken(planner, situation)
    if deadline is None:
        return planner.plan(given)
    return cast(Anytime, planner).plan(given, deadline=deadline)
