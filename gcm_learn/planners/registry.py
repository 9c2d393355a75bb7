"""Planners by name."""

from __future__ import annotations

from collections.abc import Callable

from gcm_learn.errors import UnknownNameError
from gcm_learn.planners.fronts import gcm, marching
from gcm_learn.planners.layered import layered
from gcm_learn.planners.oracle import OraclePlanner
from gcm_learn.planners.plan import Plan, Planner
from gcm_learn.planners.potential import PotentialPlanner
from gcm_learn.planners.st_rrt_star import STRRTStarPlanner
from gcm_learn.planners.straight import StraightPlanner
from gcm_learn.planners.straight_wait import StraightWaitPlanner
from gcm_learn.situation import Situation

_PLANNERS: dict[str, Callable[[], Planner]] = {
    "gcm": gcm,
    "layered": layered,
    "marching": marching,
    "oracle": OraclePlanner,
    "potential": PotentialPlanner,
    "st-rrt-star": STRRTStarPlanner,
    "straight": StraightPlanner,
    "straight-wait": StraightWaitPlanner,
}


def planner_names() -> list[str]:
    """Names of the registered planners."""
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
    if name not in _PLANNERS:
        raise UnknownNameError(f"planner: {name!r} is not one of {', '.join(planner_names())}")
    return _PLANNERS[name]()


def solve(situation: Situation, planner: str | Planner = "gcm") -> Plan:
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

    Examples
    --------
    >>> from gcm_learn import Arm, Body, Disc, PlanarQuadratic, Situation, solve
    >>> still = PlanarQuadratic((1.2, 0.9), (0, 0), (0, 0))
    >>> ball = Body("target", "ball", Disc(0.08), still)
    >>> solve(Situation("reach", 1.0, Arm((1.1, -0.4), 3.1), (ball,)), "straight").status
    'caught'
    """
    chosen = get_planner(planner) if isinstance(planner, str) else planner
    return chosen.plan(situation)
