"""Plans of spatial arms in physics, and a world that keeps its laws until a hand touches it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gcm_learn import execution
from gcm_learn.arms import forward_in_space, rotation_of
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED, LATE
from gcm_learn.execution.body.laws import laws
from gcm_learn.execution.body.model import STEP
from gcm_learn.families import paper_scene
from gcm_learn.motion import Movement
from gcm_learn.planners import get_planner
from gcm_learn.scene import pack, pose
from gcm_learn.situation import Body, Capsule, Pendulum, Situation, SolidQuadratic
from tests.worlds import among, solid_ball

NAO = paper_scene("fig8-space")


@pytest.fixture(scope="module")
def swung():
    """The paper's pendulum, planned under the motors' limits, and executed."""
    situation = execution.with_motor_limits(NAO, execution.body_for(NAO.arm))
    plan = get_planner("search").plan(situation)
    assert plan.caught
    return situation, plan, execution.execute(plan, situation)


def test_the_paper_s_ball_is_caught_in_physics(swung):
    """The hand is there in time, and motors keep their limits."""
    situation, plan, done = swung
    assert done.caught and done.catch_body == "ball"
    assert done.catch_time == pytest.approx(plan.catch_time, abs=0.02)
    assert done.error[1] < 0.005
    assert 0.2 < done.torque <= 1.0
    assert done.movement.duration == pytest.approx(done.catch_time)
    ball, _ = pose(situation, 0, done.catch_time)
    room = np.linalg.norm(done.movement.hand[-1] - ball) - situation.bodies[0].shape.radius
    assert room <= situation.arm.grasp
    used = np.abs(done.plant.torques_log[: done.plant.steps])
    assert (used <= np.array([motor.torque for motor in done.plant.body.joints]) + 1e-12).all()


def test_targets_keep_their_laws_until_they_are_touched(swung):
    situation, _, done = swung
    assert isinstance(situation.bodies[0].motion, Pendulum)
    for k in range(0, round(done.catch_time / STEP), 20):
        place, turn = pose(situation, 0, k * STEP)
        assert done.plant.targets_log[k, :3] == pytest.approx(place, abs=1e-9)
        found = rotation_of(tuple(done.plant.targets_log[k, 3:7]))
        assert found == pytest.approx(turn, abs=1e-6)


@pytest.mark.parametrize(
    ("spin", "largest"), [((9, 0, 0), {0, 1}), ((0, -9, 0), {0, 2}), ((0, 0, 9), {0, 3})]
)
def test_tumbling_targets_are_turned_and_spin_as_their_laws_say(spin, largest):
    """Over several turns, so that two of a quaternion's numbers are the largest in turn."""
    aside = (0.98, 0.1, -0.1, 0.14)
    tumble = SolidQuadratic((5.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -2.0), aside, spin)
    bar = Body("target", "bar", Capsule(0.02, 0.1), tumble)
    situation, time = Situation("tumbling", 2.0, NAO.arm, (bar,)), np.arange(1001) * STEP
    table = laws(pack(situation), time, 2.0)
    places, turns = (
        np.array(part) for part in zip(*(pose(situation, 0, t) for t in time), strict=True)
    )
    assert table.targets[:, :3] == pytest.approx(2.0 * places, abs=1e-12)
    turned = Rotation.from_quat(table.targets[:, [4, 5, 6, 3]])
    assert turned.as_matrix() == pytest.approx(turns, abs=1e-9)
    assert set(np.abs(table.targets[:, 3:]).argmax(axis=1)) == largest
    then = turned[:-1] * Rotation.from_rotvec(table.moves[:-1, 3:] * STEP)
    assert then.as_matrix() == pytest.approx(turns[1:], abs=1e-9)
    assert table.moves[500, :3] == pytest.approx((0.0, 2.0, -4.0), abs=1e-6)


