"""What failed attempts teach, and catches that need it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from gcm_learn import Arm, Body, Disc, PlanarQuadratic, Polygon, Situation, solve
from gcm_learn.charts.lattice import Lattice
from gcm_learn.motion.movement import Movement
from gcm_learn.motion.verification import Verdict
from gcm_learn.planners.completion import Attempt
from gcm_learn.planners.feedback import AROUND, WIDER, Exploration, Feedback
from tests.judging import judge

LATTICE = Lattice(n=40)
SPEED = 2.0
STILL = (0.0, 0.0)


def found(interception=0.6, arrived=0.5):
    """An exploration, as far as feedback look at it."""
    made = SimpleNamespace(chart=LATTICE, interception=SimpleNamespace(time=interception))
    return Exploration(made, arrived=arrived)


def failure(touched):
    """A hand that goes along y = 0.5 from x = 1 at t = 0 to x = 0 at t = 1, touched on the way."""
    time = np.linspace(0.0, 1.0, 11)
    hand = np.stack([1.0 - time, np.full(11, 0.5)], axis=-1)
    attempt = Attempt(Movement.of_hand(Arm((1.0, 0.5), 1.0), time, hand), 0)
    return attempt, Verdict(False, -0.1, collision_time=touched)


def test_a_touch_on_the_way_widens_the_margin_around_it():
    feedback = Feedback().after(found(), [failure(0.45), failure(0.3)], SPEED)
    assert feedback.ignore == 0.0
    x, y = np.meshgrid(LATTICE.centres, LATTICE.centres)
    near = np.maximum(abs(x - 0.7), abs(y - 0.5)) < AROUND * LATTICE.spacing  # the first touch
    assert np.array_equal(feedback.widening.reshape(40, 40), WIDER * near)
    assert 4 <= near.sum() <= 16


def test_touches_at_one_place_widen_ever_farther():
    once = Feedback().after(found(), [failure(0.3)], SPEED)
    twice = once.after(found(0.7), [failure(0.3)], SPEED)
    assert twice.widening.max() == 2 * WIDER
    assert (twice.widening > 0).sum() > (once.widening > 0).sum()
    elsewhere = once.after(found(arrived=1.0), [failure(0.9)], SPEED)
    assert (elsewhere.widening > 0).sum() <= 2 * (once.widening > 0).sum()


def test_a_contact_that_widening_does_not_move_is_passed_over():
    crossing = LATTICE.spacing / SPEED
    once = Feedback().after(found(0.6), [failure(0.3)], SPEED)
    moved = once.after(found(0.7), [failure(0.3)], SPEED)
    assert once.ignore == moved.ignore == 0.0
    again = moved.after(found(0.7), [failure(0.3)], SPEED)
    assert again.ignore == pytest.approx(0.7 + crossing)
    assert again.widening.max() == 3 * WIDER


@pytest.mark.parametrize("failures", [[], [failure(0.55)], [failure(None)]])
def test_a_contact_that_cannot_be_ended_is_passed_over(failures):
    """Nothing to try, touched after the way there, or wrong in another way."""
    crossing = LATTICE.spacing / SPEED
    once = Feedback().after(found(0.6), failures, SPEED)
    assert once.widening is None and once.ignore == pytest.approx(0.6 + crossing)
    twice = once.after(found(0.7), failures, SPEED)
    assert twice.ignore == pytest.approx(0.7 + 2 * crossing)


def test_the_hand_rests_where_the_target_will_come():
    """Going to meet it sooner leads through the plank; from where it rests the catch is late."""
    arm = Arm((1.137, 0.099), 3.024, 0.823, "right", thickness=0.03, grasp=0.05)
    fall = PlanarQuadratic((-1.424, 2.707), (0.4586, -1.8591), (0.0, 0.0))
    box = ((-0.191, -0.038), (0.191, -0.038), (0.191, 0.038), (-0.191, 0.038))
    plank = PlanarQuadratic((-0.292, 0.971), STILL, STILL, angle=2.256)
    bodies = (
        Body("target", "ball", Disc(0.082), fall),
        Body("obstacle", "plank", Polygon(box), plank),
    )
    situation = Situation("plank", 1.274, arm, bodies)
    plan = solve(situation, "layered")
    assert plan.caught and plan.catch_time < 1.10
    assert not judge(situation, plan)
    assert plan.trajectory.waits()


def test_a_gate_that_opens_just_in_time_is_passed():
    """The way through centres of cells is longer than the horizon allows, the hand's is not."""
    arm = Arm((-1.9556, 0.2684), 3.7644, 1.19, "left", thickness=0.03, grasp=0.05)
    bolt = ((0.0, -0.0476), (1.3342, -0.0476), (1.3342, 0.0476), (0.0, 0.0476))
    slides = PlanarQuadratic((-0.2275, -0.208), STILL, (-1.874, -1.7133), angle=-2.40095)
    bodies = (
        Body("target", "goal", Disc(0.0555), PlanarQuadratic((-0.7113, -1.6332), STILL, STILL)),
        Body("obstacle", "bolt", Polygon(bolt), slides),
        Body("obstacle", "post", Disc(0.0546), PlanarQuadratic((-0.1932, 0.1279), STILL, STILL)),
    )
    situation = Situation("gate", 1.27, arm, bodies)
    plan = solve(situation, "layered")
    assert plan.caught and not judge(situation, plan)
    assert not solve(situation, "marching").caught
