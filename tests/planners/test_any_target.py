"""With ``"catch": "any"`` one of several targets is caught, whichever."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest

from gcm_learn import get_planner, solve
from gcm_learn.arms import CHAIN, SPATIAL, kind_of
from gcm_learn.families import draw
from gcm_learn.planners import plan_to_json
from gcm_learn.planners.plan import takes
from gcm_learn.situation import situation_from_json, situation_to_json
from tests.judging import judge

FORMAT = "gcm-learn/situation@3"
QUICK, OTHERS = ("search", "straight", "recall"), ("straight-wait", "marching", "hybrid")
FAMILIES = {CHAIN: "throw-chain", SPATIAL: "falling-space"}
ASKED = list(product(FAMILIES, QUICK))
SLOW = [ASKED.pop(), *product(FAMILIES, OTHERS)]


def with_decoy(family, index):
    """A situation with a second target, far out of reach and first among the bodies."""
    drawn = draw(family, 3, index)
    far = drawn.targets[0]
    place = {"position": (50.0, 0.0, 0.0), "velocity": (0.0,) * 3, "acceleration": (0.0,) * 3}
    decoy = replace(far, name="decoy", motion=replace(far.motion, **place))
    return replace(drawn, bodies=(decoy, *drawn.bodies), format=FORMAT)


@pytest.mark.parametrize(
    ("kind", "planner"),
    [*ASKED, *(pytest.param(*pair, marks=pytest.mark.slow) for pair in SLOW)],
    ids=lambda one: getattr(one, "name", one),
)
def test_planners_catch_whichever_target_they_can(kind, planner):
    assert takes(get_planner(planner), kind)
    caught = 0
    for index in range(2):
        given = with_decoy(FAMILIES[kind], index)
        alone = replace(given, bodies=given.bodies[1:])
        read = situation_from_json(situation_to_json(given))
        assert read == given and kind_of(read) == kind
        plan = solve(read, planner)
        assert plan.caught == solve(alone, planner).caught
        answer = plan_to_json(plan, read)
        assert judge(read, plan) == []
        names = [entry["body"] for entry in answer["catches"]]
        assert names == [alone.targets[0].name] * plan.caught
        caught += plan.caught
    assert caught or planner.startswith("straight")
