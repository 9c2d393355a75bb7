"""The kinematic arm: it is on its trajectory, and events are found in time."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.arms import Arm, Base, SpatialArm
from gcm_learn.execution import CAUGHT, COLLIDED, LATE, RUNNING, ExactPlant
from gcm_learn.execution.loop import hand_leading, joint_leading
from gcm_learn.execution.loop.joint_leading import at_first, begun, led, rest_of
from gcm_learn.execution.loop.kinds import LEADS
from gcm_learn.motion import Movement
from gcm_learn.planners import get_planner
from gcm_learn.scene import pose
from tests.worlds import REST, among, disc, solid_ball

ARM = SpatialArm(
    upper_arm=(1.0, 0.0, 0.0), forearm=(1.0, 0.0, 0.0), joints=(0.0, 0.0, 0.0, 0.0),
    joint_range=((-2.0, 2.0),) * 4, max_joint_speed=(8.0,) * 4, grasp=0.05, thickness=0.1,
    max_joint_acceleration=(40.0,) * 4,
)  # fmt: skip


def swing(rate=2.0, until=0.5):
    """Return a movement of the second joint, from rest, about z: a cubic."""
    time = np.array([0.0, until])
    joints = np.array([[0.0] * 4, [0.0, 0.5 * rate * until, 0.0, 0.0]])
    return Movement(ARM, time, joints, np.array([[0.0] * 4, [0.0, rate, 0.0, 0.0]]))


def test_it_is_where_the_trajectory_is():
    """In steps of any length, before, on and after the samples."""
    plan = begun(ARM, swing(), 0.13)
    plant = ExactPlant(among(ARM))
    for until in (0.1, 0.13, 0.2, 0.33, 0.63, 0.65, 0.9):
        plant.follow(plan, until)
        joints, rates, _ = plan.states_at(np.array([until]))
        assert plant.time == until and plant.outcome == RUNNING
        assert np.allclose(plant.arm.joints, joints[0])
        assert np.allclose(plant.arm.joint_rates, rates[0])
    assert plan.states_at(np.array([0.9]))[0][0, 1] == pytest.approx(0.5 + 2.0**2 / 80.0)


def test_who_jumps_is_refused():
    plant = ExactPlant(among(ARM))
    plant.follow(begun(ARM, swing(), 0.0), 0.2)
    with pytest.raises(ValueError, match=r"trajectory: is 0.* away from the arm at 0.2 s"):
        plant.follow(at_first(ARM), 0.3)


def test_a_moving_arm_touches_when_it_does():
    """Against a bisection over a fine grid of the limb's distances."""
    post = ball("post", (1.2, 0.75, 0.0))
    plan = begun(ARM, swing(4.0), 0.0)
    fine = np.linspace(0.0, 0.5, 20001)
    elbow, hand = (plan.elbow_at(fine), plan.hand_at(fine))
    place = np.array(post.motion.position)
    along = hand / np.linalg.norm(hand, axis=1)[:, None]  # both bones lie in line
    s = np.clip(along @ place, 0.0, 2.0)
    away = np.linalg.norm(place - s[:, None] * along, axis=1) - 0.2 - 0.1
    assert np.allclose(elbow * 2.0, hand)
    first = fine[np.flatnonzero(away <= 0.0)[0]]
    plant = ExactPlant(among(ARM, post))
    plant.follow(plan, 1.0)
    assert plant.outcome == COLLIDED and plant.time == pytest.approx(first, abs=1e-4)
    assert 0.05 < first < 0.45


def test_a_hand_that_moves_meets_on_a_curve():
    """It passes a target in the middle of one cubic piece, which ends elsewhere."""
    plan = begun(ARM, swing(4.0), 0.0)
    place = plan.hand_at(0.3)
    target = ball("target", tuple(place.tolist()), role="target", radius=0.02)
    plant = ExactPlant(among(ARM, target))
    plant.follow(plan, 1.0)
    fine = np.linspace(0.0, 0.3, 30001)
    away = np.linalg.norm(plan.hand_at(fine) - place, axis=1) - 0.02 - 0.05
    assert plant.outcome == CAUGHT
    assert plant.catch_time == pytest.approx(fine[np.flatnonzero(away <= 0.0)[0]], abs=1e-3)


def families_of_plans():
    """Yield planar families, and spatial ones with and without limits of acceleration."""
    yield from ("falling", "gate", "pendulum", "spinning-solid")
    for name in ("falling-space", "crate-space", "pendulum-space"):
        family = families.get_family(name)
        yield name
        yield replace(family, arm=replace(family.arm, ramp=(0.1, 0.1)))


@pytest.mark.parametrize("family", list(families_of_plans()), ids=str)
def test_what_is_planned_happens(family):
    """A verified catch is caught at its time or before; however long the steps are."""
    seen = 0
    for k in range(4):
        situation = families.draw(family, 1400, k)
        plan = get_planner("search").plan(situation)
        if not plan.caught:
            continue
        seen, begin = seen + 1, LEADS.of(situation).begun
        for step in (situation.horizon, 0.02):
            plant = ExactPlant(situation)
            while plant.outcome == RUNNING:
                plant.follow(begin(situation.arm, plan.trajectory, 0.0), plant.time + step)
            assert plant.outcome == CAUGHT
            assert plant.catch_time <= plan.catch_time + 1e-9
    assert seen > 0


