"""Holds, stops and limits of jerk: every catch passes the referee."""

from __future__ import annotations

import itertools
import json
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from gcm_learn import solve
from gcm_learn.arms import hands_along
from gcm_learn.families import draw
from gcm_learn.motion.movement import Movement
from gcm_learn.motion.smoothing import half_width, smoothed, start_before
from gcm_learn.planners import Deadline, get_planner, plan_to_json
from gcm_learn.planners.joints import carry
from gcm_learn.planners.outside import broken_promise
from gcm_learn.referee import judge
from gcm_learn.scene import pose
from gcm_learn.situation import situation_from_json, situation_to_json
from tests.chains import drawn


def asked(name, k, jerk=None, hold=(0.1, 0.3), end="rest", **arm):
    """Situation k of a set whose targets have to be held, with limits of acceleration."""
    given = drawn(name, k) | {"format": "gcm-learn/situation@4", "end": end}
    forces = [5.0 * joint["max_speed"] for joint in given["arm"]["model"]["joints"]]
    given["arm"] |= {"max_acceleration": forces} | arm
    if jerk is not None:
        given["arm"]["max_jerk"] = [jerk * force for force in forces]
    for body in given["bodies"]:
        if body["role"] == "target" and hold is not None:
            body["hold"] = dict(zip(("seconds", "relative_speed"), hold, strict=True))
    return given


def answers(rows, least):
    """Solve, and let the referee see every answer."""
    plans = []
    for given in rows:
        plan = solve(situation_from_json(given), "search")
        answer = json.loads(json.dumps(plan_to_json(plan)))
        assert answer["format"] == "gcm-learn/solution@4"
        assert judge(given, answer) == [], given["name"]
        plans += [plan] if plan.caught else []
    assert len(plans) >= least
    return plans


@pytest.mark.parametrize(("name", "least"), [("slide", 2), ("panda", 4)])
@pytest.mark.parametrize("jerk", [None, 100.0])
def test_what_is_held_is_held_and_the_arm_rests(name, least, jerk):
    for plan in answers([asked(name, k, jerk) for k in range(12)], least):
        assert plan.held_until == pytest.approx(plan.catch_time + 0.1)
        assert not plan.trajectory.rates[-1].any() and plan.trajectory.duration > plan.held_until


def test_more_time_finds_earlier_holds():
    """The clock goes on by one when it is read, so that work is counted and not timed."""
    sooner = 0
    for given in (asked("panda", k) for k in range(6)):
        plans = []
        for reads in (4, 40):
            deadline = Deadline(reads, itertools.count(1.0).__next__)
            plans.append(get_planner("search").plan(situation_from_json(given), deadline=deadline))
            assert not plans[-1].caught or judge(given, plan_to_json(plans[-1])) == []
        times = [plan.catch_time if plan.caught else np.inf for plan in plans]
        assert times[1] <= times[0]
        sooner += times[1] < times[0]
    assert sooner >= 2


def test_a_movement_may_end_with_its_hold():
    for plan in answers([asked("panda", k, 50.0, end="free") for k in range(10)], 3):
        assert plan.trajectory.duration == pytest.approx(plan.held_until)


@pytest.mark.parametrize("jerk", [None, 100.0])
def test_a_touch_may_end_at_rest(jerk):
    for plan in answers([asked("panda", k, jerk, None) for k in range(10)], 5):
        assert plan.held_until is None and "held_until" not in plan.catches[0]


def test_a_target_is_hit_as_fast_as_it_moves():
    answers([asked("panda", k, hold=(0.0, 0.05), end="free") for k in range(10)], 4)


def test_the_arm_may_move_at_first():
    rates, forces = [0.1, -0.1, 0.05, 0.1, 0.1, -0.2, 0.1], [0.5, -0.4, 0.3, 0.2, -0.6, 0.4, 0.2]
    start = {"rates": rates, "accelerations": forces}
    plan = answers([asked("panda", k, 40.0, **start) for k in range(10)], 3)[0]
    begun = plan.trajectory.states_at(np.zeros(1))
    np.testing.assert_allclose(begun[1][0], rates)
    np.testing.assert_allclose(begun[2][0], forces, rtol=1e-6)


def test_what_ends_too_late_is_no_answer():
    given = next(g for g in map(lambda k: asked("panda", k), range(12)) if solved(g).caught)
    end = solved(given).trajectory.duration
    assert not solved(given | {"end_by": 0.5 * end}).caught
    assert solved(given | {"end_by": 1.01 * end}).caught