def test_a_ball_that_is_hit_flies_off_and_falls():
    """After the touch it is free: its way bends away from its law, down."""
    arm = replace(NAO.arm, joints=(0.0, 0.0, 0.0, -0.0349), grasp=0.004, thickness=0.02)
    hand = forward_in_space(arm, arm.joints)[1]
    ball = solid_ball("ball", hand + (0.3, 0.0, 0.0), (-1.0, 0.0, 0.0), "target")
    plant = execution.PhysicalPlant(among(arm, ball, horizon=0.5), execution.read_body("nao"))
    rest = Movement(arm, np.zeros(1), np.array([arm.joints]))
    plant.follow(rest, 0.5)
    assert plant.outcome == CAUGHT
    plant.follow(rest, 0.6)
    law = hand[0] + 0.3 - plant.time
    assert plant.targets_log[plant.steps, 0] > law + 0.02
    assert plant.targets_log[plant.steps, 2] < hand[2] - 0.01


def test_a_limb_that_runs_into_something_collides_there_and_then():
    """The arm falls past a ball that is in the way of its forearm."""
    arm = replace(NAO.arm, joints=(0.0, 0.0, 0.0, -0.0349))
    hand = forward_in_space(arm, arm.joints)[1]
    wall = solid_ball("in the way", hand - (0.03, 0.0, 0.08))
    plant = execution.PhysicalPlant(among(arm, wall), execution.read_body("nao"))
    plant.push(np.zeros(4), 1.0)
    assert plant.outcome == COLLIDED
    assert plant.contact.name == "in the way"
    assert 0.03 < plant.contact.time < 0.3
    assert plant.time < 0.4


def test_nothing_is_nothing_and_the_horizon_is_the_end():
    plant = execution.PhysicalPlant(among(NAO.arm, horizon=0.3), execution.read_body("nao"))
    rest = Movement(NAO.arm, np.zeros(1), np.array([NAO.arm.joints]))
    plant.follow(rest, 2.0)
    assert plant.outcome == LATE
    assert plant.time == pytest.approx(0.3, abs=0.03)
    assert plant.joints == pytest.approx(NAO.arm.joints, abs=2e-3)


def test_plans_are_followed_better_by_computed_torque(swung):
    situation, plan, done = swung
    plain = execution.execute(plan, situation, controller=execution.Controller("gravity"))
    assert 5.0 * done.error[0] < plain.error[0] < 0.05


def test_no_plan_is_told_and_not_followed():
    situation = among(NAO.arm)
    done = execution.execute(get_planner("straight").plan(situation), situation)
    assert (done.status, done.plant) == ("no plan", None)
    assert done.message


@pytest.mark.parametrize("name", ["fig5-space", "fig8-space"])
@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_motors_do_not_push_joints_beyond_their_speed(name, way):
    """At full torque without gravity joints come near their greatest speed, and not above it.

    Unlimited, the same torques would make them faster; braking torques are not cut.
    """
    arm = paper_scene(name).arm
    body = replace(execution.body_for(arm), gravity=(0.0, 0.0, 0.0))
    top, wide = np.array(arm.max_joint_speed), replace(arm, joint_range=((-99.0, 99.0),) * 4)
    near = []
    for j in range(4):
        plant = execution.PhysicalPlant(among(wide), body)
        torque = np.zeros(4)
        torque[j] = way * plant.strongest[j]
        plant.push(torque, 0.5)
        rates = way * plant.rates_log[: plant.steps + 1, j]
        assert (np.diff(rates)[0] > 0.0) and rates.max() <= 1.002 * top[j]
        near.append(rates.max() / top[j])
        free = plant.strongest[j] * 0.5 / plant.motors.inertia[j]
        assert free > 1.5 * top[j]  # what it would come to
        plant.push(-torque, plant.time + STEP)
        assert plant.torques_log[plant.steps - 1, j] == pytest.approx(-torque[j])
    assert min(near) > 0.9
