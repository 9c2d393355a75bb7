"""What "caught" promises, over random situations, before the independent referee."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gcm_learn import seeding, solve
from gcm_learn.families.paper import PAPER_SCENES
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from tests.extras import planner_params
from tests.judging import judge

PLANNERS = planner_params()
# Planners that have to solve the paper's scenes.
MAIN = ["gcm", "layered", "marching"]
# What takes its time gets fewer situations.
LESS = {"layered": 4, "potential": 4, "straight-wait": 4}
LESS |= {"st-rrt-star": 10, "oracle": 20}


def limited(rng):
    """A planar situation whose joints have limits."""
    situation = random_planar(rng, (1, 4))
    limits = tuple(float(v) for v in rng.uniform(2.0, 12.0, 2))
    return replace(situation, arm=replace(situation.arm, max_joint_speed=limits))


def slippery(rng):
    """A planar or 3D situation whose hand has to touch the target itself."""
    situation = (random_planar if rng.random() < 0.5 else random_solid)(rng)
    return replace(situation, arm=replace(situation.arm, grasp=0.0))


FAMILIES = {
    "planar": random_planar,
    "solid": random_solid,
    "limited": limited,
    "slippery": slippery,
}
COUNT = {"planar": 40, "solid": 16, "limited": 10, "slippery": 16}
# Limits compile code of their own for these two, and the slow tests ask them.
ASKED = [
    pytest.param(family, *planner.values, marks=planner.marks)
    for family in FAMILIES
    for planner in PLANNERS
    if family != "limited" or planner.values[0] not in ("oracle", "layered")
]


def broken(family, planner, seed, seeds):
    """Complaints by index over a range of random situations, and the number of catches."""
    complaints, caught = {}, 0
    for k in seeds:
        situation = FAMILIES[family](seeding.rng(seed, k))
        plan = solve(situation, planner)
        assert plan.status in ("caught", "unreachable", "start_blocked")
        if plan.status == "caught":
            caught += 1
            found = judge(situation, plan)
            if found:
                complaints[k] = found
    return complaints, caught


@pytest.mark.parametrize(("family", "planner"), ASKED)
def test_every_catch_keeps_the_promise(family, planner):
    count = COUNT[family]
    count = max(count // LESS.get(planner, 1), 10)
    complaints, caught = broken(family, planner, 61, range(count))
    assert complaints == {}
    assert caught > count / 8  # else nothing has been tested


@pytest.mark.slow
@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("part", range(20))
def test_every_catch_of_20_000_planar_situations_keeps_the_promise(part, planner):
    count = 1000 // LESS.get(planner, 1)
    complaints, caught = broken("planar", planner, 62, range(1000 * part, 1000 * part + count))
    assert complaints == {}
    assert caught > 0.3 * count


@pytest.mark.slow
@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("family", ["solid", "limited", "slippery"])
def test_every_catch_of_2_000_other_situations_keeps_the_promise(family, planner):
    count = 2000 // LESS.get(planner, 1)
    complaints, caught = broken(family, planner, 63, range(count))
    assert complaints == {}
    assert caught > count / 8


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("name", PAPER_SCENES)
def test_the_papers_scenes_keep_the_promise(name, planner):
    situation = PAPER_SCENES[name]()
    plan = solve(situation, planner)
    assert plan.status == "caught" or planner not in MAIN
    if plan.status == "caught":
        assert judge(situation, plan) == []
