"""Covers of held catches: one movement for a cell, which holds, stops and touches nothing in it."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from gcm_learn.cover import CoveredPlanner, broken_of, draws, load_cover, parametric_family
from gcm_learn.cover.families import Parameter
from gcm_learn.cover.held import held_catch, held_doubt
from gcm_learn.errors import FamilyError
from gcm_learn.planners import plan_to_json
from gcm_learn.referee import judge
from gcm_learn.situation import Hold, Place, situation_to_json
from tests.cover.conftest import grown


@pytest.fixture(scope="module")
def held():
    """Return a cover of places along the belt and across it."""
    return grown("held-belt", 2, share=0.9)


def asked_anew(situation, **change):
    """Return a situation that asks something else of its target."""
    return replace(
        situation, bodies=(replace(situation.bodies[0], **change), *situation.bodies[1:])
    )


def test_the_referee_finds_nothing_in_draws(held):
    planner = CoveredPlanner((held,))
    for theta, catch in draws(held, 40, 1):
        situation = held.family.situation(theta)
        plan = planner.plan(situation)
        assert judge(situation_to_json(situation), json.loads(json.dumps(plan_to_json(plan)))) == []
        assert plan.held_until == pytest.approx(plan.catch_time + 0.2, abs=1e-9)
        assert plan.clearance == catch.verdict(held.family, theta).clearance > 0.0
    assert held.share >= 0.9 and broken_of(held, 200, 2) == (0, 200)


def test_corners_keep_every_promise_and_other_cells_do_not(held):
    cells = [cell for cell in held.leaves() if cell.held >= 0]
    for cell, corner in product(cells, product((False, True), repeat=2)):
        catch, theta = held.catches[cell.held], np.where(corner, cell.high, cell.low)
        assert catch.verdict(held.family, theta).good
    ends = [held.family.low, held.family.high]
    assert not all(
        held.catches[c.held].verdict(held.family, end).good for c in cells for end in ends
    )


@pytest.mark.parametrize(
    "change",
    [
        lambda s: asked_anew(s, hold=Hold(0.3, 0.1)),
        lambda s: asked_anew(s, hold=Hold(0.2, 0.09)),
        lambda s: asked_anew(s, approach=(replace(s.bodies[0].approach[0], within=0.4),)),
        lambda s: asked_anew(s, place=Place((0.3, 0.3, 0.3), 0.1)),
        lambda s: replace(s, end="free"),
        lambda s: replace(s, end_by=1.7),
        lambda s: replace(s, arm=replace(s.arm, max_joint_acceleration=(7.0,) * 7)),
    ],
)
def test_who_asks_for_more_is_not_covered(held, change):
    planner, (theta, _) = CoveredPlanner((held,)), next(draws(held, 1, 3))
    situation = held.family.situation(theta)
    assert planner.plan(situation).caught and planner.plan(replace(situation, end_by=2.4)).caught
    assert not planner.plan(change(situation)).caught


def test_neighbours_of_the_box_are_not_covered(held):
    family, planner = held.family, CoveredPlanner((held,))
    for k in range(2):
        outside = family.centre + (family.high - family.centre) * 1.001 * np.eye(2)[k]
        assert not planner.plan(family.situation(outside)).caught


PART, SLOW = "part", Hold(0.2, 0.006)
LARGEST = {
    "grasp": (1.5, (PART, "position", (1.0, 0.0, 0.0)), {}),
    "grasp by speed": (2.0, (PART, "velocity", (0.0, 1.0, 0.0)), {}),
    "relative speed": (1.1, (PART, "velocity", (0.0, 1.0, 0.0)), {"hold": SLOW}),
    "clearance": (2.0, ("carrier", "position", (0.0, -1.0, -1.0)), {}),
    "clearance by speed": (2.0, ("belt", "velocity", (0.0, 0.0, 1.0)), {}),
}


@pytest.mark.parametrize("name", LARGEST)
def test_the_largest_cell_holds_in_its_corners_and_larger_ones_break(name):
    factor, move, change = LARGEST[name]
    whole = parametric_family("held-belt")
    middle = asked_anew(whole.middle, **change)
    family = replace(whole, middle=middle, parameters=(Parameter("", -1.0, 1.0, "", (move,)),))
    catch = held_catch(family, family.centre, np.array([1e-4]))
    low, high = 1e-4, 1.0
    while high - low > 1e-5 * high:
        half = 0.5 * (low + high)
        doubt = held_doubt(family, catch, family.centre, np.array([half]))
        low, high = (half, high) if doubt is None else (low, half)
    reason = held_doubt(family, catch, family.centre, np.array([high])).reason
    corners = [catch.verdict(family, np.array([side * low])).good for side in (-1.0, 1.0)]
    beyond = [catch.verdict(family, np.array([side * factor * low])).good for side in (-1.0, 1.0)]
    assert name.startswith(reason) and all(corners) and not all(beyond)


def test_held_catches_are_stored_as_they_are(held, tmp_path):
    held.save(tmp_path)
    read = CoveredPlanner((load_cover(tmp_path),))
    for theta, catch in draws(held, 5, 4):
        plan = read.plan(held.family.situation(theta))
        assert (plan.catch_time, plan.held_until) == catch.span
        assert np.array_equal(plan.trajectory.rates, catch.rates)


def test_placing_is_refused():
    whole = parametric_family("held-belt").free(1)
    placed = replace(whole, middle=asked_anew(whole.middle, place=Place((0.3, 0.3, 0.3), 0.1)))
    with pytest.raises(FamilyError, match="not placed"):
        held_catch(placed, placed.centre, np.array([1e-3]))


def test_a_limit_of_the_end_counts_where_the_family_has_none():
    whole = parametric_family("held-belt")
    family = replace(whole, middle=replace(whole.middle, end_by=None))
    situation = family.situation(family.centre)
    assert family.parameters_of(situation) is not None
    assert family.parameters_of(replace(situation, end_by=9.0)) is None


def test_names_count_where_obstacles_are_ignored():
    whole = parametric_family("held-belt")
    model = whole.middle.arm.model
    links = (replace(model.links[0], name="foot"), *model.links[1:])
    arm = replace(whole.middle.arm, model=replace(model, links=links), ignore=(("foot", "belt"),))
    family = replace(whole, middle=replace(whole.middle, arm=arm))
    situation = family.situation(family.centre)
    names = {"belt": "good 1", "good 1": "belt"}
    bodies = tuple(replace(b, name=names.get(b.name, b.name)) for b in situation.bodies)
    assert family.parameters_of(situation) is not None
    assert family.parameters_of(replace(situation, bodies=bodies)) is None


def test_families_that_proofs_do_not_speak_of_are_refused():
    whole = parametric_family("held-belt")
    second = replace(whole.middle.bodies[0], name="second")
    both = replace(whole.middle, bodies=(*whole.middle.bodies, second), catch="all")
    with pytest.raises(FamilyError, match="several targets"):
        replace(whole, middle=both)
    faster = Parameter("push", -1.0, 1.0, "m/s2", (("part", "acceleration", (0.0, 1.0, 0.0)),))
    with pytest.raises(FamilyError, match="push"):
        replace(whole, parameters=(faster,))
