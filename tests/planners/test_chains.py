"""Answers for chains: every catch passes the referee, and the same question has the same answer."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gcm_learn import solve
from gcm_learn.planners import plan_to_json
from gcm_learn.referee import judge
from gcm_learn.situation import situation_from_json, situation_to_json
from tests.chains import BLOCKED, COUNT, SETS, drawn
from tests.geometry import arm_of, hand_of

PLANNERS = {"marching": 4, "search": 9, "straight": 2, "straight-wait": 3}
"""Planners, and how many of a set they catch at least."""
ASKED = pytest.mark.parametrize(
    "planner",
    [pytest.param(name, marks=pytest.mark.slow if name == "marching" else ()) for name in PLANNERS],
)


def answered(situation, planner):
    """A planner's answer in the exchange format, without what it took."""
    given = situation_from_json(situation)
    answer = json.loads(json.dumps(plan_to_json(solve(given, planner), given)))
    return answer | {"planning_ms": 0.0}


@ASKED
@pytest.mark.parametrize("name", SETS)
def test_the_first_of_a_set(name, planner):
    caught = 0
    for k in range(COUNT):
        situation = drawn(name, k)
        answer = answered(situation, planner)
        caught += answer["status"] == "caught"
        assert judge(situation, answer) == [], situation["name"]
        assert (answer["status"] == "start_blocked") == (k == BLOCKED)
    assert caught >= PLANNERS[planner]


@ASKED
@pytest.mark.parametrize("name", SETS)
def test_the_same_question_has_the_same_answer(name, planner):
    for k in range(3):
        answers = [json.dumps(answered(drawn(name, k), planner)) for _ in range(2)]
        assert answers[0] == answers[1]


def with_another_target(situation):
    """Add a target at rest, where the hand is between the start and the middle of all ranges."""
    arm = arm_of(situation["arm"])
    middle = [sum(joint["range"]) / 2 for joint in situation["arm"]["model"]["joints"]]
    posture = 0.7 * np.array(situation["arm"]["posture"]) + 0.3 * np.array(middle)
    place = hand_of(arm, posture[None])[0][0].tolist()
    none = [0.0, 0.0, 0.0]
    motion = {"kind": "quadratic", "position": place, "velocity": none, "acceleration": none}
    other = {"role": "target", "name": "other", "motion": motion}
    other["shape"] = {"kind": "sphere", "radius": 0.02}
    return situation | {"bodies": [*situation["bodies"], other]}


@pytest.mark.parametrize("catch", ["all", "most"])
@ASKED
def test_targets_are_caught_one_after_the_other(planner, catch):
    both = 0
    for k in range(COUNT):
        situation = with_another_target(drawn("slide", k)) | {"catch": catch}
        answer = answered(situation, planner)
        assert judge(situation, answer) == [], situation["name"]
        both += len(answer["catches"]) == 2
        if catch == "all" and answer["status"] == "unreachable":
            assert answer["catches"] == []
    assert both >= (5 if planner == "search" else 0)


@pytest.mark.parametrize("name", SETS)
def test_what_is_drawn_is_read_and_written_unchanged(name):
    for k in range(COUNT):
        situation = situation_from_json(drawn(name, k))
        assert situation_from_json(situation_to_json(situation)) == situation
        assert drawn(name, k) == drawn(name, k)
