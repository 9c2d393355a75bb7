"""A catch and a touch within one step: the earlier of them counts, and only it."""

import numpy as np
import pytest

from gcm_learn import execution
from gcm_learn.arms import Arm, SpatialArm
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation, SolidQuadratic, Sphere

PLANAR = Arm((1.2, 0.0), 3.0, thickness=0.005, grasp=0.01)
SPATIAL = SpatialArm(
    upper_arm=(1.0, 0.0, 0.0), forearm=(0.8, 0.0, 0.0), joints=(0.0, 0.0, 0.0, 0.0),
    joint_range=((-3.0, 3.0),) * 4, max_joint_speed=(2.0,) * 4, grasp=0.01, thickness=0.005,
)  # fmt: skip
STEP = {"plane": 0.06, "space": 0.072}
"""Way of the hand in a step of 0.02 s: outwards in the plane, along y in space."""


def stepped(kind, part, post, horizon=1.0, steps=1):
    """Let a hand at full speed pass target and obstacle; both are given by shares of the step."""
    situation, settings, action = _MAKE[kind](part, post, horizon)
    plant = execution.KinematicPlant(execution.Pool.of([situation]), 1, settings)
    plant.put(np.array([0]), np.array([0]))
    for _ in range(steps):
        outcome = int(plant.move(np.array([action]))[0])
    return outcome, plant.caught(0), float(plant.time[0])


def _in_plane(part, post, horizon):
    def body(role, name, share):
        place = 1.2 + STEP["plane"] * share, 0.0
        return Body(role, name, Disc(0.001), PlanarQuadratic(place, (0.0, 0.0), (0.0, 0.0)))

    bodies = body("target", "part", part), body("obstacle", "post", post)
    return Situation("one step", horizon, PLANAR, bodies), execution.Settings(), [1.0, 0.0]


def _in_space(part, post, horizon):
    def body(role, name, share):
        angle = STEP["space"] / 1.8 * share
        place = 1.8 * np.cos(angle), 1.8 * np.sin(angle), 0.0
        return Body(role, name, Sphere(0.001), SolidQuadratic(place, (0.0,) * 3, (0.0,) * 3))

    bodies = body("target", "part", part), body("obstacle", "post", post)
    return (
        Situation("one step", horizon, SPATIAL, bodies),
        execution.SpatialSettings(),
        [0.0, 1.0, 0.0, 0.0],
    )


_MAKE = {"plane": _in_plane, "space": _in_space}


@pytest.mark.parametrize("kind", STEP)
def test_a_touch_before_a_catch_in_the_same_step_is_a_touch(kind):
    outcome, caught, time = stepped(kind, part=0.7, post=0.4)
    assert (outcome, caught) == (execution.COLLIDED, ()) and 0.0 < time < 0.7 * 0.02


@pytest.mark.parametrize("kind", STEP)
def test_a_catch_before_a_touch_in_the_same_step_is_a_catch(kind):
    outcome, caught, time = stepped(kind, part=0.4, post=0.9)
    assert (outcome, caught) == (execution.CAUGHT, ("part",)) and 0.0 < time < 0.4 * 0.02


@pytest.mark.parametrize("kind", STEP)
def test_the_next_step_comes_to_what_this_one_does_not(kind):
    assert stepped(kind, part=1.6, post=3.0) == (execution.RUNNING, (), 0.02)
    outcome, caught, time = stepped(kind, part=1.6, post=3.0, steps=2)
    assert (outcome, caught) == (execution.CAUGHT, ("part",)) and 0.02 < time < 0.04


@pytest.mark.parametrize("kind", STEP)
def test_a_step_ends_at_the_horizon(kind):
    assert stepped(kind, part=5.0, post=9.0, horizon=0.03, steps=2) == (execution.LATE, (), 0.03)
    outcome, caught, _ = stepped(kind, part=1.9, post=9.0, horizon=0.03, steps=2)
    assert (outcome, caught) == (execution.LATE, ()), "the catch would come in the rest of the step"