def test_margins_are_kept_and_clearances_are_without_them():
    """The referee judges both; a margin that grows too fast leaves no way."""
    rows = [asked("panda", k, end="free", hold=None) for k in range(12)]
    for given in rows:
        for body in given["bodies"]:
            if body["role"] == "obstacle":
                body["margin"] = {"now": 0.01, "rate": 0.02}
    plan = next(plan for plan in answers(rows, 4) if plan.clearance < 1e9)
    assert plan.clearance > 0.01 + 0.02 * plan.catch_time - 1e-9 or plan.clearance > 0.01
    given = next(given for given in rows if given["name"] == plan.name)
    assert "touched" in str(broken_promise(with_margin(given, 1.01 * plan.clearance), plan))
    assert "with its margin" in solve(with_margin(given, 9.0), "search").message


def spatial(k, place=False):
    """Situation k of a spatial arm whose target has to be held, and placed where the hand was."""
    given = situation_to_json(draw("behind-post-space", 5, k)) | {
        "format": "gcm-learn/situation@4",
        "end": "rest",
    }
    arm = given["arm"]
    arm["max_joint_acceleration"] = [6.0 * speed for speed in arm["max_joint_speed"]]
    (hand,), _ = hands_along(situation_from_json(given).arm, [arm["joints"]])
    for body in given["bodies"]:
        if body["role"] == "target":
            body["hold"] = {"seconds": 0.1, "relative_speed": 0.3}
            body |= {"place": {"position": hand.tolist(), "within": 0.15}} if place else {}
    return given


def placed(k, **more):
    """Situation k whose target is to be carried to where the hand was at first."""
    given = asked("panda", k, **more)
    arm = situation_from_json(given).arm
    (hand,), _ = hands_along(arm, [arm.joints])
    for body in given["bodies"]:
        if body["role"] == "target":
            body["place"] = {"position": hand.tolist(), "within": 0.15}
    return given


@pytest.mark.parametrize("made", [placed, partial(placed, jerk=60.0), partial(spatial, place=True)])
def test_what_is_caught_is_carried_to_its_place(made):
    for plan in answers([made(k) for k in range(12)], 3):
        assert plan.held_until < plan.placed == plan.trajectory.duration


def test_quicker_carries_are_looked_for(monkeypatch):
    rows = [placed(k) for k in range(8)]
    quick = [plan.placed for plan in map(solved, rows)]
    monkeypatch.setattr(carry, "SHORTER", 1e-6)
    first = [plan.placed for plan in map(solved, rows)]
    assert [a is None for a in quick] == [b is None for b in first]
    pairs = [(a, b) for a, b in zip(quick, first, strict=True) if a is not None]
    assert all(a <= b for a, b in pairs) and any(a < b for a, b in pairs)


def test_a_carry_is_judged_like_a_hold():
    given = next(g for g in map(placed, range(12)) if solved(g).caught)
    situation, plan = situation_from_json(given), solved(given)
    assert broken_promise(situation, plan) is None
    says = partial(broken_promise, situation)
    middle = plan.trajectory.time[np.searchsorted(plan.trajectory.time, plan.held_until) + 1]
    assert "while the arm moves" in says(replace(plan, placed=float(middle)))
    assert "no sample" in says(replace(plan, placed=plan.placed - 1e-4))
    assert "placed is given exactly" in says(replace(plan, placed=None))
    target = next(body for body in given["bodies"] if body["role"] == "target")
    target["place"]["within"] = 1e-6
    assert "to its place" in broken_promise(situation_from_json(given), plan)


def test_what_is_too_fast_is_said():
    """The target flies past at 30 times the speed of the joints."""
    given = asked("panda", 1, hold=(0.05, 0.05))
    for body in given["bodies"]:
        if body["role"] == "target":
            at = body["motion"].get("position", [0.5, 0.0, 0.5])
            body["motion"] = {
                "kind": "quadratic", "position": [at[0] - 20.0, *at[1:]],
                "velocity": [40.0, 0.0, 0.0], "acceleration": [0.0, 0.0, 0.0],
            }  # fmt: skip
    given["bodies"] = [body for body in given["bodies"] if body["role"] == "target"]
    assert re.search(r"too fast for joint \d: [\d.]+ of [\d.]+", solved(given).message)


def approached(given, plan, hands):
    """The situation with approaches that a plan keeps, for directions fixed to the hand."""
    situation = situation_from_json(given)
    index = [body.name for body in situation.bodies].index(plan.catch_body)
    _, turn = pose(situation, index, plan.catch_time)
    arm, at = situation.arm, plan.trajectory.joints_at(plan.catch_time)[None]
    asks = []
    for hand in hands:
        model = replace(arm.model, hand=replace(arm.model.hand, axis=hand))
        _, (along,) = hands_along(replace(arm.with_model(model), base=type(arm.base)()), at)
        asks.append({"axis": list(turn.T @ along), "within": 0.3, "hand": list(hand)})
    wanted = {"approach": asks[0] if len(asks) == 1 else asks}
    bodies = [b | (wanted if b["role"] == "target" else {}) for b in given["bodies"]]
    return given | {"bodies": bodies}


