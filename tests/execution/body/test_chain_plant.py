"""Chains in MuJoCo: kinematics of the arm file, laws of mechanics, and touches that count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import Base, Chain, Hand, hands_along, links_along, rotation_of
from gcm_learn.errors import BodyError, PhysicsError
from gcm_learn.execution import (
    PhysicalPlant,
    body_for,
    execute,
    measured_tube,
    motor_accelerations,
    read_body,
    with_motor_limits,
)
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED, LATE
from gcm_learn.execution.body.model import STEP, compiled, coupling_of, model_xml, mujoco
from gcm_learn.execution.body.motors import Dynamics
from gcm_learn.motion import Movement
from gcm_learn.planners import Plan
from gcm_learn.situation import (
    Approach,
    Body,
    ChainBody,
    FrameMass,
    Motor,
    Situation,
    SolidQuadratic,
    Sphere,
    arm_from_json,
    shipped_arm,
)
from tests.chains import LEVERS, SLIDE

TURNED = Base((0.5, -0.2, 0.1), (0.5, -0.5, 0.1, np.sqrt(1.0 - 0.51)))
READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
PANDA = Chain(shipped_arm("panda"), READY, 0.03)
CRANE = Chain(arm_from_json(SLIDE), (0.4, 0.25, -0.7), 0.02)
ROD = ((0.02, 0.001, 0.0), (0.001, 0.03, 0.002), (0.0, 0.002, 0.04))
CRANE_BODY = ChainBody(
    0.5, (0.0, 0.0, -9.81), (FrameMass(0.0, (0.0, 0.0, 0.0), ((0.0,) * 3,) * 3),)
    + tuple(FrameMass(1.0 + k, (0.02 * k, 0.03, -0.01), ROD) for k in range(3)),
    (Motor(40.0, 0.1, 0.5), Motor(90.0, 0.5, 3.0), Motor(20.0, 0.05)), "crane",
)  # fmt: skip
TREE = Chain(arm_from_json(LEVERS), (0.4, 0.25, -0.7), 0.02)
TREE_BODY = ChainBody(
    0.5, (0.0, 0.0, -9.81), (FrameMass(0.0, (0.0, 0.0, 0.0), ((0.0,) * 3,) * 3),)
    + tuple(FrameMass(1.0 + k, (0.02 * k, 0.03, -0.01), ROD) for k in range(5)),
    (Motor(60.0, 0.1, 0.5), Motor(300.0, 0.5, 3.0), Motor(0.0, 0.1, 0.1), Motor(40.0, 0.05),
     Motor(0.0)), "levers",
)  # fmt: skip
"""MuJoCo's order of its joints is another: the lever is last."""
ARMS = {
    "panda": (PANDA, read_body("panda")), "crane": (CRANE, CRANE_BODY), "tree": (TREE, TREE_BODY),
}  # fmt: skip


def still(place, role="obstacle", radius=0.02, name="ball", **more):
    """A ball that rests."""
    rest = (0.0, 0.0, 0.0)
    return Body(role, name, Sphere(radius), SolidQuadratic(tuple(place), rest, rest), **more)


def among(arm, *bodies, horizon=1.0):
    """The arm among bodies; its target is far away unless one is given."""
    far = (
        () if any(b.role == "target" for b in bodies) else (still((9.0,) * 3, "target", 0.1, "o"),)
    )
    return Situation("chain", horizon, arm, (*far, *bodies), format="gcm-learn/situation@3")


def postures(arm, count, seed=0):
    return np.random.default_rng(seed).uniform(*np.array(arm.joint_range).T, (count, arm.dof))


@pytest.mark.parametrize("name", ARMS)
def test_links_and_hands_are_where_the_contract_has_them(name):
    """In metres, the base turned, capsules and their ends included."""
    arm, body = ARMS[name]
    arm = replace(arm, base=TURNED)
    model = compiled(model_xml(arm, body, [still((1.0, 0.0, 0.0))]))
    data, metric = mujoco().MjData(model), PhysicalPlant(among(arm), body).metric
    coupling = coupling_of(model, arm, body.metres)
    for q in postures(arm, 4):
        coupling.place(data, q * metric, 0.0 * q)
        mujoco().mj_kinematics(model, data)
        ends, hand = links_along(arm, q)[0][0], hands_along(arm, q)[0][0]
        turn, origin = rotation_of(TURNED.rotation), np.array(TURNED.origin)
        there = data.geom("hand").xpos / body.metres
        np.testing.assert_allclose(there @ turn.T + origin, hand, atol=1e-9)
        for i, both in enumerate(ends):
            link = data.geom(f"link{i}")
            half = model.geom(f"link{i}").size[1] * link.xmat.reshape(3, 3)[:, 2]
            found = np.array([link.xpos + half, link.xpos - half])  # MuJoCo's z axis points back
            np.testing.assert_allclose(found / body.metres @ turn.T + origin, both, atol=1e-9)


