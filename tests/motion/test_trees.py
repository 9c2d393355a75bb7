"""Arms with branches and followers: honest plans, and planted lies that both judges find."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from gcm_learn.arms import CHAIN
from gcm_learn.errors import ArenaError
from gcm_learn.execution import Pool
from gcm_learn.motion import Movement, joint_names, opening, verify, with_stop
from gcm_learn.planners import get_planner, plan_to_json
from gcm_learn.referee import judge
from gcm_learn.scene import pack
from gcm_learn.situation import situation_from_json
from tests.worlds import ball, body, still

TURNS = {"axis": [0, 0, 1], "range": [-2, 2], "max_speed": 2}
LEVER = {
    "format": "gcm-learn/arm@2",
    "name": "lever",
    "joints": [
        TURNS | {"name": "a", "origin": [0, 0, 0.1]},
        TURNS | {"name": "b", "origin": [0.4, 0, 0]},
        TURNS | {"name": "lever", "origin": [0.1, 0, 0.1], "parent": 1,
                 "follows": {"joint": 2, "factor": 1}},
    ],
    "links": [
        {"joint": 1, "from": [0, 0, 0], "to": [0.4, 0, 0], "radius": 0.03},
        {"joint": 2, "from": [0, 0, 0], "to": [0.4, 0, 0], "radius": 0.03},
        {"joint": 3, "from": [0, 0, 0], "to": [0, 0.6, 0], "radius": 0.03, "name": "lever"},
    ],
    "hand": {"joint": 2, "point": [0.4, 0, 0]},
}  # fmt: skip
GOAL = (0.2, 0.8)
SWEPT = (-0.188, 0.5365, 0.2)
"""Place that the lever's end passes on the straight way to `GOAL`."""


def hand_at(a, b):
    """Hand of the lever arm."""
    return [0.4 * np.cos(a) + 0.4 * np.cos(a + b), 0.4 * np.sin(a) + 0.4 * np.sin(a + b), 0.1]


def situation(goal=GOAL, posts=(), **arm):
    """A ball at rest where the lever arm's hand is at a goal, and posts."""
    bodies = [body("target", "ball", ball(0.02), still(hand_at(*goal)))]
    bodies += [body("obstacle", f"post {k}", ball(0.03), still(p)) for k, p in enumerate(posts)]
    given = {"kind": "chain", "model": copy.deepcopy(LEVER), "posture": [0, 0], "grasp": 0.01}
    return {"format": "gcm-learn/situation@3", "name": "lever", "horizon": 3.0, "arm": given | arm,
            "bodies": bodies}  # fmt: skip


def judged(given, time, joints):
    """The package's word on a movement, and the referee's."""
    scene = pack(situation_from_json(given))
    moves = Movement(scene_arm(given), np.array(time), np.array(joints, dtype=float))
    verdict = verify(scene, opening(scene).rules, moves, 0)
    answer = {
        "format": "gcm-learn/solution@3", "name": "lever", "planner": "liar", "status": "caught",
        "catches": [{"body": "ball", "time": time[-1]}], "catch_time": time[-1],
        "catch_body": "ball", "clearance": None, "planning_ms": 0.0, "message": "",
        "trajectory": {"time": list(time), "joints": moves.joints.tolist(),
                       "hand": moves.hand.tolist()},
    }  # fmt: skip
    return verdict, " | ".join(map(str, judge(given, answer)))


def scene_arm(given):
    """The arm of a situation in JSON."""
    return situation_from_json(given).arm


def test_an_honest_move_pleases_both():
    verdict, words = judged(situation(), (0.0, 1.0), ((0.0, 0.0), GOAL))
    assert verdict.good and words == ""


def test_a_branch_that_sweeps_through_a_post_between_samples():
    """At neither sample is the lever near the post."""
    verdict, words = judged(situation(posts=[SWEPT]), (0.0, 1.0), ((0.0, 0.0), GOAL))
    assert not verdict.good and 0.0 < verdict.collision_time < 1.0
    assert "link 2 and post 0" in words


@pytest.mark.slow
def test_a_planner_goes_round_with_its_lever_too():
    given = situation(posts=[SWEPT])
    plan = get_planner("search").plan(situation_from_json(given))
    assert judge(given, plan_to_json(plan)) == []
    ends = situation(posts=[[0.1 - 0.6 * np.sin(1.0), 0.6 * np.cos(1.0), 0.2]], goal=(0.0, 1.0))
    plan = get_planner("search").plan(situation_from_json(ends))
    assert judge(ends, plan_to_json(plan)) == []


LIES = {
    "range": ({"range": [-0.5, 0.5]}, (0.0, 1.0), "joint 2 leaves its range"),
    "speed": ({"max_speed": 0.7}, (0.0, 1.0), "joint 2 moves too fast"),
    "factor": ({"follows": {"joint": 2, "factor": -3}}, (0.0, 1.0), "joint 2 leaves its range"),
}


@pytest.mark.parametrize("lie", LIES)
def test_what_breaks_a_followers_own_limits(lie):
    change, time, complaint = LIES[lie]
    given = situation()
    given["arm"]["model"]["joints"][2] |= change
    verdict, words = judged(given, time, ((0.0, 0.0), GOAL))
    assert not verdict.good and complaint in words


@pytest.mark.slow  # compiles a search for trees
def test_coordinates_alone_stand_in_a_trajectory():
    """A telescope whose stages follow the first is a coordinate."""
    slide = {"type": "prismatic", "axis": [1, 0, 0], "range": [0, 0.2], "max_speed": 1,
             "origin": [0.1, 0, 0]}  # fmt: skip
    stages = [slide] + [slide | {"follows": {"joint": 1, "factor": 1}} for _ in range(3)]
    links = [{"joint": k, "from": [0, 0, 0], "to": [0.1, 0, 0], "radius": 0.02} for k in range(5)]
    model = {"format": "gcm-learn/arm@2", "joints": stages, "links": links,
             "hand": {"joint": 4, "point": [0.1, 0, 0]}}  # fmt: skip
    given = situation(model=model, posture=[0.05])
    given["bodies"][0]["motion"]["position"] = [1.1, 0, 0]
    read = situation_from_json(given)
    answer = plan_to_json(get_planner("search").plan(read), read)
    assert answer["status"] == "caught" and judge(given, answer) == []
    assert np.shape(answer["trajectory"]["joints"])[1] == 1


def test_a_robots_trajectory_names_the_joints_that_lead():
    arm = scene_arm(situation())
    assert joint_names(arm) == ["a", "b"]
    stopped = with_stop(situation_from_json(situation()), _move(arm))
    assert stopped.joints.shape[1] == 2 and stopped.duration > 1.0


def _move(arm):
    return Movement(arm, np.array([0.0, 1.0]), np.array([(0.0, 0.0), GOAL]))


def test_arenas_refuse_branches():
    with pytest.raises(ArenaError, match="'lever': its arm has branches or followers, which"):
        Pool.of([situation_from_json(situation())], CHAIN)
