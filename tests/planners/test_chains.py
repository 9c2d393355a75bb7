"""Answers for chains: every catch passes the referee, and the same question has the same answer."""

from __future__ import annotations

import json

import pytest

from gcm_learn import solve
from gcm_learn.planners import plan_to_json
from gcm_learn.situation import situation_from_json, situation_to_json
from tests.chains import BLOCKED, COUNT, SETS, drawn
from tests.referee_of_chains import judge

PLANNERS = {"search": 9, "straight": 2, "straight-wait": 3}
"""Planners, and how many of a set they catch at least."""


def answered(situation, planner):
    """A planner's answer in the exchange format, without what it took."""
    given = situation_from_json(situation)
    answer = json.loads(json.dumps(plan_to_json(solve(given, planner), given)))
    return answer | {"planning_ms": 0.0}


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("name", SETS)
def test_the_first_of_a_set(name, planner):
    caught = 0
    for k in range(COUNT):
        situation = drawn(name, k)
        answer = answered(situation, planner)
        caught += answer["status"] == "caught"
        assert judge(situation, answer).complaints == [], situation["name"]
        assert (answer["status"] == "start_blocked") == (k == BLOCKED)
    assert caught >= PLANNERS[planner]


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("name", SETS)
def test_the_same_question_has_the_same_answer(name, planner):
    for k in range(3):
        answers = [json.dumps(answered(drawn(name, k), planner)) for _ in range(2)]
        assert answers[0] == answers[1]


@pytest.mark.parametrize("planner", PLANNERS)
def test_one_catch_is_not_all(planner):
    """Planners that catch one target keep the promise of "most", and do not make that of "all"."""
    situation = drawn("slide", 0)
    other = situation["bodies"][0] | {"name": "other", "shape": {"kind": "sphere", "radius": 0.01}}
    situation["bodies"].append(other)
    for catch, status in (("most", "caught"), ("all", "unreachable")):
        answer = answered(situation | {"catch": catch}, planner)
        assert answer["status"] == status
        assert judge(situation | {"catch": catch}, answer).complaints == []


@pytest.mark.parametrize("name", SETS)
def test_what_is_drawn_is_read_and_written_unchanged(name):
    for k in range(COUNT):
        situation = situation_from_json(drawn(name, k))
        assert situation_from_json(situation_to_json(situation)) == situation
        assert drawn(name, k) == drawn(name, k)
