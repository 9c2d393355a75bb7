"""A tube is measured on what was done, and a plan in a tube keeps it."""

from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

from gcm_learn.arms import forward_in_space, hands_along
from gcm_learn.execution import (
    Execution,
    body_for,
    execute,
    tube_about,
    with_motor_limits,
)
from gcm_learn.execution.body.model import STEP
from gcm_learn.families import paper_scene
from gcm_learn.planners import InTube, Tube, get_planner
from gcm_learn.scene import pose
from gcm_learn.situation import Hold
from tests.judging import judge
from tests.worlds import among, panda, solid_ball

measured_tube = import_module("experiments.14_body.tubes").measured_tube
NAO = paper_scene("fig8-space")
SEARCH = get_planner("search")


@pytest.fixture(scope="module")
def limited():
    return with_motor_limits(NAO, body_for(NAO.arm))


def test_a_plan_in_a_tube_keeps_its_width_and_meets_deeper(limited):
    tube = Tube(still=0.001, per_speed=0.002)
    bare, roomy = SEARCH.plan(limited), InTube(SEARCH, tube).plan(limited)
    assert bare.caught and roomy.caught
    fastest = np.linalg.norm(np.diff(roomy.trajectory.hand_at(np.arange(0, roomy.catch_time, STEP)),
                                     axis=0), axis=1).max() / STEP  # fmt: skip
    assert roomy.clearance >= min(tube.at(fastest), 0.0009)
    assert bare.clearance < roomy.clearance
    assert judge(limited, roomy) == []
    smaller = replace(limited, arm=replace(limited.arm, grasp=limited.arm.grasp - tube.at(0.0)))
    assert judge(smaller, roomy) == []


def test_no_room_is_no_plan(limited):
    plan = InTube(SEARCH, Tube(still=0.2)).plan(limited)
    assert plan.status == "unreachable"
    assert plan.message


def test_a_plan_of_a_chain_in_a_tube_keeps_its_width():
    """The links keep the width to a ball beside the way, and the hand meets deeper."""
    arm = panda()
    hand = hands_along(arm, arm.joints)[0][0]
    target = solid_ball("ball", hand + (0.0, 0.35, 0.1), role="target")
    between = solid_ball("o", hand + (0.0, 0.19, 0.05))
    situation = with_motor_limits(among(arm, target, between, horizon=2.0), body_for(arm))
    bare = get_planner("search").plan(situation)
    roomy = InTube(get_planner("search"), Tube(still=0.02)).plan(situation)
    assert roomy.caught and bare.clearance < 0.02 <= roomy.clearance
    assert judge(situation, roomy) == []
    width = np.linalg.norm(roomy.trajectory.hand[-1] - target.motion.position) - 0.02
    assert width <= arm.grasp - 0.02 + 1e-6


def test_a_hold_in_a_tube_keeps_deeper_within_the_grasp():
    """All of it, and the situation as it was given is answered."""
    arm = panda(max_joint_acceleration=(15, 7.5, 10, 12.5, 15, 20, 20))
    ball = replace(solid_ball("ball", (0.5, -0.4, 0.3), (0.0, 0.3, 0.0), "target"),
                   hold=Hold(0.2, 0.05))  # fmt: skip
    between = solid_ball("o", (0.42, -0.1, 0.45), radius=0.05)
    situation = among(arm, ball, between, horizon=2.0, end="rest")
    roomy = InTube(SEARCH, Tube(still=0.01)).plan(situation)
    assert roomy.caught and roomy.clearance >= 0.01 and judge(situation, roomy) == []
    times = np.linspace(roomy.catch_time, roomy.held_until, 50)
    places = np.array([pose(situation, 0, t)[0] for t in times])
    away = np.linalg.norm(roomy.trajectory.hand_at(times) - places, axis=1) - 0.02
    assert away.max() <= arm.grasp - 0.01 + 1e-6


def test_a_tube_about_a_plan_is_as_wide_as_its_errors(limited):
    """It has room for the largest, in the arm's unit."""
    body, arm = body_for(NAO.arm), NAO.arm
    bones = tuple(replace(bone, length=None) for bone in body.bones)
    body = replace(body, metres=2.0, bones=bones)
    free = replace(limited, arm=replace(arm, max_joint_acceleration=(10.0, 10.0, 30.0, 20.0)))
    plan = SEARCH.plan(free)
    about, done = tube_about(plan, free, body), execute(plan, free, body)
    assert 0.0 < done.error[1] <= 2.0 * about.still < 4.0 * done.error[1]


def strayed(done, rng):
    """Return an execution whose joints stray from the plan, the more the faster they turn."""
    steps = np.arange(len(done.movement.time))
    wanted = done.plan.joints_at(steps * STEP)
    rates = np.abs(np.gradient(wanted, STEP, axis=0))
    off = rng.normal(size=wanted.shape) * (1e-3 + 1e-3 * rates)
    log = done.plant.joints_log.copy()
    log[steps] = wanted + off
    return replace(done, plant=SimpleNamespace(joints_log=log, body=done.plant.body))


def test_a_tube_covers_errors_that_are_drawn_anew(limited, monkeypatch, rng):
    """At most a few in a hundred are outside, whether the hand is slow or fast."""
    done = execute(SEARCH.plan(limited), limited)
    ended = done.movement
    monkeypatch.setattr(Execution, "movement", property(lambda _: ended))
    measured = measured_tube([strayed(done, rng) for _ in range(60)])
    metres, time = done.plant.body.metres, ended.time
    wanted = done.plan.hand_at(time)
    speed = np.linalg.norm(np.gradient(wanted, STEP, axis=0), axis=1) * metres
    width = measured.still + measured.per_speed * speed
    outside = np.zeros((60, len(time)), dtype=bool)
    for row in outside:
        joints = strayed(done, rng).plant.joints_log[: len(time)]
        elbow, hand = forward_in_space(done.plan.arm, joints)
        at_hand = np.linalg.norm(hand - wanted, axis=1)
        at_elbow = np.linalg.norm(elbow - done.plan.elbow_at(time), axis=1)
        row[:] = np.maximum(at_hand, at_elbow) * metres > width
    for part in np.array_split(np.argsort(speed), 4):
        assert outside[:, part].mean() < 0.03
