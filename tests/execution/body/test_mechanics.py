"""Arms in MuJoCo: kinematics of the contract, laws of mechanics, and touches that count."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from gcm_learn import arms, execution
from gcm_learn.execution import PhysicalPlant, motor_accelerations, read_body, with_motor_limits
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED, LATE
from gcm_learn.execution.body.model import STEP, compiled, coupling_of, model_xml, mujoco
from gcm_learn.execution.body.motors import Dynamics
from gcm_learn.families import paper_scene
from gcm_learn.motion import Movement
from gcm_learn.planners import Plan
from gcm_learn.situation import Approach, ChainBody, FrameMass, Motor, arm_from_json
from tests.chains import LEVERS, SLIDE
from tests.worlds import READY, among, panda, solid_ball

TURNED = arms.Base((0.5, -0.2, 0.1), (0.5, -0.5, 0.1, np.sqrt(1.0 - 0.51)))
PANDA, NAO = panda(), paper_scene("fig8-space").arm
CRANE = arms.Chain(arm_from_json(SLIDE), (0.4, 0.25, -0.7), 0.02)
ROD = ((0.02, 0.001, 0.0), (0.001, 0.03, 0.002), (0.0, 0.002, 0.04))
FRAMES = (
    FrameMass(0.0, (0.0, 0.0, 0.0), ((0.0,) * 3,) * 3),
    *(FrameMass(1.0 + k, (0.02 * k, 0.03, -0.01), ROD) for k in range(5)),
)
DOWN = (0.0, 0.0, -9.81)
STRONG = (Motor(40.0, 0.1, 0.5), Motor(90.0, 0.5, 3.0), Motor(20.0, 0.05))
CRANE_BODY = ChainBody(0.5, DOWN, FRAMES[:4], STRONG, "crane")
TREE = arms.Chain(arm_from_json(LEVERS), (0.4, 0.25, -0.7), 0.02)
STRONGER = (
    Motor(60.0, 0.1, 0.5), Motor(300.0, 0.5, 3.0), Motor(0.0, 0.1, 0.1), Motor(40.0, 0.05),
    Motor(0.0),
)  # fmt: skip
TREE_BODY = ChainBody(0.5, DOWN, FRAMES, STRONGER, "levers")
"""MuJoCo's order of its joints is another: the lever is last."""
ARMS = {
    "nao": (NAO, read_body("nao")), "panda": (PANDA, read_body("panda")),
    "crane": (CRANE, CRANE_BODY), "tree": (TREE, TREE_BODY),
}  # fmt: skip
EVERY = pytest.mark.parametrize("name", ARMS)
CHAINS = pytest.mark.parametrize("name", [name for name in ARMS if name != "nao"])


def postures(arm, count, seed=0):
    low, high = np.array(arm.joint_range).T
    return np.random.default_rng(seed).uniform(low, high, (count, len(low)))


@EVERY
def test_links_and_hands_are_where_the_contract_has_them(name):
    """In metres, the base turned, capsules and their ends included."""
    arm, body = ARMS[name]
    arm = replace(arm, base=TURNED)
    model = compiled(model_xml(arm, body, [solid_ball("ball", (1.0, 0.0, 0.0))]))
    data, metric = mujoco().MjData(model), PhysicalPlant(among(arm), body).metric
    coupling = coupling_of(model, arm, body.metres)
    for q in postures(arm, 4):
        coupling.place(data, q * metric, 0.0 * q)
        mujoco().mj_kinematics(model, data)
        ends, hand = arms.links_along(arm, q)[0][0], arms.hands_along(arm, q)[0][0]
        turn, origin = arms.rotation_of(TURNED.rotation), np.array(TURNED.origin)
        there = data.geom("hand").xpos / body.metres
        np.testing.assert_allclose(there @ turn.T + origin, hand, atol=1e-9)
        for i, both in enumerate(ends):
            link = data.geom(f"link{i}")
            half = model.geom(f"link{i}").size[1] * link.xmat.reshape(3, 3)[:, 2]
            found = np.array([link.xpos + half, link.xpos - half])  # MuJoCo's z axis points back
            np.testing.assert_allclose(found / body.metres @ turn.T + origin, both, atol=1e-9)


def centres(arm, body, q):
    """Masses [kg] of an arm and where their centres are, in its own lengths."""
    if arms.kind_of(arm) is arms.SPATIAL:
        upper, fore = body.bones
        yield upper.mass, arms.links_along(replace(arm, upper_arm=upper.centre), q)[0][0, 0, 1]
        yield fore.mass, arms.hands_along(replace(arm, forearm=fore.centre), q)[0][0]
        return
    for k, carried in enumerate(body.frames[1:], 1):
        hand = arms.Hand(k, tuple(np.array(carried.centre) / body.metres))
        moved = replace(arm, model=replace(arm.model, hand=hand))
        yield carried.mass, body.metres * arms.hands_along(moved, q)[0][0]