@pytest.mark.parametrize("hands", [[(0.6, 0.8, 0.0)], [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]])
@pytest.mark.parametrize("made", [partial(asked, "panda"), spatial])
def test_the_hand_turns_as_approaches_ask(hands, made):
    rows = [(given, solved(given)) for given in map(made, range(8))]
    wanted = [approached(given, plan, hands) for given, plan in rows if plan.caught]
    assert len(wanted) >= 4
    answers(wanted, len(wanted) - 2)


def with_margin(given, now):
    margin = {"margin": {"now": now, "rate": 0.0}}
    bodies = [b | (margin if b["role"] == "obstacle" else {}) for b in given["bodies"]]
    return situation_from_json(given | {"bodies": bodies})


def solved(given):
    return solve(situation_from_json(given), "search")


@pytest.mark.parametrize("planner", ["straight", "marching"])
def test_other_planners_say_that_they_end_with_a_touch(planner):
    plan = get_planner(planner).plan(situation_from_json(asked("panda", 1)))
    assert plan.status == "unreachable" and "ends with a touch" in plan.message


LIES = {
    "held for": lambda plan: replace(plan, held_until=plan.held_until - 1e-3),
    "no sample": lambda plan: replace(
        plan, catch_time=plan.catch_time - 1e-3, held_until=plan.held_until - 1e-3
    ),
    "rest at the end": lambda plan: replace(
        plan, trajectory=plan.trajectory.until(plan.held_until)
    ),
    "held_until": lambda plan: replace(plan, held_until=None),
}


@pytest.mark.parametrize("word", LIES)
def test_no_lie_comes_through(word):
    given = next(g for g in map(lambda k: asked("panda", k), range(12)) if solved(g).caught)
    situation, plan = situation_from_json(given), solved(given)
    assert broken_promise(situation, plan) is None
    assert word in str(broken_promise(situation, LIES[word](plan)))


@pytest.mark.parametrize(
    ("narrow", "word"),
    [
        ({"hold": {"seconds": 0.1, "relative_speed": 1e-3}}, "relative_speed"),
        ({"shape": {"kind": "sphere", "radius": 1e-3}}, "before the end of the hold"),
        ({"approach": {"axis": [0, 0, 1], "within": 1e-3}}, "the approach"),
    ],
)
def test_a_hold_that_is_kept_is_broken_under_narrower_limits(narrow, word):
    said = []
    for given in (asked("panda", k) for k in range(8)):
        plan = solved(given)
        if plan.caught:
            bodies = [b | (narrow if b["role"] == "target" else {}) for b in given["bodies"]]
            arm = given["arm"] | ({"grasp": 0.0} if "shape" in narrow else {})
            situation = situation_from_json(given | {"bodies": bodies, "arm": arm})
            moves = replace(plan.trajectory, arm=situation.arm)
            said.append(str(broken_promise(situation, replace(plan, trajectory=moves))))
    assert any(word in text for text in said)


def test_an_average_keeps_limits_and_digits(rng):
    """Third derivatives are within the limits, and pieces join in their second derivatives."""
    arm = situation_from_json(asked("panda", 1, 50.0)).arm
    force, jerk = np.array(arm.max_joint_acceleration), np.array(arm.max_joint_jerk)
    half = half_width(force, jerk)
    begun = 0.3 * force
    joints, rates = start_before(np.array(arm.joints), np.zeros(7), begun, half)
    time, q, v = [0.0], [joints], [rates]
    for a in [begun, -force, force, *(rng.uniform(-1, 1, (4, 7)) * force), None]:
        span = half * (1.0 + 3.0 * rng.random()) if a is not None else np.abs(v[-1] / force).max()
        a = -v[-1] / span if a is None else a
        time.append(time[-1] + span)
        q.append(q[-1] + span * (v[-1] + 0.5 * span * a))
        v.append(v[-1] + span * a)
    made = smoothed(Movement(arm, *map(np.array, (time, q, v))), begun, half, np.zeros(0))
    t = np.linspace(0.0, made.duration, 4000)
    _, _, forces = made.states_at(t[:-1])
    np.testing.assert_allclose(made.joints[0], arm.joints, atol=1e-15)
    np.testing.assert_allclose(forces[0], begun, rtol=1e-6)
    steps = np.abs(np.diff(forces, axis=0)) / np.diff(t[:-1])[:, None]
    assert (steps <= jerk * (1.0 + 1e-6)).all()