def height(arm, body, q):
    """Potential energy of the masses at joints (n,) [J]."""
    total = 0.0
    for k, carried in enumerate(body.frames[1:], 1):
        hand = Hand(k, tuple(np.array(carried.centre) / body.metres))
        place = hands_along(replace(arm, model=replace(arm.model, hand=hand)), q)[0][0]
        total -= carried.mass * body.metres * float(np.dot(body.gravity, place))
    return total


@pytest.mark.parametrize("name", ARMS)
def test_torques_at_rest_are_the_slope_of_the_weight(name):
    """By virtual work, with the base turned; of a prismatic joint newtons, by metres."""
    arm, body = ARMS[name]
    arm, q, rest = replace(arm, base=TURNED), postures(arm, 1, 3)[0], np.zeros((1, arm.dof))
    metric = PhysicalPlant(among(arm), body).metric
    steps = 1e-6 * np.eye(arm.dof)
    slope = [(height(arm, body, q + s) - height(arm, body, q - s)) / 2e-6 for s in steps]
    found = Dynamics(arm, body).torques(q[None], rest, rest)[0]
    np.testing.assert_allclose(found, slope / metric, atol=1e-6)
    assert np.abs(slope).max() > 1.0


@pytest.mark.parametrize("name", ARMS)
def test_energy_is_kept_without_motors_and_damping(name):
    arm, body = ARMS[name]
    body = replace(body, joints=tuple(Motor(0.0, motor.armature) for motor in body.joints))
    plant = PhysicalPlant(among(replace(arm, base=TURNED)), body)
    plant.push(np.zeros(arm.dof), 0.16)
    dynamics, metric = Dynamics(plant.situation.arm, body), plant.metric
    kinetic, potential = [], []
    for k in range(0, plant.steps + 1, 8):
        rates, matrix = plant.rates_log[k], dynamics.inertia(plant.joints_log[k])
        kinetic.append(0.5 * rates @ matrix @ (metric * rates))
        potential.append(height(plant.situation.arm, body, plant.joints_log[k]))
    assert kinetic[-1] > 0.5
    total = np.add(kinetic, potential)
    assert np.abs(total - total[0]).max() < 0.02 * kinetic[-1]


def test_motors_hold_a_panda_still_and_without_torque_it_falls():
    rest = Movement(PANDA, np.zeros(1), np.array([READY]))
    held = PhysicalPlant(among(PANDA), read_body("panda"))
    held.follow(rest, 1.0)
    assert held.outcome == LATE and np.abs(held.joints - READY).max() < 1e-6
    weak = replace(read_body("panda"), joints=(Motor(0.0, 0.1, 1.0),) * 7)
    fallen = PhysicalPlant(among(PANDA), weak)
    fallen.follow(rest, 0.5)
    assert np.abs(fallen.torques_log[: fallen.steps]).max() == 0.0
    assert fallen.hand[2] < held.hand[2] - 0.2
    with pytest.raises(PhysicsError, match=r"joints\[0\]\.torque of 0 N m leaves nothing"):
        motor_accelerations(PANDA, weak)


def swing(arm, limits, share=0.9):
    """A movement to and fro within limits of acceleration, all joints at once."""
    low, high = np.array(arm.joint_range).T
    start = np.array(arm.joints)
    way = np.where(high - start > start - low, 1.0, -1.0)
    force, span = share * np.array(limits) * way, 0.25
    fastest = np.minimum(np.abs(force) * span, 0.9 * np.array(arm.max_joint_speed)) * way
    times, signs = span * np.arange(5), np.array([0, 1, 0, -1, 0])
    rates = signs[:, None] * fastest
    steps = 0.5 * span * (rates[1:] + rates[:-1])
    return Movement(arm, times, start + np.vstack([0.0 * start, np.cumsum(steps, axis=0)]), rates)


@pytest.mark.parametrize(("name", "error"), [("panda", 5e-4), ("crane", 5e-4), ("tree", 5e-4)])
def test_movements_within_the_motors_limits_are_followed(name, error):
    """To half a millimetre at the hand and half a milliradian at the joints."""
    arm, body = ARMS[name]
    situation = with_motor_limits(among(arm, horizon=0.9), body)
    moves = swing(situation.arm, situation.arm.max_joint_acceleration)
    plant = PhysicalPlant(situation, body)
    plant.follow(moves, 0.9)
    steps = np.arange(plant.steps + 1)
    assert plant.outcome == LATE and np.ptp(plant.joints_log[steps], axis=0).min() > 0.03
    wanted = Movement(arm, steps * STEP, moves.states_at(steps * STEP)[0])
    off = np.abs(plant.joints_log[steps] - wanted.joints)
    there = plant.movement_to(plant.steps).hand
    assert off.max() < error
    assert np.linalg.norm(there - wanted.hand, axis=1).max() * body.metres < error
    assert (np.abs(plant.torques_log[: plant.steps]) <= plant.strongest + 1e-12).all()


