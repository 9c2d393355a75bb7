"""Plans in the exchange format, and planners by name."""

from __future__ import annotations

import json
import math
from dataclasses import FrozenInstanceError, dataclass, replace

import pytest

import gcm_learn
from gcm_learn import seeding, solve
from gcm_learn.arms import Arm
from gcm_learn.errors import UnknownNameError
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners import Plan, get_planner, plan_to_json, planner_names
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation, read_situations
from tests.extras import INSTALLED, planner_params
from tests.spatial import EXAMPLES

REST = (0.0, 0.0)
GOAL = Body("target", "goal", Disc(0.1), PlanarQuadratic((1.4, -0.9), REST, REST))
POST = Body("obstacle", "post", Disc(0.1), PlanarQuadratic((1.9, 0.0), REST, REST))
ARM = Arm((1.5, 0.8), 3.0)
SCENES = {
    "caught": Situation("a \u00e9 \n", 2.0, ARM, (GOAL, POST)),
    "caught without obstacles": Situation("", 2.0, ARM, (GOAL,)),
    "unreachable": Situation("far", 0.1, ARM, (GOAL, POST)),
    "start_blocked": Situation(
        "blocked", 2.0, replace(ARM, thickness=0.85), (GOAL, replace(POST, name="near"))
    ),
}

KEYS = [
    "format",
    "name",
    "planner",
    "status",
    "catch_time",
    "catch_body",
    "clearance",
    "planning_ms",
    "message",
]


@pytest.mark.parametrize("planner", planner_params())
@pytest.mark.parametrize("case", SCENES)
def test_a_plan_in_json_is_as_the_contract_says(case, planner):
    situation = SCENES[case]
    record = plan_to_json(solve(situation, planner), situation)
    text = json.dumps(record, allow_nan=False)
    assert json.loads(text) == record  # plain types only
    assert record["format"] == "gcm-learn/solution@1"
    assert record["name"] == situation.name and record["planner"] == planner
    assert record["status"] == case.split()[0]
    assert isinstance(record["message"], str) and "\n" not in record["message"]
    assert isinstance(record["planning_ms"], float) and record["planning_ms"] >= 0.0
    if record["status"] != "caught":
        assert set(record) == set(KEYS) and record["message"]
        assert record["catch_time"] is record["catch_body"] is record["clearance"] is None
        return
    assert set(record) == {*KEYS, "trajectory"}
    assert record["catch_body"] == "goal"
    assert isinstance(record["catch_time"], float)
    assert (record["clearance"] is None) == (situation.obstacles == ())
    path = record["trajectory"]
    assert set(path) == {"time", "hand", "joints"}
    n = len(path["time"])
    assert n == len(path["hand"]) == len(path["joints"])
    assert path["time"][0] == 0.0 and path["time"][-1] == record["catch_time"]
    assert path["hand"][0] == list(situation.arm.hand)
    for pair in path["hand"] + path["joints"]:
        assert len(pair) == 2 and all(isinstance(v, float) and math.isfinite(v) for v in pair)


def test_a_spatial_arm_is_answered_in_the_format_of_its_situation():
    """They are of several formats; a plan that does not tell its own cannot be written."""
    old = read_situations(EXAMPLES)[0]
    plan = Plan(old.name, "none", "unreachable", "out of reach", 1.0)
    caught = replace(plan, status="caught", catch_time=0.5, catch_body="ball")
    for situation in (old, replace(old, format="gcm-learn/situation@3")):
        version = situation.format.replace("situation", "solution")
        for one in (plan, caught):
            record = plan_to_json(one, situation)
            assert record["format"] == version
            assert record.get("catches") == (one.catches if version.endswith("@3") else None)
        assert plan_to_json(replace(plan, format=situation.format))["format"] == version
    with pytest.raises(ValueError, match="situation: is needed"):
        plan_to_json(plan)


@pytest.mark.parametrize("horizon", [1e-3, 1.0])
def test_plans_know_the_format_of_their_situation(horizon):
    newer = replace(read_situations(EXAMPLES)[0], format="gcm-learn/situation@3", horizon=horizon)
    for planner in ("straight", "search"):
        assert solve(newer, planner).format == newer.format


def test_keys_come_in_the_order_of_the_contract():
    record = plan_to_json(solve(SCENES["caught"], "straight"), SCENES["caught"])
    assert list(record)[:5] == KEYS[:5] and list(record)[-1] == "trajectory"


def test_clearance_is_that_of_the_plan():
    plan = solve(SCENES["caught"], "straight")
    assert plan_to_json(plan, SCENES["caught"])["clearance"] == plan.clearance > 0.0


def test_an_unknown_planner_is_refused_with_the_known_ones():
    with pytest.raises(UnknownNameError) as error:
        solve(SCENES["caught"], "telepathy")
    message = str(error.value)
    assert "'telepathy'" in message and "\n" not in message
    assert all(name in message for name in planner_names())
    with pytest.raises(UnknownNameError):
        get_planner("")


def test_every_planner_has_the_name_it_is_registered_under():
    assert {"gcm", "marching", "straight"} <= set(planner_names())
    assert planner_names() == sorted(planner_names())
    for name in INSTALLED:
        assert get_planner(name).name == name


def test_the_papers_planner_is_the_default():
    assert solve(SCENES["caught"]).planner == "search"
    assert gcm_learn.solve is solve


@dataclass(frozen=True)
class Lazy:
    """A planner of one's own."""

    name: str = "lazy"

    def plan(self, situation):
        return Plan(situation.name, self.name, "unreachable", "too tired", 0.0)


def test_a_planner_of_ones_own_is_asked():
    plan = solve(SCENES["caught"], Lazy())
    assert (plan.planner, plan.status, plan.message) == ("lazy", "unreachable", "too tired")
    assert not plan.caught


@pytest.mark.parametrize("name", planner_params())
def test_a_planner_object_answers_as_its_name_does(name):
    situation = random_planar(seeding.rng(81, 4))
    by_name, by_object = solve(situation, name), solve(situation, get_planner(name))
    assert by_name.status == by_object.status
    assert by_name.catch_time == by_object.catch_time


def test_plans_are_frozen():
    with pytest.raises(FrozenInstanceError):
        solve(SCENES["caught"], "straight").status = "unreachable"
