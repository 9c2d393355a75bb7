"""Planners: from a situation to a verified catch."""

from typing import TYPE_CHECKING

from gcm_learn.late import late_names

if TYPE_CHECKING:
    from gcm_learn.planners.baselines.st_rrt_star import STRRTStarPlanner
    from gcm_learn.planners.baselines.straight import StraightPlanner
    from gcm_learn.planners.completion import (
        CATCH_STEP,
        Attempt,
        Problem,
        SpatialProblem,
        Task,
        attempt_of,
        checked,
        first_catch_on,
        straight_plan,
    )
    from gcm_learn.planners.feedback import Exploration, Feedback
    from gcm_learn.planners.fronts import Explore, FrontPlanner, Params, gcm, marching
    from gcm_learn.planners.joints.moves import study_of
    from gcm_learn.planners.joints.straight import any_straight, at_once, earliest_straight
    from gcm_learn.planners.joints.tree_search import TreeSearch, search_in_space
    from gcm_learn.planners.layered_front import layered
    from gcm_learn.planners.oracle.bounds import Bounds, bounds, stratum
    from gcm_learn.planners.oracle.yardstick import Yardstick, without_waits, yardstick
    from gcm_learn.planners.outside import LIMIT, broken_promise
    from gcm_learn.planners.plan import (
        FAULTS,
        GAIN,
        Anytime,
        Deadline,
        Plan,
        Planner,
        deadline_of,
        declined,
        keeps_limits,
        plan_to_json,
        taken,
        takes,
    )
    from gcm_learn.planners.references import (
        absolute,
        acts,
        found,
        in_words,
        instance,
        name_of,
        source_of,
    )
    from gcm_learn.planners.registry import (
        all_planner_names,
        as_ours,
        get_planner,
        is_registered,
        plan_with,
        planner_names,
        solve,
        summary_of,
    )
    from gcm_learn.planners.tube import InTube, Tube

# Loaded when they are asked for: a planner's compiled code takes a second to load.
__getattr__ = late_names(__name__, {
    "baselines.st_rrt_star": ("STRRTStarPlanner",),
    "baselines.straight": ("StraightPlanner",),
    "completion": (
        "CATCH_STEP", "Attempt", "Problem", "SpatialProblem", "Task", "attempt_of", "checked",
        "first_catch_on", "straight_plan",
    ),
    "feedback": ("Exploration", "Feedback"),
    "fronts": ("Explore", "FrontPlanner", "Params", "gcm", "marching"),
    "joints.moves": ("study_of",),
    "joints.straight": ("any_straight", "at_once", "earliest_straight"),
    "joints.tree_search": ("TreeSearch", "search_in_space"),
    "layered_front": ("layered",),
    "oracle.bounds": ("Bounds", "bounds", "stratum"),
    "oracle.yardstick": ("Yardstick", "without_waits", "yardstick"),
    "outside": ("LIMIT", "broken_promise"),
    "plan": (
        "FAULTS", "GAIN", "Anytime", "Deadline", "Plan", "Planner", "declined", "deadline_of",
        "plan_to_json", "keeps_limits", "taken", "takes",
    ),
    "references": (
        "absolute", "acts", "found", "in_words", "instance", "name_of", "source_of",
    ),
    "registry": (
        "all_planner_names",
        "as_ours", "get_planner", "is_registered", "plan_with", "planner_names", "solve",
        "summary_of",
    ),
    "tube": ("InTube", "Tube"),
})  # fmt: skip

__all__ = [
    "Plan",
    "Anytime",
    "Attempt",
    "Bounds",
    "CATCH_STEP",
    "Deadline",
    "Exploration",
    "Explore",
    "Feedback",
    "FAULTS",
    "FrontPlanner",
    "GAIN",
    "InTube",
    "LIMIT",
    "Params",
    "Planner",
    "Problem",
    "STRRTStarPlanner",
    "SpatialProblem",
    "StraightPlanner",
    "Task",
    "TreeSearch",
    "Tube",
    "Yardstick",
    "absolute",
    "acts",
    "all_planner_names",
    "any_straight",
    "as_ours",
    "at_once",
    "attempt_of",
    "bounds",
    "broken_promise",
    "checked",
    "declined",
    "deadline_of",
    "earliest_straight",
    "first_catch_on",
    "found",
    "gcm",
    "get_planner",
    "in_words",
    "instance",
    "is_registered",
    "layered",
    "marching",
    "name_of",
    "plan_to_json",
    "plan_with",
    "planner_names",
    "search_in_space",
    "solve",
    "source_of",
    "straight_plan",
    "study_of",
    "stratum",
    "summary_of",
    "keeps_limits",
    "taken",
    "takes",
    "without_waits",
    "yardstick",
]