def test_a_plan_is_executed_and_measured():
    """The tube covers all links; a hand that is led past a target catches it on the way."""
    body = read_body("panda")
    bare = with_motor_limits(among(PANDA, horizon=0.9), body)
    moves = swing(bare.arm, bare.arm.max_joint_acceleration)
    target = still(moves.hand_at(0.3), "target", 0.01, "o")
    situation = replace(bare, bodies=(target,))
    plan = Plan("chain", "by hand", "caught", "", 0.0, 0.3, "o", None, moves)
    done = execute(plan, situation)
    assert done.caught and done.catch_body == "o" and 0.2 < done.catch_time <= 0.3
    assert max(done.error) < 5e-4 and done.torque < 1.0 and done.body == "panda"
    tube = measured_tube([done])
    assert 0.0 < tube.still + tube.per_speed < 1e-3


HAND, AXIS = (part[0] for part in hands_along(PANDA, READY))
REST = Movement(PANDA, np.zeros(1), np.array([READY]))


@pytest.mark.parametrize(("turn", "outcome"), [(0.4, CAUGHT), (0.6, LATE)])
def test_a_catch_keeps_its_approach(turn, outcome):
    side = np.cross(AXIS, (1.0, 0.0, 0.0))
    axis = tuple(np.cos(turn) * AXIS + np.sin(turn) * side / np.linalg.norm(side))
    target = still(HAND, "target", 0.01, "o", approach=Approach(axis, 0.5))
    plant = PhysicalPlant(among(PANDA, target, horizon=0.1), read_body("panda"))
    plant.follow(REST, 0.1)
    assert plant.outcome == outcome


def thrown(place, velocity, name="ball"):
    """A ball that flies, and a link that it meets soon."""
    moves = SolidQuadratic(
        tuple(np.subtract(place, 0.1 * np.array(velocity))), velocity, (0.0,) * 3
    )
    return Body("obstacle", name, Sphere(0.02), moves)


@pytest.mark.parametrize(("link", "share"), [(8, 0.2), (0, 0.5), (7, 1.0)])
def test_links_of_the_base_and_of_the_hand_touch_obstacles_unless_they_ignore_them(link, share):
    start, end = links_along(PANDA, READY)[0][0, link]
    ball = thrown(start + share * (end - start), (0.0, 4.0, 0.0))
    for ignore, outcome in (((), COLLIDED), (((link, "ball"),), LATE)):
        arm = replace(PANDA, ignore=ignore)
        plant = PhysicalPlant(among(arm, ball, horizon=0.15), read_body("panda"))
        plant.follow(REST, 0.15)
        assert plant.outcome == outcome
        if outcome == COLLIDED:
            radius = PANDA.model.links[link].radius
            assert plant.contact.name == "ball"
            assert plant.contact.time == pytest.approx(0.1 - (radius + 0.02) / 4.0, abs=0.006)


def test_links_that_must_not_overlap_collide():
    """The crane turns its arm back until it meets its own column."""
    arm = replace(CRANE, joints=(0.0, 0.05, 0.0))
    situation = with_motor_limits(among(arm, horizon=2.0), CRANE_BODY)
    times, q = np.array([0.0, 2.0]), np.array([arm.joints, (0.0, 0.05, -1.5)])
    follow = Movement(situation.arm, times, q)
    longer = replace(arm.model.links[2], end=(0.5, 0.0, 0.0))
    for pairs, outcome in ((((0, 2),), COLLIDED), ((), LATE)):
        links = (*arm.model.links[:2], longer)
        model = replace(arm.model, self_collision=pairs, links=links)
        bare = replace(situation, arm=replace(situation.arm, model=model))
        plant = PhysicalPlant(bare, CRANE_BODY)
        plant.follow(replace(follow, arm=bare.arm), 2.0)
        assert plant.outcome == outcome
        assert outcome == LATE or plant.contact.name == "itself"


def test_the_body_of_a_shipped_arm_fits_arms_with_its_joints():
    """Whatever they are called and however their links are covered."""
    other = replace(PANDA.model, name="another", links=PANDA.model.links[:3], self_collision=())
    assert body_for(replace(PANDA, model=other)) == read_body("panda")
    joints = (replace(PANDA.model.joints[0], origin=(0.0, 0.0, 0.4)), *PANDA.model.joints[1:])
    longer = replace(PANDA, model=replace(PANDA.model, joints=joints))
    with pytest.raises(BodyError, match="panda: joints: differ from the shipped arm's") as told:
        body_for(longer)
    assert "\n" not in str(told.value)
    assert body_for(longer, "panda") == read_body("panda")
    with pytest.raises(BodyError, match=r"crane.*: does not fit: joints: the arm has 7"):
        body_for(PANDA, CRANE_BODY)
    strong = replace(TREE_BODY, joints=(*TREE_BODY.joints[:4], Motor(1.0)))
    with pytest.raises(BodyError, match=r"joints\[4\]\.torque: must be 0, as the joint follows"):
        body_for(TREE, strong)
    with pytest.raises(BodyError, match=r"body nao: does not fit: is of format .*@1, and"):
        body_for(PANDA, "nao")
