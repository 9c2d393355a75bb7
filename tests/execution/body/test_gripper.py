"""A gripper in physics: its blow is what mechanics tells, and what is carried is put down."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import Base, hands_along, rotation_of
from gcm_learn.execution import GrippingPlant, body_for, execute, execution_to_json
from gcm_learn.execution.arena.kernels.world import CAUGHT, LATE
from gcm_learn.execution.body.model import BALL_DENSITY, STEP
from gcm_learn.execution.loop.joint_leading import Grip, Gripping
from gcm_learn.planners import get_planner
from gcm_learn.scene import pose
from gcm_learn.situation import Hold, Place
from tests.worlds import READY, among, flight, panda, pick, solid_ball

PANDA = panda(max_joint_acceleration=(15, 7.5, 10, 12.5, 15, 20, 20))
HAND = hands_along(PANDA, PANDA.joints)[0][0]
PLANNER = get_planner("search")


def resting(closes, opens=None):
    """An arm at rest whose hand closes."""
    return Gripping(
        PANDA, np.zeros(1), np.array([READY]), np.zeros((1, 7)), grips=(Grip("b", closes, opens),)
    )


def passing(velocity, radius=0.02):
    """A ball that passes the hand after 0.4 s."""
    start = HAND - 0.4 * np.array(velocity)
    return among(PANDA, solid_ball("b", start, velocity, "target", radius))


@pytest.mark.parametrize("velocity", [(0.0, 0.4, 0.0), (0.1, 0.0, -0.2), (0.0, -0.8, 0.0)])
@pytest.mark.parametrize("radius", [0.02, 0.03])
def test_a_hand_at_rest_takes_the_momentum_of_what_it_grips(velocity, radius):
    """The impulse is mass times speed, as the arm is heavy, and the target then rests."""
    plant = GrippingPlant(passing(velocity, radius), body_for(PANDA), until=1.0)
    plant.follow(resting(0.4), 0.6)
    mass = BALL_DENSITY * 4.0 / 3.0 * np.pi * radius**3
    assert plant.outcome == CAUGHT
    plant.follow(resting(0.4), 0.6)
    assert plant.gripped.impulse == pytest.approx(mass * np.linalg.norm(velocity), rel=0.05)
    gripped, now = plant.targets_log[[200, plant.steps], :3]
    assert gripped == pytest.approx(HAND, abs=1e-9)
    assert now == pytest.approx(gripped, abs=2e-3)


COMES = 0.4 - (PANDA.grasp + 0.02) / 0.7


@pytest.mark.parametrize(("closes", "caught"), [(0.2, False), (COMES + 1e-9, True), (0.8, False)])
def test_a_target_is_gripped_from_the_first_step_within_grasp_on(closes, caught):
    """Too early and too late the ball flies on by its law."""
    plant = GrippingPlant(passing((0.0, 0.7, 0.0)), body_for(PANDA), until=1.0)
    plant.follow(resting(closes), 1.1)
    assert plant.outcome == (CAUGHT if caught else LATE)
    assert (len(plant.closed), len(plant.catches)) == (caught, caught)
    law, _ = pose(plant.situation, 0, plant.time)
    if caught:
        assert COMES <= plant.gripped.closed < COMES + STEP
    else:
        assert plant.targets_log[plant.steps, :3] == pytest.approx(law, abs=1e-9)


def test_what_is_put_down_rests_and_others_are_not_disturbed():
    """Two plants of one model grip at different times."""
    place = Place(tuple(HAND + (0.0, 0.01, 0.0)), 0.02)
    ball = passing((0.0, 0.4, 0.0)).bodies[0]
    kept = replace(ball, hold=Hold(0.0, 1.0), place=place)
    plants = [GrippingPlant(among(PANDA, kept), body_for(PANDA), until=1.0) for _ in range(2)]
    for end in np.arange(0.1, 1.05, 0.1):
        for plant, closes in zip(plants, (0.4, 0.41), strict=True):
            plant.follow(resting(closes, 0.7), end)
    for plant, closes in zip(plants, (0.4, 0.41), strict=True):
        assert plant.outcome == CAUGHT and plant.over == 350
        law, _ = pose(plant.situation, 0, closes)
        rows = plant.targets_log[350 : plant.steps + 1, :3]
        assert rows == pytest.approx(np.tile(rows[0], (len(rows), 1)))
        assert rows[0] == pytest.approx(law, abs=2e-3)
        off = np.linalg.norm(rows[0] - place.position)
        assert plant.gripped.off_place == pytest.approx(off, abs=1e-9)


@pytest.fixture(scope="module")
def picked():
    """A situation with a place, its plan and the execution."""
    situation = pick()
    plan = PLANNER.plan(situation)
    situation = replace(situation, horizon=plan.catch_time + 0.05)  # placed after it
    return situation, plan, execute(plan, situation)


def test_a_held_ball_is_gripped_carried_and_put_down(picked):
    situation, plan, done = picked
    assert done.caught and done.braked == 0.0
    assert done.grip.closed == pytest.approx(plan.held_until, abs=STEP)
    assert done.grip.opened == pytest.approx(plan.placed, abs=STEP)
    assert done.grip.off_place <= situation.bodies[0].place.within
    plant, (first, last) = done.plant, (round(t / STEP) for t in done.grip[:2])
    for k in range(0, first, 50):
        law, _ = pose(situation, 0, k * STEP)
        assert plant.targets_log[k, :3] == pytest.approx(law, abs=1e-9)
    hands = hands_along(PANDA, plant.joints_log[first : last + 1])[0]
    away = np.linalg.norm(plant.targets_log[first : last + 1, :3] - hands, axis=1)
    assert np.ptp(away) < 1e-3 and np.ptp(hands, axis=0).max() > 0.2
    told = execution_to_json(done)
    assert told["placed"] == done.grip.opened and told["touch_impulse"] is None


def test_a_turned_base_changes_nothing(picked):
    """Arm, belt and place are turned and moved together, about the vertical."""
    situation, _, done = picked
    base = Base((0.3, -0.2, 0.1), (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)))
    turn, ball = rotation_of(base.rotation), situation.bodies[0]
    start, goal = (tuple(turn @ np.array(p) + base.origin)
                   for p in (ball.motion.position, ball.place.position))  # fmt: skip
    law, place = flight(start, turn @ np.array(ball.motion.velocity)), Place(goal, 0.02)
    bodies = (replace(ball, motion=law, place=place),)
    turned = replace(pick(), arm=replace(situation.arm, base=base), bodies=bodies)
    found = execute(PLANNER.plan(turned), turned)
    assert found.grip == pytest.approx(done.grip, rel=1e-3)


def test_what_is_carried_collides_unless_it_may(picked):
    """A ball so small that only what is carried meets it is put near the end of the carried way."""
    situation, plan, done = picked
    k = round((0.1 * done.grip.closed + 0.9 * done.grip.opened) / STEP)
    crumb = solid_ball("crumb", done.plant.targets_log[k, :3], radius=0.001)
    for ignore, status in (((), "collided"), (("crumb",), "caught")):
        ball = replace(situation.bodies[0], ignore=ignore)
        barred = replace(situation, bodies=(ball, crumb))
        met = execute(plan, barred)
        assert met.status == status
        assert (met.contact is None) == bool(ignore)
    assert (
        done.grip.closed
        < execute(plan, replace(barred, bodies=(situation.bodies[0], crumb))).contact.time
        < done.grip.opened
    )
