"""Planners: from a situation to a verified catch."""

from gcm_learn.planners.baselines.st_rrt_star import STRRTStarPlanner
from gcm_learn.planners.baselines.straight import StraightPlanner
from gcm_learn.planners.fronts import FrontPlanner, gcm, marching
from gcm_learn.planners.plan import Plan, Planner, plan_to_json
from gcm_learn.planners.registry import get_planner, planner_names, solve
from gcm_learn.planners.retiming import retime

__all__ = [
    "FrontPlanner",
    "Plan",
    "Planner",
    "STRRTStarPlanner",
    "StraightPlanner",
    "gcm",
    "get_planner",
    "marching",
    "plan_to_json",
    "planner_names",
    "retime",
    "solve",
]
