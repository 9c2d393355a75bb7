"""Planners: from a situation to a verified catch."""

from typing import TYPE_CHECKING

from gcm_learn import late

if TYPE_CHECKING:
    from gcm_learn.planners.baselines.st_rrt_star import STRRTStarPlanner as STRRTStarPlanner
    from gcm_learn.planners.baselines.straight import StraightPlanner as StraightPlanner
    from gcm_learn.planners.completion import (
        CATCH_STEP as CATCH_STEP,
        Attempt as Attempt,
        JointProblem as JointProblem,
        Problem as Problem,
        Task as Task,
        attempt_of as attempt_of,
        checked as checked,
        ends_by_touch as ends_by_touch,
        first_catch_on as first_catch_on,
        straight_plan as straight_plan,
    )
    from gcm_learn.planners.feedback import Exploration as Exploration, Feedback as Feedback
    from gcm_learn.planners.fronts import (
        Explore as Explore,
        FrontPlanner as FrontPlanner,
        Params as Params,
        gcm as gcm,
        marching as marching,
    )
    from gcm_learn.planners.goal_directed import layered as layered
    from gcm_learn.planners.joints.end_search import EndSearch as EndSearch
    from gcm_learn.planners.joints.moves import study_of as study_of
    from gcm_learn.planners.joints.straight import (
        any_straight as any_straight,
        at_once as at_once,
        earliest_straight as earliest_straight,
    )
    from gcm_learn.planners.joints.tree_search import (
        TreeSearch as TreeSearch,
        search_in_space as search_in_space,
    )
    from gcm_learn.planners.joints.ways import JointWay as JointWay, new_way as new_way
    from gcm_learn.planners.names import (
        all_planner_names as all_planner_names,
        check_name as check_name,
        is_registered as is_registered,
        summary_of as summary_of,
    )
    from gcm_learn.planners.oracle.bounds import (
        Bounds as Bounds,
        bounds as bounds,
        stratum as stratum,
    )
    from gcm_learn.planners.oracle.yardstick import (
        Yardstick as Yardstick,
        without_waits as without_waits,
        yardstick as yardstick,
    )
    from gcm_learn.planners.outside import LIMIT as LIMIT, broken_promise as broken_promise
    from gcm_learn.planners.plan import (
        FAULTS as FAULTS,
        GAIN as GAIN,
        Anytime as Anytime,
        Catch as Catch,
        Deadline as Deadline,
        Plan as Plan,
        Planner as Planner,
        deadline_of as deadline_of,
        declined as declined,
        keeps_limits as keeps_limits,
        plan_to_json as plan_to_json,
        taken as taken,
        takes as takes,
    )
    from gcm_learn.planners.references import (
        absolute as absolute,
        acts as acts,
        found as found,
        in_words as in_words,
        instance as instance,
        name_of as name_of,
        source_of as source_of,
    )
    from gcm_learn.planners.registry import (
        as_ours as as_ours,
        get_planner as get_planner,
        plan_with as plan_with,
        planner_names as planner_names,
        solve as solve,
    )
    from gcm_learn.planners.tube import InTube as InTube, Tube as Tube

# Loaded when they are asked for: a planner's compiled code takes a second to load.
__getattr__ = late.late_names(__name__, {
    "baselines.st_rrt_star": ("STRRTStarPlanner",),
    "baselines.straight": ("StraightPlanner",),
    "completion": (
        "CATCH_STEP", "Attempt", "Problem", "JointProblem", "Task", "attempt_of", "checked",
        "ends_by_touch", "first_catch_on", "straight_plan",
    ),
    "feedback": ("Exploration", "Feedback"),
    "fronts": ("Explore", "FrontPlanner", "Params", "gcm", "marching"),
    "goal_directed": ("layered",),
    "joints.end_search": ("EndSearch",),
    "joints.moves": ("study_of",),
    "joints.straight": ("any_straight", "at_once", "earliest_straight"),
    "joints.tree_search": ("TreeSearch", "search_in_space"),
    "joints.ways": ("JointWay", "new_way"),
    "names": ("all_planner_names", "check_name", "is_registered", "summary_of"),
    "oracle.bounds": ("Bounds", "bounds", "stratum"),
    "oracle.yardstick": ("Yardstick", "without_waits", "yardstick"),
    "outside": ("LIMIT", "broken_promise"),
    "plan": (
        "FAULTS", "GAIN", "Anytime", "Catch", "Deadline", "Plan", "Planner", "declined",
        "deadline_of", "keeps_limits", "plan_to_json", "taken", "takes",
    ),
    "references": (
        "absolute", "acts", "found", "in_words", "instance", "name_of", "source_of",
    ),
    "registry": (
        "as_ours", "get_planner", "plan_with", "planner_names", "solve",
    ),
    "tube": ("InTube", "Tube"),
})  # fmt: skip
