"""Arms, planes, bodies and situations check themselves and each other."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest
from hypothesis import given

from gcm_learn.arms import Arm
from gcm_learn.errors import GcmError, SituationError
from gcm_learn.situation import (
    Body,
    Disc,
    Pendulum,
    PlanarQuadratic,
    Plane,
    Situation,
    SolidQuadratic,
    Sphere,
)
from tests import strategies

ARM = {"hand": (1.1, -0.4), "max_hand_speed": 3.1}
REST = PlanarQuadratic((0, 1), (0, 0), (0, 0))
SOLID_REST = SolidQuadratic((0, 1, 0), (0, 0, 0), (0, 0, 0))
BALL = Body("target", "ball", Disc(0.1), REST)
DISC = Body("obstacle", "disc", Disc(0.1), REST)
SOLID_BALL = Body("target", "ball", Sphere(0.1), SOLID_REST)
PLANE = Plane((0, 0, 1), (1, 0, 0), (0, 0, 1))


def message(record, *values, **fields):
    with pytest.raises(SituationError) as caught:
        record(*values, **fields)
    return str(caught.value)


def test_errors_are_ours_and_value_errors():
    with pytest.raises(GcmError) as caught:
        Disc(-1)
    assert isinstance(caught.value, ValueError)
    assert (caught.value.field, caught.value.reason) == ("radius", "must be positive (got -1.0)")


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"hand": (2.4, 0)}, "hand: (2.4, 0.0) is out of reach (max 2.0)"),
        ({"hand": (0.2, 0.0), "upper_arm": 0.5}, "hand: (0.2, 0.0) is out of reach (min 0.5)"),
        ({"hand": (0.2, 0.0), "upper_arm": 1.5}, "hand: (0.2, 0.0) is out of reach (min 0.5)"),
        ({"hand": (1, 0, 0)}, "hand: must be a list of 2 numbers (got 3)"),
        ({"max_hand_speed": 0}, "max_hand_speed: must be positive (got 0.0)"),
        ({"upper_arm": -1}, "upper_arm: must be positive (got -1.0)"),
        ({"elbow": "up"}, 'elbow: must be "left" or "right" (got "up")'),
        ({"elbow": 1}, 'elbow: must be "left" or "right" (got 1)'),
        ({"max_joint_speed": 3}, "max_joint_speed: must be a list of 2 numbers (got 3)"),
        ({"max_joint_speed": (1, 0)}, "max_joint_speed[1]: must be positive (got 0.0)"),
        ({"thickness": -0.1}, "thickness: must not be negative (got -0.1)"),
        ({"grasp": -0.1}, "grasp: must not be negative (got -0.1)"),
        ({"grasp": math.nan}, "grasp: must be finite (got nan)"),
    ],
)
def test_arm_refuses(change, expected):
    assert message(Arm, **ARM | change) == expected


def test_arm_defaults_and_reach():
    arm = Arm(**ARM)
    assert dataclasses.asdict(arm) == {
        "hand": (1.1, -0.4),
        "max_hand_speed": 3.1,
        "upper_arm": 1.0,
        "elbow": "right",
        "max_joint_speed": None,
        "thickness": 0.0,
        "grasp": 0.05,
    }
    assert (arm.reach, arm.inner_reach) == (2.0, 0.0)
    short = Arm((1, 0), 1, upper_arm=0.25)
    assert (short.reach, short.inner_reach) == (1.25, 0.75)


@pytest.mark.parametrize("angle", [0.1 * k for k in range(63)])
def test_hand_on_the_rim_is_within_reach_up_to_rounding(angle):
    direction = (math.cos(angle), math.sin(angle))
    for radius in (0.5, 2.5):
        hand = (radius * direction[0], radius * direction[1])
        assert Arm(hand, 1.0, upper_arm=1.5).hand == hand
    far = (2.5001 * direction[0], 2.5001 * direction[1])
    assert "out of reach (max 2.5)" in message(Arm, far, 1.0, upper_arm=1.5)


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [
        ((2, 0, 0), (0, 1, 0), "x: must have length 1 (got 2)"),
        ((1, 0, 0), (0, 0.5, 0), "y: must have length 1 (got 0.5)"),
        ((1, 0, 0), (0.6, 0.8, 0), "y: must be orthogonal to x (dot product 0.6)"),
        ((1, 0, 0), (1, 0, 0), "y: must be orthogonal to x (dot product 1)"),
        ((1, 0), (0, 1, 0), "x: must be a list of 3 numbers (got 2)"),
    ],
)
def test_plane_refuses(x, y, expected):
    assert message(Plane, (0, 0, 0), x, y) == expected


def test_plane_normal_is_right_handed():
    assert PLANE.normal == (0.0, -1.0, 0.0)
    assert Plane((0, 0, 0), (1, 0, 0), (0, 1, 0)).normal == (0.0, 0.0, 1.0)


@given(strategies.planes())
def test_plane_normal_is_the_cross_product(plane):
    assert np.cross(plane.x, plane.y) == pytest.approx(np.array(plane.normal))


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (("goal", "a", Disc(1), REST), 'role: must be "target" or "obstacle" (got "goal")'),
        (("target", 7, Disc(1), REST), "name: must be a string (got 7)"),
        (
            ("target", "\ud800", Disc(1), REST),
            'name: is not valid Unicode (lone surrogate in "\\ud800")',
        ),
        (("target", "a", 0.1, REST), "shape: must be a shape (got 0.1)"),
        (("target", "a", Disc(1), None), "motion: must be a motion (got null)"),
        (
            ("target", "a", Disc(1), SOLID_REST),
            'motion: planar shape "disc" needs a planar motion (got SolidQuadratic)',
        ),
        (
            ("target", "a", Sphere(1), REST),
            'motion: 3D shape "sphere" needs a 3D motion (got PlanarQuadratic)',
        ),
    ],
)
def test_body_refuses(values, expected):
    assert message(Body, *values) == expected


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ((3, 1.0, Arm(**ARM), [BALL]), "name: must be a string (got 3)"),
        (("s", 0, Arm(**ARM), [BALL]), "horizon: must be positive (got 0.0)"),
        (("s", 1.0, None, [BALL]), "arm: must be an arm (got null)"),
        (
            ("s", 1.0, Arm(**ARM), BALL),
            "bodies: must be a list of bodies (got a value of type Body)",
        ),
        (("s", 1.0, Arm(**ARM), ["ball"]), 'bodies[0]: must be a body (got "ball")'),
        (("s", 1.0, Arm(**ARM), []), "bodies: no target among 0 bodies"),
        (
            ("s", 1.0, Arm(**ARM), [Body("obstacle", "a", Disc(1), REST)]),
            "bodies: no target among 1 bodies",
        ),
        (
            ("s", 1.0, Arm(**ARM), [BALL, Body("obstacle", "ball", Disc(1), REST)]),
            'bodies[1].name: "ball" is already the name of bodies[0]',
        ),
        (
            ("s", 1.0, Arm(**ARM), [SOLID_BALL]),
            'bodies[0].shape.kind: "sphere" is 3D, but the situation has no plane',
        ),
        (
            ("s", 1.0, Arm(**ARM), [SOLID_BALL, DISC], PLANE),
            'bodies[1].shape.kind: "disc" is planar, but the situation has a plane',
        ),
        (("s", 1.0, Arm(**ARM), [BALL], 0), "plane: must be a plane (got 0)"),
    ],
)
def test_situation_refuses(values, expected):
    assert message(Situation, *values) == expected


@given(strategies.situations())
def test_targets_and_obstacles_share_out_the_bodies(situation):
    assert sorted(b.name for b in situation.targets + situation.obstacles) == sorted(
        b.name for b in situation.bodies
    )
    assert situation.bodies[0] in situation.targets
    assert situation.is_solid == all(body.is_solid for body in situation.bodies)


def test_a_horizon_of_too_many_swings_is_refused_by_name():
    swing = Pendulum((0, 0, 1), (1, 0, 0), (0, 0, -1), 1.0, 9.81, 0.5, 0.0)
    ball = Body("target", "ball", Sphere(0.1), swing)
    period = 2.0 * math.pi / math.sqrt(9.81)
    assert Situation("s", 999.0 * period, Arm(**ARM), [ball], PLANE).horizon > 0.0
    refused = message(Situation, "s", 1001.0 * period, Arm(**ARM), [ball], PLANE)
    assert re.fullmatch(
        r"horizon: [\d.]+ s is over 1000 periods of bodies\[0\] \(at most .+\)", refused
    )