def height(arm, body, q):
    """Potential energy of the masses at joints (n,) [J]."""
    return -sum(mass * np.dot(body.gravity, place) for mass, place in centres(arm, body, q))


@EVERY
def test_torques_at_rest_are_the_slope_of_the_weight(name):
    """By virtual work, with the base turned; of a prismatic joint newtons, by metres."""
    arm, body = ARMS[name]
    arm, q = replace(arm, base=TURNED), postures(arm, 1, 3)[0]
    metric = PhysicalPlant(among(arm), body).metric
    steps = 1e-6 * np.eye(len(q))
    slope = [(height(arm, body, q + s) - height(arm, body, q - s)) / 2e-6 for s in steps]
    rest = np.zeros((1, len(q)))
    found = Dynamics(arm, body).torques(q[None], rest, rest)[0]
    np.testing.assert_allclose(found, slope / metric, atol=1e-6)
    assert np.abs(slope).max() > 0.1


@EVERY
def test_energy_is_kept_without_motors_and_damping(name):
    arm, body = ARMS[name]
    body = replace(body, joints=tuple(Motor(motor.torque, motor.armature) for motor in body.joints))
    plant = PhysicalPlant(among(replace(arm, base=TURNED)), body)
    plant.push(np.zeros(len(arm.joints)), 0.16)
    dynamics, metric = Dynamics(plant.situation.arm, body), plant.metric
    kinetic, potential = [], []
    for k in range(0, plant.steps + 1, 8):
        rates, matrix = plant.rates_log[k], dynamics.inertia(plant.joints_log[k])
        kinetic.append(0.5 * rates @ matrix @ (metric * rates))
        potential.append(height(plant.situation.arm, body, plant.joints_log[k]))
    total = np.add(kinetic, potential)
    assert kinetic[-1] > 10.0 * np.abs(total - total[0]).max()
    assert np.abs(total - total[0]).max() < 0.02 * kinetic[-1]


def test_inverse_dynamics_undo_the_physics():
    """Torques that inverse dynamics asks for give the accelerations that it was asked for."""
    body, wanted = read_body("human"), np.array([3.0, -2.0, 5.0, 4.0])
    arm = paper_scene("fig5-space").arm
    joints, rates = np.array([0.2, 0.5, -0.3, -1.0]), np.array([1.0, -0.5, 2.0, 1.5])
    torque = Dynamics(arm, body).torques(joints[None], rates[None], wanted[None])[0]
    free = replace(arm, joints=tuple(joints), max_joint_acceleration=(99.0,) * 4,
                   joint_rates=tuple(rates))  # fmt: skip
    plant = PhysicalPlant(among(free), body)
    plant.push(torque, STEP)
    assert (plant.rates - rates) / STEP == pytest.approx(wanted, rel=0.02)


def test_motors_can_give_the_limits_that_come_from_them():
    """At nine tenths of postures, so where the arm hangs, and gives way where a motor is weaker."""
    body = read_body("nao")
    most = motor_accelerations(NAO, body)
    joints = np.array(NAO.joints)[None]
    for signs in ((1, 1, 1, 1), (1, -1, 1, -1), (-1, -1, 1, 1)):
        torque = Dynamics(NAO, body).torques(joints, 0.0 * joints, most[None] * signs)[0]
        assert (np.abs(torque) <= [motor.torque for motor in body.joints]).all()
    weak = replace(body, joints=(replace(body.joints[0], torque=0.9), *body.joints[1:]))
    assert (motor_accelerations(NAO, weak) < most).all()


@pytest.mark.parametrize(("name", "scene"), [("nao", "fig8-space"), ("human", "fig5-space")])
def test_motors_keep_torque_for_feedback(name, scene):
    """An arm that is a tenth heavier than its plan assumed still accelerates as planned.

    It does at nine tenths of postures and rates, of which others are drawn than limits come from.
    """
    body, arm = read_body(name), paper_scene(scene).arm
    most, count = motor_accelerations(arm, body), 400
    heavy = [
        replace(b, mass=1.1 * b.mass, inertia=tuple(1.1 * i for i in b.inertia)) for b in body.bones
    ]
    heavy = replace(body, bones=tuple(heavy))
    rng, top = np.random.default_rng(5), np.array(arm.max_joint_speed)
    joints = rng.uniform(*np.array(arm.joint_range).T, (count, 4))
    rates = rng.uniform(-top, top, (count, 4))
    enough = np.ones(count, dtype=bool)
    for signs in product((1.0, -1.0), repeat=4):
        forces = np.broadcast_to(most * signs, joints.shape)
        torque = Dynamics(arm, heavy).torques(joints, rates, forces)
        enough &= (np.abs(torque) <= [motor.torque for motor in body.joints]).all(axis=1)
    assert enough.mean() > 0.9


