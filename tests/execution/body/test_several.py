"""Several catches by arms with mass: which targets are caught, when, and what ends an episode."""

import json
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import execution
from gcm_learn.arms import hands_along
from gcm_learn.cli import main
from gcm_learn.execution.arena.kernels.world import CAUGHT
from gcm_learn.execution.body.model import STEP
from gcm_learn.planners import get_planner, solve
from gcm_learn.situation import (
    write_situations,
)
from tests.worlds import READY, among, flight, panda, solid_ball

PLANNER = get_planner("search")


PANDA = panda()


def along(*turns):
    """Places of the hand with the first joint turned."""
    postures = np.tile(READY, (len(turns), 1))
    postures[:, 0] = turns
    return hands_along(PANDA, postures)[0].tolist()


@pytest.fixture(scope="module")
def two():
    """Two balls, one of which falls slowly, and a plan for both."""
    first, second = along(0.5, -0.6)
    falling = solid_ball("second", second, role="target")
    falling = replace(falling, motion=flight(second, (0, 0, 0.1), (0, 0, -0.1)))
    bodies = solid_ball("first", first, role="target"), falling
    situation = among(PANDA, *bodies, horizon=2.5, name="several", catch="all")
    situation = execution.with_motor_limits(situation, execution.body_for(PANDA))
    plan = solve(situation)
    assert len(plan.catches) == 2
    return situation, plan


def test_all_targets_of_a_plan_are_caught_in_time(two):
    situation, plan = two
    done = execution.execute(plan, situation)
    assert done.status == "caught" and [c.body for c in done.catches] == [
        catch["body"] for catch in plan.catches
    ]
    for seen, wanted in zip(done.catches, plan.catches, strict=True):
        assert seen.time == pytest.approx(wanted["time"], abs=0.01)
    assert (done.catch_body, done.catch_time) == done.catches[-1]
    told = execution.execution_to_json(done)
    assert told["catches"] == [{"body": c.body, "time": c.time} for c in done.catches]


FAR = solid_ball("far", (0.0, 2.0, 0.0), role="target")


def test_a_caught_target_is_gone_and_the_other_keeps_its_law(two):
    """Nothing pushes the hand that goes through the place of a catch, as without any ball."""
    situation, plan = two
    done = execution.execute(plan, situation)
    first, last = (round(catch.time / STEP) for catch in done.catches)
    names = [body.name for body in situation.bodies]
    gone, other = (slice(7 * k, 7 * k + 7) for k in (names.index(c.body) for c in done.catches))
    log, laws = done.plant.targets_log[: last + 1], done.plant._laws.targets[: last + 1]
    np.testing.assert_array_equal(log[:, other], laws[:, other])
    after = log[first:, gone]
    np.testing.assert_array_equal(after, np.tile(after[0], (len(after), 1)))
    alone = execution.PhysicalPlant(
        replace(situation, bodies=(FAR,), catch="any"), execution.body_for(PANDA)
    )
    alone.follow(done.plan, done.catch_time)
    mine, its = (plant.joints_log[: last + 1] for plant in (done.plant, alone))
    np.testing.assert_allclose(mine, its, atol=1e-12)


def test_all_is_late_and_most_is_not_where_one_target_is_missed(two):
    situation, plan = two
    moves = plan.trajectory
    until = int(np.searchsorted(moves.time, plan.catches[0]["time"]))
    some = replace(moves, time=moves.time[: until + 1], joints=moves.joints[: until + 1],
                   rates=moves.rates[: until + 1])  # fmt: skip
    for catch, status in (("all", "late"), ("most", "caught")):
        done = execution.execute(replace(plan, trajectory=some), replace(situation, catch=catch))
        assert done.status == status and [c.body for c in done.catches] == [plan.catches[0]["body"]]
        assert (done.catch_time is None) == (status == "late") and done.contact is None


def test_a_plan_for_one_of_most_ends_with_it(two):
    situation, _ = two
    most = replace(situation, catch="most", bodies=(situation.bodies[0], FAR))
    plan = solve(most)
    done = execution.execute(plan, most)
    assert len(plan.catches) == 1 and done.status == "caught"
    assert done.plant.outcome == CAUGHT and done.stays is not None and done.braked is not None


def test_a_touch_between_two_catches_counts(two):
    """The post comes when the first ball is caught; with it alone nothing is touched before."""
    situation, plan = two
    first, last = (catch["time"] for catch in plan.catches)
    middle = 0.5 * (first + last)
    there = plan.trajectory.hand_at(middle) + (0.0, 0.0, -0.05 - 2.0 * middle)
    post = solid_ball("post", there, (0.0, 0.0, 2.0))
    done = execution.execute(plan, replace(situation, bodies=(*situation.bodies, post)))
    assert done.status == "collided" and done.contact.name == "post"
    assert [c.body for c in done.catches] == [plan.catches[0]["body"]]
    assert first < done.contact.time < last and done.catch_time is None


def test_a_plant_begins_anew_with_all_targets(two):
    situation, plan = two
    plant = execution.PhysicalPlant(situation, execution.body_for(PANDA))
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
    loop = execution.Loop(execution.Perception(), 2, thinking=0.0)
    done = execution.execute_seen(
        execution.Planning(PLANNER), situation, loop, 0, kinematic=kinematic
    )
    assert done.status == "caught" and {c.body for c in done.catches} == {"first", "second"}


def test_outcomes_of_kinematic_plants_are_those_of_plans(two):
    situation, plan = two
    done = execution.execute(plan, situation, kinematic=True)
    assert done.status == "caught"
    for seen, wanted in zip(done.catches, plan.catches, strict=True):
        assert seen.body == wanted["body"] and seen.time <= wanted["time"] + 1e-9


@pytest.mark.slow
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
