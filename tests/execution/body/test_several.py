"""Several catches by arms with mass: which targets are caught, when, and what ends an episode."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import Chain, hands_along
from gcm_learn.cli import main
from gcm_learn.execution import (
    Loop,
    Perception,
    PhysicalPlant,
    Planning,
    body_for,
    execute,
    execute_seen,
    execution_to_json,
    with_motor_limits,
)
from gcm_learn.execution.arena.kernels.world import CAUGHT
from gcm_learn.execution.body.model import STEP
from gcm_learn.planners import get_planner, solve
from gcm_learn.situation import (
    Body,
    Situation,
    SolidQuadratic,
    Sphere,
    shipped_arm,
    write_situations,
)

READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
PANDA = Chain(shipped_arm("panda"), READY, 0.03)
PLANNER = get_planner("search")
FAR = (0.0, 2.0, 0.0)


def ball(name, place, velocity=(0.0, 0.0, 0.0), role="target"):
    motion = SolidQuadratic(tuple(place), velocity, (0.0, 0.0, 0.0))
    return Body(role, name, Sphere(0.02), motion)


def along(*turns):
    """Places of the hand with the first joint turned."""
    postures = np.tile(READY, (len(turns), 1))
    postures[:, 0] = turns
    return hands_along(PANDA, postures)[0].tolist()


def asking(catch, *bodies, horizon=2.5):
    """The Panda among bodies, with limits from its motors."""
    situation = Situation("several", horizon, PANDA, tuple(bodies), catch=catch)
    return with_motor_limits(situation, body_for(PANDA))


@pytest.fixture(scope="module")
def two():
    """Two balls, one of which falls slowly, and a plan for both."""
    first, second = along(0.5, -0.6)
    falling = replace(
        ball("second", second), motion=SolidQuadratic(second, (0, 0, 0.1), (0, 0, -0.1))
    )
    situation = asking("all", ball("first", first), falling)
    plan = solve(situation)
    assert len(plan.catches) == 2
    return situation, plan


def test_all_targets_of_a_plan_are_caught_in_time(two):
    situation, plan = two
    done = execute(plan, situation)
    assert done.status == "caught" and [c.body for c in done.catches] == [
        catch["body"] for catch in plan.catches
    ]
    for seen, wanted in zip(done.catches, plan.catches, strict=True):
        assert seen.time == pytest.approx(wanted["time"], abs=0.01)
    assert (done.catch_body, done.catch_time) == done.catches[-1]
    told = execution_to_json(done)
    assert told["catches"] == [{"body": c.body, "time": c.time} for c in done.catches]


def test_a_caught_target_is_gone_and_the_other_keeps_its_law(two):
    """Nothing pushes the hand that goes through the place of a catch, as without any ball."""
    situation, plan = two
    done = execute(plan, situation)
    first, last = (round(catch.time / STEP) for catch in done.catches)
    names = [body.name for body in situation.bodies]
    j, other = (7 * names.index(catch.body) for catch in done.catches)
    log, laws = done.plant.targets_log, done.plant._laws.targets
    np.testing.assert_array_equal(
        log[: last + 1, other : other + 7], laws[: last + 1, other : other + 7]
    )
    np.testing.assert_array_equal(
        log[first : last + 1, j : j + 7], np.tile(log[first, j : j + 7], (last - first + 1, 1))
    )
    bare = replace(situation, bodies=(ball("far", FAR),), catch="any")
    alone = PhysicalPlant(bare, body_for(PANDA))
    alone.follow(done.plan, done.catch_time)
    np.testing.assert_allclose(
        done.plant.joints_log[: last + 1], alone.joints_log[: last + 1], atol=1e-12
    )


def test_all_is_late_and_most_is_not_where_one_target_is_missed(two):
    situation, plan = two
    moves = plan.trajectory
    until = int(np.searchsorted(moves.time, plan.catches[0]["time"]))
    some = replace(moves, time=moves.time[: until + 1], joints=moves.joints[: until + 1],
                   rates=moves.rates[: until + 1])  # fmt: skip
    for catch, status in (("all", "late"), ("most", "caught")):
        done = execute(replace(plan, trajectory=some), replace(situation, catch=catch))
        assert done.status == status and [c.body for c in done.catches] == [plan.catches[0]["body"]]
        assert (done.catch_time is None) == (status == "late") and done.contact is None


def test_a_plan_for_one_of_most_ends_with_it(two):
    situation, _ = two
    most = replace(situation, catch="most", bodies=(situation.bodies[0], ball("far", FAR)))
    plan = solve(most)
    done = execute(plan, most)
    assert len(plan.catches) == 1 and done.status == "caught"
    assert done.plant.outcome == CAUGHT and done.stays is not None and done.braked is not None


def test_a_touch_between_two_catches_counts(two):
    """The post comes when the first ball is caught; with it alone nothing is touched before."""
    situation, plan = two
    first, last = (catch["time"] for catch in plan.catches)
    middle = 0.5 * (first + last)
    there = plan.trajectory.hand_at(middle) + (0.0, 0.0, -0.05)
    post = ball("post", there + (0.0, 0.0, -2.0 * middle), (0.0, 0.0, 2.0), "obstacle")
    blocked = replace(situation, bodies=(*situation.bodies, post))
    done = execute(plan, blocked)
    assert done.status == "collided" and done.contact.name == "post"
    assert [c.body for c in done.catches] == [plan.catches[0]["body"]]
    assert first < done.contact.time < last and done.catch_time is None


def test_a_plant_begins_anew_with_all_targets(two):
    situation, plan = two
    plant = PhysicalPlant(situation, body_for(PANDA))
    told = []
    for _ in range(2):
        plant.begin()
        plant.follow(plan.trajectory, situation.horizon)
        told.append((plant.outcome, list(plant.catches), plant.joints_log[: plant.steps].copy()))
    assert told[0][:2] == told[1][:2] and told[0][0] == CAUGHT
    np.testing.assert_array_equal(told[0][2], told[1][2])


@pytest.mark.parametrize("kinematic", [True, False])
def test_the_closed_loop_goes_on_after_a_catch(two, kinematic):
    situation, _ = two
    loop = Loop(Perception(), 2, thinking=0.0)
    done = execute_seen(Planning(PLANNER), situation, loop, 0, kinematic=kinematic)
    assert done.status == "caught" and {c.body for c in done.catches} == {"first", "second"}


def test_outcomes_of_kinematic_plants_are_those_of_plans(two):
    situation, plan = two
    done = execute(plan, situation, kinematic=True)
    assert done.status == "caught"
    for seen, wanted in zip(done.catches, plan.catches, strict=True):
        assert seen.body == wanted["body"] and seen.time <= wanted["time"] + 1e-9


def test_execute_says_which_targets_were_caught(two, tmp_path, capsys):
    situation, _ = two
    free = replace(situation, arm=PANDA)
    path, out = tmp_path / "two.jsonl", tmp_path / "out.jsonl"
    write_situations(path, [free, replace(free, name="one", bodies=free.bodies[:1], catch="any")])
    assert main(["execute", str(path), "--out", str(out), "--film", str(tmp_path / "films")]) == 0
    both, one, _ = capsys.readouterr().out.splitlines()
    assert both.startswith("several: caught: 2 of 2 targets, '") and "(planned " in both
    assert one.startswith("one: caught 'first' at ")
    told = [json.loads(line) for line in out.read_text().splitlines()]
    assert [c["body"] for c in told[0]["catches"]][-1] == told[0]["catch_body"]
    assert "catches" not in told[1]
