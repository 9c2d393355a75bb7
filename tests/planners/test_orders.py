"""Orders in which several targets are caught."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gcm_learn.families import draw
from gcm_learn.planners import TreeSearch, plan_to_json
from gcm_learn.planners.joints.meetings import INSTANTS, soonest
from gcm_learn.planners.orders import ORDERS, SHORT, LegCourse, bounded, distances, with_targets
from gcm_learn.planners.sequences import caught_in_turn, joined
from gcm_learn.referee import judge
from gcm_learn.situation import situation_to_json

LEG = TreeSearch(rounds=100).plan
SPACE = pytest.param(("sequence-space", 9), marks=pytest.mark.slow)


@pytest.fixture(params=[("sequence-chain", 10), SPACE], ids=["chain", "spatial"])
def situations(request):
    """Return situations of several targets."""
    family, seed = request.param
    return [draw(family, seed, k) for k in range(4)]


def never():
    """Never halt."""
    return False


@pytest.mark.parametrize("order", ["found", "distance", "time", "bound"])
def test_courses_get_better_and_their_movement_holds(situations, order):
    caught = 0
    for situation in situations:
        courses = list(ORDERS[order](LEG, LegCourse(situation), never))
        worths = [course.worth for course in courses]
        assert worths == sorted(worths)
        if courses:
            plan = joined(situation, courses[-1].legs, 0.0)
            assert plan.caught and len(plan.on_the_way) + 1 == len(courses[-1].legs)
            assert judge(situation_to_json(situation), plan_to_json(plan, situation)) == []
            names = {name for name, *_ in plan.on_the_way} | {plan.catch_body}
            assert len(names) == len(courses[-1].legs)
            caught += len(names)
    assert caught >= len(situations)


def test_branch_and_bound_catches_at_least_as_many_as_its_first_way_down(situations):
    for situation in situations:
        worths = [course.worth for course in bounded(LEG, LegCourse(situation), never)]
        greedy = list(ORDERS["time"](LEG, LegCourse(situation), never))
        if greedy:
            assert worths[-1][0] >= greedy[-1].worth[0]


def test_an_order_stops_when_time_is_up(situations):
    asked = []

    def leg(situation):
        asked.append(situation)
        return LEG(situation)

    for order in ORDERS.values():
        assert list(order(leg, LegCourse(situations[0]), lambda: True)) == []
    assert asked == []


def test_what_cannot_be_reached_is_met_never_and_a_target_at_hand_at_once(situations):
    situation = situations[0]
    target = situation.targets[0]
    place = tuple(1e3 + x for x in target.motion.position)
    far = replace(target, motion=replace(target.motion, position=place))
    there = soonest(situation)
    assert target.name in there and all(0.0 < t <= situation.horizon for t in there.values())
    others = [far if body is target else body for body in situation.bodies]
    gone = soonest(replace(situation, bodies=tuple(others)))
    assert target.name not in gone
    assert gone == {name: t for name, t in there.items() if name != target.name}
    assert INSTANTS * min(there.values()) >= situation.horizon * (1.0 - 1e-9)


def test_distances_are_those_of_all_targets(situations):
    found = distances(situations[0])
    assert set(found) == {body.name for body in situations[0].targets}
    assert all(value > 0.0 for value in found.values())


def test_targets_caught_at_once_are_told_in_the_order_of_the_bodies(situations):
    situation = situations[0]
    first = LEG(with_targets(situation, {situation.targets[0].name}))
    assert first.caught
    last = situation.targets[0]
    twin = replace(last, name="twin")
    both = replace(situation, bodies=(twin, *situation.bodies))
    for names in (["twin", last.name], [last.name, "twin"]):
        course = LegCourse(both)
        for name in names:
            course = course.with_leg(LEG(with_targets(course.now, {name})))
        plan = joined(both, course.legs, 0.0)
        assert judge(situation_to_json(both), plan_to_json(plan, both)) == []
        assert [plan.on_the_way[0][0], plan.catch_body] == ["twin", last.name]


def test_with_more_time_orders_are_tried_again_with_longer_legs(situations):
    situation, given = situations[0], []

    class Counting:
        anytime = True

        def plan(self, now, deadline=None):
            given.append(deadline)
            return LEG(now)

    plan = caught_in_turn(Counting(), situation, 0.5)
    assert plan.caught and judge(situation_to_json(situation), plan_to_json(plan, situation)) == []
    assert given[0] == SHORT and given == sorted(given) and given[-1] > SHORT


def test_only_courses_better_than_a_known_one_are_told(situations):
    best = list(bounded(LEG, LegCourse(situations[0]), never))[-1]
    assert list(bounded(LEG, LegCourse(situations[0]), never, best)) == []
