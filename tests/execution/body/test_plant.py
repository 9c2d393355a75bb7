"""The arm in MuJoCo is the arm of the contract, its dynamics are those of mechanics, and the world
about it keeps its laws until a hand touches it."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gcm_learn.arms import Base, forward_in_space, rotation_of
from gcm_learn.errors import PhysicsError
from gcm_learn.execution import (
    Controller,
    PhysicalPlant,
    body_for,
    execute,
    motor_accelerations,
    read_body,
    with_motor_limits,
)
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED, LATE
from gcm_learn.execution.body.laws import laws
from gcm_learn.execution.body.model import STEP, compiled, model_xml, mujoco
from gcm_learn.execution.body.motors import Dynamics
from gcm_learn.families import paper_scene
from gcm_learn.motion import Movement
from gcm_learn.planners import get_planner
from gcm_learn.scene import pack, pose
from gcm_learn.situation import Body, Capsule, Motor, Pendulum, Situation, SolidQuadratic, Sphere

NAO = paper_scene("fig8-space")
TURNED = (0.5, -0.5, 0.1, np.sqrt(1.0 - 0.51))


def still(place, role="obstacle", radius=0.02, name="ball"):
    """A ball that rests."""
    rest = (0.0, 0.0, 0.0)
    return Body(role, name, Sphere(radius), SolidQuadratic(tuple(place), rest, rest))


def far_target():
    return still((9.0, 9.0, 9.0), "target", name="far")


@pytest.fixture(scope="module")
def swung():
    """The paper's pendulum, planned under the motors' limits, and executed."""
    situation = with_motor_limits(NAO, body_for(NAO.arm))
    plan = get_planner("layered").plan(situation)
    assert plan.caught
    return situation, plan, execute(plan, situation)


@pytest.mark.parametrize("seed", range(4))
def test_hands_and_elbows_are_where_the_contract_has_them(seed):
    rng = np.random.default_rng(seed)
    arm = replace(NAO.arm, base=Base((0.3, 0.2, 0.1), TURNED), upper_arm=(0.1, 0.02, -0.03))
    model = compiled(model_xml(arm, read_body("nao"), [still((1.0, 0.0, 0.0))]))
    data = mujoco().MjData(model)
    joints = rng.uniform(*np.array(arm.joint_range).T)
    data.qpos[:4] = joints
    mujoco().mj_kinematics(model, data)
    elbow, hand = forward_in_space(arm, joints)
    turn, origin = rotation_of(arm.base.rotation), np.array(arm.base.origin)
    assert data.body("forearm").xpos @ turn.T + origin == pytest.approx(elbow, abs=1e-12)
    assert data.geom("hand").xpos @ turn.T + origin == pytest.approx(hand, abs=1e-12)


def test_torques_at_rest_are_the_slope_of_the_weight():
    """By virtual work: torque = derivative of the potential energy, with the base turned."""
    body = read_body("nao")
    arm = replace(NAO.arm, base=Base((0.0, 0.0, 0.0), TURNED))
    joints = np.array([0.4, 0.3, -0.8, -0.9])

    def energy(q):
        total = 0.0
        for k, bone in enumerate(body.bones):
            shaped = {
                "upper_arm": bone.centre if k == 0 else arm.upper_arm,
                "forearm": (1.0, 0.0, 0.0) if k == 0 else bone.centre,
            }
            place = forward_in_space(replace(arm, **shaped), q)[k]
            total -= bone.mass * float(np.dot(body.gravity, place))
        return total

    steps = 1e-6 * np.eye(4)
    slope = [(energy(joints + s) - energy(joints - s)) / 2e-6 for s in steps]
    rest = np.zeros((1, 4))
    found = Dynamics(arm, body).torques(joints[None], rest, rest)[0]
    assert found == pytest.approx(slope, abs=1e-7)
    assert np.abs(slope).max() > 0.1


def test_inverse_dynamics_undo_the_physics():
    """Torques that inverse dynamics asks for give the accelerations that it was asked for."""
    body, wanted = read_body("human"), np.array([3.0, -2.0, 5.0, 4.0])
    arm = paper_scene("fig5-space").arm
    joints, rates = np.array([0.2, 0.5, -0.3, -1.0]), np.array([1.0, -0.5, 2.0, 1.5])
    torque = Dynamics(arm, body).torques(joints[None], rates[None], wanted[None])[0]
    free = replace(arm, joints=tuple(joints), max_joint_acceleration=(99.0,) * 4,
                   joint_rates=tuple(rates))  # fmt: skip
    plant = PhysicalPlant(Situation("free", 1.0, free, (far_target(),)), body)
    plant.push(torque, STEP)
    assert (plant.rates - rates) / STEP == pytest.approx(wanted, rel=0.02)


def test_mass_matrices_are_symmetric_and_positive():
    dynamics = Dynamics(NAO.arm, read_body("nao"))
    matrix = dynamics.inertia(np.array([0.1, 0.9, -1.0, -0.7]))
    assert matrix == pytest.approx(matrix.T, abs=1e-12)
    assert np.linalg.eigvalsh(matrix)[0] > 0.0


def test_motors_can_give_the_limits_that_come_from_them():
    """At nine tenths of postures, so where the arm hangs, and gives way where a motor is weaker."""
    body = read_body("nao")
    most = motor_accelerations(NAO.arm, body)
    joints = np.array(NAO.arm.joints)[None]
    for signs in ((1, 1, 1, 1), (1, -1, 1, -1), (-1, -1, 1, 1)):
        torque = Dynamics(NAO.arm, body).torques(joints, 0.0 * joints, most[None] * signs)[0]
        assert (np.abs(torque) <= [motor.torque for motor in body.joints]).all()
    weak = replace(body, joints=(replace(body.joints[0], torque=0.9), *body.joints[1:]))
    assert (motor_accelerations(NAO.arm, weak) < most).all()


@pytest.mark.parametrize("name", ["nao", "human"])
def test_motors_keep_torque_for_feedback(name):
    """An arm that is a tenth heavier than its plan assumed still accelerates as planned.

    It does at nine tenths of postures and rates, of which others are drawn than limits come from.
    """
    body = read_body(name)
    arm = paper_scene("fig8-space" if name == "nao" else "fig5-space").arm
    most, count = motor_accelerations(arm, body), 400
    heavy = replace(
        body,
        bones=tuple(
            replace(b, mass=1.1 * b.mass, inertia=tuple(1.1 * i for i in b.inertia))
            for b in body.bones
        ),
    )
    rng, top = np.random.default_rng(5), np.array(arm.max_joint_speed)
    joints = rng.uniform(*np.array(arm.joint_range).T, (count, 4))
    rates = rng.uniform(-top, top, (count, 4))
    enough = np.ones(count, dtype=bool)
    for signs in product((1.0, -1.0), repeat=4):
        forces = np.broadcast_to(most * signs, joints.shape)
        torque = Dynamics(arm, heavy).torques(joints, rates, forces)
        enough &= (np.abs(torque) <= [motor.torque for motor in body.joints]).all(axis=1)
    assert enough.mean() > 0.9


def test_a_motor_that_cannot_hold_the_arm_is_named():
    body = read_body("nao")
    weak = replace(body, joints=(Motor(0.05), *body.joints[1:]))
    with pytest.raises(PhysicsError, match=r"joints\[0\]\.torque of 0\.05 N m leaves nothing"):
        motor_accelerations(NAO.arm, weak)


def test_a_body_of_another_arm_is_refused():
    with pytest.raises(PhysicsError, match=r"does not fit: upper_arm: is 0\.1061 m long"):
        PhysicalPlant(NAO, replace(read_body("human"), metres=1.0))
    odd = replace(NAO.arm, forearm=(0.2, 0.0, 0.0))
    with pytest.raises(PhysicsError, match="none that is shipped fits"):
        body_for(odd)


def test_the_paper_s_ball_is_caught_in_physics(swung):
    _situation, plan, done = swung
    assert done.caught
    assert done.catch_body == "ball"
    assert done.catch_time == pytest.approx(plan.catch_time, abs=0.02)
    assert done.error[1] < 0.005
    assert 0.2 < done.torque <= 1.0


def test_what_was_done_is_where_the_hand_was_in_time(swung):
    situation, _plan, done = swung
    moves = done.movement
    assert moves.duration == pytest.approx(done.catch_time)
    ball, _ = pose(situation, 0, done.catch_time)
    room = np.linalg.norm(moves.hand[-1] - ball) - situation.bodies[0].shape.radius
    assert room <= situation.arm.grasp


def test_motors_keep_their_limits(swung):
    plant = swung[2].plant
    used = np.abs(plant.torques_log[: plant.steps])
    assert (used <= np.array([motor.torque for motor in plant.body.joints]) + 1e-12).all()


def test_targets_keep_their_laws_until_they_are_touched(swung):
    situation, _, done = swung
    plant = done.plant
    caught = round(done.catch_time / STEP)
    for k in range(0, caught, 20):
        place, turn = pose(situation, 0, k * STEP)
        assert plant.targets_log[k, :3] == pytest.approx(place, abs=1e-9)
        w, x, y, z = plant.targets_log[k, 3:7]
        assert rotation_of((w, x, y, z)) == pytest.approx(turn, abs=1e-6)


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
    way = SolidQuadratic(tuple(hand + (0.3, 0.0, 0.0)), (-1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    ball = Body("target", "ball", Sphere(0.02), way)
    plant = PhysicalPlant(Situation("hit", 0.5, arm, (ball,)), read_body("nao"))
    rest = Movement(arm, np.zeros(1), np.array([arm.joints]))
    plant.follow(rest, 0.5)
    assert plant.outcome == CAUGHT
    plant.follow(rest, 0.6)
    law = hand[0] + 0.3 - plant.time
    assert plant.targets_log[plant.steps, 0] > law + 0.02
    assert plant.targets_log[plant.steps, 2] < hand[2] - 0.01


def test_pendulums_swing_by_their_own_law():
    swing = next(b for b in NAO.bodies if b.role == "target")
    assert isinstance(swing.motion, Pendulum)
    law = np.array([pose(NAO, 0, t)[0] for t in (0.0, 0.1, 0.3)])
    plant = PhysicalPlant(NAO, read_body("nao"))
    assert plant.targets_log[0, :3] == pytest.approx(law[0])
    assert np.linalg.norm(law[2] - law[0]) > 0.1


def test_a_limb_that_runs_into_something_collides_there_and_then():
    """The arm falls past a ball that is in the way of its forearm."""
    arm = replace(NAO.arm, joints=(0.0, 0.0, 0.0, -0.0349))
    hand = forward_in_space(arm, arm.joints)[1]
    wall = still(hand - (0.03, 0.0, 0.08), name="in the way")
    plant = PhysicalPlant(Situation("fall", 1.0, arm, (far_target(), wall)), read_body("nao"))
    plant.push(np.zeros(4), 1.0)
    assert plant.outcome == COLLIDED
    assert plant.contact.name == "in the way"
    assert 0.03 < plant.contact.time < 0.3
    assert plant.time < 0.4


def test_nothing_is_nothing_and_the_horizon_is_the_end():
    plant = PhysicalPlant(Situation("idle", 0.3, NAO.arm, (far_target(),)), read_body("nao"))
    rest = Movement(NAO.arm, np.zeros(1), np.array([NAO.arm.joints]))
    plant.follow(rest, 2.0)
    assert plant.outcome == LATE
    assert plant.time == pytest.approx(0.3, abs=0.03)
    assert plant.joints == pytest.approx(NAO.arm.joints, abs=2e-3)


def test_plans_are_followed_better_by_computed_torque(swung):
    situation, plan, done = swung
    plain = execute(plan, situation, controller=Controller("gravity"))
    assert 5.0 * done.error[0] < plain.error[0] < 0.05


def test_no_plan_is_told_and_not_followed():
    situation = Situation("far", 1.0, NAO.arm, (far_target(),))
    done = execute(get_planner("straight").plan(situation), situation)
    assert (done.status, done.plant) == ("no plan", None)
    assert done.message


@pytest.mark.parametrize(
    "given", [{"feedforward": "pid"}, {"bandwidth": 0.0}, {"bandwidth": float("nan")}]
)
def test_a_controller_checks_itself(given):
    with pytest.raises(PhysicsError, match=next(iter(given))):
        Controller(**given)


@pytest.mark.parametrize("name", ["fig5-space", "fig8-space"])
@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_motors_do_not_push_joints_beyond_their_speed(name, way):
    """At full torque without gravity joints come near their greatest speed, and not above it.

    Unlimited, the same torques would make them faster; braking torques are not cut.
    """
    arm = paper_scene(name).arm
    body = replace(body_for(arm), gravity=(0.0, 0.0, 0.0))
    top, wide = np.array(arm.max_joint_speed), ((-99.0, 99.0),) * 4
    near = []
    for j in range(4):
        plant = PhysicalPlant(
            Situation("spin", 1.0, replace(arm, joint_range=wide), (far_target(),)), body
        )
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


def test_numbers_that_are_not_finite_are_an_error():
    plant = PhysicalPlant(Situation("nan", 0.3, NAO.arm, (far_target(),)), read_body("nao"))
    with pytest.raises(PhysicsError, match="numbers are not finite"):
        plant.push(np.full(4, np.nan), 0.1)