def test_motors_hold_a_panda_still_and_without_torque_it_falls():
    held = PhysicalPlant(among(PANDA), read_body("panda"))
    held.follow(RESTING, 1.0)
    assert held.outcome == LATE and np.abs(held.joints - READY).max() < 1e-6
    weak = replace(read_body("panda"), joints=(Motor(0.0, 0.1, 1.0),) * 7)
    fallen = PhysicalPlant(among(PANDA), weak)
    fallen.follow(RESTING, 0.5)
    assert np.abs(fallen.torques_log[: fallen.steps]).max() == 0.0
    assert fallen.hand[2] < held.hand[2] - 0.2


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


@CHAINS
def test_movements_within_the_motors_limits_are_followed(name):
    """To half a millimetre at the hand and half a milliradian at the joints."""
    arm, body = ARMS[name]
    situation = with_motor_limits(among(arm, horizon=0.9), body)
    moves = swing(situation.arm, situation.arm.max_joint_acceleration)
    plant = PhysicalPlant(situation, body)
    plant.follow(moves, 0.9)
    steps = np.arange(plant.steps + 1)
    assert plant.outcome == LATE and np.ptp(plant.joints_log[steps], axis=0).min() > 0.03
    wanted = Movement(arm, steps * STEP, moves.states_at(steps * STEP)[0])
    assert np.abs(plant.joints_log[steps] - wanted.joints).max() < 5e-4
    there = plant.movement_to(plant.steps).hand
    assert np.linalg.norm(there - wanted.hand, axis=1).max() * body.metres < 5e-4
    assert (np.abs(plant.torques_log[: plant.steps]) <= plant.strongest + 1e-12).all()


def test_a_plan_is_executed_and_measured():
    """The tube covers all links; a hand that is led past a target catches it on the way."""
    bare = with_motor_limits(among(PANDA, horizon=0.9), read_body("panda"))
    moves = swing(bare.arm, bare.arm.max_joint_acceleration)
    target = solid_ball("o", moves.hand_at(0.3), role="target", radius=0.01)
    plan = Plan("chain", "by hand", "caught", "", 0.0, 0.3, "o", None, moves)
    done = execution.execute(plan, replace(bare, bodies=(target,)))
    assert done.caught and done.catch_body == "o" and 0.2 < done.catch_time <= 0.3
    assert max(done.error) < 5e-4 and done.torque < 1.0 and done.body == "panda"
    assert 0.0 < execution.tube_about(plan, done.plant.situation, done.plant.body).still < 1e-3


HAND, AXIS = (part[0] for part in arms.hands_along(PANDA, READY))
RESTING = Movement(PANDA, np.zeros(1), np.array([READY]))


@pytest.mark.parametrize(("turn", "outcome"), [(0.4, CAUGHT), (0.6, LATE)])
def test_a_catch_keeps_its_approach(turn, outcome):
    side = np.cross(AXIS, (1.0, 0.0, 0.0))
    axis = tuple(np.cos(turn) * AXIS + np.sin(turn) * side / np.linalg.norm(side))
    target = solid_ball("o", HAND, role="target", radius=0.01, approach=(Approach(axis, 0.5),))
    plant = PhysicalPlant(among(PANDA, target, horizon=0.1), read_body("panda"))
    plant.follow(RESTING, 0.1)
    assert plant.outcome == outcome


@pytest.mark.parametrize(("link", "share"), [(8, 0.2), (0, 0.5), (7, 1.0)])
def test_links_of_the_base_and_of_the_hand_touch_obstacles_unless_they_ignore_them(link, share):
    start, end = arms.links_along(PANDA, READY)[0][0, link]
    ball = solid_ball("ball", start + share * (end - start) - (0.0, 0.4, 0.0), (0.0, 4.0, 0.0))
    for ignore, outcome in (((), COLLIDED), (((link, "ball"),), LATE)):
        arm = replace(PANDA, ignore=ignore)
        plant = PhysicalPlant(among(arm, ball, horizon=0.15), read_body("panda"))
        plant.follow(RESTING, 0.15)
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
    links = (*arm.model.links[:2], replace(arm.model.links[2], end=(0.5, 0.0, 0.0)))
    for pairs, outcome in ((((0, 2),), COLLIDED), ((), LATE)):
        model = replace(arm.model, self_collision=pairs, links=links)
        bare = replace(situation, arm=replace(situation.arm, model=model))
        plant = PhysicalPlant(bare, CRANE_BODY)
        plant.follow(replace(follow, arm=bare.arm), 2.0)
        assert plant.outcome == outcome
        assert outcome == LATE or plant.contact.name == "itself"


def test_the_body_of_a_shipped_arm_fits_arms_with_its_joints():
    """Whatever they are called and however their links are covered."""
    other = replace(PANDA.model, name="another", links=PANDA.model.links[:3], self_collision=())
    assert execution.body_for(replace(PANDA, model=other)) == read_body("panda")
    assert execution.body_for(longer_panda(), "panda") == read_body("panda")


def longer_panda():
    """A Panda whose first joint is higher."""
    joints = (replace(PANDA.model.joints[0], origin=(0.0, 0.0, 0.4)), *PANDA.model.joints[1:])
    return replace(PANDA, model=replace(PANDA.model, joints=joints))