def test_what_is_left_is_the_same_movement():
    plan = begun(ARM, swing(), 0.2)
    left = rest_of(plan, 0.45)
    times = np.linspace(0.0, 0.5, 40)
    for one, other in zip(left.states_at(times), plan.states_at(times + 0.45), strict=True):
        assert np.allclose(one[1:], other[1:], atol=1e-8)
    arm = led(ARM, plan, 0.45)
    assert np.allclose(arm.joints, left.joints[0]) and np.allclose(arm.joint_rates, left.rates[0])
    assert rest_of(plan, 2.0).time.size == 1


def test_an_arm_without_limits_stops_at_once():
    """Its trajectories are linear, and after the end it rests."""
    arm = replace(ARM, max_joint_acceleration=None, joint_rates=None)
    linear = Movement(arm, np.array([0.0, 0.5]), np.array([[0.0] * 4, [0.0, 1.0, 0.0, 0.0]]))
    plan, plant = begun(arm, linear, 0.1), ExactPlant(among(arm))
    for until, angle in ((0.1, 0.0), (0.2, 0.2), (0.6, 1.0), (0.9, 1.0)):
        plant.follow(plan, until)
        assert plant.arm.joints[1] == pytest.approx(angle)
        assert led(arm, plan, until).joint_rates is None


def test_an_arm_that_moves_at_first_comes_to_rest():
    arm = replace(ARM, joint_rates=(0.0, 4.0, 0.0, -2.0))
    plant = ExactPlant(among(arm))
    plant.follow(at_first(arm), 0.5)
    assert not any(plant.arm.joint_rates)
    assert np.allclose(plant.arm.joints, [0.0, 0.2, 0.0, -0.05])


def test_the_place_of_bodies_is_that_of_the_scene():
    """The world of a plant is the situation's own: a turned base changes nothing."""
    turned = replace(ARM, base=Base((1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0)))
    target = ball("target", (-1.0, 2.0, 3.0 + 0.35), (0.0, 0.0, -1.0), "target", 0.1)
    situation = among(turned, target)
    assert pose(situation, 0, 0.0)[0] == pytest.approx((2.0, 0.0, 0.35))
    plant = ExactPlant(situation)
    assert at_first(turned).hand[0] == pytest.approx((-1.0, 2.0, 3.0))
    plant.follow(at_first(turned), 1.0)
    assert plant.catch_time == pytest.approx(0.2, abs=1e-3)


HAND = Arm(hand=(1.5, 0.0), max_hand_speed=4.0, thickness=0.1, grasp=0.05)


def ball(name, place, velocity=REST, role="obstacle", radius=0.2):
    return solid_ball(name, place, velocity, role, radius)


def straight(until=0.5):
    """Return a movement of the hand, outwards and then back."""
    hand = np.array([[1.5, 0.0], [1.9, 0.0], [1.7, 0.0]])
    return Movement.of_hand(HAND, np.array([0.0, 0.6 * until, until]), hand)


def resting(lead, arm, body, flies, stones):
    """Yield situations of an arm at rest with the outcome and its time.

    A target flies at its hand; of three stones one hits first, one later, one too late.
    """
    first, later, late = (body("stone", *stone) for stone in stones)
    ball = body("target", *flies, "target", 0.1)
    at_rest = lead.at_first(arm)
    for bodies, outcome, when in (
        ((ball,), CAUGHT, 0.5),
        ((first,), COLLIDED, 0.4),
        ((ball, first), COLLIDED, 0.4),
        ((ball, later), CAUGHT, 0.5),
        ((late,), LATE, 1.0),
    ):
        yield among(arm, *bodies), at_rest, outcome, when


RESTING = {
    "space": (
        joint_leading, ARM, ball, ((2.0, 1.15, 0.0), (0.0, -2.0, 0.0)),
        [((1.5, 1.5, 0.0), (0.0, -speed, 0.0)) for speed in (3.0, 2.0, 1.0)],
    ),
    "plane": (
        hand_leading, HAND, disc, ((1.5, 1.15), (0.0, -2.0)),
        [((2.6, 0.0), (-2.0, 0.0)), ((2.8, 0.0), (-1.0, 0.0)), ((2.8, 0.0), (-0.9, 0.0))],
    ),
}  # fmt: skip


@pytest.mark.parametrize("steps", [1, 7, 50])
@pytest.mark.parametrize("arm", RESTING)
def test_what_comes_to_an_arm_at_rest_is_met_when_it_comes(arm, steps):
    for situation, at_rest, outcome, when in resting(*RESTING[arm]):
        plant = ExactPlant(situation)
        for k in range(steps):
            plant.follow(at_rest, (k + 1) / steps)
        assert plant.outcome == outcome
        assert plant.time == pytest.approx(when, abs=2e-3)
        assert plant.catch_time == (plant.time if outcome == CAUGHT else None)


def test_a_moving_hand_collides_when_it_does():
    """A post stands in the way out; nothing is touched on the way back."""
    plan = hand_leading.begun(HAND, straight(), 0.1)
    plant = ExactPlant(among(HAND, disc("post", (2.0, 0.0), radius=0.2)))
    plant.follow(plan, 1.0)
    assert plant.outcome == COLLIDED
    assert plant.time == pytest.approx(0.1 + 0.3 * 0.2 / 0.4, abs=1e-4)
    assert plant.arm.hand == pytest.approx((1.7, 0.0), abs=1e-3)


def test_the_rest_of_a_hand_path_is_the_same_movement():
    plan = hand_leading.begun(HAND, straight(), 0.2)
    left = hand_leading.rest_of(plan, 0.4)
    times = np.linspace(0.0, 0.5, 40)
    assert np.allclose(left.hand_at(times), plan.hand_at(times + 0.4))
    assert hand_leading.led(HAND, plan, 0.4).hand == pytest.approx(left.hand[0])
    assert hand_leading.rest_of(plan, 2.0).time.size == 1
